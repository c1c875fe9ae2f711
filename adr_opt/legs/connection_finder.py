"""Connections of an instance, found pair by pair over all its families of legs."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from ..common.constants import HOUR_S, MU_M3_S2, SLACK_S
from ..common.errors import InputError
from ..common.processors import usable_cores
from ..kernels.legs import connections as kernels
from ..kernels.legs.found import GIVEN, ConnectionArrays
from ..kernels.legs.given import legs_of
from ..kernels.tables import timetable as tables
from ..kernels.tables import timetable_making as making
from ..plan.leg_kinds import leg_kinds
from ..problem.drives import drive_of
from ..problem.given_functions import Function
from ..problem.instance import Instance
from .connections import ConnectionCache, Connections, Pair
from .corrections import NO_CORRECTIONS, Corrections
from .families import registry
from .families.ends import AllEnds, is_regular
from .families.family import FlownLeg, StatedLeg
from .families.low_thrust import by_departure, lighter, of_mass
from .timetable_size import GIVEN_S, LISTED_S, THRUST_S, Size

FloatArray = npt.NDArray[np.float64]

NO_CONNECTIONS = ConnectionArrays(
    np.empty(0),
    np.empty(0),
    np.empty(0),
    np.empty(0, np.int8),
    np.empty(0, np.int32),
    np.empty(0, np.int8),
)

SAMPLED_PAIRS = 8
"""Number of pairs whose connections are counted to estimate the total."""

SAMPLED_STEPS, SAMPLED_EVENTS = 1000, 5000
"""Maximum number of grid steps and of departure events in a sampled mission."""


class ConnectionFinder:
    """Computes the connections of an instance, pair by pair.

    Where events are regular (two-body motion) a pair takes a tenth of a millisecond, and is worked
    out on every call. Where nodes drift it takes half a millisecond to many, and what planning
    needs is kept, as far as there is room (:class:`.ConnectionCache`). So it is where connections
    are given, or of a family that was registered.

    Parameters
    ----------
    instance : Instance
    corrections : Corrections, optional
        What connections cost beyond the model. Then they are listed also where events are regular.
    chaser : int
        Number of the one that the connections are for; those of one drive share them.
    relaxed : bool
        Whether connections of low thrust are lower bounds, whatever the mass of the chaser.

    Attributes
    ----------
    drive : Drive or None
        Of the chaser, if its thrust is low.
    ends : AllEnds
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

    def __init__(
        self,
        instance: Instance,
        corrections: Corrections = NO_CORRECTIONS,
        chaser: int = 0,
        *,
        relaxed: bool = False,
    ) -> None:
        self.instance, self.chaser, self.relaxed = instance, chaser, relaxed
        self.drive = drive = drive_of(instance.chasers[chaser], instance.targets)
        self.corrections = corrections
        self._names = instance.names
        self.ends = ends = AllEnds(instance, drive, relaxed=relaxed)
        self.inputs = ends.leaving, ends.arriving, ends.eccentricity_m_s, ends.rule
        self.given = instance.given
        self.times = ends.times
        self.families = registry.families_of(instance, drive)
        self._is_listed = are_listed(instance)
        self._has_registered = bool(registry.registered_of(instance))
        told = self.times is not None or self.given is not None
        self._is_kept = told or self._has_registered
        self._spent = instance.spent_m_s
        self.kept = ConnectionCache()
        self.counts: dict[Pair, int] = {}
        self._chosen: dict[Pair, ConnectionArrays] = {}
        self._chosen_for = math.nan
        self._resolution = instance.transfer.delta_v_resolution_m_s
        self._end = ends.latest_s
        self._longer: ConnectionFinder | None = None
        self._numbers: list[int] = []

    @property
    def is_listed(self) -> bool:
        """Whether connections are listed: not all leave at regular events, or costs are corrected.

        A launch is a connection, too, and so is what is given.
        """
        return self._is_listed or bool(self.corrections)

    @property
    def may_be_on_demand(self) -> bool:
        """Whether single connections can be computed on demand.

        Only short ones, which are not waited for and cost what the model says.
        """
        told = self._spent or self.corrections or self.ends.pieced or self.ends.launched
        return not told and registry.has_only_short(self.instance)

    @property
    def planning_resolution_m_s(self) -> float:
        """Saving of ΔV below which connections are omitted from planning [m/s].

        0 where listing all is affordable: where events are regular, or connections given.
        """
        return self._resolution if self.times is not None else 0.0

    def find(
        self, i: int, j: int, resolution_m_s: float, since_s: float = -math.inf
    ) -> ConnectionArrays:
        """Compute all connections of two bodies; some that leave before a time may be missing."""
        return self.charged(i, j, self._of_model(i, j, resolution_m_s, since_s))

    def charged(self, i: int, j: int, found: ConnectionArrays) -> ConnectionArrays:
        """Connections at the ΔV they take from a tank: corrected, and with earlier expenditure.

        A chaser whose tank is not full at the start pays for what is lacking with its first leg:
        then the same is left after it, and for all that plans the tank was full. No other leg
        leaves the place where it starts.
        """
        found = self.corrections.applied(self._names[i], self._names[j], found)
        spent = self._spent.get(i, 0.0)
        return found._replace(delta_v=found.delta_v + spent) if spent else found

    def spent_m_s(self, i: int) -> float:
        """ΔV charged to connections from a body for expenditure before the start [m/s]."""
        return self._spent.get(i, 0.0)

    def _of_model(
        self, i: int, j: int, resolution_m_s: float, since_s: float = -math.inf
    ) -> ConnectionArrays:
        if self.ends.altitudes.bars(i, j):
            return NO_CONNECTIONS
        ends = self.ends.of(i, j)._replace(since_s=since_s)
        claiming = next((family for family in self.families if family.claims(ends)), None)
        if claiming is not None and claiming.kind.from_nowhere:
            return claiming.connections(ends, None, resolution_m_s)
        if self._longer is not None and resolution_m_s == self.planning_resolution_m_s:
            known = self._longer.kept_of_model(self._numbers[i], self._numbers[j])
            return _until(known, math.inf, self._end)
        if claiming is not None:
            return claiming.connections(ends, None, resolution_m_s)
        found: ConnectionArrays | None = None
        for family in self.families:
            found = family.connections(ends, found, resolution_m_s)
        assert found is not None  # there are short legs
        return _until(found, self.ends.altitudes.leave_by[i], math.inf)

    def flown(
        self,
        i: int,
        j: int,
        family: int,
        stated: StatedLeg,
        delta_v_m_s: float | None = None,
        class_kg: float | None = None,
    ) -> FlownLeg:
        """Flight of a connection of a pair by a family, given by its number.

        Of low thrust for a class of chasers with a largest mass, by default the heaviest.

        Raises
        ------
        InputError
            It cannot be flown.
        """
        known, ends = registry.families()[family], of_mass(self.ends.of(i, j), class_kg)
        if delta_v_m_s is None:
            return known.flown(ends, stated)
        return known.flown_at(ends, stated, delta_v_m_s)

    def found(self, i: int, j: int) -> ConnectionArrays:
        """The connections of a pair that planning needs: cached, or computed."""
        if not self._is_kept:
            return self.find(i, j, self.planning_resolution_m_s)
        return self.charged(i, j, self.kept_of_model(i, j))

    def kept_of_model(self, i: int, j: int) -> ConnectionArrays:
        """The cached connections of a pair by the model."""
        return self.kept.get((i, j), lambda: self._of_model(i, j, self.planning_resolution_m_s))

    def corrected(self, corrections: Corrections) -> ConnectionFinder:
        """A finder with other corrections; cached connections of the model are shared."""
        made = ConnectionFinder(self.instance, corrections, self.chaser, relaxed=self.relaxed)
        made.kept = self.kept
        return made

    @property
    def depends_on_tank(self) -> bool:
        """Whether connections depend on the tank: only affordable ones are kept, where listed."""
        return self.times is not None or self._has_registered

    def shortened(self, instance: Instance) -> ConnectionFinder:
        """A finder for a mission of no longer duration or with other tanks; reuses connections.

        A connection is dominated by none that arrives later, so those of the shorter mission are
        those that arrive in time. Tanks may differ unless connections :attr:`depends_on_tank`.
        Prizes may, and targets may be left out: no pair knows of other bodies.
        """
        made = self._for(instance)
        if self.is_listed:
            made._longer, made._numbers = self, self.numbers_of(instance)
        return made

    def numbers_of(self, part: Instance) -> list[int]:
        """Body numbers in this instance of a part of the same field, in its order."""
        number = {name: at for at, name in enumerate(self._names)}
        return [number[name] for name in part.names]

    def counted_as(self, longer: ConnectionFinder) -> None:
        """Take over the numbers of connections per pair from the finder of a longer mission."""
        back = {number: body for body, number in enumerate(longer.numbers_of(self.instance))}
        self.counts |= {
            (back[i], back[j]): count
            for (i, j), count in longer.counts.items()
            if i in back and j in back
        }

    def limited(self, instance: Instance) -> ConnectionFinder:
        """A finder for a mission with another duration or tank: :meth:`shortened`, or a new one.

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
            return self._for(instance)
        return self.shortened(instance)

    def of_chaser(self, chaser: int) -> ConnectionFinder:
        """The finder for a chaser, given by its number: this one if its drive is the same."""
        if drive_of(self.instance.chasers[chaser], self.instance.targets) == self.drive:
            return self
        return ConnectionFinder(self.instance, self.corrections, chaser, relaxed=self.relaxed)

    def _for(self, instance: Instance) -> ConnectionFinder:
        """A finder for another instance with the same chasers."""
        return ConnectionFinder(instance, self.corrections, self.chaser, relaxed=self.relaxed)

    def modelled(self, i: int, j: int, family: int, delta_v_m_s: float) -> float:
        """Cost of a connection without corrections and earlier expenditure [m/s]."""
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
        """Choose connections of pairs from number ``first`` up to ``last``, for a table."""
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

    def table(self, slot: npt.NDArray[np.int16]) -> tables.Table:
        """The timetable of the chosen connections; ``slot`` as in :class:`tables.Table`."""
        chosen, self._chosen = self._chosen, {}
        return making.pack(len(self.instance.names), chosen, slot)

    @property
    def has_functions(self) -> bool:
        """Whether arrivals of any pair are a function of time."""
        return self.given is not None and self.given.functions is not None

    def function_of(self, i: int, j: int) -> Function | None:
        """The function of a pair whose arrivals are one of time; None for any other pair."""
        if self.given is None or self.given.functions is None:
            return None
        return self.given.functions.of_pair(self._names[i], self._names[j])

    def by_function(self, i: int, j: int, ready: FloatArray) -> Connections | None:
        """Legs by the function of a pair, one for each ready time from which a leg ends in time.

        None for a pair without a function. As arrivals never overtake, a chaser that is ready needs
        no other one.
        """
        function = self.function_of(i, j)
        if function is None:
            return None
        departure, arrival = legs_of(function.departure, function.arrival, ready)
        there = arrival <= self._end
        count = int(there.sum())
        found = ConnectionArrays(
            departure[there],
            arrival[there],
            np.full(count, function.cost),
            np.zeros(count, dtype=np.int8),
            np.arange(count, dtype=np.int32),
            np.full(count, GIVEN, dtype=np.int8),
        )
        found = self.charged(i, j, found)
        return Connections(
            found.departure, found.arrival, found.delta_v, found.revolutions, found.family
        )

    def refuse_function(self, i: int, j: int) -> None:
        """Refuse a pair whose connections are too many to be listed.

        Raises
        ------
        InputError
            Its arrivals are a function of time.
        """
        if self.function_of(i, j) is not None:
            raise InputError(
                f"{self._names[i]!r} to {self._names[j]!r}: arrivals are a function of time, whose "
                "connections cannot be listed; plan with auto or exact"
            )

    def of_pair(
        self, i: int, j: int, resolution_m_s: float, since_s: float = -math.inf
    ) -> Connections:
        """All connections of a pair; none from a body to itself.

        Where events are regular, most of those that leave before ``since_s`` are left out, and
        their time with them.

        Raises
        ------
        InputError
            Arrivals of the pair are a function of time.
        """
        self.refuse_function(i, j)
        if i == j:
            none, nothing = np.empty(0), np.empty(0, dtype=np.int8)
            return Connections(none, none, none, nothing, nothing)
        planning = self.is_listed and resolution_m_s == self.planning_resolution_m_s
        found = self.found(i, j) if planning else self.find(i, j, resolution_m_s, since_s)
        return Connections(
            found.departure, found.arrival, found.delta_v, found.revolutions, found.family
        )

    @property
    def lighter_classes_kg(self) -> tuple[float, ...]:
        """Largest mass of each class of its chaser, without the heaviest class [kg].

        None where legs do not depend on the mass, for lower bounds, which hold for any, and where
        costs are corrected: what is vented by the model would be missing from a tank whose legs
        take more.
        """
        if self.drive is None or self.relaxed or self.corrections:
            return ()
        return self.drive.classes_kg(self.instance.transfer.mass_class)[1:]

    def by_class(self, i: int, j: int) -> Connections:
        """The connections of a pair for planning, including those for lighter chasers only.

        A chaser flies those of its own class of mass and of all heavier ones. What connections are
        for, :attr:`.Connections.mass_kg` says if that depends on the mass.
        """
        resolution, ends = self.planning_resolution_m_s, self.ends.of(i, j)
        classes_kg = self.lighter_classes_kg
        if i == j or not classes_kg or any(family.claims(ends) for family in self.families):
            return self.of_pair(i, j, resolution)
        heaviest = self.kept_of_model(i, j)
        found = [(math.inf, heaviest)]
        for family in self.families:
            found += lighter(family, ends, heaviest, classes_kg, resolution)
        return by_departure((mass_kg, self.charged(i, j, of_class)) for mass_kg, of_class in found)

    def choose(
        self,
        times: FloatArray,
        worth: float,
        time_value: float,
        delta_v: FloatArray,
        duration: FloatArray,
    ) -> None:
        """Best connections at ready times, into arrays (departure, origin, destination).

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

        with ThreadPoolExecutor(usable_cores()) as pool:
            list(pool.map(fill, range(len(self.instance.names))))


