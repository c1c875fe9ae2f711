"""Remedies for an order that cannot be flown: more ΔV or time, or one change of the order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Literal

from ..common.constants import SLACK_S
from ..mission.mission import Mission
from ..mission.relaxed import LARGEST, LONGEST, Relaxed, with_tank

Moves = tuple[int, ...]


@dataclass(frozen=True)
class Shortfall:
    """Additional resources with which the whole order could be flown.

    Attributes
    ----------
    delta_v_m_s : float or None
        Additional ΔV of each full tank, all else unchanged; None where no tank of four times the
        size would do, or where it is not ΔV that is missing.
    time_s : float or None
        Additional time before the mission or the chaser's availability ends, likewise; None
        where twice the time would not do.
    window_s : float or None
        Additional opening time of the target's window where the order breaks, likewise.
    both : bool
        Neither ΔV nor time alone is enough, and the two figures are together: the least time that
        would do with any tank, and the least tank for that time.
    """

    delta_v_m_s: float | None = None
    time_s: float | None = None
    window_s: float | None = None
    both: bool = False

    def to_dict(self) -> dict[str, Any]:
        """The shortfall as JSON data."""
        return asdict(self)


@dataclass(frozen=True)
class Remedy:
    """A change of an order that makes all of it flyable.

    Attributes
    ----------
    kind : {"leave-out", "refuel", "swap"}
        One target is left out; the chaser refuels before a body; two neighbours change places.
    body : str
        Which is left out; before which it refuels; the first of those that change places.
    order : tuple of str
    prize : float
        Of its targets, without what planners add for those that are required.
    delta_v_m_s, end_s : float
        Of all legs and tows, and the end of the last service, or tow.
    """

    kind: Literal["leave-out", "refuel", "swap"]
    body: str
    order: tuple[str, ...]
    prize: float
    delta_v_m_s: float
    end_s: float

    def to_dict(self) -> dict[str, Any]:
        """The change as JSON data."""
        return {**asdict(self), "order": list(self.order)}


def remedies(mission: Mission, moves: Moves) -> tuple[Remedy, ...]:
    """All single changes that repair an order, by remaining prize, then by cost."""
    found: list[tuple[float, float, int, Remedy]] = []
    for kind, body, changed in _changes(mission, moves):
        timing = mission.time(changed)
        if timing.made < len(changed) or not mission.may_stop(changed):
            continue
        names = tuple(mission.names[j] for j in changed)
        prize = mission.prizes(changed, timing.ends.tolist())
        end_s = float(timing.ends[-1]) if changed else 0.0
        remedy = Remedy(kind, mission.names[body], names, prize, timing.delta_v, end_s)
        found.append((-prize, timing.cost, len(found), remedy))
    return tuple(entry[-1] for entry in sorted(found))


def _changes(
    mission: Mission, moves: Moves
) -> Iterator[tuple[Literal["leave-out", "refuel", "swap"], int, Moves]]:
    required = mission.required
    for at, j in enumerate(moves):
        # What is required may not be left out, but for its second visit.
        if j not in required or moves.count(j) > 1:
            yield "leave-out", j, moves[:at] + moves[at + 1 :]
    for at, j in enumerate(moves[1:], start=1):
        for station in range(mission.rules.stations):
            yield "refuel", j, (*moves[:at], station, *moves[at:])
        yield "swap", moves[at - 1], (*moves[: at - 1], j, moves[at - 1], *moves[at + 1 :])


def missing(mission: Mission, moves: Moves, made: int) -> Shortfall:
    """Additional resources for an order that breaks after a number of moves."""
    if mission.in_order(moves) < len(moves):
        return Shortfall()  # the order itself is against the rules, and nothing helps
    chaser = mission.chaser
    larger, longer = with_tank(chaser, LARGEST), mission.instance.mission.duration_s * LONGEST
    tank, time = Relaxed(mission, larger, None), Relaxed(mission, chaser, longer)
    by_tank = tank.least_scale(moves)
    by_time = time.least_end(moves, 1.0)
    both = by_tank is None and by_time is None
    if both:
        by_time = Relaxed(mission, larger, longer).least_end(moves, LARGEST)
        if by_time is not None:
            tank = Relaxed(mission, larger, by_time)
            by_tank = tank.least_scale(moves)
        both = by_tank is not None
        if not both:
            by_time = None
    return Shortfall(
        None if by_tank is None else tank.added_m_s(by_tank),
        None if by_time is None else max(by_time - mission.rules.duration, 0.0),
        _window(mission, moves, made),
        both,
    )


def _window(mission: Mission, moves: Moves, made: int) -> float | None:
    """Additional opening time of the window at which an order breaks [s]."""
    rules, j = mission.rules, moves[made]
    latest, service = float(rules.windows.closing[j]), float(rules.service[j])
    if not latest < rules.duration - service:
        return None
    longer = rules.windows.later(j, rules.duration - service)
    scheduler = mission.schedules.under(rules._replace(windows=longer))
    fronts = scheduler.fronts(moves)
    if len(fronts) <= len(moves):
        return None
    # The way that is earliest there need not be one that can go on; so it is asked of each end.
    ends = sorted(set(fronts[made + 1].ready.tolist()))
    low, high = 0, len(ends) - 1
    while low < high:
        middle = (low + high) // 2
        longer = rules.windows.later(j, ends[middle] - service + SLACK_S)
        again = mission.schedules.under(rules._replace(windows=longer))
        if len(again.fronts(moves)) > len(moves):
            high = middle
        else:
            low = middle + 1
    return float(max(ends[low] - service - latest, 0.0))
