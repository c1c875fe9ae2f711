"""States of bodies from ephemerides, read for the judge.

Element sets are run by the ``sgp4`` package as their OMM says, without the records and tables of
:mod:`adr_opt.sources`, and turned by the axes of each date. States between those of messages are on
SciPy's polynomials through the nearest ones. Reading lines, labels of time, what they cover and
names of objects is shared with :mod:`adr_opt.sources.ephemerides`; neither its interpolation nor
its turning of axes is.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BarycentricInterpolator, KroghInterpolator

from ...common.constants import DAY_S
from ...common.errors import InputError, MissingExtra
from ...common.json_text import loaded
from ...plan.refined_plan import EphemeridesReference
from ...problem.frame import Frame, FrameName
from ...problem.frame_rotation import from_gcrf, teme_axes
from ...problem.instance import Instance
from ...sources.ephemerides.coverage import Coverage, Span
from ...sources.ephemerides.message_times import seconds_since
from ...sources.ephemerides.oem import read_oem
from ...sources.ephemerides.oem_segment import MessageSegment
from ...sources.ephemerides.of_instance import by_body

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
"""Frames by their names in messages, spaces removed."""


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
        x, wanted = (there - centre) / half, (times_s[at] - centre) / half
        if method == "HERMITE":
            values = np.stack((table[:, :3], table[:, 3:] * half), axis=1).reshape(-1, 3)
            polynomial = KroghInterpolator(np.repeat(x, 2), values)
            found[at, :3], found[at, 3:] = polynomial(wanted), polynomial.derivative(wanted) / half
        else:
            found[at] = BarycentricInterpolator(x, table)(wanted)
    return found


def _within(span: Span, times_s: Array, epoch: datetime, frame: Frame) -> Array:
    """States of a span of an ephemeris, converted to a frame."""
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


class ReportedStates:
    """States of the bodies of an instance that have an ephemeris.

    Parameters
    ----------
    instance : Instance
    onto : EphemeridesReference
        Those that a plan was refined onto.

    Raises
    ------
    InputError
        They are not those of the instance, or cannot be read.
    MissingExtra
        sgp4 or astropy is not installed.
    """

    def __init__(self, instance: Instance, onto: EphemeridesReference) -> None:
        its = instance.ephemerides
        if its is None or (its.kind, its.sha256) != (onto.kind, onto.sha256):
            raise InputError(
                f"the plan was refined onto ephemerides (sha256 {onto.sha256[:12]}…) that are not "
                f"those of {instance.name!r}; refine it again"
            )
        self._instance, self._elements = instance, dict[str, dict[str, Any]]()
        self._segments: dict[str, list[MessageSegment]] = {}
        self._covered: dict[str, Coverage] = {}
        contents = its.contents(instance.folder())
        if onto.kind == "oem":
            every = [one for name, content in contents.items() for one in read_oem(content, name)]
            listed = {station.name: station.object_id for station in instance.stations}
            listed |= {target.name: target.object_id for target in instance.targets}
            self._segments = by_body(every, listed)
        else:
            for content in contents.values():
                self._elements |= loaded(content)["bodies"]
        self.bodies = tuple(self._segments or self._elements)

    def state(self, body: str, time_s: float) -> Array:
        """State of a body by its ephemeris, in the frame of the instance, shape (6,) [m, m/s]."""
        found: Array = self.states(body, np.array([time_s]))[0]
        return found

    def states(self, body: str, times_s: Array) -> Array:
        """States of a body at times by its ephemeris, shape (times, 6) [m, m/s].

        Raises
        ------
        InputError
            The ephemeris does not reach as far.
        """
        instance = self._instance
        assert instance.frame is not None  # ephemerides require it
        if self._segments:
            if body not in self._covered:
                self._covered[body] = Coverage(body, self._segments[body], instance.epoch)
            return interpolated_states(self._covered[body], times_s, instance.epoch, instance.frame)
        try:
            from sgp4 import omm
            from sgp4.api import Satrec
            from sgp4.conveniences import jday_datetime
        except ImportError:
            raise MissingExtra("flying onto element sets", "sgp4", "astro") from None
        satellite = Satrec()
        omm.initialize(satellite, self._elements[body])
        day, fraction = jday_datetime(instance.epoch)
        fractions = fraction + times_s / DAY_S
        codes, *vectors = satellite.sgp4_array(np.full(times_s.size, day), fractions)
        if codes.any():
            raise InputError(f"{body!r}: SGP4 error {codes.max()}; refine the plan again")
        dates = [instance.epoch + timedelta(seconds=time_s) for time_s in times_s.tolist()]
        turns = from_gcrf(instance.frame) @ np.swapaxes(teme_axes(dates), 1, 2)
        turned = [np.einsum("tij,tj->ti", turns, vector) for vector in vectors]
        return 1e3 * np.column_stack(turned)
