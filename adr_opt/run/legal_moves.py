"""The legal beginning of a sequence of bodies, and why its next move is not legal."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from ..common.constants import DAY_S, HOUR_S
from ..common.errors import InputError
from ..kernels.core.windows import service_ends
from ..kernels.rules.loads import Loads
from ..mission.mission import Mission
from ..mission.orders import told, why_broken
from ..mission.schedule import FloatArray


def legal_beginning(
    mission: Mission, destinations: Iterable[str], *, repair: bool
) -> tuple[int, ...]:
    """The bodies with these names, up to the first that the mission lacks.

    Raises
    ------
    InputError
        Without ``repair``: a move is illegal; the sentence says which and why.
    """
    index = {name: number for number, name in enumerate(mission.names)}
    moves = [index[name] for name in takewhile(index.__contains__, destinations)]
    timing = mission.time(moves)
    if timing.made < len(moves) and not repair:
        # Next to impossible for a plan that was checked: rounding at the very edge of the slack.
        raise InputError(
            f"start plan: leg {timing.made + 1} {why_illegal(mission, moves, timing.made)}; "
            "correct it; to keep its legal beginning only, solve with repair"
        )
    return tuple(moves[: timing.made])


def why_illegal(mission: Mission, moves: list[int], made: int) -> str:
    """Reason why the first illegal move of a sequence is illegal."""
    why = why_broken(mission.rules, moves[: made + 1], mission.schedules.kits_for)
    if why:
        return told(mission.rules, why, mission.names[moves[made]])
    return why_not_flown(mission, moves, made)


class _Ways(NamedTuple):
    """All ways to fly the leg, as arrays: cost of each, tow included, and its end.

    Attributes
    ----------
    needs_m_s, left_m_s : (ways,) float64
        What is needed for it, and left before it.
    end_s : (ways,) float64
        End of the service, or of the tow.
    """

    needs_m_s: FloatArray
    left_m_s: FloatArray
    end_s: FloatArray


def why_not_flown(mission: Mission, moves: list[int], made: int) -> str:
    """Reason why a chaser cannot make the next move of an otherwise legal order.

    Of all ways to have flown the moves before it, and of all connections. ΔV is named if some way
    would be in time, time if some way can be paid, and both if neither is so, or either would do.
    """
    rules, j = mission.rules, moves[made]
    name = repr(mission.names[j])
    if rules.is_station[j] and rules.windows.closing[j] == -math.inf:
        return f"goes to {name}, whose refuellings are used up"
    ways = _ways(mission, moves, made)
    if not ways.end_s.size:
        return f"goes to {name}, but no transfer there leaves in time"
    lacks_m_s = ways.needs_m_s - ways.left_m_s
    in_time = ways.end_s <= rules.windows.closing[j] + rules.service[j]
    paid = lacks_m_s <= 0.0
    told = []
    if in_time.any() or not paid.any():
        nearest = int(np.argmin(np.where(in_time | ~in_time.any(), lacks_m_s, np.inf)))
        besides = ", the tow included" if rules.loads is not None and rules.loads.flown[j] else ""
        when = " to end in time" if in_time.any() and paid.any() else ""
        told.append(
            f"needs {ways.needs_m_s[nearest]:.6g} m/s{when}{besides}, but only "
            f"{ways.left_m_s[nearest]:.6g} m/s are left"
        )
    if paid.any() or not in_time.any():
        earliest_s = float(np.min(ways.end_s[paid | ~paid.any()]))
        what = "an affordable leg " if in_time.any() else ""
        told.append(
            f"{what}ends on {_day(earliest_s)} at the earliest{_after(mission, j, earliest_s)}"
        )
    return f"to {name} {', and '.join(told)}"


def _ways(mission: Mission, moves: list[int], made: int) -> _Ways:
    """Every connection of the leg, from every state in which it may begin."""
    rules, schedules, j = mission.rules, mission.schedules, moves[made]
    whole = tuple(moves[: mission.in_order(tuple(moves))])
    # The kits of all of the order are aboard, as when it was timed.
    kits = schedules.kits_for(whole)
    if rules.loads is not None:
        kits = min(kits, rules.loads.full.size - 1)
    before = tuple(moves[:made])
    front = schedules.fronts(before, kits)[-1]
    body = before[-1] if before else rules.start
    extra_m_s = _for_service(rules.loads, j, kits - schedules.kits_for(before))
    spent_m_s = mission.connecting.spent_m_s(body)
    open_end = rules.windows.later(j, math.inf)
    found = []
    for ready_s, left_m_s in zip(front.ready, front.left, strict=True):
        after = schedules.from_ready(body, j, np.array([ready_s])).after(float(ready_s))
        ends_s = service_ends(open_end, j, after.arrival, rules.service[j])
        needs_m_s = after.delta_v + (extra_m_s - spent_m_s)
        found.append((needs_m_s, np.full(ends_s.size, left_m_s - spent_m_s), ends_s))
    return _Ways(*(np.concatenate(columns) for columns in zip(*found, strict=True)))


def _for_service(loads: Loads | None, body: int, kits: int) -> float:
    """ΔV needed on arrival for the service, as for a tow [m/s]."""
    if loads is None:
        return 0.0
    scale, loss = loads.scale[body, kits], loads.loss[body, kits]
    if loss == 0.0 or not math.isfinite(loads.exhaust):
        return 0.0
    return max(loads.exhaust * math.log((1.0 + loss) / scale), 0.0)


def _after(mission: Mission, body: int, end_s: float) -> str:
    """The limit that the end of a leg exceeds, in words."""
    rules = mission.rules
    service_s, closing_s = float(rules.service[body]), float(rules.windows.closing[body])
    if end_s <= rules.duration:
        return f", {_lasting(end_s - service_s - closing_s)} after its window closes"
    ends = "the mission"
    if rules.duration < mission.instance.mission.duration_s:
        ends = "its chaser is gone"
    closed = ", and its window closes before" if closing_s < rules.duration - service_s else ""
    return f", {_lasting(end_s - rules.duration)} after {ends}{closed}"


def _day(time_s: float) -> str:
    return f"day {time_s / DAY_S:.3f}"


def _lasting(duration_s: float) -> str:
    """A duration in its most readable unit."""
    for unit_s, name in ((DAY_S, "d"), (HOUR_S, "h"), (60.0, "min")):
        if duration_s >= unit_s:
            return f"{duration_s / unit_s:.3g} {name}"
    return f"{duration_s:.3g} s"
