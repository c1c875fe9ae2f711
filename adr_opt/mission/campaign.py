"""A campaign: the missions of all chasers of an instance over its targets.

See docs/model.md section 5.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..common.card import Shown
from ..common.errors import InputError
from ..kernels.tables.timetable_making import Pairs
from ..legs.connections import ConnectionFinder
from ..legs.corrections import Corrections
from ..legs.timetable import Timetable
from ..plan.cargo import loads_of
from ..plan.station_limits import StationLimits, Use
from ..problem.chasers import InOrbit
from ..problem.instance import AnyInstance, Instance, instance_of
from .prizes import Prizes
from .problem import Mission

Routes = tuple[tuple[int, ...], ...]
"""Bodies in order, for each chaser."""


@dataclass(frozen=True)
class ChaserType:
    """Chasers that can do the same: what one of them flies any other could.

    Attributes
    ----------
    mission : Mission
    chasers : tuple of int
        Their numbers.
    """

    mission: Mission
    chasers: tuple[int, ...]


class Campaign(Shown, Prizes):
    """An instance ready for planning, with all its chasers.

    Parameters
    ----------
    instance : Instance
    threads, margin
        As :class:`Mission` takes them.
    connecting : ConnectionFinder, optional
        Of the instance, if there is one already.
    timetables : sequence of Timetable
        Of the instance, one for each chaser, if they are there already.

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, in the order of their numbers.
    missions : tuple of Mission
        Of each chaser; of those of one kind it is the same one but for its name.
    kinds : tuple of ChaserType
    limits : StationLimits
    """

    def __init__(
        self,
        instance: Instance,
        *,
        threads: int | None = None,
        margin: float = 0.0,
        connecting: ConnectionFinder | None = None,
        timetables: Sequence[Timetable] = (),
    ) -> None:
        super().__init__(instance)
        self.margin = margin
        self.limits = StationLimits(instance)
        self._threads = threads
        if timetables:
            connecting = timetables[0].connecting
        self.connecting = connecting or ConnectionFinder(instance)
        # Chasers that are there at the same times choose the same transfers.
        there: dict[Any, Mission] = {}
        available = instance.available_s
        missions = []
        for number, _ in enumerate(instance.chasers):
            twin = there.get(available[number])
            mission = Mission(
                instance, threads=threads, margin=margin, chaser=number,
                connecting=self.connecting, twin=twin,
                timetable=timetables[number] if timetables and twin is None else None,
            )  # fmt: skip
            there.setdefault(available[number], mission)
            missions.append(mission)
        self.missions = tuple(missions)
        alike: dict[Any, list[int]] = {}
        for number, chaser in enumerate(instance.chasers):
            can = chaser.replace(name=instance.chasers[0].name), available[number]
            # Given connections lead from a start by its name, whatever the orbit.
            by_name = instance.transfer.given is not None and isinstance(chaser.start, InOrbit)
            alike.setdefault((can, chaser.name if by_name else None), []).append(number)
        self.kinds = tuple(
            ChaserType(self.missions[numbers[0]], tuple(numbers)) for numbers in alike.values()
        )

    @cached_property
    def kind_of(self) -> tuple[int, ...]:
        """Number of the kind of each chaser."""
        numbers = {
            chaser: number for number, kind in enumerate(self.kinds) for chaser in kind.chasers
        }
        return tuple(numbers[chaser] for chaser in range(len(self.missions)))

    @cached_property
    def networks(self) -> tuple[tuple[int, ...], ...]:
        """Numbers of kinds that move on one network, the earliest first.

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
        """Whether the timetables of all chasers are built."""
        return all(mission.has_timetable for mission in self.missions)

    @property
    def is_whole(self) -> bool:
        """Whether no timetable is built, or one that has all pairs."""
        return self.missions[0].is_whole

    def build(
        self, pairs: Pairs | None, enough: Callable[[float], bool] = lambda share: False
    ) -> None:
        """Build the timetables, be it those of some pairs: as many for all as for the first chaser.

        Parameters
        ----------
        pairs, enough
            As :class:`adr_opt.legs.timetable.Timetable` takes them.
        """
        first, *others = self.missions
        first.build(pairs, enough)
        for mission in others:
            if not mission.has_timetable:
                mission.build(first.timetable.pairs, most=first.timetable.built)

    def with_margin(self, margin: float) -> Campaign:
        """The same campaign with another share of each tank kept back."""
        return Campaign(
            self.instance, threads=self._threads, margin=margin, connecting=self.connecting
        )

    def with_limits(
        self,
        duration_s: float | None = None,
        delta_v_m_s: float | None = None,
        propellant_kg: float | None = None,
    ) -> Problem:
        """The same of another duration or with other tanks, see :meth:`Mission.with_limits`.

        The connections are shared, as far as they do not depend on tanks; each campaign has tables
        of its own. With tanks in ΔV, one that was a campaign for its masses alone is a mission.

        Raises
        ------
        InputError
            A limit is not valid, or longer than what is known.
        """
        instance = self.instance.with_limits(duration_s, delta_v_m_s, propellant_kg)
        connecting, threads = self.connecting.limited(instance), self._threads
        if is_campaign(instance):
            return Campaign(instance, threads=threads, margin=self.margin, connecting=connecting)
        return Mission(instance, threads=threads, margin=self.margin, connecting=connecting)

    def corrected(self, corrections: Corrections) -> Campaign:
        """The same campaign over connections that cost more than the model says."""
        return Campaign(
            self.instance, threads=self._threads, margin=self.margin,
            connecting=self.connecting.corrected(corrections),
        )  # fmt: skip

    def use(self, mission: Mission, moves: Iterable[int], delta_vs: Iterable[float]) -> Use:
        """What a chaser takes of stations by moves with so much ΔV each [m/s]."""
        if not self.limits:
            return ()
        legs = [(self.names[j], float(spent)) for j, spent in zip(moves, delta_vs, strict=True)]
        return self.limits.use(mission.chaser, legs)

    def closed(self, routes: Iterable[Iterable[int | str]]) -> Routes:
        """Routes as missions end, see :meth:`Mission.closed`."""
        return tuple(
            mission.closed(route) for mission, route in zip(self.missions, routes, strict=True)
        )


Problem = Mission | Campaign
"""What is planned: with one chaser or with several."""


def is_campaign(instance: Instance) -> bool:
    """Whether an instance is planned as a campaign.

    With several chasers, or with one whose load or expense counts, or where stations run empty.
    """
    limited = any(station.is_limited for station in instance.stations)
    if len(instance.chasers) > 1 or limited or instance.objective.cost == "expense":
        return True
    return loads_of(instance, instance.chasers[0], 0.0) is not None


def problem_of(instance: AnyInstance | Problem, threads: int | None = None) -> Problem:
    """An instance ready for planning, see :func:`is_campaign`.

    A campaign of one chaser for whom nothing of that counts is its mission: same plans, same
    proofs, same time.

    Raises
    ------
    InputError
        It is the mission of one chaser, and the instance has to be planned as a campaign: rules
        that count for all its chasers would be left out.
    """
    if isinstance(instance, Mission) and is_campaign(instance.instance):
        raise InputError(
            f"{instance.instance.name!r} is planned as a campaign, with all its chasers and what "
            "they carry, cost and take of stations; hand over the instance in place of a Mission"
        )
    if isinstance(instance, Campaign) and not is_campaign(instance.instance):
        return instance.missions[0]
    if isinstance(instance, (Mission, Campaign)):
        return instance
    instance = instance_of(instance)
    if is_campaign(instance):
        return Campaign(instance, threads=threads)
    return Mission(instance, threads=threads)
