"""Targets that a plan leaves out, each with the limit that keeps it out."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial, reduce

from ..common.errors import InputError
from ..kernels.rules.loads import most_kits
from ..plan.plan import Reason, Unvisited
from .mission import Mission
from .orders import FULL, NOTHING, counts_after, why_full
from .relaxed import LARGEST, LONGEST, Relaxed, with_tank

_WITHOUT: dict[Reason, dict[str, bool]] = {
    "not-worth-it": {},
    "capacity": {"counts": False},
    "kits": {"counts": False},
    "delta-v": {"tank": True},
    "duration": {"time": True},
    "several": {"tank": True, "time": True, "counts": False},
    "no-transfer": {},
    "not-considered": {},
}
"""Limits that stand in the way of reaching a target, those nearest to it first."""


def unvisited(flown: Iterable[tuple[Mission, Iterable[int]]]) -> tuple[Unvisited, ...]:
    """Targets left out of all sequences, each with its reason (see :class:`.plan.Unvisited`).

    Parameters
    ----------
    flown : iterable of (Mission, sequence of int)
        What each chaser visits. Of several the one is asked that comes nearest to the target.
    """
    routes = [(mission, tuple(int(j) for j in sequence)) for mission, sequence in flown]
    visited = {j for _, moves in routes for j in moves}
    asked: dict[str, list[tuple[Reason, _Limits, int]]] = {}
    for mission, moves in routes:
        limits = _Limits(mission, moves)
        for j in range(mission.rules.first_target, len(mission.names)):
            if j not in visited:
                reasons = asked.setdefault(mission.names[j], [])
                reasons += [(reason, limits, j) for reason in limits.possible(j)]
    nearest = list(_WITHOUT)
    found: list[Unvisited] = []
    for name, reasons in asked.items():
        # Nearest first: connections of a longer mission take long, and are rarely asked for.
        reasons.sort(key=lambda one: nearest.index(one[0]))
        reason = next(reason for reason, limits, j in reasons if limits.are_all(reason, j))
        found.append(Unvisited(target=name, reason=reason))
    return tuple(found)


class _Limits:
    """Limits that keep a chaser from one more leg after its moves.

    A limit is named if one more leg can be flown without it, and with all others as they are.
    """

    def __init__(self, mission: Mission, moves: tuple[int, ...]) -> None:
        self._mission, self._moves = mission, moves
        self._schedules = mission.schedules.by_class.unpriced.passing
        self._known: dict[tuple[bool, bool], Relaxed | None] = {}
        counts_next = partial(counts_after, mission.rules)
        self._why_full = why_full(mission.rules, reduce(counts_next, moves, NOTHING))

    def possible(self, j: int) -> tuple[Reason, ...]:
        """Reasons why a target may not be the next move; the last one always holds."""
        mission, more = self._mission, (*self._moves, j)
        if not mission.timetable.holds((mission.rules.start, *more)[-2], j):
            return ("not-considered",)
        loads = mission.rules.loads
        lacks_kit = loads is not None and mission.schedules.kits_for(more) > most_kits(loads)
        if self._why_full or lacks_kit:
            by_kits = self._is_full_by_kits if self._why_full else lacks_kit
            return "kits" if by_kits else "capacity", "several", "no-transfer"
        return "not-worth-it", "delta-v", "duration", "several", "no-transfer"

    def are_all(self, reason: Reason, j: int) -> bool:
        """Whether the limits that a reason names are all that keep a target out."""
        more, without = (*self._moves, j), _WITHOUT[reason]
        if reason == "not-worth-it":
            return len(self._schedules.fronts(more)) > len(more)
        return not without or self._flies(more, **without)

    @property
    def _is_full_by_kits(self) -> bool:
        """Whether what allows no further target is too few kits, rather than a limit of targets."""
        kits, most = self._mission.chaser.kits, self._mission.chaser.max_targets
        limit = self._mission.rules.limits.targets
        return self._why_full == FULL["targets"] and kits == limit != most

    def _flies(
        self, more: tuple[int, ...], *, tank: bool = False, time: bool = False, counts: bool = True
    ) -> bool:
        """Whether a larger tank, more time or more targets make moves possible."""
        larger = tank or (time and not self._mission.connecting.depends_on_tank)
        key = larger, time
        if key not in self._known:
            mission = self._mission
            longer_s = LONGEST * mission.instance.mission.duration_s if time else None
            try:
                chaser = with_tank(mission.chaser, LARGEST) if larger else mission.chaser
                made = Relaxed(mission, chaser, longer_s, windows=not time, passing=True)
            except InputError:  # motion that is known for the time of the mission alone
                made = None
            self._known[key] = made
        relaxed = self._known[key]
        scale = LARGEST if tank else 1.0
        return relaxed is not None and relaxed.front(more, scale, counts=counts) is not None
