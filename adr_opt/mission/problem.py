"""A problem: the missions of all chasers of an instance.

A mission of one chaser is a campaign of one. See docs/model.md section 5.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..common.card import Shown
from ..common.errors import InputError
from ..kernels.tables.timetable_making import Pairs
from ..legs.connection_finder import ConnectionFinder
from ..legs.corrections import Corrections
from ..legs.nearest_pairs import Neighbours
from ..legs.timetable import Timetable
from ..plan.station_limits import StationLimits, Use
from ..problem.chasers import InOrbit
from ..problem.drives import drive_of
from ..problem.instance import AnyInstance, Instance
from ..problem.rules import CAMPAIGNS, TOURS
from ..problem.support import binding, followed
from .mission import FOLLOWS, Mission
from .prizes import Prizes

Routes = tuple[tuple[int, ...], ...]
"""Bodies in order, for each chaser."""


@dataclass(frozen=True)
class ChaserType:
    """Interchangeable chasers: any of them could fly another's route.

    Attributes
    ----------
    mission : Mission
    chasers : tuple of int
        Their numbers.
    """

    mission: Mission
    chasers: tuple[int, ...]


class Problem(Shown, Prizes):
    """An instance ready for planning, with one chaser or several.

    Parameters
    ----------
    instance : Instance, path or dict
    threads, margin
        As :class:`Mission` takes them.
    connecting : ConnectionFinder, optional
        Of the instance, if there is one already.
    timetables : sequence of Timetable
        Of the instance, one for each chaser, if they are there already.
    missions : sequence of Mission
        Of the instance, one for each chaser, if they are there already. They replace the arguments
        above.

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, in the order of their numbers.
    margin : float
    missions : tuple of Mission
        Of each chaser; of those of one kind it is the same one but for its name.
    kinds : tuple of ChaserType
    limits : StationLimits
    """

    def __init__(
        self,
        instance: AnyInstance,
        *,
        threads: int | None = None,
        margin: float = 0.0,
        connecting: ConnectionFinder | None = None,
        timetables: Sequence[Timetable] = (),
        missions: Sequence[Mission] = (),
    ) -> None:
        instance = followed(instance, FOLLOWS)
        super().__init__(instance)
        self.limits = StationLimits(instance)
        self._threads = threads
        if not missions:
            if timetables:
                connecting = timetables[0].connecting
            connecting = connecting or ConnectionFinder(instance)
            missions = _missions(instance, threads, margin, connecting, timetables)
        self.missions = tuple(missions)
        self.margin = self.missions[0].margin
        available = instance.available_s
        alike: dict[Any, list[int]] = {}
        for number, chaser in enumerate(instance.chasers):
            can = chaser.replace(name=instance.chasers[0].name), available[number]
            # Given connections lead from a start by its name, whatever the orbit.
            by_name = instance.transfer.given is not None and isinstance(chaser.start, InOrbit)
            alike.setdefault((can, chaser.name if by_name else None), []).append(number)
        self.kinds = tuple(
            ChaserType(self.missions[numbers[0]], tuple(numbers)) for numbers in alike.values()
        )

    @classmethod
    def of(cls, mission: Mission) -> Problem:
        """The problem of an instance's only mission, with the same worths.

        Raises
        ------
        InputError
            The instance has several chasers.
        """
        if len(mission.instance.chasers) > 1:
            raise InputError(
                f"{mission.instance.name!r} has several chasers, but a Mission has only one; "
                "pass the instance in place of a Mission"
            )
        made = cls(mission.instance, missions=(mission,))
        # A mission may offer others.
        for name in ("planning_prizes", "is_required", "prize_step", "falls"):
            made.__dict__[name] = getattr(mission, name)
        return made

    @property
    def depends_on_mass(self) -> bool:
        """Whether costs of transfers depend on mass, and are those of the heaviest chaser."""
        finders = [mission.connecting for mission in self.missions]
        return any(each.drive is not None and not each.relaxed for each in finders)

    @cached_property
    def relaxed(self) -> Problem:
        """The same problem with lower bounds on the costs of low-thrust legs, whatever the mass."""
        connecting = ConnectionFinder(self.instance, self.connecting.corrections, relaxed=True)
        return self._of(self.instance, connecting, self.margin)

    @property
    def connecting(self) -> ConnectionFinder:
        """Finder of the connections of pairs."""
        return self.missions[0].connecting

    @cached_property
    def alone(self) -> Mission | None:
        """The mission of the only chaser, where a plan is a single route.

        None with several chasers, and where loads, what stations have, the expense of a chaser that
        is used, or the time of its launch count as well. What is quicker with one chaser is chosen
        by it.
        """
        if any(binding(self.instance, CAMPAIGNS | TOURS)):
            return None
        return self.missions[0]

    @cached_property
    def asks_for_least_end(self) -> bool:
        """Whether the task is to order all targets for the earliest end.

        One chaser over given connections, of which none leads to a station, all targets required,
        the cost the end of the mission, and a tank that no order empties.
        """
        instance, mission = self.instance, self.missions[0]
        given, chaser = instance.given, mission.chaser
        targets = len(instance.targets)
        if self.alone is None or given is None or given.functions is not None or not targets:
            return False
        if instance.objective.cost != "duration" or self.connecting.corrections:
            return False
        all_required = all(target.required for target in instance.targets)
        if not all_required or min(mission.limits) < targets:
            return False
        if chaser.end != "anywhere":
            return False
        stations = [name in instance.station_names for name in given.names]
        if np.isin(given.destination, np.flatnonzero(stations)).any():
            return False
        spent = chaser.spent_m_s + mission.reserve_m_s
        dearest = float(given.cost.max(initial=0.0))
        return targets * dearest <= chaser.usable.delta_v_m_s - spent

    @cached_property
    def kind_of(self) -> tuple[int, ...]:
        """Number of each chaser's type."""
        numbers = {
            chaser: number for number, kind in enumerate(self.kinds) for chaser in kind.chasers
        }
        return tuple(numbers[chaser] for chaser in range(len(self.missions)))

    @cached_property
    def networks(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of types that share a network, earliest first.

        They differ in nothing but where they start, and since when.
        """
        alike: dict[Any, list[int]] = {}
        for number, kind in enumerate(self.kinds):
            chaser = kind.mission.chaser
            can = chaser.replace(
                name=self.instance.chasers[0].name, start="anywhere", available_s=(0.0, None)
            )
            alike.setdefault((can, chaser.available_s[1]), []).append(number)
        return tuple(
            tuple(sorted(numbers, key=lambda n: self.kinds[n].mission.rules.ready))
            for numbers in alike.values()
        )

    @property
    def has_timetable(self) -> bool:
        """Whether the timetables of all chasers have been built."""
        return all(mission.has_timetable for mission in self.missions)

    @property
    def is_whole(self) -> bool:
        """Whether there is no timetable yet, or one with all pairs."""
        return self.missions[0].is_whole

    def build(
        self,
        pairs: Pairs | None,
        enough: Callable[[float], bool] = lambda share: False,
        most: int | None = None,
    ) -> None:
        """Build the timetables, of all pairs or of as many for each chaser as for the first.

        Parameters
        ----------
        pairs, enough, most
            As :class:`adr_opt.legs.timetable.Timetable` takes them.
        """
        first, *others = self.missions
        first.build(pairs, enough, most)
        for mission in others:
            if not mission.has_timetable:
                mission.build(first.timetable.pairs, most=first.timetable.built)

    def ask(self, near: Neighbours) -> None:
        """Do without timetables, see :meth:`Mission.ask`."""
        for mission in self.missions:
            mission.ask(near)

    def do_without(self) -> None:
        """Do without timetables, see :meth:`Mission.do_without`."""
        for mission in self.missions:
            mission.do_without()

    def forget_tables(self) -> None:
        """Discard the timetables, which are built anew once they are needed."""
        for mission in self.missions:
            mission.forget_table()

    def with_margin(self, margin: float) -> Problem:
        """The same problem with another reserved share of each tank; a built timetable stays."""
        if len(self.missions) == 1:
            return Problem.of(self.missions[0].with_margin(margin))
        return self._of(self.instance, self.connecting, margin)

    def with_limits(
        self,
        duration_s: float | None = None,
        delta_v_m_s: float | None = None,
        propellant_kg: float | None = None,
    ) -> Problem:
        """The same problem with another duration or tanks, see :meth:`Mission.with_limits`.

        The connections are shared, as far as they do not depend on tanks; of several chasers each
        has a table of its own.

        Raises
        ------
        InputError
            A limit is not valid, or longer than what is known.
        """
        if len(self.missions) == 1:
            mission = self.missions[0]
            return Problem.of(mission.with_limits(duration_s, delta_v_m_s, propellant_kg))
        instance = self.instance.with_limits(duration_s, delta_v_m_s, propellant_kg)
        return self._of(instance, self.connecting.limited(instance), self.margin)

    def corrected(self, corrections: Corrections) -> Problem:
        """The same problem with corrected costs of connections."""
        if len(self.missions) == 1:
            return Problem.of(self.missions[0].corrected(corrections))
        return self._of(self.instance, self.connecting.corrected(corrections), self.margin)

    def _of(self, instance: Instance, connecting: ConnectionFinder, margin: float) -> Problem:
        return Problem(instance, threads=self._threads, margin=margin, connecting=connecting)

    def use(self, mission: Mission, moves: Iterable[int], delta_vs: Iterable[float]) -> Use:
        """Use of station supplies by a chaser's moves with given ΔV [m/s]."""
        if not self.limits:
            return ()
        legs = [(self.names[j], float(spent)) for j, spent in zip(moves, delta_vs, strict=True)]
        return self.limits.use(mission.chaser, legs)

    def closed(self, routes: Iterable[Iterable[int | str]]) -> Routes:
        """Routes made to end legally, see :meth:`Mission.closed`."""
        return tuple(
            mission.closed(route) for mission, route in zip(self.missions, routes, strict=True)
        )


AnyProblem = AnyInstance | Mission | Problem
"""An instance in any form, or already prepared for planning."""


def problem_of(instance: AnyProblem, threads: int | None = None) -> Problem:
    """An instance ready for planning.

    Raises
    ------
    InputError
        It is the mission of one of several chasers.
    """
    if isinstance(instance, Problem):
        return instance
    if isinstance(instance, Mission):
        return Problem.of(instance)
    return Problem(instance, threads=threads)


def _missions(
    instance: Instance,
    threads: int | None,
    margin: float,
    connecting: ConnectionFinder,
    timetables: Sequence[Timetable],
) -> list[Mission]:
    """The missions of all chasers.

    Those of one drive share their connections, and with equal time windows their choices, too.
    """
    there: dict[Any, Mission] = {}
    finders = {connecting.drive: connecting}
    missions = []
    for number, since in enumerate(instance.available_s):
        drive = drive_of(instance.chasers[number], instance.targets)
        finder = finders.get(drive)
        if finder is None:
            finder = finders[drive] = connecting.of_chaser(number)
        twin = there.get((since, drive))
        mission = Mission(
            instance,
            threads=threads,
            margin=margin,
            chaser=number,
            connecting=finder,
            twin=twin,
            timetable=timetables[number] if timetables and twin is None else None,
        )
        there.setdefault((since, drive), mission)
        missions.append(mission)
    return missions
