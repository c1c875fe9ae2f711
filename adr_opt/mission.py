"""The mission: an instance with its timetable and its rules, as every planner gets it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .chasers import AtStation
from .connections import Connecting
from .corrections import Corrections
from .errors import InputError
from .instance import Instance
from .kernels import rules as kernels
from .kernels.constants import SLACK_M_S
from .kernels.timetable import transfer_exists
from .kernels.transfer import TransferRule
from .schedule import Schedule, Scheduler
from .timetable import Timetable
from .tolerance import RELATIVE, ROUNDING, common_step

Sequence = npt.NDArray[np.int64]


class Mission:
    """An instance ready for planning.

    Parameters
    ----------
    instance : Instance
    timetable : Timetable, optional
        Built on first use if not given.
    threads : int, optional
        Threads to build the timetable with; all cores by default.
    margin : float
        Share of each tank that is kept back: planners and bounds see the rest only.
    time_value_m_s_per_h : float, optional
        What an hour is worth to planners that choose one connection for each move without looking
        ahead; the instance's by default [m/s per h].

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, in the order of their numbers.
    margin : float
    """

    def __init__(
        self,
        instance: Instance,
        timetable: Timetable | None = None,
        *,
        threads: int | None = None,
        margin: float = 0.0,
        time_value_m_s_per_h: float | None = None,
    ) -> None:
        if not 0.0 <= margin < 1.0:
            raise InputError(f"margin = {margin!r}: must be a share of the tank, from 0 to below 1")
        self.instance = instance
        self.margin = margin
        self.names = instance.names
        if time_value_m_s_per_h is None:
            time_value_m_s_per_h = instance.time_value_m_s_per_h
        self.time_value_m_s_per_h = time_value_m_s_per_h
        self._threads = threads
        self._variants: dict[float, Mission] = {time_value_m_s_per_h: self}
        if timetable is not None:
            if not timetable.instance.same(instance):
                raise InputError("the timetable belongs to another instance")
            self.time_value_m_s_per_h = timetable.time_value_m_s_per_h
            self.__dict__["timetable"] = timetable
            self.__dict__["connecting"] = timetable.connecting

    @cached_property
    def timetable(self) -> Timetable:
        """The exact costs of the connection chosen for every transfer at every time."""
        return Timetable(
            self.instance, self._threads, time_value_m_s_per_h=self.time_value_m_s_per_h,
            connecting=self.connecting,
        )  # fmt: skip

    @property
    def has_timetable(self) -> bool:
        """Whether the timetable is built."""
        return "timetable" in self.__dict__

    def build(self, order: list[int] | None, enough: Callable[[float], bool]) -> Mission:
        """The mission once its timetable is built, or that of a part of its bodies.

        Parameters
        ----------
        order, enough
            As :class:`Timetable` takes them.
        """
        timetable = Timetable(
            self.instance, self._threads, time_value_m_s_per_h=self.time_value_m_s_per_h,
            order=order, enough=enough, connecting=self.connecting,
        )  # fmt: skip
        if timetable.instance is not self.instance:
            return Mission(timetable.instance, timetable, margin=self.margin)
        self.__dict__["timetable"] = timetable
        return self

    @cached_property
    def rules(self) -> kernels.Rules:
        """The mission as the kernels take it; its arrays are read-only."""
        limits, table = self.timetable.limits, self.timetable.table
        instance, chaser = self.instance, self.instance.chaser
        bodies, stations = limits.service.size, len(instance.stations)
        is_station = np.arange(bodies) < stations
        may_end = np.ones(bodies, dtype=np.bool_)
        if isinstance(chaser.end, AtStation):
            may_end[:] = [name == chaser.end.station for name in self.names]
        worth = np.zeros(bodies)
        worth[instance.first_target :] = [
            target.prize + self.bonus * target.required for target in instance.targets
        ]
        for array in (worth, is_station, may_end):
            array.setflags(write=False)
        budget = chaser.tank.delta_v_m_s - self.reserve_m_s + SLACK_M_S
        return kernels.Rules(
            table,
            limits.service,
            limits.opens,
            limits.closes,
            worth,
            is_station,
            may_end,
            stations,
            instance.first_target,
            instance.start,
            limits.ready,
            bodies if chaser.max_targets is None else chaser.max_targets,
            not may_end.all(),
            budget,
            limits.duration,
            kernels.shortest_sortie(table, limits.service, budget, stations, instance.first_target),
        )

    @cached_property
    def bonus(self) -> float:
        """What servicing a required target is worth to a planner, besides its prize.

        More than all prizes together, and a multiple of what they are multiples of.
        """
        prizes = [target.prize for target in self.instance.targets]
        return math.fsum(prizes) + (self.prize_step or max(prizes, default=0.0) or 1.0)

    @cached_property
    def is_required(self) -> npt.NDArray[np.bool_]:
        """Whether every plan services a body, shape (bodies,)."""
        is_required = np.zeros(len(self.names), dtype=np.bool_)
        is_required[self.instance.first_target :] = [
            target.required for target in self.instance.targets
        ]
        is_required.setflags(write=False)
        return is_required

    @cached_property
    def required(self) -> frozenset[int]:
        """The targets that every plan services."""
        return frozenset(np.flatnonzero(self.is_required).tolist())

    def worth(self, prizes: float) -> float:
        """What a plan with all required targets and so many prizes is worth to a planner."""
        return prizes + len(self.required) * self.bonus

    def shown(self, worth: float) -> float:
        """The prizes of what is worth so much to a planner; −inf if it lacks a required target."""
        if not self.required or not math.isfinite(worth):
            return worth
        prizes = worth - len(self.required) * self.bonus
        # The difference of two numbers that large has lost digits.
        step = self.prize_step or RELATIVE * self.bonus
        whole = step * round(prizes / step)
        if abs(prizes - whole) < ROUNDING * step:
            prizes = whole
        return prizes if prizes >= 0.0 else -math.inf

    @property
    def reserve_m_s(self) -> float:
        """What is kept back of each tank [m/s]."""
        return self.margin * self.instance.chaser.tank.delta_v_m_s

    def with_margin(self, margin: float) -> Mission:
        """The same mission, timetable included, with another share of each tank kept back."""
        made = self.__dict__.get("timetable")
        other = Mission(
            self.instance, made, threads=self._threads, margin=margin,
            time_value_m_s_per_h=self.time_value_m_s_per_h,
        )  # fmt: skip
        other.__dict__["connecting"] = self.connecting
        return other

    def corrected(self, corrections: Corrections) -> Mission:
        """The same mission over connections that cost more than the model says.

        What is kept of the model's connections is shared; the timetable is another one.
        """
        other = Mission(
            self.instance, threads=self._threads, margin=self.margin,
            time_value_m_s_per_h=self.time_value_m_s_per_h,
        )  # fmt: skip
        other.__dict__["connecting"] = self.connecting.corrected(corrections)
        return other

    def with_time_value(self, time_value_m_s_per_h: float) -> Mission:
        """The same mission with the timetable of another choice; what was built before is kept.

        Raises
        ------
        InputError
            The time value is negative or not finite.
        """
        if time_value_m_s_per_h == self.time_value_m_s_per_h:
            return self
        if time_value_m_s_per_h not in self._variants:
            other = Mission(
                self.instance, threads=self._threads, margin=self.margin,
                time_value_m_s_per_h=time_value_m_s_per_h,
            )  # fmt: skip
            other._variants = self._variants
            other.__dict__["connecting"] = self.connecting
            other.__dict__["schedules"] = self.schedules
            self._variants[time_value_m_s_per_h] = other
        return self._variants[time_value_m_s_per_h]

    @cached_property
    def connecting(self) -> Connecting:
        """Works out the connections of pairs."""
        return Connecting(self.instance)

    @cached_property
    def schedules(self) -> Scheduler:
        """Finds the best schedule of an order of bodies."""
        return Scheduler(self.connecting, lambda: self.rules, self.instance.objective.cost)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the instance, worked out once."""
        return self.instance.sha256

    @cached_property
    def transfer_inputs(
        self,
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], TransferRule]:
        """Orbits, eccentricity costs and transfer rule of the instance, worked out once."""
        return self.connecting.inputs

    @cached_property
    def has_transfer(self) -> npt.NDArray[np.bool_]:
        """Whether any body has a transfer to a body at any departure event, shape (bodies,)."""
        found: npt.NDArray[np.bool_] = transfer_exists(self.rules.table)
        return found

    @property
    def total_prize(self) -> float:
        """Sum of the prizes of as many targets as the chaser may service: the trivial bound."""
        return self._largest([target.prize for target in self.instance.targets])

    @property
    def total_worth(self) -> float:
        """The same of what targets are worth to a planner."""
        return self._largest(self.rules.prize.tolist())

    def _largest(self, prizes: list[float]) -> float:
        most = self.instance.chaser.max_targets
        return math.fsum(sorted(prizes, reverse=True)[:most])

    @cached_property
    def prize_step(self) -> float:
        """All objectives are multiples of it, so that a bound may be rounded down; 0 for none."""
        return common_step(target.prize for target in self.instance.targets)

    def numbers(self, sequence: Iterable[int | str]) -> Sequence:
        """The numbers of bodies that are given by number or by name.

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

    def time(self, sequence: Iterable[int | str]) -> Schedule:
        """The best schedule of an order of bodies, by number or by name, as far as it is legal.

        Of all schedules over all connections, waiting allowed, the one of least cost. Moves that
        the rules of the order forbid end it.
        """
        moves = tuple(self.numbers(sequence).tolist())
        return self.schedules.of(moves[: self._in_order(moves)])

    def _in_order(self, moves: tuple[int, ...]) -> int:
        """How many moves the rules of the order allow: no target twice, refuelling earned."""
        rules = self.rules
        body, since, visited = rules.start, 0, set[int]()
        for made, j in enumerate(moves):
            if j == body:
                return made
            if rules.is_station[j]:
                if since == 0:
                    return made
                since = 0
            elif j in visited or j < rules.first_target or len(visited) == rules.most_targets:
                return made
            else:
                visited.add(j)
                since += 1
            body = j
        return len(moves)

    def collected(self, sequence: Iterable[int]) -> float:
        """What the bodies of a sequence are worth to a planner; their order does not matter."""
        return math.fsum(self.rules.prize[j] for j in sequence)

    def prizes(self, sequence: Iterable[int]) -> float:
        """Sum of the prizes of a sequence of bodies."""
        first = self.instance.first_target
        return math.fsum(self.instance.targets[j - first].prize for j in sequence if j >= first)

    def lacking(self, sequence: Iterable[int]) -> tuple[int, ...]:
        """The required targets that a sequence of bodies leaves out."""
        return tuple(sorted(self.required.difference(sequence)))

    def may_stop(self, sequence: tuple[int, ...]) -> bool:
        """Whether a mission may end after these moves."""
        rules = self.rules
        return bool(rules.may_end[sequence[-1] if sequence else rules.start])

    def closed(self, sequence: Iterable[int]) -> tuple[int, ...]:
        """A sequence as a mission ends: without a refuelling that nothing follows, and at an end.

        Where the mission must end at a station, the one is added that can be reached at least
        cost; a sequence after which none can be reached stays as it is.
        """
        rules = self.rules
        moves = [int(j) for j in sequence]
        while moves and rules.is_station[moves[-1]]:
            moves.pop()
        if self.may_stop(tuple(moves)):
            return tuple(moves)
        ways = [(*moves, s) for s in range(rules.stations) if rules.may_end[s]]
        made = [(self.time(way), way) for way in ways]
        flown = [(timing.delta_v, way) for timing, way in made if timing.made == len(way)]
        return min(flown)[1] if flown else tuple(moves)
