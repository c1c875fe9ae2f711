"""The mission of one chaser: an instance with a timetable and rules, as given to planners."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.constants import SLACK_M_S
from ..common.errors import InputError
from ..kernels.legs.co_elliptic import TransferRule
from ..kernels.rules import rules as kernels
from ..kernels.rules.resources import ANY, CountLimits
from ..kernels.tables import on_demand
from ..kernels.tables.timetable import Table, source_of, transfer_exists
from ..kernels.tables.timetable_making import Pairs
from ..legs.connection_finder import ConnectionFinder
from ..legs.corrections import Corrections
from ..legs.nearest_pairs import Neighbours
from ..legs.timetable import Timetable
from ..plan.cargo import loads_of, most_left_m_s
from ..problem.chasers import AtStation
from ..problem.instance import AnyInstance
from ..problem.rules import JUDGED, Follower, most_targets
from ..problem.support import followed
from .orders import first_break
from .prizes import Prizes
from .schedule import Schedule, Scheduler

Sequence = npt.NDArray[np.int64]


FOLLOWS = Follower("planning", JUDGED)
"""Rules that missions pass on to planners; each planner states which of them it follows."""


class Mission(Shown, Prizes):
    """The mission of a chaser of an instance, ready for planning.

    Parameters
    ----------
    instance : Instance, path or dict
    timetable : Timetable, optional
        Built on first use if not given.
    threads : int, optional
        Threads to build the timetable with; all cores by default.
    margin : float
        Share of each tank held in reserve: planners and bounds see only the rest.
    time_value_m_s_per_h : float, optional
        Value of an hour to planners that choose one connection per move without lookahead; by
        default the instance's [m/s per h].
    chaser : int, optional
        Number of the chaser that flies, where there are several.
    connecting : ConnectionFinder, optional
        Finder of the instance's connections, if one exists already.
    twin : Mission, optional
        Mission of a chaser of the same instance with the same availability, whose timetables and
        known connections are shared.

    Attributes
    ----------
    instance : Instance
    chaser : Chaser
    names : tuple of str
        Bodies, in the order of their numbers.
    margin : float

    Raises
    ------
    InputError
        There are several chasers, and none is named: see :class:`.problem.Problem`.
    """

    def __init__(
        self,
        instance: AnyInstance,
        timetable: Timetable | None = None,
        *,
        threads: int | None = None,
        margin: float = 0.0,
        time_value_m_s_per_h: float | None = None,
        chaser: int | None = None,
        connecting: ConnectionFinder | None = None,
        twin: Mission | None = None,
    ) -> None:
        instance = followed(instance, FOLLOWS)
        super().__init__(instance)
        if not 0.0 <= margin < 1.0:
            raise InputError(f"margin = {margin!r}: must be a share of the tank, from 0 to below 1")
        self.chaser = instance.chaser if chaser is None else instance.chasers[chaser]
        self._number = instance.chasers.index(self.chaser) if chaser is None else chaser
        self.margin = margin
        if time_value_m_s_per_h is None:
            time_value_m_s_per_h = instance.time_value_m_s_per_h
        self.time_value_m_s_per_h = time_value_m_s_per_h
        self._threads = threads
        self._variants: dict[float, Mission] = {time_value_m_s_per_h: self}
        self._twin = twin
        self._of_length: dict[tuple[float, float], Mission] = {}  # by duration and time value
        self._all: Mission | None = None  # that this one offers other worths of
        if connecting is not None:
            self.__dict__["connecting"] = connecting
        if timetable is not None:
            if not timetable.instance.same(instance):
                raise InputError("the timetable belongs to another instance")
            self.time_value_m_s_per_h = timetable.time_value_m_s_per_h
            self.__dict__["timetable"] = timetable
            self.__dict__["connecting"] = timetable.connecting
        self._of_length[instance.mission.duration_s, self.time_value_m_s_per_h] = self

    @cached_property
    def timetable(self) -> Timetable:
        """The timetable: exact costs of the connection chosen for every transfer at every time."""
        if self._twin is not None:
            return self._twin.timetable
        return Timetable(
            self.instance,
            self._threads,
            time_value_m_s_per_h=self.time_value_m_s_per_h,
            connecting=self.connecting,
            chaser=self._number,
        )

    @property
    def has_timetable(self) -> bool:
        """Whether the timetable has been built."""
        return "timetable" in self.__dict__ or (self._twin is not None and self._twin.has_timetable)

    @property
    def is_whole(self) -> bool:
        """Whether there is no timetable yet, or one with all pairs."""
        return not self.has_timetable or self.timetable.is_whole

    def build(
        self,
        pairs: Pairs | None,
        enough: Callable[[float], bool] = lambda share: False,
        most: int | None = None,
    ) -> None:
        """Build the timetable, of all pairs or some.

        Parameters
        ----------
        pairs, enough, most
            As :class:`Timetable` takes them.
        """
        self._forget()
        self.__dict__["timetable"] = Timetable(
            self.instance,
            self._threads,
            time_value_m_s_per_h=self.time_value_m_s_per_h,
            pairs=pairs,
            most=most,
            enough=enough,
            connecting=self.connecting,
            chaser=self._number,
        )

    def ask(self, near: Neighbours) -> None:
        """Do without a timetable: costs of a pair are computed when a search first asks for them.

        Parameters
        ----------
        near : Neighbours
            Destinations that searches examine.
        """
        self._forget()
        self.__dict__["timetable"] = Timetable(
            self.instance,
            time_value_m_s_per_h=self.time_value_m_s_per_h,
            connecting=self.connecting,
            chaser=self._number,
            examined=near,
        )

    def do_without(self) -> None:
        """Do without a timetable, for planners that examine connections themselves."""
        bodies = len(self.names)
        self.build(Pairs(np.arange(bodies), np.empty((bodies, 0), dtype=np.int32)), most=0)

    def forget_table(self) -> None:
        """Discard the timetable, which is built anew once it is needed."""
        self._forget()
        self.__dict__.pop("timetable", None)

    def _forget(self) -> None:
        """Discard everything derived from another timetable."""
        for name in ("rules", "has_transfer"):
            self.__dict__.pop(name, None)
        self._variants = {self.time_value_m_s_per_h: self}

    @cached_property
    def rules(self) -> kernels.Rules:
        """The mission as kernels take it; its arrays are read-only."""
        limits, table = self.timetable.limits, self.timetable.table
        instance, chaser = self.instance, self.chaser
        bodies, stations = limits.service.size, len(instance.stations)
        is_station = np.arange(bodies) < stations
        may_end = np.ones(bodies, dtype=np.bool_)
        if isinstance(chaser.end, AtStation):
            may_end[:] = [name == chaser.end.station for name in self.names]
        for array in (is_station, may_end):
            array.setflags(write=False)
        loads = loads_of(instance, chaser, self.margin)
        budget = chaser.usable.delta_v_m_s - self.reserve_m_s + SLACK_M_S
        if loads is not None:
            budget = most_left_m_s(loads)
        return kernels.Rules(
            table=table,
            service=limits.service,
            windows=limits.windows,
            prize=self.planning_prizes,
            is_station=is_station,
            may_end=may_end,
            stations=stations,
            first_target=instance.first_target,
            start=instance.starts[self._number],
            ready=limits.ready,
            limits=self.limits,
            returns=not may_end.all(),
            budget=budget,
            duration=limits.duration,
            shortest_sortie=_shortest_sortie(
                table, limits.service, budget, stations, instance.first_target
            ),
            loads=loads,
            falls=self.falls,
        )

    @property
    def reserve_m_s(self) -> float:
        """ΔV reserved in each tank [m/s]."""
        return self.margin * self.chaser.usable.delta_v_m_s

    @property
    def most_targets(self) -> int | None:
        """Maximum number of targets; ``None`` if unlimited."""
        return most_targets(self.instance, self.chaser)

    @property
    def limits(self) -> CountLimits:
        """Limits on the chaser's counts, without those that all targets together satisfy."""
        targets = len(self.instance.targets)

        def limit(most: int | None) -> int:
            return ANY if most is None or most >= targets else most

        return CountLimits(
            targets=limit(self.most_targets), between=limit(self.chaser.max_visits_between_refuels)
        )

    def _like(self, **changes: Any) -> Mission:
        """The same mission with some arguments changed."""
        arguments: dict[str, Any] = {
            "threads": self._threads,
            "margin": self.margin,
            "time_value_m_s_per_h": self.time_value_m_s_per_h,
            "chaser": self._number,
            "connecting": self.connecting,
        }
        arguments |= changes
        return Mission(arguments.pop("instance", self.instance), **arguments)

    def with_margin(self, margin: float) -> Mission:
        """The same mission with another reserved share of each tank; the timetable is shared."""
        return self._like(timetable=self.__dict__.get("timetable"), margin=margin)

    def offering(self, worths: npt.NDArray[np.float64]) -> Mission:
        """The same mission with other prizes for planners, and no required targets.

        Parameters
        ----------
        worths : (bodies,) float64
            0 except for targets; −inf for targets that must not be serviced.
        """
        if self._all is not None:
            return self._all.offering(worths)
        other = self._like(twin=self)
        other._all = self
        barred = np.isneginf(worths)
        offered = np.where(barred, 0.0, worths)
        windows = self.rules.windows.until(np.where(barred, -np.inf, np.inf))
        offered.setflags(write=False)
        other.__dict__ |= {
            "planning_prizes": offered,
            "is_required": np.zeros(worths.size, dtype=np.bool_),
            "prize_step": 0.0,
            "rules": self.rules._replace(prize=offered, windows=windows),
        }
        other.__dict__["schedules"] = self.schedules.under(other.rules)
        return other

    def with_limits(
        self,
        duration_s: float | None = None,
        delta_v_m_s: float | None = None,
        propellant_kg: float | None = None,
    ) -> Mission:
        """The same mission with another duration or tank, reusing known connections.

        Missions made from one share its timetable if only tanks differ, and its cached connections
        if it is shortened. Under J2, and where departures are spaced, another tank has connections
        of its own.

        Parameters
        ----------
        duration_s : float, optional
            No longer than this mission [s].
        delta_v_m_s : float, optional
            Of a full tank [m/s].
        propellant_kg : float, optional
            Of a full tank by mass, instead [kg].

        Raises
        ------
        InputError
            A limit is not valid, or the duration exceeds this mission's.
        """
        instance = self.instance.with_limits(duration_s, delta_v_m_s, propellant_kg)
        connecting = self.connecting.limited(instance)
        usual = self.time_value_m_s_per_h == self.instance.time_value_m_s_per_h
        worth = instance.time_value_m_s_per_h if usual else self.time_value_m_s_per_h
        key = instance.mission.duration_s, worth
        # Where events are regular, all tanks have one table: that of the first mission so long.
        twin = None if connecting.is_listed else self._of_length.get(key)
        made = self._like(
            instance=instance, connecting=connecting, time_value_m_s_per_h=worth, twin=twin
        )
        made._of_length = self._of_length
        self._of_length.setdefault(key, made)
        return made

    def corrected(self, corrections: Corrections) -> Mission:
        """The same mission with corrected costs of connections.

        Cached connections of the model are shared; the timetable is built again.
        """
        return self._like(connecting=self.connecting.corrected(corrections))

    def with_time_value(self, time_value_m_s_per_h: float) -> Mission:
        """The same mission with the timetable of another choice; earlier tables are kept.

        Returns the mission itself if its timetable has some pairs only, as another would take all
        the time.

        Raises
        ------
        InputError
            The time value is negative or not finite.
        """
        source = source_of(self.timetable.table) if self.has_timetable else None
        may_change = self.is_whole or source is not None
        if time_value_m_s_per_h == self.time_value_m_s_per_h or not may_change:
            return self
        if time_value_m_s_per_h not in self._variants:
            if self._all is None:
                twin = self._twin and self._twin.with_time_value(time_value_m_s_per_h)
                other = self._like(time_value_m_s_per_h=time_value_m_s_per_h, twin=twin)
                other.__dict__["schedules"] = self.schedules
                if source is not None:
                    other.ask(Neighbours(source.near, source.period))
            else:
                barred = np.isneginf(self.rules.windows.closing)
                worths = np.where(barred, -np.inf, self.planning_prizes)
                other = self._all.with_time_value(time_value_m_s_per_h).offering(worths)
            other._variants = self._variants
            self._variants[time_value_m_s_per_h] = other
        return self._variants[time_value_m_s_per_h]

    @cached_property
    def connecting(self) -> ConnectionFinder:
        """Finder of the connections of pairs."""
        return ConnectionFinder(self.instance, chaser=self._number)

    @cached_property
    def over_all(self) -> Scheduler:
        """Schedules over all connections, where :attr:`schedules` are restricted to some."""
        return self.schedules

    @cached_property
    def schedules(self) -> Scheduler:
        """Finder of the best schedule of an order of bodies."""
        if self._twin is not None:
            return self._twin.schedules.under(self.rules, self.chaser)
        return Scheduler(
            self.connecting,
            lambda: self.rules,
            self.instance.objective.cost,
            self.chaser,
            self.instance.time_m_s_per_s,
        )

    @cached_property
    def transfer_inputs(
        self,
    ) -> tuple[
        npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64], TransferRule
    ]:
        """Data that determine transfers, as in :attr:`.ConnectionFinder.inputs`."""
        return self.connecting.inputs

    @cached_property
    def has_transfer(self) -> npt.NDArray[np.bool_]:
        """Whether any body has a transfer to each body, at any departure event, shape (bodies,)."""
        table = self.rules.table
        if source_of(table) is not None:  # one would have to ask for all pairs
            return np.ones(len(self.names), dtype=np.bool_)
        found: npt.NDArray[np.bool_] = transfer_exists(table)
        return found

    @property
    def has_functions(self) -> bool:
        """Whether arrivals of any pair are a function of time."""
        return self.connecting.has_functions

    def numbers(self, sequence: Iterable[int | str]) -> Sequence:
        """Numbers of bodies given by number or name.

        Raises
        ------
        InputError
            There is no such body.
        """
        moves = list(sequence)
        if any(isinstance(body, str) for body in moves):
            index: dict[int | str, int] = {name: at for at, name in enumerate(self.names)}
            for body in moves:
                if isinstance(body, str) and body not in index:
                    raise InputError(f"{body!r} is not a body of {self.instance.name!r}")
            moves = [index.get(body, body) for body in moves]
        numbers = np.array(moves) if moves else np.empty(0, dtype=np.int64)
        if moves and not (
            numbers.dtype.kind in "iu" and numbers.min() >= 0 and numbers.max() < len(self.names)
        ):
            raise InputError(
                f"a sequence may only name the bodies 0 to {len(self.names) - 1}, by their numbers "
                "or their names"
            )
        return numbers.astype(np.int64)

    def named(self, sequence: Iterable[int | str]) -> tuple[str, ...]:
        """Names of bodies given by number or name.

        Raises
        ------
        InputError
            There is no such body.
        """
        return tuple(self.names[j] for j in self.numbers(sequence).tolist())

    def time(self, sequence: Iterable[int | str]) -> Schedule:
        """The best schedule of an order of bodies, by number or name, as far as it is legal.

        Of all schedules over all connections, waiting allowed, the one of least cost. Moves that
        the rules of the order forbid end it.
        """
        moves = tuple(self.numbers(sequence).tolist())
        return self.schedules.of(moves[: self.in_order(moves)])

    def time_by_class(self, sequence: Iterable[int | str]) -> Schedule:
        """The best schedule of an order, including legs of lighter chasers, as plans have it.

        Planners look for orders with :meth:`time`, which takes the legs of the heaviest chaser.
        """
        moves = tuple(self.numbers(sequence).tolist())
        return self.schedules.by_class.of(moves[: self.in_order(moves)])

    def in_order(self, moves: tuple[int, ...]) -> int:
        """Number of leading moves within the rules of orders: no repeats, refuelling earned."""
        return first_break(self.rules, moves)[0]

    def may_stop(self, sequence: tuple[int, ...]) -> bool:
        """Whether a mission may end after these moves."""
        rules = self.rules
        return bool(rules.may_end[sequence[-1] if sequence else rules.start])

    def closed(self, sequence: Iterable[int | str]) -> tuple[int, ...]:
        """A sequence made to end legally: without an unused refuelling, and at an allowed end.

        Bodies are given by number or name, and returned as numbers. If the mission must end at a
        station, the one reached at least cost is added; a sequence after which none can be reached
        is returned unchanged.
        """
        rules = self.rules
        listed = list(sequence)
        named = any(isinstance(body, str) for body in listed)
        moves = self.numbers(listed).tolist() if named else [int(j) for j in listed]
        while moves and rules.is_station[moves[-1]]:
            moves.pop()
        if self.may_stop(tuple(moves)):
            return tuple(moves)
        ways = [(*moves, s) for s in range(rules.stations) if rules.may_end[s]]
        made = [(self.time(way), way) for way in ways]
        flown = [
            (timing.cost, timing.delta_v, way) for timing, way in made if timing.made == len(way)
        ]
        return min(flown)[-1] if flown else tuple(moves)


def _shortest_sortie(
    table: Table, service: npt.NDArray[np.float64], budget: float, stations: int, first_target: int
) -> float:
    """Lower bound on the time from a station's departure to the end of a service [s]."""
    source = source_of(table)
    if source is not None:
        return float(on_demand.shortest_sortie(source, stations, first_target))
    return float(kernels.shortest_sortie(table, service, budget, stations, first_target))
