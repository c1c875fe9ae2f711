"""Legs visible to a policy from a chaser's position, computed on demand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S, SLACK_S
from ...kernels.core.windows import service_ends
from ...kernels.episodes.choice_rows import look_ahead, note_all_onward, write_rows
from ...kernels.episodes.choices import (
    CERTAIN,
    CHOICE_FIELDS,
    LOOKED_AHEAD,
    M_S_PER_HOUR,
    MISSION_FIELDS,
    ONWARD,
    Choices,
    Standing,
)
from ...kernels.episodes.worlds import OBSERVED
from ...kernels.legs import found as families
from ...kernels.orbits.ephemeris import ORBIT_COLUMNS
from ...kernels.rules.loads import after_service
from ...kernels.tables.on_demand import Source, at_regular_events, shortest_sortie
from ...kernels.tables.timetable import from_source
from ...learning.episodes.near_orbits import NearOrbits
from ...learning.episodes.worlds import leg_row, stay_row
from ...legs.connection_finder import ConnectionFinder
from ...legs.families.ends import is_regular
from ...plan.leg_kinds import LAUNCH, SHORT
from ...plan.tows import any_from_apogee
from ...problem.uncertainty import Uncertainty
from .flying_chasers import FlyingChaser, full_of
from .mission_facts import MATCH_S, Hop, MissionFacts, hop_of
from .service_delays import largest_delays_s, mean_delays_s

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

RANKS = 64
"""Number of nearest open targets to which legs are computed; required ones are always added."""

KEPT = 24
"""Number of those bodies that a policy sees: stations, planned and required ones first, then the
cheapest to reach."""

MATCH_M_S = 1e-3
"""Tolerance of costs when a connection computed on demand is matched with those of a pair."""

LATE = 0.9
"""Quantile of service times, and chance of captures, at which a way to refuel is kept."""


STAY = len(OBSERVED)
"""Number of columns of :attr:`Choices.stay`."""


class Seen(NamedTuple):
    """Legs from which a chaser may choose, with their features for the policy.

    Attributes
    ----------
    bodies : (legs,) int64
        Where they lead.
    delta_v, arrival : (legs,) float64
        [m/s], [s].
    legal : (legs,) bool
    moves : (1, legs, len(CHOICE_FIELDS)) float32
    mission : (1, len(MISSION_FIELDS)) float32
    """

    bodies: IntArray
    delta_v: FloatArray
    arrival: FloatArray
    legal: BoolArray
    moves: npt.NDArray[np.float32]
    mission: npt.NDArray[np.float32]


class VisibleLegs:
    """Legs from a body at a time with mean outcomes, shared by rehearsals.

    Where all legs between bodies are short, connections are computed on demand, as those of large
    fields are by planners; otherwise they come from the lists of the pairs of the body.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty

    Attributes
    ----------
    required : (bodies,) bool
    later_s : (bodies,) float64
        By how much later than planned services end on average [s].
    late_s : (bodies,) float64
        By how much later than planned services may well end (:data:`LATE`) [s].
    """

    def __init__(self, facts: MissionFacts, uncertainty: Uncertainty) -> None:
        self._facts, self._model = facts, uncertainty.of(facts.instance)
        instance = facts.instance
        bodies = len(facts.names)
        self._around = NearOrbits(instance)
        self._orbits = np.zeros((bodies, len(ORBIT_COLUMNS)))
        if instance.has_orbits:
            self._orbits = np.nan_to_num(instance.orbits())
        worths = np.array([facts.prizes.get(j, 0.0) for j in range(bodies)])
        positive = worths > 0.0
        self._worths = worths / (worths[positive].mean() if positive.any() else 1.0)
        self.required = np.array([j in facts.required for j in range(bodies)])
        self.later_s = mean_delays_s(facts, uncertainty)
        self.late_s = largest_delays_s(facts, uncertainty, LATE)
        self._towed = np.array([j in facts.tow_s for j in range(bodies)])
        self._tows = bool(self._towed.any())
        self._stations = np.arange(facts.stations)
        self._targets = np.arange(facts.first_target, bodies)
        self._sources: dict[tuple[int, bool], Source | None] = {}
        self._sorties: dict[int, float] = {}
        self._what_may_come = np.zeros((bodies, STAY + len(CERTAIN)))
        self._is_known = np.zeros(bodies, dtype=np.bool_)

    def seen(
        self, craft: FlyingChaser, closed: set[int], planned: list[int], own: Hop | None
    ) -> Seen:
        """The legs from which a chaser may choose, with their features for the policy.

        Parameters
        ----------
        craft : FlyingChaser
        closed : set of int
            Targets that are done, or on the way to which a chaser is.
        planned : list of int
            Bodies to which the rest of its plan leads, in order.
        own : Hop or None
            The planned leg, in place of the connection chosen now to the same body.
        """
        facts, what = self._facts, self._facts.chasers[craft.chaser]
        limits, here = what.limits, craft.body
        bodies = self._candidates(craft, closed, planned)
        delta_v, arrival = self._rows(craft, bodies)
        is_first = (bodies < facts.stations) | self.required[bodies] | np.isin(bodies, planned[:2])
        if own is not None:
            at = bodies == own.destination
            delta_v[at], arrival[at] = own.delta_v, own.arrival
            is_first |= at
        if bodies.size > KEPT:
            few = max(KEPT, int(np.count_nonzero(is_first)))
            dear = np.where(is_first, -np.inf, arrival / HOUR_S + delta_v / M_S_PER_HOUR)
            kept = np.sort(np.argpartition(dear, few - 1)[:few])
            bodies, delta_v, arrival = bodies[kept], delta_v[kept], arrival[kept]
        end = service_ends(limits.windows, bodies, arrival, limits.service[bodies])
        station = bodies < facts.stations
        legal = end <= limits.duration
        legal &= (delta_v <= craft.left) & (~station | (craft.since > 0))
        full = full_of(what, craft.kits)
        left = np.where(station, full, craft.left - delta_v)
        left[bodies == here] = -np.inf
        if what.most_targets is not None and craft.serviced >= what.most_targets:
            legal &= station
        if what.loads is not None:
            for leg in np.flatnonzero(legal & ~station).tolist():
                left[leg], kits = after_service(what.loads, int(bodies[leg]), craft.kits, left[leg])
                legal[leg] = kits >= 0 and left[leg] >= 0.0
        coming = self._coming(bodies)
        choices = Choices(
            bodies,
            station,
            (~station | (craft.since > 0)) & (bodies != here),
            legal,
            delta_v,
            end,
            left,
            np.zeros(bodies.size),
            end.copy(),
            np.full((bodies.size, 4), np.inf),
            np.empty(bodies.size),
            self._worths[bodies],
            np.ascontiguousarray(coming[:, :STAY]),
            np.ascontiguousarray(coming[:, STAY:]),
        )
        self._look_back(craft, choices)
        self._look_ahead(craft, closed, choices)
        home = self._orbits[0 if facts.stations else what.start]
        docked = here < facts.stations
        standing = Standing(
            float(craft.free_s),
            float(limits.duration),
            float(craft.left),
            float(full),
            int(craft.since),
            docked,
            self._orbits[here],
            home,
        )
        moves = np.zeros((1, bodies.size, len(CHOICE_FIELDS)), dtype=np.float32)
        mission = np.zeros((1, len(MISSION_FIELDS)), dtype=np.float32)
        places = np.arange(bodies.size)
        write_rows(standing, choices, bodies.size, self._orbits, places, moves[0], mission[0])
        return Seen(bodies, delta_v, arrival, legal, moves, mission)

    def _look_back(self, craft: FlyingChaser, choices: Choices) -> None:
        """Write the ways back to stations from the destinations of choices."""
        facts, limits = self._facts, self._facts.chasers[craft.chaser].limits
        if not facts.stations:
            return
        legal = np.flatnonzero((choices.end <= limits.duration) & ~choices.station)
        source = None if self._tows else self._source(craft.chaser, False)
        bodies, ready = choices.bodies[legal], choices.end[legal]
        back, ends, delta_v, arrival = np.full((4, legal.size), np.inf)
        for s in self._stations.tolist():
            if source is not None:
                there = np.full(legal.size, s)
                from_source(source, bodies, ready, there, delta_v, arrival)
            else:
                delta_v[:] = arrival[:] = np.inf
                for at, (j, since_s) in enumerate(
                    zip(bodies.tolist(), ready.tolist(), strict=True)
                ):
                    hop = facts.best(j, s, since_s, towed=bool(self._towed[j]))
                    if hop is not None:
                        delta_v[at], arrival[at] = hop.delta_v, hop.arrival
            nearer = delta_v < back
            back[nearer] = delta_v[nearer]
            ends[nearer] = arrival[nearer] + limits.service[s]
        choices.back[legal], choices.back_end[legal] = back, ends

    def _look_ahead(self, craft: FlyingChaser, closed: set[int], choices: Choices) -> None:
        """Write the moves after the cheapest ones; none where connections are listed."""
        facts, limits = self._facts, self._facts.chasers[craft.chaser].limits
        is_open = np.zeros(len(facts.names), dtype=np.bool_)
        is_open[self._targets] = True
        is_open[list(closed)] = False
        is_open[craft.body] = False
        near = self._around.at(craft.free_s).neighbours_of(choices.bodies)
        there = np.empty((LOOKED_AHEAD, 1 + ONWARD), dtype=np.int64)
        look_ahead(choices, near, is_open, float(craft.free_s), choices.bodies.size, there)
        at, column = np.nonzero(there[:, 1:] >= 0)
        leaving, onward = there[at, 0], there[at, 1 + column]
        origins, ready = choices.bodies[leaving], choices.end[leaving]
        delta_v, end = np.full((2, LOOKED_AHEAD, ONWARD), np.inf)
        for is_towed in (False, True) if self._tows else (False,):
            source = self._source(craft.chaser, is_towed)
            if source is None:
                return
            those = np.flatnonzero(self._towed[origins] == is_towed) if self._tows else slice(None)
            pairs = origins[those], ready[those], onward[those]
            needed, arrival = np.empty((2, pairs[0].size))
            from_source(source, *pairs, needed, arrival)
            delta_v[at[those], column[those]] = needed
            end[at[those], column[those]] = arrival + limits.service[pairs[2]]
        note_all_onward(choices, there, delta_v, end, float(limits.duration))

    def _coming(self, bodies: IntArray) -> FloatArray:
        """Distributions for going to bodies: stay and factor of :class:`Choices`, side by side."""
        facts = self._facts
        for body in bodies[~self._is_known[bodies]].tolist():
            name = None if body < facts.stations else facts.names[body]
            planned_s = float(facts.chasers[0].limits.service[body]) - facts.tow_s.get(body, 0.0)
            row = self._what_may_come[body]
            row[:STAY] = np.array(stay_row(self._model, name, planned_s))[list(OBSERVED)]
            row[STAY:] = leg_row(self._model.factor_of(SHORT.name, name))
        self._is_known[bodies] = True
        return self._what_may_come[bodies]

    def way_back_m_s(self, craft: FlyingChaser, body: int, free_s: float) -> float:
        """Least ΔV from a body to a station; 0 if nothing could be serviced after refuelling there.

        +inf where no station can be reached in time.
        """
        facts, limits = self._facts, self._facts.chasers[craft.chaser].limits
        there = FlyingChaser(craft.chaser, body, bool(self._towed[body]), free_s, 0.0, craft.kits)
        delta_v, arrival = self._rows(there, self._stations)
        ends = arrival + limits.service[: facts.stations]
        if not (ends <= limits.duration - self._sortie_s(craft.chaser)).any():
            return 0.0
        return float(delta_v[ends <= limits.duration].min())

    def hop(
        self, craft: FlyingChaser, body: int, arrival_s: float, delta_v_m_s: float
    ) -> Hop | None:
        """The connection of a leg: one of its pair, else the timetable's choice, or None."""
        facts = self._facts
        is_launching = self._is_launching(craft)
        source = self._source(craft.chaser, craft.towed and craft.body in facts.tow_s)
        if source is not None and not source.is_listed and not is_launching:
            # Events are regular: this is in the list of the pair, up to rounding.
            made = at_regular_events(source, craft.body, body, craft.free_s)
            leg = body, made.departure, made.arrival, made.delta_v
            return Hop(*leg, families.SHORT, made.revolutions) if made.delta_v < np.inf else None
        rows = facts.rows(craft.body, body, towed=craft.towed)
        if is_launching:
            return hop_of(body, rows, 0) if rows.arrival.size else None
        first = int(np.searchsorted(rows.departure, craft.free_s - SLACK_S))
        off = np.abs(rows.arrival[first:] - arrival_s) / MATCH_S
        off += np.abs(rows.delta_v[first:] - delta_v_m_s) / MATCH_M_S
        if off.size and off.min() < 1.0:
            return hop_of(body, rows, first + int(np.argmin(off)))
        return facts.best(craft.body, body, craft.free_s, towed=craft.towed)

    def _is_launching(self, craft: FlyingChaser) -> bool:
        return self._facts.chasers[craft.chaser].is_launched and not craft.made

    def _candidates(self, craft: FlyingChaser, closed: set[int], planned: list[int]) -> IntArray:
        """Stations and the nearest open targets."""
        is_open = np.ones(len(self._facts.names), dtype=np.bool_)
        is_open[: self._facts.first_target] = False
        is_open[list(closed)] = False
        is_open[craft.body] = False
        targets = np.flatnonzero(is_open)
        if targets.size > RANKS:
            places = self._around.at(craft.free_s)
            few = RANKS + int(np.count_nonzero(self.required & is_open))
            if self._is_launching(craft):
                near = places.neighbours_of(targets)
                away = -(self._worths[targets] + (self._worths * is_open)[near].mean(1))
                away[self.required[targets]] = -np.inf
                targets = targets[np.argpartition(away, min(few, targets.size) - 1)[:few]]
            else:
                targets = places.nearest_of(craft.body, is_open, self.required, few)
            first = [j for j in planned[:2] if j >= self._facts.stations and is_open[j]]
            targets = np.union1d(targets, first) if first else np.sort(targets)
        return np.concatenate([self._stations, targets.astype(np.int64)])

    def _rows(self, craft: FlyingChaser, bodies: IntArray) -> tuple[FloatArray, FloatArray]:
        """ΔV and arrival of the connection chosen to each body; +inf where there is none."""
        facts, here, ready = self._facts, craft.body, craft.free_s
        delta_v, arrival = np.full(bodies.size, np.inf), np.full(bodies.size, np.inf)
        if self._is_launching(craft):
            for at, j in enumerate(bodies.tolist()):
                rows = facts.rows(here, j, towed=False)
                if rows.arrival.size:
                    delta_v[at], arrival[at] = rows.delta_v[0], max(rows.arrival[0], ready)
            return delta_v, arrival
        source = self._source(craft.chaser, craft.towed and here in facts.tow_s)
        if source is not None:
            origins, since = np.full(bodies.size, here), np.full(bodies.size, ready)
            from_source(source, origins, since, bodies, delta_v, arrival)
            return delta_v, arrival
        for at, j in enumerate(bodies.tolist()):
            hop = None if j == here else facts.best(here, j, ready, towed=craft.towed)
            if hop is not None:
                delta_v[at], arrival[at] = hop.delta_v, hop.arrival
        return delta_v, arrival

    def _source(self, chaser: int, towed: bool) -> Source | None:
        """Data for connections on demand; None where they are listed."""
        key = chaser, towed
        if key not in self._sources:
            facts = self._facts
            finder = facts.finder_of(towed=towed)
            self._sources[key] = _source_of(finder, facts, chaser)
        return self._sources[key]

    def _sortie_s(self, chaser: int) -> float:
        """Least time from a station to the end of a service, as far as it is known quickly [s]."""
        if chaser not in self._sorties:
            source, facts = self._source(chaser, False), self._facts
            self._sorties[chaser] = (
                float(facts.chasers[chaser].limits.service[facts.first_target :].min(initial=0.0))
                if source is None
                else float(shortest_sortie(source, facts.stations, facts.first_target))
            )
        return self._sorties[chaser]


def _source_of(finder: ConnectionFinder, facts: MissionFacts, chaser: int) -> Source | None:
    instance = facts.instance
    kinds = {family.kind for family in finder.families}
    told = instance.given is not None or instance.spent_m_s or any_from_apogee(instance)
    if not kinds <= {SHORT, LAUNCH} or told:
        return None
    rule = instance.transfer_rule(instance.time_value_m_s_per_h)
    most = np.inf if finder.times is None else finder.times.most
    return Source(
        *finder.inputs[:3],
        rule,
        facts.chasers[chaser].limits,
        np.zeros((1, 1, 1), np.int32),
        1.0,
        not is_regular(instance),
        instance.transfer.departure_spacing_s,
        most,
    )
