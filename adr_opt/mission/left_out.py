"""Targets that a plan leaves out, each with the limit that keeps it out."""

from __future__ import annotations

from collections.abc import Iterable

from ..common.errors import InputError
from ..plan.plan import Reason, Unvisited
from .mission import Mission
from .orders import FULL, KITS, why_broken
from .relaxed import LARGEST, LONGEST, Relaxed, with_tank

_FURTHEST: tuple[Reason, ...] = (
    "not-considered",
    "no-transfer",
    "several",
    "duration",
    "delta-v",
    "kits",
    "capacity",
    "not-worth-it",
)
"""Obstacles to reaching a target, hardest first."""


def unvisited(flown: Iterable[tuple[Mission, Iterable[int]]]) -> tuple[Unvisited, ...]:
    """Targets left out of all sequences, each with its reason (see :class:`.plan.Unvisited`).

    Parameters
    ----------
    flown : iterable of (Mission, sequence of int)
        What each chaser visits. Of several the one is asked that comes nearest to the target.
    """
    found: dict[str, Reason] = {}
    routes = [(mission, tuple(int(j) for j in sequence)) for mission, sequence in flown]
    visited = {j for _, moves in routes for j in moves}
    for mission, moves in routes:
        limits = _Limits(mission, moves)
        for j in range(mission.rules.first_target, len(mission.names)):
            if j in visited:
                continue
            name, reason = mission.names[j], limits.before(j)
            if name not in found or _FURTHEST.index(reason) > _FURTHEST.index(found[name]):
                found[name] = reason
    return tuple(Unvisited(target=name, reason=reason) for name, reason in found.items())


class _Limits:
    """Limits that keep a chaser from one more leg after its moves.

    A limit is named if one more leg can be flown without it, and with all others as they are.
    """

    def __init__(self, mission: Mission, moves: tuple[int, ...]) -> None:
        self._mission, self._moves = mission, moves
        self._schedules = mission.schedules.by_class.unpriced
        self._known: dict[tuple[bool, bool], Relaxed | None] = {}

    def before(self, j: int) -> Reason:
        """The reason why a target cannot be the next move."""
        mission, more = self._mission, (*self._moves, j)
        rules = mission.rules
        if not mission.timetable.holds((rules.start, *more)[-2], j):
            return "not-considered"
        why = why_broken(rules, more, mission.schedules.kits_for)
        if not why and len(self._schedules.fronts(more)) > len(more):
            return "not-worth-it"
        tried: dict[Reason, dict[str, bool]] = {
            "delta-v": {"tank": True},
            "duration": {"time": True},
        }
        if why:
            tried = {"kits" if self._lacks_kit(why) else "capacity": {"counts": False}}
        tried["several"] = {"tank": True, "time": True, "counts": False}
        flown = (reason for reason, without in tried.items() if self._flies(more, **without))
        return next(flown, "no-transfer")

    def _lacks_kit(self, why: str) -> bool:
        """Whether an order has too few kits, rather than too many targets."""
        kits, most = self._mission.chaser.kits, self._mission.chaser.max_targets
        by_kits = why == FULL["targets"] and kits == self._mission.rules.limits.targets != most
        return why == KITS or by_kits

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
                made = Relaxed(mission, chaser, longer_s, windows=not time)
            except InputError:  # motion that is known for the time of the mission alone
                made = None
            self._known[key] = made
        relaxed = self._known[key]
        scale = LARGEST if tank else 1.0
        return relaxed is not None and relaxed.front(more, scale, counts=counts) is not None
