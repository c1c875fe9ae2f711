"""State of the installation: versions, machine, cache of kernels, extras, methods, and problems."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from ..common.errors import InputError
from ..common.memory import available_bytes
from ..common.packages import INSTALLED, OURS, Requirement, foreign_package, installed, requirements
from ..common.processors import usable_cores
from ..common.version import __version__
from .methods import BOUNDS, PLANNERS, names

LEAST_MEMORY_BYTES = 2.0**30
"""Free memory below which to warn: kernels and a timetable of 50 targets take half of it."""

OF_OTHERS = ("llvmlite", "pydantic-core")
"""Packages installed with required ones whose versions matter."""


@dataclass(frozen=True)
class Cache:
    """Compiled kernels on this machine.

    Attributes
    ----------
    folder : str
        Where they are kept; empty if there is no such place.
    kernels, size_bytes : int
    trouble : str or None
        Why the place is none, or not the best one, in a sentence that says what to do.
    """

    folder: str
    kernels: int
    size_bytes: int
    trouble: str | None = None


@dataclass(frozen=True)
class Installation:
    """Facts about adr-opt on this machine.

    Attributes
    ----------
    python, system : str
    place : str
        Folder of the package.
    versions : mapping of str to str or None
        Of adr-opt and of what it always stands on; None for a package that is missing.
    cores : int
        That this process may use.
    memory_bytes : float
        Free memory; +inf where the system does not say.
    cache : Cache or None
        None where kernels cannot be compiled at all.
    archive : str
        State of the archive of compiled kernels.
    extras : mapping of str to tuple of str
        For each extra the packages that are missing.
    planners, bounds : tuple of str
    problems : tuple of str
        What is wrong, each in a sentence with its cure.
    """

    python: str
    system: str
    place: str
    versions: Mapping[str, str | None]
    cores: int
    memory_bytes: float
    cache: Cache | None
    archive: str
    extras: Mapping[str, tuple[str, ...]]
    planners: tuple[str, ...]
    bounds: tuple[str, ...]
    problems: tuple[str, ...]


def examine() -> Installation:
    """Examine everything that a run depends on."""
    needed = requirements()
    base = [each for each in needed if not each.extra]
    problems = [*_of_versions(needed), *_of_imports(base)]
    cache, brought = None, "not examined"
    uncompiled = None if problems else _uncompiled()
    if uncompiled is not None:
        problems.append(uncompiled)
    if not problems:  # what is broken would break what follows, and not say why
        cache, brought = kernel_cache(), archive()
        problems += [] if cache.trouble is None else [cache.trouble]
        problems += _of_methods()
    shown = sorted({*(each.package for each in base), *OF_OTHERS})
    memory = available_bytes()
    if memory < LEAST_MEMORY_BYTES:
        problems.append(
            f"only {memory / 2.0**20:.0f} MiB of memory are free; end other programs, or plan "
            "with --memory and fewer targets"
        )
    return Installation(
        python=platform.python_version(),
        system=f"{platform.system()} {platform.machine()}",
        place=str(INSTALLED),
        versions={OURS: __version__, **{name: installed(name) for name in shown}},
        cores=usable_cores(),
        memory_bytes=memory,
        cache=cache,
        archive=brought,
        extras=_extras(needed),
        planners=names(PLANNERS),
        bounds=names(BOUNDS),
        problems=tuple(problems),
    )


def _of_versions(needed: tuple[Requirement, ...]) -> Iterator[str]:
    """Packages that are missing, too old or known to be bad, and metadata of another version."""
    stated = installed(OURS)
    if stated is None or not needed:
        yield f"{OURS} is not installed in this Python ({sys.executable}); install it with pip"
        return
    if stated != __version__:
        yield (
            f"{OURS} {__version__} has the metadata of version {stated}, so that methods may be "
            "missing; install it again"
        )
    told, missing = set(), _extras(needed)
    for each in needed:
        found = installed(each.package)
        if each.package == OURS or each.package in told:
            continue
        if found is None and not each.extra:
            yield f"{each.package} is missing; install it with pip install '{each}'"
            told.add(each.package)
        # An extra that lacks packages is not in use: Python itself may bring some of the others.
        is_in_use = not each.extra or not missing[each.extra]
        if found is not None and is_in_use and not each.allows(found):
            what = f"[{each.extra}]" if each.extra else OURS
            yield (
                f"{each.package} {found} does not work with {what}; replace it with pip install "
                f"'{each}'"
            )
            told.add(each.package)


def _of_imports(base: list[Requirement]) -> Iterator[str]:
    """Packages that are installed but broken."""
    for each in base:
        if installed(each.package) is None:
            continue
        try:
            import_module(each.package)
        except Exception as error:
            said = " ".join(str(error).split())
            yield (
                f"{each.package} cannot be imported ({said}); install it again with pip install "
                f"--force-reinstall '{each}'"
            )


def _of_methods() -> Iterator[str]:
    """Planners, bounds and families of legs that cannot be loaded, and packages that hide ours."""
    from ..plan.leg_kinds import leg_kinds
    from .method_call import method_of

    foreign = foreign_package()
    if foreign is not None:
        yield foreign
    if not names(PLANNERS):
        yield "no planner is installed; install adr-opt again with pip"
    found = [(kind, name) for kind in (PLANNERS, BOUNDS) for name in names(kind)]
    told = set()
    for group, name in found if foreign is None else ():
        try:
            method_of(name, group)
        except InputError as error:
            told.add(str(error))
    yield from sorted(told)
    try:
        leg_kinds()
    except InputError as error:
        yield str(error)


def _uncompiled() -> str | None:
    """Why no kernel is compiled; None if kernels are. Call only where Numba is installed."""
    from ..kernels.core import enabled

    return enabled.obstacle()


def kernel_cache() -> Cache:
    """The folder of compiled kernels, with its contents."""
    from ..kernels.core import cache

    first = next((f"compiled kernels cannot be kept in {said}" for said in cache.refused()), None)
    for folder in cache.folders():
        trouble = _unwritable(folder)
        if trouble is None:
            sizes = [each.stat().st_size for each in folder.glob("*.kernel")]
            if first is not None:
                first += f", so they are kept in {folder}, which the next restart may empty"
                first += f"; make it writable, or name another folder in {cache.VARIABLE}"
            return Cache(str(folder), len(sizes), sum(sizes), first)
        first = first or f"compiled kernels cannot be kept in {folder} ({trouble})"
    said = first or "there is no folder to keep compiled kernels in"
    cure = f"name a folder that is writable in {cache.VARIABLE}"
    return Cache("", 0, 0, f"{said}, so every run compiles for a minute; {cure}")


def _unwritable(folder: Path) -> str | None:
    """Reason why a folder cannot be written to; None if it can be, or could be once created."""
    try:
        if folder.is_dir():
            with tempfile.TemporaryFile(dir=folder) as file:
                file.write(b"0")
            return None
    except OSError as error:
        return error.strerror or str(error)
    nearest = next(each for each in (folder, *folder.parents) if each.exists())
    if nearest.is_dir() and os.access(nearest, os.W_OK | os.X_OK):
        return None
    return f"{nearest} is not a writable folder"


def archive() -> str:
    """State of the archive of compiled kernels in wheels, in words."""
    from ..kernels.core import archive

    if not archive.FILE.is_file():
        return "none in this installation; kernels are compiled when first called"
    if not archive.serves_this_processor():
        return f"made for processors of level {archive.LEVEL}, which this one does not reach"
    if not archive.is_usable():
        return f"made for {archive.versions_of_archive()}, which this Python does not have"
    return f"{len(archive.names())} kernels for processors of level {archive.LEVEL}"


def _extras(needed: tuple[Requirement, ...]) -> dict[str, tuple[str, ...]]:
    """Missing packages of each extra, including those of extras that it refers to."""

    def missing(extra: str) -> Iterator[str]:
        for each in needed:
            if each.extra == extra and each.package == OURS:
                for part in each.parts:
                    yield from missing(part)
            elif each.extra == extra and installed(each.package) is None:
                yield each.package

    extras = dict.fromkeys(each.extra for each in needed if each.extra)
    return {extra: tuple(dict.fromkeys(missing(extra))) for extra in extras}
