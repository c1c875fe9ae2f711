"""Short transfers between drifting planes, at events, sifted by dominance.

Nothing is regular here as it is between two bodies: the lines of nodes move, so events are found
one by one (:mod:`.precession`); sequences of one event leave within seconds of it, and those that
meet the target on one crossing arrive within seconds of each other. To be found in one row of a
network, departures are rounded down to whole steps from the event: a chaser has to be ready by
then, and leaves up to a step later.

Sequences are settled many at a time (:mod:`.fixed_points`). Those that are not sure there, or would
have to wait for a zone, are settled one by one, and only where an estimate says that one may be
worth it: its ε is read off at the flight time that it would have without, and moves both ends in
proportion.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_S, TURN_RAD
from ..core.compile import kernel
from ..core.memory import borrowed
from ..orbits import eccentricity
from . import co_elliptic, fixed_points, free_burns, phasing, precession, zones
from .departure_events import events_of, least_speed, listed_at
from .fixed_points import BAND_S, BLOCK, COST, FLAT_RAD, LEFT, MET, REVOLUTIONS

SURE_STEPS = 3
"""Number of steps within which a fixed point counts as found from any nearby start."""

NEAR_RAD = 0.003
"""Angle between planes below which convergence is not certain [rad]."""

STEEPEST = 4.0
"""Largest growth of a node's rate ε with the flight time, approximately."""

RESTLESS = 0.3
"""Rate of the line of nodes against the chaser above which convergence is not certain."""

ERROR_M_S, BEND_M_S = 0.05, 400.0
"""Largest error of an estimated ΔV: the first, plus the second times (ε/θ)²."""


@kernel
def _found_again(pair, rule, revolutions, event, departure, stand_off):
    """Whether the departure of a flown sequence can be recovered from the sequence."""
    ready = max(listed_at(event, departure), 0.0)
    again = precession.leaving(pair, rule, revolutions, ready, stand_off)
    return abs(again - departure) < precession.ROUNDING_S


class Shorts(NamedTuple):
    """Short transfers of a pair, in order of events from the last to the first, then of arrival.

    Attributes
    ----------
    departure, arrival, delta_v : (transfers,) float64
        [s], [s], [m/s].
    revolutions : (transfers,) int8
    """

    departure: np.ndarray
    arrival: np.ndarray
    delta_v: np.ndarray
    revolutions: np.ndarray


class Known(NamedTuple):
    """Costs of later departures by crossing of the target, and their end of validity.

    Attributes
    ----------
    delta_v : (crossings,) float64
        The least of them, +inf for none [m/s].
    until : (crossings,) float64
        [s].
    """

    delta_v: np.ndarray
    until: np.ndarray


class _Sifted(NamedTuple):
    """State of the sift over the later events of a pair."""

    known: Known
    shorts: Shorts


class DeparturePiece(NamedTuple):
    """Times within which short transfers leave: none before ``since`` or after ``until`` [s].

    Those of events after ``leave_by`` are left out as well.
    """

    since: float
    until: float
    leave_by: float


class _Limits(NamedTuple):
    """Limits on the short transfers of :func:`short` [s], [m/s], [m/s]."""

    duration: float
    most: float
    resolution: float
    since: float
    last: float


class _PlacedEvent(NamedTuple):
    """A departure event and its place in a grid.

    Attributes
    ----------
    half_turns : int
    number : (5,) float64
        What else :func:`events_of` says of it.
    place : int
        In the grid, −1 if its sequences have to be settled one by one.
    base : float
        Flight time of the first row without ε [s].
    """

    half_turns: int
    number: np.ndarray
    place: int
    base: float


