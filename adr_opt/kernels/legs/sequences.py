"""The most valuable sequence of a departure event.

With Δ the lead of the target at departure, the phase condition reads n_j T = 3π − Δ + δ + 2π s,
s = k + m: the flight time depends on (k, m) through s alone. So the search runs over s with T
ascending, and inside over the few k whose phasing radius lies within the altitude limits. Since w·T
grows by w·P_j with every s, it stops as soon as w·T plus a floor of the ΔV exceeds the best cost
found: no later sequence can win. A sequence whose phasing must cost too much is not solved for.
"""

import math
from typing import NamedTuple

from ...common.constants import SLACK_M_S, TURN_RAD
from ..core.compile import kernel
from ..core.windows import last_begin, service_begin
from .co_elliptic import leg_delta_v, phasing_radius
from .zones import is_blocked


class Sequence(NamedTuple):
    """A sequence as flown: ``delta_v`` is +inf if there is none."""

    delta_v: float  # [m/s]
    flight_time: float  # departure to stand-off [s]
    revolutions: int  # k
    phasing_radius: float  # r_x [m]


@kernel
def best_sequence(pair, rule, departure, lead, windows, body, after, most=math.inf):
    """The sequence of a departure event with the least ΔV + w·T (docs/model.md sections 2 and 4).

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    departure : float
        Time of the departure event [s].
    lead : float
        Δ, the target's lead over the chaser at departure, in [0, 2π) [rad].
    windows, body : Windows, int
        Where a sequence ends before the service may begin it has to wait, so that T is the time
        until that; one after which none may begin is out of the question.
    after : float
        Time of the departure with that of an approach [s].
    most : float
        So is one whose ΔV + w·T is no less than this [m/s].

    Returns
    -------
    Sequence
        Ties, up to the slack, go to the shorter time, then to the smaller k; ``delta_v`` is +inf
        if every sequence is out of limits or blocked.
    """
    best_cost, best_delta_v, best_time, best_k, best_r = most, math.inf, math.inf, -1, math.nan
    w = rule.time_value
    k_max = rule.max_phasing_revolutions
    phase = 3.0 * math.pi - lead + rule.standoff / pair.radius_j
    s = math.ceil((pair.shortest * pair.rate_j - phase) / TURN_RAD)
    until, laps = last_begin(windows, body), 2.0 - rule.first_leg_fraction
    last = min(pair.longest + k_max * pair.longest_lap, until - after)
    while True:
        time = (phase + TURN_RAD * s) / pair.rate_j
        s += 1
        worth = w * (service_begin(windows, body, min(after + time, until)) - after)
        # Dearer than the best by time alone, or longer than any sequence: so is all that follows.
        if time > last or worth + pair.floor_delta_v > best_cost:
            break
        # The k whose range of times [T(r_min), T(r_max)] holds this time.
        k = max(0, math.ceil((time - pair.longest) / pair.longest_lap))
        while k <= k_max and pair.shortest + k * pair.shortest_lap <= time:
            # What its phasing costs at least, before it is solved for.
            swing = pair.swing * abs(time - pair.flight - k * pair.lap) / (laps + 2.0 * k)
            if pair.turning + swing + worth > best_cost:
                k += 1
                continue
            r = phasing_radius(pair, rule, k, time)
            delta_v = leg_delta_v(pair, rule, k, r, departure, time, pair.turn)
            cost = delta_v + worth
            if cost < best_cost - SLACK_M_S and not (
                rule.zones.shape[0] > 0 and is_blocked(pair, rule, k, r, departure)
            ):
                best_cost, best_delta_v, best_time, best_k, best_r = cost, delta_v, time, k, r
            k += 1
    return Sequence(best_delta_v, best_time, best_k, best_r)
