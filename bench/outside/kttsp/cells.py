"""Before when nobody arrives who leaves in a cell of time or later, proven box by box."""

import math

import numpy as np

from adr_opt.kernels.core.compile import kernel

from .boxes import possible
from .spans import spans


@kernel
def _first_within(pair, k, m, step, depth, least, limit, scratch):
    """The earliest begin of parts of a box that may hold a leg [s]; infinite if none does.

    Departures ``k`` and arrivals ``m`` are counted in steps. A part is halved both ways, and what
    arrives earlier looked at first, until it is ``step / 2**depth`` long.
    """
    elements_i, elements_j, normal_1, normal_2, between = pair
    time, one, other, stack = scratch
    best = math.inf
    size = 1
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, k, m
    while size:
        size -= 1
        level, leaves, lands = stack[size, 0], stack[size, 1], stack[size, 2]
        wide = step / (1 << level)
        begin = max(lands * wide, leaves * wide + least)
        fly_low, fly_high = max((lands - leaves - 1) * wide, least), (lands + 1 - leaves) * wide
        if begin >= best or fly_high <= least:
            continue
        time[0] = (leaves + 0.5) * wide
        spans(elements_i, time, 0.5 * wide, one)
        time[0] = (lands + 0.5) * wide
        spans(elements_j, time, 0.5 * wide, other)
        if not possible(one[0], other[0], normal_1, normal_2, between, fly_low, fly_high, limit):
            continue
        if level == depth:
            best = begin
            continue
        for part in range(3, -1, -1):
            stack[size, 0] = level + 1
            stack[size, 1], stack[size, 2] = 2 * leaves + (part & 1), 2 * lands + (part >> 1)
            size += 1
    return best


@kernel
def first_arrivals(  # noqa: PLR0913
    elements_i, elements_j, normal_1, normal_2, between, step, widest, depth, least, longest,
    limit, first, last, wanted, out,
):  # fmt: skip
    """No leg that leaves at ``k step`` or later arrives before ``out[k]``.

    Spans of arrivals are tried wide, and halved where they may hold a leg; those of a step that
    may are looked at in parts.

    Parameters
    ----------
    elements_i, elements_j : (6,) float64
    normal_1, normal_2 : (3,) float64
        Of the planes.
    between : float
        Angle between the planes [rad].
    step : float
        Of departures and arrivals [s].
    widest, depth : int
        The longest span of arrivals is 2^widest steps, the shortest part a step / 2^depth.
    least, longest : float
        Flights [s]; longer ones count as possible.
    limit : float
        [m/s].
    first, last : int
        For ``k`` from the first to before the last. What is known from the last one on is taken
        for granted.
    wanted : (departures,) float64
        Later arrivals need not be proven [s].
    out : (departures,) float64
        Is raised where more is known [s]; what leaves later than all of it may arrive at once.
    """
    reach = math.ceil(longest / step)
    first -= first & ((1 << widest) - 1)
    total = last - first + reach + (2 << widest)
    one, others = np.empty((last - first, 10)), np.empty((widest + 1, total, 10))
    times = np.empty(total)
    for k in range(total):
        times[k] = (first + k + 0.5) * step
    spans(elements_i, times[: last - first], 0.5 * step, one)
    for level in range(widest + 1):
        wide = step * (1 << level)
        for k in range(total >> level):
            times[k] = ((first >> level) + k + 0.5) * wide
        spans(elements_j, times[: total >> level], 0.5 * wide, others[level])
    pair = elements_i, elements_j, normal_1, normal_2, between
    scratch = (
        np.empty(1), np.empty((1, 10)), np.empty((1, 10)), np.empty((4 * depth + 4, 3), np.int64),
    )  # fmt: skip
    known = out[last] if last < out.size else out.size * step + least
    for k in range(last - 1, first - 1, -1):
        known = min(known, (k + reach) * step, wanted[k])
        m, level = k + int(least / step), 0
        # What was known is not proven once more.
        m = max(m, int(out[k] / step) if out[k] < math.inf else m)
        while m * step < known:
            while m & ((1 << level) - 1):
                level -= 1
            wide = 1 << level
            fly_low, fly_high = max((m - k - 1) * step, least), (m + wide - k) * step
            if fly_high > least and possible(
                one[k - first], others[level, (m >> level) - (first >> level)], normal_1, normal_2,
                between, fly_low, fly_high, limit,
            ):  # fmt: skip
                if level:
                    level -= 1
                    continue
                begin = _first_within(pair, k, m, step, depth, least, limit, scratch)
                if begin < math.inf:
                    known = min(known, begin)
                    break
            m += wide
            level = min(level + 1, widest)
        known = max(known, out[k])
        out[k] = known
