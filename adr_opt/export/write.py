"""Write matrices in the format that the suffix of the file asks for."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..files import check_writable, write_whole
from ..instance import Instance
from ..mission import Mission
from ..timetable import FloatArray, Matrices
from . import netcdf, npz, tsp, vrp
from .weights import check_quantity, check_scale

SUFFIXES = (".npz", ".nc", ".tsp", ".vrp")
ONE_DEPARTURE = (".tsp", ".vrp")


def write_matrix(
    instance_or_mission: Instance | Mission,
    path: str | os.PathLike[str],
    departures: Sequence[float] | FloatArray,
    *,
    quantity: str = "delta_v",
    scale: float | None = None,
) -> Matrices:
    """Sample the timetable at ready times and write it, whole or not at all.

    Parameters
    ----------
    instance_or_mission : Instance or Mission
        A :class:`Mission` brings its timetable along.
    path : path
        The suffix chooses the format: ``.npz``, ``.nc`` (extra ``[io]``), ``.tsp`` or ``.vrp``.
    departures : sequence of float
        Times since the epoch at which the chaser is ready [s]; one for ``.tsp`` and ``.vrp``.
    quantity : {"delta_v", "duration"}
        What the weights of ``.tsp`` and ``.vrp`` are; the other formats hold both.
    scale : float, optional
        Weight of one m/s or one second in ``.tsp`` and ``.vrp``; by default the largest power of
        ten up to 1000 for which every weight fits into 31 bits.

    Returns
    -------
    Matrices
        What was written, before any scaling.

    Raises
    ------
    InputError
        Unknown suffix or quantity, a departure that is not a finite time ≥ 0, no departure, more
        than one where the format holds one, weights that do not fit, or a file that cannot be
        written.
    MissingExtra
        ``.nc`` without xarray and h5netcdf.
    """
    # What can be wrong with the call is asked before the timetable is built.
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: suffix {suffix!r} is unknown; use one of {', '.join(SUFFIXES)}")
    check_quantity(quantity)
    check_scale(scale)
    times = np.atleast_1d(np.asarray(departures, dtype=float))
    if times.size == 0:
        raise InputError("departures: there are none; give at least one ready time")
    if suffix in ONE_DEPARTURE and times.size > 1:
        raise InputError(
            f"{path}: a {suffix} file holds one departure, but {times.size} are given; "
            "give one, or write .npz or .nc"
        )
    if suffix == ".nc":
        netcdf.require()
    check_writable(path)

    if isinstance(instance_or_mission, Mission):
        mission = instance_or_mission
    else:
        mission = Mission(instance_or_mission)
    matrices = mission.timetable.matrices(times)

    def write(temporary: Path) -> None:
        if suffix == ".npz":
            npz.write(temporary, mission, matrices)
        elif suffix == ".nc":
            netcdf.write(temporary, mission, matrices)
        elif suffix == ".tsp":
            tsp.write(temporary, mission.instance, matrices, quantity, scale)
        else:
            vrp.write(temporary, mission, matrices, quantity, scale)

    write_whole(path, write)
    return matrices
