"""Archive of compiled kernels in a wheel, so that users compile nothing.

Its kernels are compiled for x86-64-v3, the level of most processors since 2015. They serve with the
versions of Python, Numba, llvmlite and NumPy they were made with; with other versions, kernels are
compiled when they are first called. ``bench/wheel.py`` makes the archive.
"""

import platform
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import llvmlite
import numba
import numpy as np
from llvmlite import binding as llvm
from numba.core import config

FILE = Path(__file__).parents[1] / "compiled.zip"

LEVEL = "x86-64-v3"
"""Level of the x86-64 processors that the archive is for."""

FEATURES = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave")
"""Features of a processor of that level."""


def processor(own: tuple[str, ...]) -> tuple[str, ...]:
    """Triple, name and features of the processors that the archive is for.

    Parameters
    ----------
    own : tuple of str
        Those of this machine.
    """
    return (own[0], LEVEL, "")


def serves_this_processor() -> bool:
    """Whether this machine's processor reaches the level that archives are made for."""
    if not llvm.get_process_triple().startswith("x86_64"):
        return False
    features = llvm.get_host_cpu_features()
    return all(features.get(name, False) for name in FEATURES)


def versions() -> str:
    """System and versions that compiled kernels depend on."""
    made_by = f"numba {numba.__version__}, llvmlite {llvmlite.__version__}, numpy {np.__version__}"
    return f"{platform.system()}, {sys.implementation.cache_tag}, {made_by}"


def versions_of_archive() -> str | None:
    """System and versions that the archive was made with; None if it cannot be read."""
    try:
        return _opened().comment.decode()
    except (OSError, ValueError, zipfile.BadZipFile):
        return None


@cache
def is_usable() -> bool:
    """Whether an archive exists for this processor and these versions."""
    asked: str | None = vars(config)["CPU_NAME"]
    is_for_this = asked in (None, LEVEL) and serves_this_processor()
    return is_for_this and FILE.is_file() and versions_of_archive() == versions()


def find(name: Callable[[tuple[str, ...]], str], own: tuple[str, ...]) -> bytes | None:
    """Stored form of a kernel; None if the archive lacks it or is not usable.

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
    """Write an archive.

    Parameters
    ----------
    kernels : dict
        By name.
    file : Path
    """
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as made:
        made.comment = versions().encode()
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
