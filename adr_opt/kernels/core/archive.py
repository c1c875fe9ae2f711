"""The archive of compiled kernels that a wheel brings along, so that nothing need be compiled.

Its kernels are compiled for x86-64-v3, which most processors of the last ten years are. It serves
with the versions of Python, Numba, llvmlite and NumPy that it was made with; with others, kernels
are compiled when they are first called. ``bench/wheel.py`` makes it.
"""

import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

from llvmlite import binding as llvm
from numba.core import config

FILE = Path(__file__).parents[1] / "compiled.zip"

LEVEL = "x86-64-v3"
"""Level of the x86-64 processors that the archive is for."""

FEATURES = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
"""Features of a processor of that level."""


def processor(own: tuple[str, ...]) -> tuple[str, ...]:
    """The processor that the archive is for: triple, name and features.

    Parameters
    ----------
    own : tuple of str
        The same of this machine.
    """
    return (own[0], LEVEL, "")


@cache
def is_usable() -> bool:
    """Whether there is an archive, and this processor is of its level."""
    asked: str | None = vars(config)["CPU_NAME"]
    return FILE.is_file() and asked in (None, LEVEL) and serves_this_processor()


def serves_this_processor() -> bool:
    """Whether this machine's processor is of the level that archives are for."""
    if not llvm.get_process_triple().startswith("x86_64"):
        return False
    features = llvm.get_host_cpu_features()
    return all(features.get(name, False) for name in FEATURES)


def find(name: Callable[[tuple[str, ...]], str], own: tuple[str, ...]) -> bytes | None:
    """A kernel; None if the archive lacks it, cannot be read or is not for this machine.

    Parameters
    ----------
    name : callable
        The name of the kernel, compiled for a processor.
    own : tuple of str
        The processor of this machine.
    """
    if not is_usable():
        return None
    try:
        return _opened().read(name(processor(own)))
    except (KeyError, OSError, zipfile.BadZipFile):
        return None


def write(kernels: dict[str, bytes], file: Path = FILE) -> None:
    """Make an archive.

    Parameters
    ----------
    kernels : dict
        By name.
    file : Path
    """
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in sorted(kernels.items()):
            # Without the time of day, so that the same kernels make the same file.
            made.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)


def names() -> list[str]:
    """Names of the kernels in the archive; empty if it cannot be read."""
    try:
        return _opened().namelist()
    except (OSError, zipfile.BadZipFile):
        return []


@cache
def _opened() -> zipfile.ZipFile:
    return zipfile.ZipFile(FILE)
