"""States between those of messages, for the judge: SciPy's polynomials through the nearest states.

Shares the reading of lines, labels of time, what they cover and names of objects with
:mod:`adr_opt.sources.ephemerides`, and neither its interpolation nor its turning of axes.
"""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

from ...problem.frame import Frame, FrameName
from ...problem.frame_rotation import from_gcrf, teme_axes
from ...sources.ephemerides.coverage import Coverage, Span
from ...sources.ephemerides.message_times import seconds_since

Array = npt.NDArray[np.float64]

NAMES: dict[str, FrameName] = {
    "EME2000": "EME2000",
    "J2000": "EME2000",
    "GCRF": "GCRF",
    "ICRF": "ICRF",
    "TEME": "TEME",
    "TEMEOFDATE": "TEME",
    "TEMEOFEPOCH": "TEME",
}
"""Frames by how messages call them, spaces apart."""


def interpolated_states(coverage: Coverage, times_s: Array, epoch: datetime, frame: Frame) -> Array:
    """States of a body at times, shape (times, 6) [m, m/s].

    Parameters
    ----------
    coverage : Coverage
        Of the messages of the body.
    times_s : (times,) float64
        Since the epoch [s].
    epoch, frame
        Of the instance.

    Raises
    ------
    InputError
        The messages do not cover a time.
    """
    found = np.empty((times_s.size, 6))
    for span, inside in coverage.within(times_s):
        found[inside] = _within(span, times_s[inside], epoch, frame)
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


def _within(span: Span, times_s: Array, epoch: datetime, frame: Frame) -> Array:
    """States of a span in a frame."""
    segment = span.segment
    system = segment.fields["TIME_SYSTEM"].upper()
    found = between(span.knots, span.states, times_s, *segment.method)
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
