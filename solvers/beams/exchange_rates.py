"""Exchange rates between prize, time and ΔV in a mission, for comparing partial plans.

A mission that services n targets in h hours services n / h in one of them: so an hour is worth
n mean prizes over its duration. ΔV can be bought for time where there are stations, a tank for a
refuelling stop, and is worth that time; elsewhere it is what limits the mission, and is worth the n
prizes over the tank. How many targets n are serviced is learnt from the guarded greedy plan.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from adr_opt.common.constants import HOUR_S
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.mission import Mission

from .greedy_order import greedy_sequence

GREED = 1.15
"""Ratio of targets serviced by a good plan to those of the guarded greedy one."""

ON_THE_WAY = 0.6
"""Share of a refuelling stop's time that is lost, as the stop is also on the way to a target."""

SAMPLES = 5
"""Number of times at which ways to stations are sampled."""


class Worth(NamedTuple):
    """Exchange rates of a mission.

    Attributes
    ----------
    prize : float
        Mean prize of the targets that have one; 1 if there is none.
    hour : float
        Worth of an hour [prizes].
    kilometre_per_s : float
        Worth of a km/s of ΔV [prizes].
    """

    prize: float
    hour: float
    kilometre_per_s: float


@kernel
def _refuelling_s(rules, samples):
    """Durations of stops at the next station, from ready to refuelled [s]; returns their number."""
    bodies = rules.service.size
    found = np.empty(samples * (bodies - rules.first_target))
    count = 0
    for j in range(rules.first_target, bodies):
        for sample in range(samples):
            ready = (sample + 0.5) / (samples + 1) * rules.duration
            best = np.inf
            for s in range(rules.stations):
                _, delta_v, end = rule_kernels.fits(rules, j, ready, rules.budget, s)
                if delta_v <= rules.budget:
                    best = min(best, end - ready)
            if best < np.inf:
                found[count] = best
                count += 1
    return found, count


def worth_of(mission: Mission) -> Worth:
    """The exchange rates of a mission, computed once."""
    if mission not in _known:
        _known[mission] = _worth_of(mission)
    return _known[mission]


_known: WeakKeyDictionary[Mission, Worth] = WeakKeyDictionary()


def _worth_of(mission: Mission) -> Worth:
    rules = mission.rules
    worthy = rules.prize[rules.prize > 0.0]
    mean = float(worthy.mean()) if worthy.size else 1.0
    greedy = greedy_sequence(mission)
    serviced = GREED * max(1, int(np.count_nonzero(~rules.is_station[greedy])))
    hours = max(rules.duration - rules.ready, 1.0) / HOUR_S
    hour = serviced * mean / hours
    found, count = _refuelling_s(rules, SAMPLES)
    stop_h = float(np.median(found[:count])) / HOUR_S if count > 0 else np.inf
    kilometres = max(rules.budget, 1.0) / 1000.0
    # Without stations, or where a stop takes longer than the mission, a tank is all there is.
    delta_v = min(ON_THE_WAY * hour * stop_h, serviced * mean) / kilometres
    return Worth(mean, hour, delta_v)