@kernel
def _settled(pair, rule, curves, half_turns, number, met, below):
    """The cheapest sequence of an event that meets the target near a time, solved one by one.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    curves : Curves
    half_turns : int
        Of the event.
    number : (5,) float64
        What else :func:`events_of` says of it.
    met : float
        When the chaser would be at the stand-off without ε [s].
    below : float
        It has to cost less [m/s].

    Returns
    -------
    delta_v : float
        +inf for none [m/s].
    revolutions : int
    departure, stand_off : float
        The departure exactly [s].
    """
    event, lag, alpha_i, alpha_j = number[0], number[1], number[2], number[3]
    theta = number[4]
    turn_i, turn_j = precession.turning(pair, lag, alpha_i, alpha_j)
    sines = 4.0 * math.sin(pair.inclination_i) * math.sin(pair.inclination_j)
    tilt = 4.0 * math.sin(0.5 * (pair.inclination_j - pair.inclination_i)) ** 2
    matching = 0.0 if pair.free_speed > 0.0 else eccentricity.matching(pair, event)
    moves = turn_j / pair.rate_j - turn_i / pair.rate_i
    base = met - event
    best, best_k, best_d, best_a = math.inf, -1, 0.0, 0.0
    for k in range(rule.max_phasing_revolutions + 1):
        if pair.shortest + k * pair.shortest_lap > base + BAND_S:
            break
        if pair.longest + k * pair.longest_lap < base - BAND_S:
            continue
        left, there = event, met
        if curves.time.shape[0] > 0:
            shift = phasing.parts_at(curves, k, base)[4]
            time = base + moves * shift
            climb, rest, chord, square, shift = phasing.parts_at(curves, k, time)
            angle = tilt + sines * math.sin(0.5 * (lag + shift)) ** 2
            if pair.free_speed > 0.0:
                estimate = free_burns.least(pair, k, time, angle)
            else:
                estimate = co_elliptic.whole(climb, rest, chord, square * angle, matching)
            # The estimate errs by less than what is taken off, so that no cheaper sequence is left
            # out.
            estimate += pair.fixed_delta_v
            if estimate - ERROR_M_S - BEND_M_S * (shift / theta) ** 2 >= min(below, best):
                continue
            left += turn_i * shift / pair.rate_i
            there += turn_j * shift / pair.rate_j
        found = precession.fixed_point(pair, rule, half_turns, k, left, there, alpha_i, alpha_j)
        if found.delta_v >= min(below, best):
            continue
        if found.departure < -SLACK_S or abs(found.stand_off - met) > math.pi / pair.rate_j:
            continue
        if rule.zones.shape[0] > 0 and zones.is_blocked(
            pair, rule, k, found.radius, found.departure
        ):
            continue
        if (found.steps > SURE_STEPS or theta < NEAR_RAD) and not _found_again(
            pair, rule, k, event, found.departure, found.stand_off
        ):
            continue
        best, best_k = found.delta_v, k
        best_d, best_a = found.departure, found.stand_off
    return best, best_k, best_d, best_a


@kernel
def _sift(pair, rule, curves, grid, placed, limits, sifted, count):
    """Add the sequences of an event that no later departure dominates; returns their number.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    curves : Curves
    grid : MeetingGrid
        With the event in it.
    placed : _PlacedEvent
    limits : _Limits
    sifted : _Sifted
        What is known is brought up to date, and transfers are written from number ``count`` on.
    count : int
    """
    grid, placed, sifted = borrowed(grid), borrowed(placed), borrowed(sifted)
    half_turns, number, place, base = placed
    duration, most, resolution, since, last = limits
    known, shorts = sifted
    event, lap = number[0], TURN_RAD / pair.rate_j
    approach = rule.approach_revolutions * lap
    decays = co_elliptic.decays(pair)
    longest = pair.longest + rule.max_phasing_revolutions * pair.longest_lap
    latest = min(longest, duration - event - approach) + BAND_S
    turned = co_elliptic.latitude_of_j(pair, event + base) - rule.standoff / pair.radius_j
    first = math.floor((turned - number[3]) / math.pi + 0.5) + 1
    zoned, cheapest = rule.zones.shape[0] > 0, most + resolution
    # About how fast the line of nodes moves while the chaser gets ready, against the chaser.
    pace = abs(pair.lag_rate) + STEEPEST * abs(pair.node_rate_j)
    pace *= math.sin(pair.inclination_j) / (number[4] * pair.rate_i)
    near = number[4] < NEAR_RAD or pace > RESTLESS
    for row in range(grid.found.shape[0]):
        met = event + base + row * lap
        if decays:
            # Laps grow shorter, and are counted from the first one.
            met = co_elliptic.time_at(
                pair.latitude_j,
                pair.rate_j,
                pair.acceleration_j,
                turned + rule.standoff / pair.radius_j + TURN_RAD * row,
            )
        if met - event > latest:
            break
        below = cheapest - resolution
        best, best_k, departure, stand_off = -math.inf, 0, event, met
        if place >= 0:
            best = grid.found[row, COST * BLOCK + place]
            best_k = int(grid.found[row, REVOLUTIONS * BLOCK + place])
            departure += grid.found[row, LEFT * BLOCK + place]
            stand_off += grid.found[row, MET * BLOCK + place]
        alone = best == -math.inf
        if best < below and not alone:
            alone = (zoned and zones.any_closed(rule.zones, departure, stand_off + approach)) or (
                near and not _found_again(pair, rule, best_k, event, departure, stand_off)
            )
        if alone:
            best, best_k, departure, stand_off = _settled(
                pair, rule, curves, half_turns, number, met, below
            )
        better, arrival = best < below, stand_off + approach
        crossing = min(max(first + 2 * row, 1), known.until.size - 1)
        # Sequences of one crossing arrive within seconds, and crossings of other events are counted
        # from lines that move: of the last few the time of arrival decides.
        for c in range(max(crossing - 3, 0), crossing + 1):
            if not better or known.until[c] <= arrival + SLACK_S:
                cheapest = min(cheapest, known.delta_v[c])
        listed = max(listed_at(event, departure), 0.0)
        # It may leave a step later.
        better = better and since <= listed and listed + precession.STEP_S + 1.0 <= last
        if better and best < cheapest - resolution and arrival <= duration:
            shorts.departure[count] = listed
            shorts.arrival[count], shorts.delta_v[count] = arrival, best
            shorts.revolutions[count] = best_k
            count += 1
            cheapest = best
            until = known.until[crossing]
            known.until[crossing] = (
                arrival if known.delta_v[crossing] == math.inf else max(until, arrival)
            )
            known.delta_v[crossing] = min(known.delta_v[crossing], best)
    return count