def _until(found: ConnectionArrays, leave_by: float, arrive_by: float) -> ConnectionArrays:
    """Connections that leave and arrive by some times [s]."""
    in_time = (found.departure <= leave_by) & (found.arrival <= arrive_by)
    return found if in_time.all() else ConnectionArrays(*(part[in_time] for part in found))


def are_listed(instance: Instance) -> bool:
    """Whether connections are listed: not all of them leave at the events of two-body motion."""
    only_short = registry.has_only_short(instance)
    return not (is_regular(instance) and only_short) or bool(instance.spent_m_s)


def estimate(instance: Instance) -> Size:
    """Estimated size of the timetable of an instance."""
    duration, bodies = instance.mission.duration_s, len(instance.names)
    if instance.given is not None:
        most, rows, near = instance.given.sizes(instance.names)
        if instance.given.functions is not None:
            near = bodies - 1
        return Size(bodies, most + 1, rows / max(1, bodies * near), GIVEN_S, near)
    shortest = _shortest_spacing_s(instance)
    if not are_listed(instance):
        return Size(bodies, int(duration / shortest) + 2)
    settings = instance.transfer
    events = duration / max(shortest, settings.departure_spacing_s) + 2
    if settings.max_drift_s > 0.0:
        events += duration / settings.drift_step_s
    dear = instance.has_low_thrust or registry.registered_of(instance)
    return Size(bodies, int(events), _listed(instance), THRUST_S if dear else LISTED_S)


