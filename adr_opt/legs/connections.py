"""Connections: every transfer of a pair that a chaser who is free to wait may want."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.constants import HOUR_S, SLACK_M_S, SLACK_S
from ..common.errors import InputError
from ..kernels.legs import connections as kernels
from ..kernels.legs.found import ConnectionArrays
from ..kernels.legs.times import Times
from ..kernels.tables import timetable as tables
from ..kernels.tables import timetable_making as making
from ..plan.leg_kinds import SHORT, leg_kinds
from ..plan.tows import leaving_eccentricity_delta_v, leaving_orbits
from ..problem.instance import Instance
from .connection_cache import ConnectionCache, Pair
from .corrections import NO_CORRECTIONS, Corrections
from .families import registry
from .families.family import FlownLeg, PairEnds, StatedLeg

FloatArray = npt.NDArray[np.float64]

CHOICES = {"earliest": (0.0, 1.0), "cheapest": (1.0, 0.0)}
"""Weights of ΔV and of the time of arrival that a name stands for."""

Choice = float | str
"""How one connection is chosen of many: a name, or what an hour is worth [m/s]."""


@dataclass(frozen=True, repr=False)
class Connections(Shown):
    """The connections of a pair in order of departure, then of arrival.

    Attributes
    ----------
    departure, arrival : (connections,) float64
        Times since the epoch; the arrival is the end of the approach [s].
    delta_v : (connections,) float64
        [m/s].
    revolutions : (connections,) int8
        Phasing revolutions; −1 for a transfer that drifts, 0 for one that is given.
    family : (connections,) int8
        Number of the family of legs that each is of, in the order of :func:`.leg_kinds`.
    """

    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    revolutions: npt.NDArray[np.int8]
    family: npt.NDArray[np.int8]

    def at(self, rows: slice | npt.NDArray[Any]) -> Connections:
        """Those at some places."""
        columns = (getattr(self, field.name) for field in fields(self))
        return Connections(*(column[rows] for column in columns))

    def after(self, ready: float) -> Connections:
        """Those that a chaser can take that is ready at a time [s]."""
        return self.at(slice(int(np.searchsorted(self.departure, ready - SLACK_S)), None))


@dataclass(frozen=True, repr=False)
class AllConnections(Shown):
    """The connections of all pairs in arrays: pair by pair by origin, then by destination.

    Within a pair in order of departure, then of arrival, as :class:`Connections`.

    Attributes
    ----------
    names : tuple of str
        Bodies, in the order of their numbers.
    origin, destination : (connections,) int32
        Numbers of bodies.
    departure, arrival : (connections,) float64
        Times since the epoch; the arrival is the end of the approach [s].
    delta_v : (connections,) float64
        [m/s].
    revolutions : (connections,) int8
        Phasing revolutions; −1 for a transfer that drifts, 0 for one that is given.
    family : (connections,) int8
        Number of the family of legs that each is of, in the order of :func:`.leg_kinds`.
    """

    names: tuple[str, ...]
    origin: npt.NDArray[np.int32]
    destination: npt.NDArray[np.int32]
    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    revolutions: npt.NDArray[np.int8]
    family: npt.NDArray[np.int8]

    def __len__(self) -> int:
        """How many there are."""
        return int(self.departure.size)

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """The arrays by the names of :meth:`.Timetable.from_connections`, for tables of others.

        Returns
        -------
        dict of str to array
            ``origin``, ``destination``, ``departure_s``, ``arrival_s``, ``delta_v_m_s``,
            ``revolutions``.
        """
        return {
            "origin": self.origin, "destination": self.destination, "departure_s": self.departure,
            "arrival_s": self.arrival, "delta_v_m_s": self.delta_v,
            "revolutions": self.revolutions,
        }  # fmt: skip

    @classmethod
    def joined(cls, names: tuple[str, ...], pairs: Iterable[Pairwise]) -> AllConnections:
        """Those of pairs, one pair after the other: origin, destination, connections."""
        listed = list(pairs)
        counts = [found.departure.size for _, _, found in listed]

        def column(name: str, kind: type[np.generic]) -> npt.NDArray[Any]:
            parts = [getattr(found, name) for _, _, found in listed]
            array = np.concatenate(parts) if parts else np.empty(0)
            return array.astype(kind, copy=False)

        def bodies(numbers: list[int]) -> npt.NDArray[np.int32]:
            return np.repeat(np.array(numbers, dtype=np.int32), counts)

        return cls(
            names,
            bodies([i for i, _, _ in listed]),
            bodies([j for _, j, _ in listed]),
            column("departure", np.float64),
            column("arrival", np.float64),
            column("delta_v", np.float64),
            column("revolutions", np.int8),
            column("family", np.int8),
        )


Pairwise = tuple[int, int, Connections]
"""Origin, destination, and the connections between them."""


class ConnectionFinder:
    """Works out the connections of an instance, pair by pair.

    Where events are regular (two-body motion) a pair takes a tenth of a millisecond, and is worked
    out on every call. Where nodes drift it takes half a millisecond to many, and what planning
    needs is kept, as far as there is room (:mod:`.connection_cache`). So it is where connections
    are given, or of a family that was registered.

    Parameters
    ----------
    instance : Instance
    corrections : Corrections, optional
        What connections cost beyond the model. Then they are listed also where events are regular.

    Attributes
    ----------
    families : tuple of LegFamily
        Those that legs may be of.
    inputs : tuple
        Bodies as they are left and as they are arrived at, shape (bodies, columns); what matching
        eccentricity vectors alone costs, shape (origin, destination) [m/s]; the transfer rule.
    kept : ConnectionCache
        The connections of pairs that are kept, as the model has them, where they are listed.
    counts : dict of (origin, destination) to int
        How many connections the pairs have that a table was made of, where they are listed.
    """

    def __init__(self, instance: Instance, corrections: Corrections = NO_CORRECTIONS) -> None:
        self.instance = instance
        self.corrections = corrections
        self._names = instance.names
        leaving = leaving_orbits(instance)
        extra = leaving_eccentricity_delta_v(instance, leaving)
        self.inputs = leaving, instance.orbits(), extra, instance.transfer_rule()
        self.given = instance.given
        self.times = _times(instance)
        self.families = registry.families_of(instance)
        self._is_listed = are_listed(instance)
        self._has_registered = bool(registry.registered_of(instance))
        asked_anew = self.times is None and self.given is None and not self._has_registered
        self._is_kept = not asked_anew
        self._spent = instance.spent_m_s
        self.kept = ConnectionCache()
        self.counts: dict[Pair, int] = {}
        self._chosen: dict[Pair, ConnectionArrays] = {}
        self._chosen_for = math.nan
        self._resolution = instance.transfer.delta_v_resolution_m_s
        self._end = instance.mission.duration_s + SLACK_S
        self._longer: ConnectionFinder | None = None
        self._numbers: list[int] = []

    @property
    def is_listed(self) -> bool:
        """Whether connections are listed: not all leave at regular events, or costs are corrected.

        A launch is a connection, too, and so is what is given.
        """
        return self._is_listed or bool(self.corrections)

    @property
    def may_be_asked(self) -> bool:
        """Whether single connections can be worked out on demand.

        Only short ones, which are not waited for and cost what the model says.
        """
        told = self._spent or self.corrections
        return not told and [family.kind for family in self.families] == [SHORT]

    @property
    def planning_resolution_m_s(self) -> float:
        """Connections that save no more are left out of planning [m/s].

        None is, where that is affordable: where events are regular, or connections given.
        """
        return self._resolution if self.times is not None else 0.0

    def find(self, i: int, j: int, resolution_m_s: float) -> ConnectionArrays:
        """Work out all connections of two bodies."""
        return self._charged(i, j, self._of_model(i, j, resolution_m_s))

    def _charged(self, i: int, j: int, found: ConnectionArrays) -> ConnectionArrays:
        """What connections take out of a tank: corrected, and with what was spent before.

        A chaser whose tank is not full at the start pays for what is lacking with its first leg:
        then the same is left after it, and for all that plans the tank was full. No other leg
        leaves the place where it starts.
        """
        found = self.corrections.applied(self._names[i], self._names[j], found)
        spent = self._spent.get(i, 0.0)
        return found._replace(delta_v=found.delta_v + spent) if spent else found

    def spent_m_s(self, i: int) -> float:
        """What connections from a body cost besides, because it was spent before the start."""
        return self._spent.get(i, 0.0)

    def ends(self, i: int, j: int) -> PairEnds:
        """What the legs of a pair follow from."""
        leaving, orbits, extra, rule = self.inputs
        return PairEnds(
            self.instance, i, j, leaving[i], orbits[j], extra[i, j], rule, self.times, self._end
        )

    def _of_model(self, i: int, j: int, resolution_m_s: float) -> ConnectionArrays:
        ends = self.ends(i, j)
        claiming = next((family for family in self.families if family.claims(ends)), None)
        if claiming is not None and claiming.kind.from_nowhere:
            return claiming.connections(ends, None, resolution_m_s)
        if self._longer is not None and resolution_m_s == self.planning_resolution_m_s:
            known = self._longer.kept_of_model(self._numbers[i], self._numbers[j])
            in_time = known.arrival <= self._end
            return known if in_time.all() else ConnectionArrays(*(part[in_time] for part in known))
        if claiming is not None:
            return claiming.connections(ends, None, resolution_m_s)
        found: ConnectionArrays | None = None
        for family in self.families:
            found = family.connections(ends, found, resolution_m_s)
        assert found is not None  # there are short legs
        return found

    def flown(self, i: int, j: int, family: int, stated: StatedLeg) -> FlownLeg:
        """How a connection of a pair is flown that a family has, by its number.

        Raises
        ------
        InputError
            It cannot be flown.
        """
        return registry.families()[family].flown(self.ends(i, j), stated)

    def found(self, i: int, j: int) -> ConnectionArrays:
        """What planning needs of a pair: kept, or worked out."""
        if not self._is_kept:
            return self.find(i, j, self.planning_resolution_m_s)
        return self._charged(i, j, self.kept_of_model(i, j))

    def kept_of_model(self, i: int, j: int) -> ConnectionArrays:
        """The connections of a pair as the model has them, kept."""
        return self.kept.get((i, j), lambda: self._of_model(i, j, self.planning_resolution_m_s))

    def corrected(self, corrections: Corrections) -> ConnectionFinder:
        """The same of other corrections; what is kept of the model is shared."""
        made = ConnectionFinder(self.instance, corrections)
        made.kept = self.kept
        return made

    @property
    def depends_on_tank(self) -> bool:
        """Whether other tanks have other connections: those that they can pay, where listed."""
        return self.times is not None or self._has_registered

    def shortened(self, instance: Instance) -> ConnectionFinder:
        """That of a mission that differs in limits alone, and is no longer; what is known is used.

        A connection is dominated by none that arrives later, so those of the shorter mission are
        those that arrive in time. Tanks may differ unless connections :attr:`depends_on_tank`.
        Prizes may, and targets may be left out: no pair knows of other bodies.
        """
        made = ConnectionFinder(instance, self.corrections)
        if self.is_listed:
            made._longer, made._numbers = self, self.numbers_of(instance)
        return made

    def numbers_of(self, part: Instance) -> list[int]:
        """The numbers here of the bodies of a part of the same field, in its order."""
        number = {name: at for at, name in enumerate(self._names)}
        return [number[name] for name in part.names]

    def counted_as(self, longer: ConnectionFinder) -> None:
        """Take over how many connections pairs have, for a table that is not made of them anew."""
        back = {number: body for body, number in enumerate(longer.numbers_of(self.instance))}
        self.counts |= {
            (back[i], back[j]): count
            for (i, j), count in longer.counts.items()
            if i in back and j in back
        }

    def limited(self, instance: Instance) -> ConnectionFinder:
        """That of a mission that differs in limits alone: :meth:`shortened`, or anew for its tank.

        Raises
        ------
        InputError
            It is longer.
        """
        longest_s, duration_s = self.instance.mission.duration_s, instance.mission.duration_s
        if duration_s > longest_s:
            raise InputError(
                f"duration_s = {duration_s!r}: connections are known up to {longest_s!r} s; begin "
                "with the longest mission"
            )
        if self.depends_on_tank and instance.largest_tank_m_s != self.instance.largest_tank_m_s:
            return ConnectionFinder(instance, self.corrections)
        return self.shortened(instance)

    def modelled(self, i: int, j: int, family: int, delta_v_m_s: float) -> float:
        """What a connection costs without the corrections, and what was spent before [m/s]."""
        delta_v_m_s -= self._spent.get(i, 0.0)
        if not self.corrections:
            return delta_v_m_s
        kind = leg_kinds()[family].name
        return self.corrections.modelled(self._names[i], self._names[j], kind, delta_v_m_s)

    def choose_pairs(
        self,
        pairs: making.Pairs,
        first: int,
        last: int,
        limits: making.ServiceLimits,
        time_value_m_s_per_h: float,
    ) -> None:
        """Make the choice of pairs number ``first`` to before ``last``, for a table."""
        if self._chosen_for != time_value_m_s_per_h:
            self._chosen, self._chosen_for = {}, time_value_m_s_per_h
        for number in range(first, last):
            i, rank = making.pair_at(number, pairs)
            i, j = int(i), int(pairs.near[i, rank])
            found = self.found(i, j)
            taken = np.empty(found.departure.size, dtype=np.int64)
            count = making.choose(found, limits, j, time_value_m_s_per_h / HOUR_S, taken)
            chosen = taken[taken.size - count :]
            self._chosen[i, j] = ConnectionArrays(*(column[chosen] for column in found))
            self.counts[i, j] = found.departure.size

    def table(self, duration: float, slot: npt.NDArray[np.int16]) -> tables.Table:
        """The timetable of the choices made; ``slot`` as in :class:`tables.Table`."""
        chosen, self._chosen = self._chosen, {}
        return making.pack(len(self.instance.names), chosen, duration, slot)

    def of_pair(self, i: int, j: int, resolution_m_s: float) -> Connections:
        """All connections of a pair; none from a body to itself."""
        if i == j:
            none, nothing = np.empty(0), np.empty(0, dtype=np.int8)
            return Connections(none, none, none, nothing, nothing)
        planning = self.is_listed and resolution_m_s == self.planning_resolution_m_s
        found = self.found(i, j) if planning else self.find(i, j, resolution_m_s)
        return Connections(
            found.departure, found.arrival, found.delta_v, found.revolutions, found.family
        )

    def choose(
        self,
        times: FloatArray,
        worth: float,
        time_value: float,
        delta_v: FloatArray,
        duration: FloatArray,
    ) -> None:
        """The best connections at ready times, into arrays (departure, origin, destination).

        Parameters
        ----------
        times : (departures,) float64
            [s].
        worth, time_value : float
            The best has the least worth·ΔV + time_value·arrival.
        delta_v, duration : (departures, bodies, bodies) float64
            Written: [m/s], and from ready to arrival [s].
        """

        def fill(i: int) -> None:
            for j in range(len(self.instance.names)):
                if i == j:
                    delta_v[:, i, j] = duration[:, i, j] = 0.0
                    continue
                found = self.of_pair(i, j, self._resolution)
                best = kernels.best_from(
                    found.departure, found.arrival, found.delta_v, worth, time_value
                )
                first = np.searchsorted(found.departure, times - SLACK_S)
                there = first < best.size
                chosen = best[first[there]]
                delta_v[:, i, j] = duration[:, i, j] = np.inf
                delta_v[there, i, j] = found.delta_v[chosen]
                duration[there, i, j] = found.arrival[chosen] - times[there]

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(fill, range(len(self.instance.names))))


def weights_of(choose: Choice) -> tuple[float, float]:
    """Weights of ΔV [per m/s] and of time [per s] that a choice stands for.

    Raises
    ------
    InputError
        There is no such choice.
    """
    if choose in CHOICES:
        return CHOICES[str(choose)]
    try:
        value = float(choose)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise InputError(
            f"choose = {choose!r}: must be 'earliest', 'cheapest' or what an hour is worth, "
            "a number of m/s ≥ 0"
        )
    return 1.0, value / HOUR_S


def are_listed(instance: Instance) -> bool:
    """Whether connections are listed: not all of them leave at the events of two-body motion."""
    found = registry.families_of(instance)
    only_short = [family.kind for family in found] == [SHORT]
    return not (_is_regular(instance) and only_short) or bool(instance.spent_m_s)


def _is_regular(instance: Instance) -> bool:
    """Whether departure events are those of two-body motion, where connections are the model's."""
    return instance.dynamics == "two-body" and instance.transfer.departure_spacing_s == 0.0


def _times(instance: Instance) -> Times | None:
    """When transfers may leave; None where events are regular or given: no such thing is needed."""
    settings = instance.transfer
    if _is_regular(instance) or settings.given is not None:
        return None
    return Times(
        settings.departure_spacing_s, settings.drift_step_s, settings.max_drift_s,
        instance.largest_tank_m_s + SLACK_M_S,
    )  # fmt: skip
