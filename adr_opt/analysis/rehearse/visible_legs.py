"""What a policy sees from where a chaser is: legs to bodies nearby, computed when asked for."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_S
from ...kernels.legs import found as families
from ...kernels.rules.loads import after_service
from ...kernels.tables.on_demand import Source, at_regular_events, shortest_sortie
from ...kernels.tables.timetable import from_source
from ...learning.next_leg.choices import Choices
from ...learning.next_leg.near_orbits import NearOrbits
from ...learning.next_leg.onward import OnwardLegs, onward, unknown
from ...legs.connection_finder import ConnectionFinder
from ...legs.families.ends import is_regular
from ...plan.leg_kinds import LAUNCH, SHORT
from ...plan.tows import any_from_apogee
from ...problem.uncertainty import Uncertainty
from .flying_chasers import FlyingChaser, full_of
from .mission_facts import MATCH_S, Hop, MissionFacts, hop_of
from .service_delays import largest_delays_s, mean_delays_s
from .tries import TryWorths

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

RANKS = 64
"""Number of nearest open targets to which legs are considered; required ones are always added."""

MATCH_M_S = 1e-3
"""Tolerance of costs when a connection computed on demand is looked for among those of a pair."""

LATE = 0.9
"""Share of times of services, and chance of captures, for which a way to refuel is kept."""


class VisibleLegs:
    """Legs from a body at a time, and what they lead to on average; shared by rehearsals.

    Where all legs between bodies are short, connections are computed on demand, as those of large
    fields are by planners; otherwise they come from the lists of the pairs of the body.

    Parameters
    ----------
    facts : MissionFacts
    uncertainty : Uncertainty

    Attributes
    ----------
    around : NearOrbits
    worths : (bodies,) float64
        Of going to each target on average, over the mean of all that are worth something.
    required : (bodies,) bool
    later_s : (bodies,) float64
        By how much later than planned services end on average [s].
    late_s : (bodies,) float64
        By how much later than planned services may well end (:data:`LATE`) [s].
    """

    def __init__(self, facts: MissionFacts, uncertainty: Uncertainty) -> None:
        self._facts = facts
        instance = facts.instance
        bodies = len(facts.names)
        self.around = NearOrbits(instance)
        tries = TryWorths(instance, uncertainty)
        worths = np.array([tries.most(j) if j in facts.prizes else 0.0 for j in range(bodies)])
        positive = worths > 0.0
        self.worths = worths / (worths[positive].mean() if positive.any() else 1.0)
        self.required = np.array([j in facts.required for j in range(bodies)])
        self.later_s = mean_delays_s(facts, uncertainty)
        self.late_s = largest_delays_s(facts, uncertainty, LATE)
        self._towed = np.array([j in facts.tow_s for j in range(bodies)])
        self._stations = np.arange(facts.stations)
        self._targets = np.arange(facts.first_target, bodies)
        self._sources: dict[tuple[int, bool], Source | None] = {}
        self._sorties: dict[int, float] = {}

    def choices(
        self,
        craft: FlyingChaser,
        closed: set[int],
        planned: list[int],
        planned_by_others: set[int],
        others: list[int],
        own: Hop | None,
    ) -> Choices:
        """The legs from which a chaser may choose.

        Parameters
        ----------
        craft : FlyingChaser
        closed : set of int
            Targets that are done, or on the way to which a chaser is.
        planned : list of int
            Bodies to which the rest of its plan leads, in order.
        planned_by_others : set of int
            Targets to which plans of others lead.
        others : list of int
            Bodies at which other chasers are.
        own : Hop or None
            The planned leg, in place of the connection chosen now to the same body.
        """
        facts, what = self._facts, self._facts.chasers[craft.chaser]
        limits = what.limits
        bodies = self._candidates(craft, closed, planned)
        delta_v, arrival = self._rows(craft, bodies)
        if own is not None:
            at = np.flatnonzero(bodies == own.destination)
            delta_v[at], arrival[at] = own.delta_v, own.arrival
        opens, latest = limits.windows.opening[bodies], limits.windows.closing[bodies]
        begin = np.maximum(arrival, opens)
        free = begin + limits.service[bodies]
        station = bodies < facts.stations
        legal = (begin <= latest) & (free <= limits.duration)
        legal &= (delta_v <= craft.left) & (~station | (craft.since > 0))
        left = np.where(station, full_of(what, craft.kits), craft.left - delta_v)
        if what.most_targets is not None and craft.serviced >= what.most_targets:
            legal &= station
        if what.loads is not None:
            for leg in np.flatnonzero(legal & ~station).tolist():
                left[leg], kits = after_service(what.loads, int(bodies[leg]), craft.kits, left[leg])
                legal[leg] = kits >= 0 and left[leg] >= 0.0
        ranks = np.full(len(facts.names), -1)
        for rank, j in reversed(list(enumerate(planned))):
            ranks[j] = rank
        theirs = np.zeros(ranks.size, dtype=np.bool_)
        theirs[list(planned_by_others)] = True
        apart = np.full(bodies.size, np.inf)
        places = self.around.at(craft.free_s)
        for body in others:
            apart = np.minimum(apart, places.distances(body, bodies))
        return Choices(
            bodies,
            delta_v,
            arrival,
            free + self.later_s[bodies],
            left,
            latest + limits.service[bodies],
            np.maximum(opens - arrival, 0.0),
            legal,
            ranks[bodies],
            theirs[bodies],
            apart,
        )

    def onward(self, craft: FlyingChaser, choices: Choices, worths: FloatArray) -> OnwardLegs:
        """The legs after the next one; unknown where connections are listed."""
        chaser, facts = craft.chaser, self._facts
        sources = self._source(chaser, False), self._source(chaser, True)

        def connecting(
            origins: IntArray, ready: FloatArray, destinations: IntArray
        ) -> tuple[FloatArray, FloatArray]:
            delta_v, arrival = np.empty(origins.size), np.empty(origins.size)
            towed = self._towed[origins]
            for source, is_towed in zip(sources, (False, True), strict=True):
                at = np.flatnonzero(towed == is_towed)
                if at.size:
                    found = np.empty(at.size), np.empty(at.size)
                    from_source(source, origins[at], ready[at], destinations[at], *found)
                    delta_v[at], arrival[at] = found
            return delta_v, arrival

        if sources[0] is None or sources[1] is None:
            return unknown(choices.bodies.size)
        places, end_s = self.around.at(craft.free_s), facts.chasers[chaser].limits.duration
        return onward(choices, places, worths, end_s, facts.stations, connecting)

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
        """The connection of a leg among those of its pair; else the one chosen there, or none."""
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
        """Stations and open targets, of many the nearest."""
        is_open = np.ones(len(self._facts.names), dtype=np.bool_)
        is_open[list(closed)] = False
        is_open[craft.body] = False
        targets = self._targets[is_open[self._targets]]
        if targets.size > RANKS:
            places = self.around.at(craft.free_s)
            if self._is_launching(craft):
                near, _, counts = places.neighbours_of(targets)
                dense = ((self.worths * is_open)[near] * counts[:, :, 1]).sum(1)
                away = -(self.worths[targets] + dense)
            else:
                away = places.distances(craft.body, targets)
            away[self.required[targets]] = -np.inf
            few = RANKS + int(self.required[targets].sum())
            nearest = targets[np.argpartition(away, min(few, targets.size) - 1)[:few]]
            first = [j for j in planned[:2] if j >= self._facts.stations and is_open[j]]
            targets = np.sort(nearest)
            if first:
                targets = np.union1d(nearest, np.array(first, dtype=np.int64))
        stations = self._stations[is_open[: self._facts.stations]]
        return np.concatenate([stations, targets])

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
