"""States between those of messages, for the judge: SciPy's polynomials through the nearest states.

Shares the reading of lines, labels of time and names of objects with
:mod:`adr_opt.sources.ephemerides`, and neither its interpolation nor its turning of axes.
"""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime, timedelta

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

from ...common.errors import InputError
from ...problem.frame import Frame, FrameName
from ...problem.frame_rotation import from_gcrf, teme_axes
from ...sources.ephemerides.message_times import seconds_since
from ...sources.ephemerides.oem_segment import MessageSegment

Array = npt.NDArray[np.float64]

WITHIN_S = 1e-6
"""Times this close to the ends of a segment are within it: labels have microseconds [s]."""

NAMES: dict[str, FrameName] = {
    "EME2000": "EME2000", "J2000": "EME2000", "GCRF": "GCRF", "ICRF": "ICRF", "TEME": "TEME",
    "TEMEOFDATE": "TEME", "TEMEOFEPOCH": "TEME",
}  # fmt: skip
"""Frames by how messages call them, spaces apart."""


def interpolated_states(
    segments: Iterable[MessageSegment], times_s: Array, epoch: datetime, frame: Frame
) -> Array:
    """States of a body at times, shape (times, 6) [m, m/s].

    Parameters
    ----------
    segments : iterable of MessageSegment
        All of the body.
    times_s : (times,) float64
        Since the epoch [s].
    epoch, frame
        Of the instance.

    Raises
    ------
    InputError
        No segment covers a time.
    """
    found = np.full((times_s.size, 6), np.nan)
    for segment in segments:
        ends = [
            segment.fields.get(f"USEABLE_{end}_TIME", segment.fields[f"{end}_TIME"])
            for end in ("START", "STOP")
        ]
        begin, end = seconds_since(epoch, ends, segment.fields["TIME_SYSTEM"].upper(), "")
        within = (times_s >= begin - WITHIN_S) & (times_s <= end + WITHIN_S)
        if within.any():
            found[within] = _within(segment, times_s[within], epoch, frame)
    if np.isnan(found).any():
        raise InputError("the messages do not cover the plan; refine it again")
    return found


def between(knots: Array, states: Array, times_s: Array, method: str, degree: int) -> Array:
    """States by the polynomial of a degree through the nearest states of a table, (times, 6)."""
    if method == "LINEAR":
        degree = 1
    count = (degree + 2) // 2 if method == "HERMITE" else degree + 1
    count = min(max(count, 2), knots.size)
    middles = np.convolve(knots, np.full(count, 1.0 / count), "valid")
    # Of two windows as near, the later one; a knot belongs to the interval after it.
    chosen = np.searchsorted(0.5 * (middles[1:] + middles[:-1]), times_s, side="right")
    found = np.empty((times_s.size, 6))
    for first in np.unique(chosen):
        at = chosen == first
        there, table = knots[first : first + count], states[first : first + count]
        centre, half = 0.5 * (there[0] + there[-1]), 0.5 * (there[-1] - there[0])
        x, asked = (there - centre) / half, (times_s[at] - centre) / half
        if method == "HERMITE":
            values = np.stack((table[:, :3], table[:, 3:] * half), axis=1).reshape(-1, 3)
            polynomial = KroghInterpolator(np.repeat(x, 2), values)
            found[at, :3], found[at, 3:] = polynomial(asked), polynomial.derivative(asked) / half
        else:
            found[at] = BarycentricInterpolator(x, table)(asked)
    return found


def _within(segment: MessageSegment, times_s: Array, epoch: datetime, frame: Frame) -> Array:
    """States of a segment in a frame."""
    system = segment.fields["TIME_SYSTEM"].upper()
    labels, states = segment.states()
    found = between(seconds_since(epoch, labels, system, ""), states, times_s, *segment.method)
    name = NAMES[segment.fields["REF_FRAME"].upper().replace(" ", "")]
    of_epoch = segment.fields.get("REF_FRAME_EPOCH")
    if name != "TEME":
        turns = from_gcrf(frame) @ from_gcrf(Frame(name=name)).T
    elif of_epoch is not None:
        (since,) = seconds_since(epoch, [of_epoch], system, "")
        (axes,) = teme_axes([epoch + timedelta(seconds=float(since))])
        turns = from_gcrf(frame) @ axes.T
    else:
        dates = [epoch + timedelta(seconds=time_s) for time_s in times_s.tolist()]
        turns = from_gcrf(frame) @ np.swapaxes(teme_axes(dates), 1, 2)
    turned: Array = np.einsum("...ij,...kj->...ki", turns, found.reshape(-1, 2, 3)).reshape(-1, 6)
    return turned
