"""A sequence of bodies flown on connections that are computed on demand."""

from ..core.compile import inlined, kernel
from ..core.windows import service_end
from . import on_demand


PLENTY = 0.4
"""Share of a tank above which the way to the next station is not looked at."""


@inlined
def _next_station(sequence, place, stations):
    """The first station of a sequence from a place on; −1 for none."""
    for other in range(place, sequence.size):
        if sequence[other] < stations:
            return sequence[other]
    return -1


@kernel
def collected_along(source, stations, sequence, worths, state, full):
    """Worth of a sequence of bodies from a state, of which what cannot be reached is left out.

    Where a station of the sequence cannot be reached any more, targets are left out as well after
    which it could not.

    Parameters
    ----------
    source : adr_opt.kernels.tables.on_demand.Source
        Its limits are those of the chaser; it carries nothing that a service changes.
    stations : int
        Bodies with smaller numbers are stations.
    sequence : (legs,) int64
    worths : (bodies,) float64
        0 of targets that do not count, which are left out.
    state : tuple of (int, float, float)
        Body, since when the chaser is free there [s], and ΔV left [m/s].
    full : float
        ΔV of a full tank [m/s].
    """
    worth, stranded = _along(source, stations, sequence, worths, state, full, False)
    if stranded:
        worth = max(worth, _along(source, stations, sequence, worths, state, full, True)[0])
    return worth


@kernel
def _along(source, stations, sequence, worths, state, full, guarded):
    """The same with or without a guard, and whether a station could not be reached."""
    limits = source.limits
    body, time, left = state
    total, since, stranded = 0.0, 1, False
    for place in range(sequence.size):
        j = sequence[place]
        if j == body or (j < stations and since == 0) or (j >= stations and worths[j] <= 0.0):
            continue
        delta_v, arrival = on_demand.chosen(source, body, j, time)
        end = service_end(arrival, limits.opens[j], limits.service[j])
        rest = left - delta_v
        stranded |= j < stations and rest < 0.0
        if rest < 0.0 or end > limits.closes[j] or end > limits.duration:
            continue
        if guarded and j >= stations and rest < PLENTY * full:
            station = _next_station(sequence, place + 1, stations)
            if station >= 0 and on_demand.chosen(source, j, station, end)[0] > rest:
                continue
        body, time, left = j, end, rest
        since += 1
        total += worths[j]
        if j < stations:
            left, since = full, 0
    return total, stranded
