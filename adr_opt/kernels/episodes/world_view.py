"""The observation ``transfer-worlds``: that of moves with prizes, and what worlds may make of them.

:data:`WORLD_FIELDS` names the numbers that follow the prize, in order, with unit and scale. What a
world has drawn is never among them.
"""

import math

from ..core.compile import inlined, kernel
from ..core.draws import delay_at, lognormal_at
from ..core.memory import borrowed
from .episodes import BODIES, SERVICE, clip, rules_of, state_of
from .observation import LEGAL, LIMIT, NEEDED, PER_HOUR, PER_KM_S, PER_TEN, PRIZE, observe_transfer
from .outlook import HOME
from .worlds import (
    ALL_TRIES_S,
    CAUGHT,
    DEVIATION,
    GONE_CHANCE,
    LATE_S,
    LEAST,
    MEAN,
    MEAN_S,
    MOST,
    SIGMA,
    SUCCESS,
    kind_of,
)

WORLD_FIELDS = (
    "mean worth: prize times the chance of a service [mean prizes of the field]",
    "chance that it is gone",
    "chance that a try succeeds",
    "mean ΔV of the move [km/s]",
    "standard deviation of its ΔV [km/s]",
    "chance that the tank holds it",
    "mean time of a try [10 h]",
    "time that a try exceeds once in ten [10 h]",
    "mean time of the stay with all tries [10 h]",
)

(WORTH, IS_GONE, SUCCEEDS, MEAN_NEEDED, SPREAD_NEEDED, HOLDS, MEAN_TRY, LATE_TRY, MEAN_STAY) = (
    range(PRIZE + 1, PRIZE + 1 + len(WORLD_FIELDS))
)
# Columns of the moves, in the order of their names.

LATE_SHARE = 0.9
"""Share of tries that do not take longer than the late one."""

PARTS = 64
"""Number of equally likely parts of a factor by which its sum with a delay is looked at."""

HALVINGS = 40


@inlined
def _chance_within(factor, sigma, least, most):
    """Chance that a factor is at most a number."""
    if factor >= most:
        return 1.0
    if factor < least:
        return 0.0
    return 0.5 * math.erfc(-math.log(factor) / (sigma * math.sqrt(2.0)))


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


@kernel
def observe_worlds(pool, episodes, order, first, last, into, worlds):
    """Observations ``transfer-worlds`` of the episodes ``order[first:last]``.

    Parameters
    ----------
    order : (episodes,) int32
    into : adr_opt.kernels.episodes.observation.ObservationArrays
        Written.
    worlds : Worlds or None
        None where everything goes as planned.
    """
    observe_transfer(pool, episodes, order, first, last, into, True)
    pool, episodes, worlds = borrowed(pool), borrowed(episodes), borrowed(worlds)
    moves, _, mask, _ = borrowed(into)
    targets = mask.shape[1] - 1
    for place in range(first, last):
        e = order[place]
        slot, out, visited = episodes.slot[e], moves[e], episodes.visited[e]
        left = max(episodes.left[e], 0.0) * PER_KM_S
        for j in range(pool.counts[slot, BODIES]):
            row = targets if j == HOME else j - 1
            if j != HOME and visited[j]:
                continue
            _look(pool, episodes, worlds, e, j, left, out[row])


@inlined
def _look(pool, episodes, worlds, e, j, left, row):
    """Write the numbers of one move."""
    slot = episodes.slot[e]
    needed, legal = float(row[NEEDED]), row[LEGAL] > 0.0
    if worlds is None:
        stay = clip(pool.limits[slot, SERVICE, j] * PER_HOUR * PER_TEN, 0.0, LIMIT)
        row[WORTH], row[IS_GONE], row[SUCCEEDS] = row[PRIZE], 0.0, 1.0
        row[MEAN_NEEDED], row[SPREAD_NEEDED] = row[NEEDED], 0.0
        row[HOLDS] = 1.0 if legal else 0.0
        row[MEAN_TRY] = row[LATE_TRY] = row[MEAN_STAY] = stay
        return
    tables = worlds.tables
    model, kind = worlds.states.model[e], 0
    if tables.families.shape[2] > 0:
        rules, state = rules_of(pool, episodes, e), state_of(episodes, e)
        kind = kind_of(pool, worlds, slot, rules, state, j)
    what, spread = tables.models[slot, model, j], tables.factors[slot, model, kind, j]
    row[WORTH] = clip(row[PRIZE] * what[CAUGHT], 0.0, LIMIT)
    row[IS_GONE], row[SUCCEEDS] = what[GONE_CHANCE], what[SUCCESS]
    row[MEAN_NEEDED] = clip(needed * spread[MEAN], 0.0, LIMIT)
    row[SPREAD_NEEDED] = clip(needed * spread[DEVIATION], 0.0, LIMIT)
    holds = 0.0
    if legal:
        # Legal as planned, so it holds without a spread, whatever 32 bits make of it.
        holds = 1.0
        if spread[SIGMA] > 0.0 and needed > 0.0:
            holds = _chance_within(left / needed, spread[SIGMA], spread[LEAST], spread[MOST])
    row[HOLDS] = holds
    row[MEAN_TRY] = clip(what[MEAN_S] * PER_HOUR * PER_TEN, 0.0, LIMIT)
    row[LATE_TRY] = clip(what[LATE_S] * PER_HOUR * PER_TEN, 0.0, LIMIT)
    row[MEAN_STAY] = clip(what[ALL_TRIES_S] * PER_HOUR * PER_TEN, 0.0, LIMIT)
