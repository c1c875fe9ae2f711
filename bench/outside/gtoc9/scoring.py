"""The rules of GTOC9 and J, for missions in time and ΔV of their legs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from .campaign import FIRST_D, LAST_D, Removals
from .expense import MOST_PROPELLANT_KG, expense_meur, launched_kg, propellant_kg

STAY_D, WITHIN_D, APART_D = 5.0, 30.0, 30.0
"""Least stay at a debris; most from an arrival to the next; least between missions [d]."""


@dataclass(frozen=True)
class Score:
    """Score of a campaign.

    Attributes
    ----------
    total_meur : float
        J.
    missions_meur, propellant_kg : tuple of float
        Of each mission.
    violations : tuple of str
        A sentence for each rule that is broken.
    """

    total_meur: float
    missions_meur: tuple[float, ...]
    propellant_kg: tuple[float, ...]
    violations: tuple[str, ...]


def score(
    missions: Sequence[Removals],
    delta_v_m_s: Sequence[Sequence[float]],
    debris: int,
    slack_d: float = 1e-6,
) -> Score:
    """J of a campaign, and which rules it breaks.

    Parameters
    ----------
    missions : sequence of Removals
    delta_v_m_s : sequence of sequence of float
        Of the legs of each mission.
    debris : int
        How many there are: each must be removed once.
    slack_d : float
        Times that break a rule by less pass [d].
    """
    expenses = tuple(expense_meur(launched_kg(legs)) for legs in delta_v_m_s)
    used = tuple(propellant_kg(legs) for legs in delta_v_m_s)
    broken = _not_once(missions, debris)
    before = None
    for number, mission in sorted(enumerate(missions), key=lambda item: item[1].begin_d):
        name = f"mission {number}"
        if len(delta_v_m_s[number]) != len(mission.stops) - 1:
            broken.append(f"{name}: ΔV of {len(delta_v_m_s[number])} legs")
        if used[number] > MOST_PROPELLANT_KG:
            broken.append(f"{name}: {used[number]:.1f} kg of propellant")
        broken += [f"{name}: {said}" for said in _times(mission, slack_d)]
        if before is not None and mission.begin_d < before + APART_D - slack_d:
            broken.append(f"{name}: {mission.begin_d - before:.3f} d after the one before")
        before = mission.end_d
    return Score(sum(expenses), expenses, used, tuple(broken))


def _not_once(missions: Sequence[Removals], debris: int) -> list[str]:
    """Debris that are not removed exactly once."""
    times = Counter(stop.debris for mission in missions for stop in mission.stops)
    wrong = sorted({*times, *range(debris)})
    broken = [f"debris {one}: removed {times[one]} times" for one in wrong if times[one] != 1]
    return broken + [f"debris {one}: there is none" for one in sorted(times) if one >= debris]


def _times(mission: Removals, slack_d: float) -> list[str]:
    """Rules on times that a mission breaks by itself."""
    broken = []
    if mission.begin_d < FIRST_D - slack_d or mission.end_d > LAST_D + slack_d:
        broken.append(f"from {mission.begin_d:.3f} to {mission.end_d:.3f}")
    for stop in mission.stops:
        stayed = stop.departure_d - stop.arrival_d
        if stayed < STAY_D - slack_d:
            broken.append(f"{stayed:.3f} d at debris {stop.debris}")
    for one, other in zip(mission.stops[:-1], mission.stops[1:], strict=True):
        if other.arrival_d > one.arrival_d + WITHIN_D + slack_d:
            between = other.arrival_d - one.arrival_d
            broken.append(f"{between:.3f} d from arrival to arrival at debris {other.debris}")
        if other.arrival_d <= one.departure_d:
            broken.append(f"arrival at debris {other.debris} before the departure to it")
    return broken
