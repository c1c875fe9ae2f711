"""The mission: an instance with its timetable and its rules, as every planner gets it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from .errors import InputError
from .instance import Instance
from .kernels import orbits as orbit_kernels
from .kernels import rules as kernels
from .kernels.constants import SLACK_M_S, SLACK_S, STATION
from .kernels.timetable import transfer_exists
from .kernels.transfer import TransferRule
from .support import refuse_unsupported
from .timetable import Timetable
from .tolerance import common_step

Sequence = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Timing:
    """What happens when a sequence of bodies is visited as far as the rules allow.

    Attributes
    ----------
    made : int
        Number of legal moves; less than the length of the sequence if a move is illegal.
    objective : float
        Sum of the prizes of the moves made.
    delta_v : float
        Total ΔV of the moves made [m/s].
    ends, lefts : (made,) float64
        End of service [s] and ΔV left [m/s] after each move, as the rules count it: with the slack
        that a tank may be overdrawn by.
    """

    made: int
    objective: float
    delta_v: float
    ends: npt.NDArray[np.float64]
    lefts: npt.NDArray[np.float64]


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

    Attributes
    ----------
    instance : Instance
    names : tuple of str
        Bodies, the station first (index 0).
    margin : float
    """

    def __init__(
        self,
        instance: Instance,
        timetable: Timetable | None = None,
        *,
        threads: int | None = None,
        margin: float = 0.0,
    ) -> None:
        if not 0.0 <= margin < 1.0:
            raise InputError(f"margin = {margin!r}: must be a share of the tank, from 0 to below 1")
        refuse_unsupported(instance)
        self.instance = instance
        self.margin = margin
        self.names = instance.names
        self._threads = threads
        if timetable is not None:
            if not timetable.instance.same(instance):
                raise InputError("the timetable belongs to another instance")
            self.__dict__["timetable"] = timetable

    @cached_property
    def timetable(self) -> Timetable:
        """The exact costs of every transfer at every time."""
        return Timetable(self.instance, self._threads)

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
        timetable = Timetable(self.instance, self._threads, order=order, enough=enough)
        if timetable.instance is not self.instance:
            return Mission(timetable.instance, timetable, margin=self.margin)
        self.__dict__["timetable"] = timetable
        return self

    @cached_property
    def rules(self) -> kernels.Rules:
        """The mission as the kernels take it; its arrays are read-only."""
        limits = self.instance.mission
        assert limits.service_revolutions is not None  # refused above
        periods = np.array(
            [orbit_kernels.period(radius) for radius in self.instance.orbits()[:, 0]]
        )
        service = limits.service_revolutions * periods
        service[STATION] = limits.refuel_revolutions * periods[STATION]
        prize = np.array([0.0, *(target.prize for target in self.instance.targets)])
        service.setflags(write=False)
        prize.setflags(write=False)
        return kernels.Rules(
            self.timetable.table,
            service,
            prize,
            self.instance.chaser.tank.delta_v_m_s - self.reserve_m_s + SLACK_M_S,
            limits.duration_s + SLACK_S,
        )

    @property
    def reserve_m_s(self) -> float:
        """What is kept back of each tank [m/s]."""
        return self.margin * self.instance.chaser.tank.delta_v_m_s

    def with_margin(self, margin: float) -> Mission:
        """The same mission, timetable included, with another share of each tank kept back."""
        made = self.__dict__.get("timetable")
        return Mission(self.instance, made, threads=self._threads, margin=margin)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the instance, worked out once."""
        return self.instance.sha256

    @cached_property
    def transfer_inputs(
        self,
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], TransferRule]:
        """Orbits, eccentricity costs and transfer rule of the instance, worked out once."""
        instance = self.instance
        return instance.orbits(), instance.eccentricity_delta_v(), instance.transfer_rule()

    @cached_property
    def has_transfer(self) -> npt.NDArray[np.bool_]:
        """Whether any body has a transfer to a body at any departure event, shape (bodies,)."""
        found: npt.NDArray[np.bool_] = transfer_exists(self.rules.table)
        return found

    @property
    def total_prize(self) -> float:
        """Sum of all prizes: the trivial upper bound."""
        return float(sum(target.prize for target in self.instance.targets))

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

    def time(self, sequence: Iterable[int | str]) -> Timing:
        """Time a sequence of bodies, by number or by name, exactly, as far as it is legal."""
        moves = self.numbers(sequence)
        ends, lefts = np.empty(moves.size), np.empty(moves.size)
        rules = self.rules
        visited = np.zeros(len(self.names), dtype=np.bool_)
        made, delta_v = kernels.replay(
            rules, moves, 0, STATION, 0.0, rules.budget, 0, visited, ends, lefts
        )
        objective = float(kernels.collected(rules, moves[:made]))
        return Timing(int(made), objective, float(delta_v), ends[:made], lefts[:made])
