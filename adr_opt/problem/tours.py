"""Campaigns that can be planned as one tour through time.

Chasers that are launched onto any target are one order of all targets, cut where a mission ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .instance import Instance


def tour_obstacle(instance: Instance) -> str | None:
    """Why a campaign cannot be planned as one tour, as the end of a sentence; None if it can."""
    if instance.transfer.given is not None or instance.transfer.max_drift_s <= 0.0:
        return "transfer.max_drift_s allows no drift legs"
    if instance.has_low_thrust:
        return "chasers have low thrust"
    if instance.stations or instance.keep_out_zones:
        return "there are stations or keep-out zones"
    if instance.objective.cost == "duration":
        return 'the cost is "duration"'
    chaser = instance.chasers[0]
    if not instance.targets or not chaser.is_launched or not _are_alike(instance):
        return 'its chasers are not all alike and launched from "anywhere"'
    few = [most for most in (*chaser.most_visits, chaser.kits) if most is not None]
    if min(few, default=len(instance.targets)) < len(instance.targets) or chaser.spent_m_s:
        return f"{chaser.name!r} has a limit of targets or kits, or a tank that is not full"
    if len({target.removal for target in instance.targets}) > 1:
        return "some targets take kits and others do not"
    if instance.windows is not None:
        return "targets have windows"
    for target in instance.targets:
        if not target.required:
            return f"{target.name!r} is not required"
        if target.removal == "tow" or target.windows != ((0.0, None),):
            return f"{target.name!r} is towed or has a window"
    return None


def _are_alike(instance: Instance) -> bool:
    """Whether any chaser could fly the route of any other."""
    first = instance.chasers[0]
    same_times = len(set(instance.available_s)) == 1
    return same_times and all(
        chaser.model_copy(update={"name": first.name}) == first for chaser in instance.chasers
    )
