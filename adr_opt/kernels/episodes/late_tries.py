"""The 90 % quantile of a try's time: a random factor and a random delay together."""

import math

from ..core.compile import kernel
from ..core.draws import delay_at, lognormal_at

LATE_SHARE = 0.9
"""Share of tries that take no longer than the late try."""

PARTS = 64
"""Number of equally likely parts into which the factor is split to add the delay."""

HALVINGS = 40


@kernel
def late_try(planned, factor, delay):
    """Time of a try that is exceeded with a chance of 1 − :data:`LATE_SHARE` [s].

    Parameters
    ----------
    planned : float
        [s].
    factor : (float, float, float)
        Spread and bounds.
    delay : (float, float, float)
        Chance, mean and maximum [s].
    """
    sigma, least, most_factor = factor
    chance, mean, most = delay
    alone = planned * lognormal_at(LATE_SHARE, sigma, least, most_factor)
    if chance == 0.0 or mean == 0.0 or most == 0.0:
        return alone
    longest = delay_at(chance * (1.0 - 1e-15), chance, mean, most)
    low, high = planned * least if sigma > 0.0 else planned, planned * most_factor + longest
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        within = 0.0
        for part in range(PARTS):
            rest = middle - planned * lognormal_at((part + 0.5) / PARTS, sigma, least, most_factor)
            if rest >= most:
                within += 1.0
            elif rest >= 0.0:
                within += 1.0 - chance * math.exp(-rest / mean)
        if within < LATE_SHARE * PARTS:
            low = middle
        else:
            high = middle
    return high
