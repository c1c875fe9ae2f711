"""All approaches of catalogued objects to a refined plan, by a sieve that misses none.

Objects move by SGP4. Those whose shell between perigee and apogee does not meet the chaser's on a
day are left out of it. The others are looked at each minute: between two samples the distance has a
least value where its rate changes sign, since two orbits about the Earth turn towards and away from
each other twice a revolution; ends of arcs, and so burns, are looked at as well. What could come
near enough is then found by bisection of the rate.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...common.errors import InputError
from ...fly.refine.lessons import Unsafe
from ...judge.admit import AnyRefined, admit
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...sources.catalogue.propagation import satellite_of
from ...sources.catalogue.records import ElementSet
from .flown import Array, FlownArc, flown_arcs
from .position_errors import PositionErrors, errors_of, orbital_axes
from .probability import collision_probability

DISTANCE_M = 5_000.0
"""Distance within which approaches are reported by default."""

SAMPLE_S = 60.0
"""Largest time between samples of the sieve."""

WOBBLE_M = 40_000.0
"""Largest excursion of an SGP4 radius from the shell of its mean elements [m]."""

TIDE_1_S2 = 3e-6
"""Bound on the relative acceleration of two objects in low orbit, for each metre between them."""

SAGITTA_M = 5_000.0
"""Largest excursion of a radius between samples a minute apart, up to eccentricity 0.1 [m]."""

CHUNK = 200
"""Number of objects propagated at once: 70 MB for a day."""

NEAR_S = 0.5
"""Spacing of the positions from which a least distance is interpolated [s]."""

PRECISION_S = 1e-4
"""Precision of the times of least distance [s]."""

SHORT_M_S = 100.0
"""Relative speed above which an encounter counts as short: relative motion is straight."""


@dataclass(frozen=True)
class CloseApproach:
    """A least distance between a chaser and an object.

    Attributes
    ----------
    time_s : float
        Since the epoch of the instance [s].
    epoch : str
        The same in UTC.
    chaser : str
    leg : int
        Number of the leg.
    phase : str
        What the chaser does.
    object : str
        As the catalogue names it.
    object_id : str or None
        Its international designator.
    own : bool
        Whether it is the body that the leg leaves or leads to.
    miss_m : float
        Distance [m].
    radial_m, along_m, cross_m : float
        Of the object from the chaser: upwards, ahead, and along the chaser's angular momentum [m].
    speed_m_s : float
        Of the one against the other [m/s].
    age_days : float
        Of the elements at that time.
    probability : float or None
        Of a collision; None where the errors of one are not known, or the encounter is not short.
    states : (2, 6) tuple of float
        Of the chaser and of the object in TEME of date, which tables leave out [m, m/s].
    """

    time_s: float
    epoch: str
    chaser: str
    leg: int
    phase: str
    object: str
    object_id: str | None
    own: bool
    miss_m: float
    radial_m: float
    along_m: float
    cross_m: float
    speed_m_s: float
    age_days: float
    probability: float | None
    states: tuple[tuple[float, ...], tuple[float, ...]]

    def to_dict(self) -> dict[str, Any]:
        """The approach as JSON data."""
        content = asdict(self)
        del content["states"]
        return content


class _Objects:
    """Objects of a catalogue, moved by SGP4 from an epoch on."""

    def __init__(self, records: Sequence[ElementSet], epoch: datetime, span_s: float) -> None:
        from sgp4 import api

        self.records, self._array = records, api.SatrecArray
        self._satellites = [satellite_of(record) for record in records]
        now = epoch.astimezone(UTC)
        seconds = now.second + 1e-6 * now.microsecond
        self._day, self._start = api.jday(*now.timetuple()[:5], seconds)
        self.shells = np.array([self._shell(row, span_s) for row in range(len(records))])

    def _shell(self, row: int, span_s: float) -> tuple[float, float]:
        """Least and largest radius of the mean orbit in a span [m]; of a decayed one, all."""
        satellite, radii = self._satellites[row], list[float]()
        for share in (0.0, 0.5, 1.0):
            code, *_ = satellite.sgp4(self._day, self._start + share * span_s / DAY_S)
            if code:
                return 0.0, math.inf
            axis = satellite.am * EARTH_RADIUS_M
            radii += [axis * (1.0 - satellite.em), axis * (1.0 + satellite.em)]
        return min(radii) - WOBBLE_M, max(radii) + WOBBLE_M

    def states(self, rows: npt.NDArray[np.intp], times_s: Array) -> Array:
        """States of some objects, shape (objects, times, 6); NaN where SGP4 fails."""
        array = self._array([self._satellites[row] for row in rows])
        fractions = self._start + times_s / DAY_S
        codes, positions, velocities = array.sgp4(np.full(times_s.size, self._day), fractions)
        found: Array = 1e3 * np.concatenate([positions, velocities], axis=2)
        found[codes != 0] = np.nan
        return found

    def state(self, row: int, time_s: float) -> Array:
        """State of one object."""
        code, position, velocity = self._satellites[row].sgp4(
            self._day, self._start + time_s / DAY_S
        )
        return 1e3 * np.array([*position, *velocity]) if code == 0 else np.full(6, np.nan)


def screen(
    instance: Instance,
    refined: AnyRefined,
    records: Sequence[ElementSet],
    *,
    distance_m: float = DISTANCE_M,
    errors: Mapping[str, PositionErrors] | None = None,
) -> tuple[CloseApproach, ...]:
    """All approaches of some objects to a refined plan, by time.

    Parameters
    ----------
    instance : Instance
        With a frame, which defines the axes of the plan.
    refined : RefinedPlan or Admitted
    records : sequence of ElementSet
    distance_m : float
        Least distances up to this are reported [m].
    errors : dict of str to PositionErrors, optional
        Of chasers and objects by name, objects also by international designator, and ``*`` for all
        others: probabilities of collision follow from them.

    Returns
    -------
    tuple of CloseApproach

    Raises
    ------
    InputError
        The refined plan belongs to another instance or has violations, there is no frame, or the
        distance is not positive.
    MissingExtra
        sgp4 or astropy is not installed.
    """
    return Screening(instance, records, distance_m, errors or {}).approaches(refined)


class Screening:
    """Approaches to refined plans of one instance; arcs that were screened are remembered.

    The parameters are those of :func:`screen`.
    """

    def __init__(
        self,
        instance: Instance,
        records: Sequence[ElementSet],
        distance_m: float,
        errors: Mapping[str, PositionErrors],
    ) -> None:
        if not 0.0 < distance_m < math.inf:
            raise InputError(f"distance_m = {distance_m:g}: must be a positive number of metres")
        self._instance, self._distance_m, self._errors = instance, distance_m, errors
        self._records, self._span_s = records, instance.mission.duration_s
        self._objects = _Objects(records, instance.epoch, self._span_s)
        self._known: dict[bytes, list[tuple[int, float]]] = {}

    def approaches(self, refined: AnyRefined) -> tuple[CloseApproach, ...]:
        """All approaches to a refined plan, by time."""
        instance, found = self._instance, list[CloseApproach]()
        ids = {each.name: each.object_id for each in instance.stations}
        ids |= {each.name: each.object_id for each in instance.targets}
        admitted = admit(instance, refined)
        arcs = [arc for arc in flown_arcs(admitted.instance, admitted.plan) if arc.times_s.size > 1]
        ends_s = max((float(arc.times_s[-1]) for arc in arcs), default=0.0)
        if ends_s > self._span_s:  # objects are known to be within their shells up to there alone
            self._span_s = ends_s
            self._objects = _Objects(self._records, instance.epoch, ends_s)
        objects = self._objects
        for arc in arcs:
            content = arc.times_s.tobytes() + arc.states.tobytes()
            key = hashlib.sha256(content).digest()
            if key not in self._known:
                self._known[key] = list(_meetings(objects, arc, self._distance_m))
            found += [
                _approach(instance, objects, arc, row, time_s, ids, self._errors)
                for row, time_s in self._known[key]
            ]
        return tuple(sorted(found, key=lambda each: (each.time_s, each.object)))


def _meetings(objects: _Objects, arc: FlownArc, distance_m: float) -> Iterator[tuple[int, float]]:
    """Numbers of objects, and times of least distances below a limit."""
    if objects.records:
        begin, end = float(arc.times_s[0]), float(arc.times_s[-1])
        pieces = max(1, math.ceil((end - begin) / DAY_S))
        cuts = np.linspace(begin, end, pieces + 1)
        for number, (first, last) in enumerate(pairwise(cuts.tolist())):
            is_open = number == 0, number == pieces - 1
            samples = max(2, math.ceil((last - first) / SAMPLE_S) + 1)
            times = np.linspace(first, last, samples)
            mine = arc.at(times)
            radii = np.linalg.norm(mine[:, :3], axis=1)
            reach = distance_m + SAGITTA_M
            low, high = radii.min() - reach, radii.max() + reach
            meeting = np.flatnonzero((objects.shells[:, 0] < high) & (objects.shells[:, 1] > low))
            for at in range(0, meeting.size, CHUNK):
                rows = meeting[at : at + CHUNK]
                for one, sample in _possible(
                    objects.states(rows, times) - mine, times, distance_m, is_open
                ):
                    row = int(rows[one])
                    span = float(times[sample]), float(times[sample + 1])
                    time_s, miss_m = _least(objects, arc, row, span)
                    # An end is a least distance only where an arc ends, or it is another piece's.
                    inner = (is_open[0] or time_s > first) and (is_open[1] or time_s < last)
                    if miss_m <= distance_m and inner:
                        yield row, time_s


def _possible(
    apart: Array, times: Array, distance_m: float, is_open: tuple[bool, bool]
) -> npt.NDArray[np.intp]:
    """Objects and samples after which a least distance may be within a limit, shape (n, 2)."""
    positions, rates = apart[..., :3], apart[..., 3:]
    closing = np.sum(positions * rates, axis=2)
    distances, speeds = np.linalg.norm(positions, axis=2), np.linalg.norm(rates, axis=2)
    comes, goes = closing[:, :-1] <= 0.0, closing[:, 1:] >= 0.0
    least = comes & goes
    if is_open[0]:
        least[:, 0] |= goes[:, 0]
    if is_open[1]:
        least[:, -1] |= comes[:, -1]
    # Straight lines miss by so much; what bends them is the difference of two pulls of the Earth.
    step = float(times[1] - times[0])
    missed = np.sqrt(np.maximum(distances**2 - (closing / np.maximum(speeds, 1e-6)) ** 2, 0.0))
    bent = 0.5 * TIDE_1_S2 * np.maximum(distances[:, :-1], distances[:, 1:]) * step**2
    near = np.maximum(missed[:, :-1], missed[:, 1:]) - bent <= distance_m
    # At the ends of an arc the distance itself counts.
    near[:, 0] |= is_open[0] & (distances[:, 0] <= distance_m)
    near[:, -1] |= is_open[1] & (distances[:, -1] <= distance_m)
    return np.argwhere(least & near)


def _least(
    objects: _Objects, arc: FlownArc, row: int, span_s: tuple[float, float]
) -> tuple[float, float]:
    """Time and value of the least distance in a span where its rate changes sign at most once."""

    def apart(time_s: float) -> Array:
        state: Array = objects.state(row, time_s) - arc.at(np.array([time_s]))[0]
        return state

    low, high = span_s
    one, other = apart(low), apart(high)
    if one[:3] @ one[3:] > 0.0:
        high = low
    elif other[:3] @ other[3:] < 0.0:
        low = high
    while high - low > PRECISION_S:
        middle = 0.5 * (low + high)
        now = apart(middle)
        low, high = (middle, high) if now[:3] @ now[3:] < 0.0 else (low, middle)
    time_s = 0.5 * (low + high)
    if span_s[0] + NEAR_S < time_s < span_s[1] - NEAR_S:
        # The velocities of SGP4 are not quite the derivatives of its positions, which count.
        squares = [float(np.sum(apart(time_s + by)[:3] ** 2)) for by in (-NEAR_S, 0.0, NEAR_S)]
        bend = squares[0] - 2.0 * squares[1] + squares[2]
        if bend > 0.0:
            shift_s = 0.5 * NEAR_S * (squares[0] - squares[2]) / bend
            time_s += min(max(shift_s, -NEAR_S), NEAR_S)
    return time_s, float(np.linalg.norm(apart(time_s)[:3]))


def _approach(
    instance: Instance,
    objects: _Objects,
    arc: FlownArc,
    row: int,
    time_s: float,
    ids: dict[str, str | None],
    errors: Mapping[str, PositionErrors],
) -> CloseApproach:
    record, mine = objects.records[row], arc.at(np.array([time_s]))[0]
    its = objects.state(row, time_s)
    apart = its - mine
    radial_m, along_m, cross_m = (orbital_axes(mine) @ apart[:3]).tolist()
    speed_m_s = float(np.linalg.norm(apart[3:]))
    known_of = errors_of(errors, arc.chaser), errors_of(errors, record.label, record.designator)
    probability = None
    if known_of[0] and known_of[1] and speed_m_s >= SHORT_M_S:
        covariance = known_of[0].turned(mine) + known_of[1].turned(its)
        radius_m = known_of[0].radius_m + known_of[1].radius_m
        probability = collision_probability(apart[:3], apart[3:], covariance, radius_m)
    now = instance.epoch + timedelta(seconds=time_s)
    known = {ids.get(body) for body in arc.beside} - {None}
    return CloseApproach(
        time_s=time_s,
        epoch=now.isoformat(timespec="milliseconds").replace("+00:00", "Z"),
        chaser=arc.chaser,
        leg=arc.leg,
        phase=arc.phase,
        object=record.label,
        object_id=record.designator,
        own=record.designator in known or record.label in arc.beside,
        miss_m=float(np.linalg.norm(apart[:3])),
        radial_m=radial_m,
        along_m=along_m,
        cross_m=cross_m,
        speed_m_s=speed_m_s,
        age_days=(now - record.epoch).total_seconds() / DAY_S,
        probability=probability,
        states=(tuple(mine.tolist()), tuple(its.tolist())),
    )


def approaches_csv(approaches: Iterable[CloseApproach]) -> str:
    """Approaches as the text of a CSV file, a row for each."""
    text = io.StringIO()
    columns = [each.name for each in fields(CloseApproach) if each.name != "states"]
    rows = csv.DictWriter(text, columns, lineterminator="\n")
    rows.writeheader()
    rows.writerows(each.to_dict() for each in approaches)
    return text.getvalue()


AVOID_M = 1_000.0
"""Miss within which an approach is avoided by default."""


def avoiding(
    instance: Instance,
    records: Sequence[ElementSet],
    *,
    avoid_m: float = AVOID_M,
    most_probability: float = math.inf,
    errors: Mapping[str, PositionErrors] | None = None,
    within_m: float = DISTANCE_M,
) -> Callable[[RefinedPlan], tuple[Unsafe, ...]]:
    """Close approaches of catalogued objects, for :func:`adr_opt.solve_refined` to avoid.

    Parameters
    ----------
    instance : Instance
        With a frame.
    records : sequence of ElementSet
    avoid_m : float
        Misses up to this are avoided, except those of visited bodies [m].
    most_probability : float
        Probability of a collision from which an approach is avoided whatever its miss.
    errors : dict of str to PositionErrors, optional
        As of :func:`.screen`.
    within_m : float
        Largest miss for which probabilities are computed [m].

    Raises
    ------
    InputError
        There is no frame, the distance is not positive, or a probability is given without errors.
    """
    if instance.frame is None:
        raise InputError(f"{instance.name!r} has no frame; make it with import")
    if math.isfinite(most_probability) and not errors:
        raise InputError("a probability of collision needs position errors; give them")
    asked_m = max(avoid_m, within_m) if errors else avoid_m
    screening = Screening(instance, records, asked_m, errors or {})

    def unsafe(refined: RefinedPlan) -> tuple[Unsafe, ...]:
        return tuple(
            Unsafe(
                each.leg,
                each.time_s,
                f"leg {each.leg} ({each.phase}) passes {each.object!r} by {each.miss_m:.0f} m at "
                f"{each.epoch}",
            )
            for each in screening.approaches(refined)
            if not each.own
            and (each.miss_m <= avoid_m or (each.probability or 0.0) >= most_probability)
        )

    return unsafe