@kernel
def short(pair, rule, curves, duration, spacing, most, piece, resolution):
    """Undominated short transfers of a pair.

    Parameters
    ----------
    pair : Pair
    rule : TransferRule
    curves : adr_opt.kernels.legs.phasing.Curves
        Of the pair; they are the same for all pieces.
    duration : float
        Those that arrive later are left out [s].
    spacing : float
        Between departure events, at least [s].
    most : float
        Dearer ones are left out [m/s].
    piece : DeparturePiece
    resolution : float
        A transfer that saves no more than this is dominated [m/s].

    Returns
    -------
    shorts : Shorts
        With room for more.
    order : (transfers,) int64
        Those that there are, event by event and then by arrival.
    """
    leave_by = min(piece.leave_by, piece.until)
    half_turns, numbers = events_of(pair, piece.since, min(duration, leave_by), spacing)
    lap = TURN_RAD / pair.rate_j
    least_turn = least_speed(pair, rule)
    # Events whose planes are near enough, and their flight times in the first row.
    size, bases = 0, np.empty(half_turns.size)
    for e in range(half_turns.size):
        if least_turn * math.sin(min(0.9 * numbers[e, 4], 0.5 * math.pi)) > most:
            continue
        for field in range(5):
            numbers[size, field] = numbers[e, field]
        half_turns[size] = half_turns[e]
        about = numbers[e, 0] + pair.shortest - BAND_S + 0.5 * lap
        met = precession.meeting(pair, rule, half_turns[e], numbers[e, 3], about)
        bases[size] = met - numbers[e, 0]
        size += 1
    span = pair.longest + rule.max_phasing_revolutions * pair.longest_lap - pair.shortest
    decays, least_lap = co_elliptic.decays(pair), lap
    if decays:
        late = max(duration, 0.0) + span
        least_lap = TURN_RAD / max(pair.rate_j, co_elliptic.rate_of_j(pair, late))
    rows = int((span + 2.0 * BAND_S) / least_lap + 1e-6) + 1
    crossings = int(max(duration, 0.0) / least_lap * 2.0) + 8
    known = Known(np.empty(crossings), np.empty(crossings))
    for c in range(crossings):
        known.delta_v[c], known.until[c] = math.inf, math.inf
    room = rows * size
    shorts = Shorts(np.empty(room), np.empty(room), np.empty(room), np.empty(room, np.int8))
    sifted = _Sifted(known, shorts)
    limits = _Limits(duration, most, resolution, piece.since, piece.until)
    grid, count, ends = fixed_points.grid_of(curves, rows), 0, np.empty(size + 1, np.int64)
    ends[size] = 0
    approach = rule.approach_revolutions * lap
    # From the last event to the first, as dominance looks at later departures only.
    for end in range(size, 0, -BLOCK):
        begin = max(end - BLOCK, 0)
        in_time = duration - numbers[begin, 0] - approach - pair.shortest + 2.0 * BAND_S
        if not decays:
            fixed_points.lay_out(
                pair,
                grid,
                numbers[begin:end],
                bases[begin:end],
                min(int(max(in_time, 0.0) / lap + 1e-6) + 1, rows),
            )
        for e in range(end - 1, begin - 1, -1):
            theta = numbers[e, 4]
            sure = curves.time.shape[0] > 0 and FLAT_RAD <= theta <= math.pi - FLAT_RAD
            # Rows of a grid are whole laps apart, which those of decaying orbits are not.
            sure = sure and not decays
            place = grid.place[e - begin] if sure else -1
            placed = _PlacedEvent(half_turns[e], numbers[e], place, bases[e])
            count = _sift(pair, rule, curves, grid, placed, limits, sifted, count)
            ends[e] = count
    order, place = np.empty(count, np.int64), 0
    for e in range(size):
        for c in range(ends[e + 1], ends[e]):
            order[place] = c
            place += 1
    return shorts, order