def _shortest_spacing_s(instance: Instance) -> float:
    """Half the period of the lowest body, which holds at most one departure event [s]."""
    lowest = min(orbit.semi_major_axis_m for orbit in instance.body_orbits)
    return math.pi * math.sqrt(lowest**3 / MU_M3_S2)


def _listed(instance: Instance) -> float:
    """Mean number of connections per pair, from a sample of pairs.

    Where a single pair would take minutes, the sample has a coarser grid: there are as many short
    transfers as events, and as many long ones as pairs of times.
    """
    settings, bodies = instance.transfer, len(instance.names)
    duration = instance.mission.duration_s
    spacing = max(_shortest_spacing_s(instance), settings.departure_spacing_s)
    events = max(1.0, duration / SAMPLED_EVENTS / spacing)
    times = max(1.0, duration / SAMPLED_STEPS / settings.drift_step_s)
    if events > 1.0:
        settings = settings.replace(departure_spacing_s=events * spacing)
    coarser = settings.replace(drift_step_s=times * settings.drift_step_s)
    sample = ConnectionFinder(instance.replace(transfer=coarser))
    # Pairs all over the field, since how far planes are apart decides what is worth flying.
    rng = np.random.default_rng(0)
    listed = [0.0]
    gridded = [number for number, kind in enumerate(leg_kinds()) if kind.on_time_grid]
    for number in range(SAMPLED_PAIRS if bodies > 1 else 0):
        i, j = rng.choice(bodies, 2, replace=False)
        found = sample.find(i, j, sample.planning_resolution_m_s)
        long = np.isin(found.family, gridded).sum()
        short = found.departure.size - long
        listed[number:] = [events * short + times**2 * long]
    return float(np.mean(listed))
