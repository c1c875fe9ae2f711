"""Orbit Ephemeris Messages, written by other means than those of the product."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

TEME_OF_DATE = {"REF_FRAME": "TEME"}


def label(time: datetime) -> str:
    """A time to the microsecond."""
    return time.replace(tzinfo=None).isoformat(timespec="microseconds")


def oem(
    name: str,
    designator: str,
    epoch: datetime,
    states: Callable[[Array], Array],
    *,
    span_s: tuple[float, float] = (-3600.0, 0.0),
    step_s: float = 120.0,
    ahead_s: float = 0.0,
    **fields: str,
) -> str:
    """A message with one segment.

    Parameters
    ----------
    name, designator : str
    epoch : datetime
    states : callable
        Of times since the epoch, shape (times, 6) [m, m/s].
    span_s : (2,)
        First time, and the least last one.
    step_s : float
    ahead_s : float
        By how much the clock of the message is ahead of UTC.
    **fields : str
        Other metadata.
    """
    times = np.arange(span_s[0], span_s[1] + step_s, step_s)
    labels = [label(epoch + timedelta(seconds=float(time) + ahead_s)) for time in times]
    about = {
        "OBJECT_NAME": name,
        "OBJECT_ID": designator,
        "CENTER_NAME": "EARTH",
        "TIME_SYSTEM": "UTC",
        "START_TIME": labels[0],
        "STOP_TIME": labels[-1],
        "INTERPOLATION": "LAGRANGE",
        "INTERPOLATION_DEGREE": "7",
        **TEME_OF_DATE,
        **fields,
    }
    lines = ["CCSDS_OEM_VERS = 2.0", "CREATION_DATE = 2025-03-01T00:00:00", "ORIGINATOR = NOBODY"]
    lines += ["META_START", *(f"{key} = {value}" for key, value in about.items()), "META_STOP"]
    for at, row in zip(labels, states(times), strict=True):
        lines.append(" ".join([at, *(f"{number / 1e3:.9f}" for number in row)]))
    return "\n".join(lines) + "\n"


def oem_in_xml(text: str) -> str:
    """The segments of a message in lines, as XML; a state on each line, as there."""
    tags = ("EPOCH", "X", "Y", "Z", "X_DOT", "Y_DOT", "Z_DOT")
    out, is_metadata = '<?xml version="1.0"?>\n<oem version="2.0"><header/><body>', False
    for line in text.splitlines()[3:]:
        if line == "META_START":
            out += "</data></segment>" if "<segment>" in out else ""
            out += "\n<segment><metadata>"
            is_metadata = True
        elif line == "META_STOP":
            out += "</metadata><data>"
            is_metadata = False
        elif is_metadata:
            key, _, value = line.partition(" = ")
            out += f"<{key}>{value}</{key}>"
        else:
            leaves = zip(tags, line.split(), strict=True)
            row = "".join(f"<{tag}>{value}</{tag}>" for tag, value in leaves)
            out += f"\n<stateVector>{row}</stateVector>"
    return f"{out}</data></segment></body></oem>\n"
