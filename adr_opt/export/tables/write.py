"""Writing of matrices, or of the whole timetable, in the format given by the file's suffix."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np

from ...common.errors import InputError
from ...common.files import check_writable, write_whole
from ...common.packages import load
from ...legs.connections import Choice
from ...legs.matrices import FloatArray, Matrices
from ...mission.mission import Mission
from ...problem.instance import Instance
from ...problem.rules import FIRST, JUDGED, MODELLED, SUPPLIES, TOURS, Follower
from ...problem.support import followed, refuse
from .arrays import require_netcdf, require_parquet, write_netcdf, write_npz, write_parquet
from .weights import check_quantity, check_scale, write_oplib, write_tsp, write_vrp

MODELS = "adr_opt.models"
"""Entry-point group; a package that declares it adds its formats to ``matrix``."""

WriteModel = Callable[[Mission, Path], None]


def model_suffixes() -> tuple[str, ...]:
    """Suffixes of the installed model formats, with the dot, sorted; nothing is imported."""
    return tuple(sorted({f".{entry.name}" for entry in entry_points(group=MODELS)}))


def model_writer(suffix: str) -> WriteModel:
    """The writer of files with an installed suffix.

    Raises
    ------
    InputError
        It is declared but cannot be imported.
    """
    (entry, *_) = entry_points(group=MODELS, name=suffix.removeprefix("."))
    try:
        found: WriteModel = load(entry)
    except (ImportError, AttributeError) as error:
        raise InputError(
            f"format {suffix!r} is declared, but cannot be imported ({error}); "
            "reinstall the package that declares it"
        ) from error
    return found


SAMPLED = (".npz", ".nc")
"""Formats of matrices at any number of departures."""

ONE_DEPARTURE = (".tsp", ".vrp", ".oplib")
"""Formats of one matrix at one departure."""

ONE_DEPOT = (".vrp", ".oplib")
"""Formats of routes that begin and end at node 1."""


Building = Callable[[float], None]
"""Callback for the share of the timetable that is built."""


TRANSFERS = Follower("a file of transfers", JUDGED - {"several chasers"})
"""Rules followed by all files, which hold the transfers of one chaser."""

MODEL_FILES = Follower(
    "a file of the model",
    FIRST | MODELLED | SUPPLIES | TOURS | {"expense", "functions of time", "capture windows"},
    "write transfers alone, as .npz, .nc or .parquet",
)
"""Rules followed by files of the exact network of one chaser, whose legs have no masses."""

DEPOT_FILES = Follower(
    "a file with one depot",
    MODEL_FILES.follows
    - {"capture windows", "number of stations", "prizes that fall"}
    - {"start orbits", "launches", "launches into orbits"},
    "write transfers alone, as .npz, .nc or .parquet",
)
"""Rules followed by files with one depot, where the chaser starts and refuels, and fixed prizes."""


def whole_suffixes() -> tuple[str, ...]:
    """Suffixes of formats that hold every connection, those of installed models included."""
    return (".parquet", *model_suffixes())


def suffix_of(path: str | os.PathLike[str]) -> str:
    """The suffix of a file to be written, in lower case.

    Raises
    ------
    InputError
        No format has it; the sentence lists those that there are.
    """
    suffix = Path(path).suffix.lower()
    known = (*SAMPLED, *ONE_DEPARTURE, *whole_suffixes())
    if suffix not in known:
        raise InputError(f"{path}: suffix {suffix!r} is unknown; use one of {', '.join(known)}")
    return suffix


def write_matrix(
    instance_or_mission: Instance | Mission,
    path: str | os.PathLike[str],
    departures: Sequence[float] | FloatArray,
    *,
    quantity: str = "delta_v",
    scale: float | None = None,
    choose: Choice | None = None,
    building: Building = lambda share: None,
) -> Matrices:
    """Sample the timetable at ready times and write it, completely or not at all.

    Parameters
    ----------
    instance_or_mission : Instance or Mission
        A :class:`Mission` brings its timetable along.
    path : path
        The suffix chooses the format: ``.npz``, ``.nc`` (extra ``[io]``), ``.tsp``, ``.vrp`` or
        ``.oplib``.
    departures : sequence of float
        Times since the epoch at which the chaser is ready [s]; one for the last three.
    quantity : {"delta_v", "duration"}
        What the weights of the last three are; the other formats hold both.
    scale : float, optional
        Weight of one m/s or one second in the last three; by default the largest power of ten up
        to 1000 for which every weight fits into 31 bits.
    choose : {"earliest", "cheapest"} or float, optional
        As in :meth:`adr_opt.Timetable.matrices`.
    building : callable
        Called with the share of the timetable that is built.

    Returns
    -------
    Matrices
        What was written, before any scaling.

    Raises
    ------
    InputError
        Unknown suffix or quantity, a departure that is not a finite time ≥ 0, no departure, more
        than one where the format holds one, a format without departures, weights or prizes that
        do not fit, a format with one depot for a mission that does not start at its only
        station, or a file that cannot be written.
    MissingExtra
        ``.nc`` without xarray and h5netcdf.
    """
    # What can be wrong with the call is asked before the timetable is built.
    suffix = suffix_of(path)
    check_quantity(quantity)
    check_scale(scale)
    times = np.atleast_1d(np.asarray(departures, dtype=float))
    if suffix in whole_suffixes():
        raise InputError(
            f"{path}: a {suffix} file holds every connection; leave out the ready times"
        )
    if times.size == 0:
        raise InputError("departures: there are none; give at least one ready time")
    if suffix in ONE_DEPARTURE and times.size > 1:
        raise InputError(
            f"{path}: a {suffix} file holds one departure, but {times.size} are given; "
            "give one, or write .npz or .nc"
        )
    if suffix == ".nc":
        require_netcdf()
    check_writable(path)

    mission = _mission(instance_or_mission)
    if suffix in ONE_DEPOT:
        refuse(mission.instance, DEPOT_FILES)
    _build(mission, building)
    matrices = mission.timetable.matrices(times, choose)

    def write(temporary: Path) -> None:
        if suffix == ".npz":
            write_npz(temporary, mission, matrices)
        elif suffix == ".nc":
            write_netcdf(temporary, mission, matrices)
        elif suffix == ".tsp":
            write_tsp(temporary, mission.instance, matrices, quantity, scale)
        elif suffix == ".vrp":
            write_vrp(temporary, mission, matrices, quantity, scale)
        else:
            write_oplib(temporary, mission, matrices, quantity, scale)

    write_whole(path, write)
    return matrices


def write_timetable(
    instance_or_mission: Instance | Mission,
    path: str | os.PathLike[str],
    *,
    building: Building = lambda share: None,
) -> None:
    """Write every connection of every pair, completely or not at all.

    Parameters
    ----------
    instance_or_mission : Instance or Mission
        A :class:`Mission` brings its timetable along.
    path : path
        The suffix chooses the format: ``.parquet`` (extra ``[io]``), or an installed model such as
        ``.lp`` and ``.mps`` (extra ``[mip]``), see :mod:`.models`.
    building : callable
        Called with the share of the timetable that is built.

    Raises
    ------
    InputError
        Unknown suffix, a format that needs ready times, a model that would be too large, or a file
        that cannot be written.
    MissingExtra
        The package that writes the format is not installed.
    """
    suffix = suffix_of(path)
    if suffix not in whole_suffixes():
        raise InputError(
            f"{path}: a {suffix} file holds matrices at ready times; give at least one"
        )
    write_model = None
    if suffix == ".parquet":
        require_parquet()
    else:
        write_model = model_writer(suffix)
    check_writable(path)
    mission = _mission(instance_or_mission)
    if write_model is not None:
        refuse(mission.instance, MODEL_FILES)
    _build(mission, building)

    def write(temporary: Path) -> None:
        if write_model is None:
            write_parquet(temporary, mission)
        else:
            write_model(mission, temporary)

    write_whole(path, write)


def _build(mission: Mission, building: Building) -> None:
    """Build the timetable, if a mission has none."""

    def enough(share: float) -> bool:
        building(share)
        return False

    if not mission.has_timetable:
        mission.build(None, enough)


def _mission(instance_or_mission: Instance | Mission) -> Mission:
    if isinstance(instance_or_mission, Mission):
        return instance_or_mission
    return Mission(followed(instance_or_mission, TRANSFERS))
