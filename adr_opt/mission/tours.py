"""Campaigns that can be planned as one tour through time, and rules that ask for one.

Chasers that are launched onto any target are one order of all targets, cut where a mission ends.
Where the time from one arrival to the next is limited, or missions are kept apart, to be earlier is
not always better (docs/model.md section 5.5), and planners that rely on it do not apply.
"""

from __future__ import annotations

from ..problem.instance import Instance
from .problem import Problem

LONGEST_LEG, SEPARATION = "transfer.max_leg_s", "mission.mission_separation_s"


def tour_rule(instance: Instance) -> str | None:
    """Field of a rule that only tours through time are planned with; None if none is set."""
    if instance.transfer.max_leg_s is not None:
        return LONGEST_LEG
    return None if instance.mission.mission_separation_s is None else SEPARATION


def tour_obstacle(problem: Problem) -> str | None:
    """Why a problem is no tour through time, as the end of a sentence; None if it is one."""
    instance = problem.instance
    if instance.transfer.given is not None or instance.transfer.max_drift_s <= 0.0:
        return "transfer.max_drift_s allows no drift legs"
    if instance.stations or instance.keep_out_zones:
        return "there are stations or keep-out zones"
    if instance.objective.cost == "duration":
        return 'the cost is "duration"'
    if not instance.targets or len(problem.kinds) > 1 or not instance.chasers[0].is_launched:
        return 'its chasers are not all alike and launched from "anywhere"'
    chaser = instance.chasers[0]
    few = [most for most in (chaser.max_targets, chaser.kits) if most is not None]
    if min(few, default=len(instance.targets)) < len(instance.targets) or chaser.tank.spent_m_s:
        return f"{chaser.name!r} has a limit of targets or kits, or a tank that is not full"
    if len({target.removal for target in instance.targets}) > 1:
        return "some targets take kits and others do not"
    for target in instance.targets:
        if not target.required:
            return f"{target.name!r} is not required"
        if target.removal == "tow" or target.window_s != (0.0, None):
            return f"{target.name!r} is towed or has a window"
    return None
