"""A campaign: the missions of all chasers of an instance over its targets (MODEL section 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .cargo import loads_of
from .chasers import InOrbit
from .connections import Connecting
from .corrections import Corrections
from .instance import Instance
from .mission import Mission
from .prizes import Prizes

Routes = tuple[tuple[int, ...], ...]
"""Bodies in order, for each chaser."""


@dataclass(frozen=True)
class Kind:
    """Chasers that can do the same: what one of them flies any other could.

    Attributes
    ----------
    mission : Mission
    chasers : tuple of int
        Their numbers.
    """

    mission: Mission
    chasers: tuple[int, ...]


class Campaign(Prizes):
    """An instance ready for planning, with all its chasers.

    Parameters
    ----------
    instance : Instance
    threads, margin
        As :class:`Mission` takes them.
    connecting : Connecting, optional
        Of the instance, if there is one already.

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, in the order of their numbers.
    missions : tuple of Mission
        Of each chaser; of those of one kind it is the same one but for its name.
    kinds : tuple of Kind
    """

    def __init__(
        self,
        instance: Instance,
        *,
        threads: int | None = None,
        margin: float = 0.0,
        connecting: Connecting | None = None,
    ) -> None:
        super().__init__(instance)
        self.margin = margin
        self._threads = threads
        self.connecting = connecting or Connecting(instance)
        # Chasers that are there at the same times choose the same transfers.
        there: dict[Any, Mission] = {}
        missions = []
        for number, chaser in enumerate(instance.chasers):
            mission = Mission(
                instance, threads=threads, margin=margin, chaser=number,
                connecting=self.connecting, twin=there.get(chaser.available_s),
            )  # fmt: skip
            there.setdefault(chaser.available_s, mission)
            missions.append(mission)
        self.missions = tuple(missions)
        alike: dict[Any, list[int]] = {}
        for number, chaser in enumerate(instance.chasers):
            can = chaser.replace(name=instance.chasers[0].name)
            # Given connections lead from a start by its name, whatever the orbit.
            by_name = instance.transfer.given is not None and isinstance(chaser.start, InOrbit)
            alike.setdefault((can, chaser.name if by_name else None), []).append(number)
        self.kinds = tuple(
            Kind(self.missions[numbers[0]], tuple(numbers)) for numbers in alike.values()
        )

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
            tuple(sorted(numbers, key=lambda n: self.kinds[n].mission.chaser.available_s[0]))
            for numbers in alike.values()
        )

    @property
    def has_timetable(self) -> bool:
        """Whether the timetables of all chasers are built."""
        return all(mission.has_timetable for mission in self.missions)

    def build(self, order: list[int] | None, enough: Callable[[float], bool]) -> Campaign:
        """The campaign once its timetables are built, or that of a part of its bodies.

        Parameters
        ----------
        order, enough
            As :class:`adr_opt.timetable.Timetable` takes them.
        """
        first = self.missions[0].build(order, enough)
        if first is not self.missions[0]:
            return Campaign(
                first.instance, threads=self._threads, margin=self.margin,
                connecting=first.connecting,
            ).build(None, lambda share: False)  # fmt: skip
        for mission in self.missions:
            assert mission.timetable.instance is self.instance
        return self

    def with_margin(self, margin: float) -> Campaign:
        """The same campaign with another share of each tank kept back."""
        return Campaign(
            self.instance, threads=self._threads, margin=margin, connecting=self.connecting
        )

    def corrected(self, corrections: Corrections) -> Campaign:
        """The same campaign over connections that cost more than the model says."""
        return Campaign(
            self.instance, threads=self._threads, margin=self.margin,
            connecting=self.connecting.corrected(corrections),
        )  # fmt: skip

    def closed(self, routes: Iterable[Iterable[int]]) -> Routes:
        """Routes as missions end, see :meth:`Mission.closed`."""
        return tuple(
            mission.closed(route) for mission, route in zip(self.missions, routes, strict=True)
        )


Problem = Mission | Campaign
"""What is planned: with one chaser or with several."""


def is_campaign(instance: Instance) -> bool:
    """Whether an instance is planned as a campaign: several chasers, or one whose load counts."""
    if len(instance.chasers) > 1:
        return True
    return loads_of(instance, instance.chasers[0], 0.0) is not None


def problem_of(instance: Instance | Problem, threads: int | None = None) -> Problem:
    """An instance ready for planning, see :func:`is_campaign`."""
    if not isinstance(instance, Instance):
        return instance
    if is_campaign(instance):
        return Campaign(instance, threads=threads)
    return Mission(instance, threads=threads)
