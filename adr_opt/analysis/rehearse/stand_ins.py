"""Bodies that stand for targets in a known world, and those whose prizes fall with time.

See docs/model.md section 13.3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...problem.bodies import Target
from ...problem.capture_windows import intervals_of, windows_from
from ...problem.instance import Instance
from ...problem.world import DrawnWorld
from .mission_facts import MissionFacts
from .worths import Counted

UNIT_DIGITS, ALMOST = 3, 1e-9
"""Digits of falling prizes after the first digit of the largest prize; excess that counts as
rounding [units]."""


class StandIn(NamedTuple):
    """A body that stands for a target in a known world.

    Attributes
    ----------
    target : Target
    of : str
        Name of the target that it stands for.
    took_s : float
        Time of its service, without a tow [s].
    planned_s : float
        What that was planned to be [s].
    uncounted : int
        Services that count towards no maximum.
    over_s : float or None
        By what the service may end after the mission; None where it has to end before [s].
    """

    target: Target
    of: str
    took_s: float
    planned_s: float
    uncounted: int
    over_s: float | None = None


def timed_stand_in(
    facts: MissionFacts, world: DrawnWorld, counted: Counted, target: Target, planned_s: float
) -> StandIn:
    """A body for a target whose prize falls as less time is left at its service.

    One that has begun in time may go on after the mission.
    """
    name, mission_s = target.name, facts.instance.mission.duration_s
    is_gone = world.is_gone(name)
    took_s = 0.0 if is_gone else world.service_s(name, planned_s)
    caught = not is_gone and world.first_success(name) is not None
    unit = _unit(facts.instance)
    prizes = [counted.going_on, *(level.worth for level in counted.late or ())]
    *falling, last = (_whole(prize, unit) for prize in prizes)
    ends_s = [mission_s - level.below_s + took_s for level in counted.late or ()]
    until = [(end_s, prize) for end_s, prize in zip(ends_s, falling, strict=True) if end_s > 0.0]
    made = target.replace(
        prize=last,
        prize_until=_strictly_falling(until, last) or None,
        required=False,
        removal=target.removal if caught else "visit",
    )
    return StandIn(made, name, took_s, planned_s, int(not caught), max(took_s - planned_s, 0.0))


def _strictly_falling(
    levels: Sequence[tuple[float, float]], last: float
) -> tuple[tuple[float, float], ...]:
    """The levels without those from which a prize does not fall to the next one."""
    after = [*(prize for _, prize in levels), last][1:]
    return tuple(level for level, then in zip(levels, after, strict=True) if level[1] > then)


def _unit(instance: Instance) -> float:
    """Common step of falling prizes, about a thousandth of the largest."""
    most = max(target.prize for target in instance.targets)
    return 10.0 ** (math.floor(math.log10(most)) - UNIT_DIGITS) if most > 0.0 else 1.0


def _whole(prize: float, unit: float) -> float:
    """A prize rounded up to a multiple of a power of ten."""
    return float(f"{math.ceil(prize / unit - ALMOST) * unit:.12g}")


def in_time(stand_ins: Sequence[StandIn], instance: Instance) -> list[StandIn]:
    """The stand-ins with windows that end with the mission, and prizes of one unit.

    They are for a mission that is longer.

    A window limits when a service begins by what is planned of it. A service of a certain prize
    also has to end in time, or is left out.
    """
    kept, mission_s, unit = list[StandIn](), instance.mission.duration_s, _unit(instance)
    for part in stand_ins:
        late_s = 0.0 if part.over_s is not None else max(part.took_s - part.planned_s, 0.0)
        capture_s = part.target.capture_s
        over_s = late_s if capture_s is None else late_s + part.planned_s - capture_s
        found = intervals_of(part.target.windows)
        found[:, 1] = np.minimum(found[:, 1], mission_s - over_s)
        found = found[found[:, 1] > found[:, 0]]
        if len(found):
            own = {"window_s": (0.0, None), "windows_s": windows_from(found)}
            target = part.target.replace(prize=_whole(part.target.prize, unit), **own)
            kept.append(part._replace(target=target))
    return kept
