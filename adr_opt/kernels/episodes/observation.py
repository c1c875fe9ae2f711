"""Observations of many episodes, as the learned policies see them.

``transfer`` says of every move what it costs now and what it leaves;
:mod:`.lookahead` adds where it leads. Those two do not see prizes;
``transfer-prizes`` and ``lookahead-prizes`` do, by one more number for every move.
:data:`MOVE_FIELDS` and :data:`MISSION_FIELDS` name every number in order, with its unit and scale;
all are clipped to :data:`LIMIT`. Where planes drift, RAANs and phases are those of the present
time, and angles between planes those at t = 0. What the published study lists is in
:mod:`.published`.
"""

import math
from typing import NamedTuple

import numpy as np

from ..core.compile import inlined, kernel
from ..core.memory import borrowed, fetch
from ..orbits.ephemeris import inclination_at, latitude_at, node_at, radius_at
from ..rules import rules as rule_kernels
from ..tables.stacked_timetables import lookup_in_column
from ..tables.timetable import steps_begun
from .episodes import BODIES, clip, outlook_of, rules_of, state_of, turned
from .outlook import AHEAD, DELTA_V_UNIT_M_S, HOME, HOUR_UNIT, M_S_PER_HOUR, NEAR, NOBODY

LIMIT = 5.0
"""Largest magnitude of a number in an observation."""

# Factors, not divisors: the kernels below are called for every step of a training.
PER_50_KM = 1.0 / 50e3
PER_KM_S = 1.0 / 1e3
PER_HOUR = 1.0 / 3600.0
PER_TEN = 1.0 / 10.0
HOURS_PER_M_S = 1.0 / M_S_PER_HOUR
WEEK_S = 604800.0
TARGET_SCALE = 50.0

MOVE_FIELDS = (
    "legal",
    "is the station",
    "open: an unvisited target, or a refuelling that is earned",
    "ΔV of the move now [km/s]",
    "ΔV of the move / ΔV left",
    "time from now to the end of service [10 h]",
    "that time / time left",
    "hours + ΔV / (450 m/s) [10 h]",
    "ΔV left afterwards [km/s]",
    "time left afterwards [10 h]",
    "ΔV of the way back to the station from there [km/s]",
    "ΔV left after the way back [km/s]",
    "the station stays reachable",
    "time of the way back, refuelling included [10 h]",
    "ΔV of the best move after it [km/s]",
    "time of the best move after it [10 h]",
    "cost of the best move after it, hours + ΔV / (450 m/s) [10 h]",
    "cost of the second best move after it [10 h]",
    "share of the 6 targets of the nearest planes that are open",
    "mean angle to the open ones of the 6 nearest planes [deg]",
    "radius less the chaser's [50 km]",
    "inclination less the chaser's [deg]",
    "RAAN less the chaser's, times sin i [deg]",
    "angle between its plane and the chaser's [deg]",
    "radius less the station's [50 km]",
    "inclination less the station's [deg]",
    "RAAN less the station's, times sin i [deg]",
    "angle between its plane and the station's [deg]",
    "phase ahead of the chaser now [half turns]",
)

(
    LEGAL,
    IS_STATION,
    IS_OPEN,
    NEEDED,
    NEEDED_OF_LEFT,
    TAKEN,
    TAKEN_OF_LEFT,
    COST,
    LEFT_AFTER,
    TIME_AFTER,
    BACK,
    LEFT_AFTER_BACK,
    SAFE,
    BACK_TIME,
    NEXT_NEEDED,
    NEXT_TAKEN,
    NEXT_COST,
    SECOND_COST,
    NEAR_OPEN,
    NEAR_ANGLE,
    RADIUS_FROM_CHASER,
    INCLINATION_FROM_CHASER,
    RAAN_FROM_CHASER,
    ANGLE_FROM_CHASER,
    RADIUS_FROM_HOME,
    INCLINATION_FROM_HOME,
    RAAN_FROM_HOME,
    ANGLE_FROM_HOME,
    PHASE,
) = range(len(MOVE_FIELDS))
# Columns of the moves, in the order of their names.

PRIZE_FIELD = "prize [mean prizes of the field]"
PRIZE = len(MOVE_FIELDS)
"""Extra field of observations that show prizes, after :data:`MOVE_FIELDS`, and its column."""

MISSION_FIELDS = (
    "ΔV left [km/s]",
    "ΔV left / budget",
    "ΔV budget [km/s]",
    "time left [weeks]",
    "time left / duration",
    "duration [weeks]",
    "share of the targets that are open",
    "open targets [50]",
    "share of the actions that are legal",
    "docked at the station",
    "refuelling is earned",
    "radius less the station's [50 km]",
    "inclination less the station's [deg]",
    "RAAN less the station's, times sin i [deg]",
    "the station is reachable now",
    "hours left for each open target [10 h]",
)

(
    LEFT,
    LEFT_OF_BUDGET,
    BUDGET,
    TIME,
    TIME_OF_DURATION,
    DURATION,
    OPEN_SHARE,
    OPEN_TARGETS,
    LEGAL_SHARE,
    DOCKED,
    EARNED,
    CHASER_RADIUS,
    CHASER_INCLINATION,
    CHASER_RAAN,
    HOME_REACHABLE,
    TIME_PER_TARGET,
) = range(len(MISSION_FIELDS))
# Columns of the mission, in the order of their names.

DEGREES = 180.0 / math.pi
FAR = LIMIT


class ObservationArrays(NamedTuple):
    """Arrays that observations are written to, by episode.

    Attributes
    ----------
    moves : (episodes, actions, fields) float32
        :data:`MOVE_FIELDS` of every action; 0 for targets that are visited or that the field does
        not have. What cannot be reached has the upper limit for its costs. There may be more
        columns, which are 0 in the same rows.
    mission : (episodes, len(MISSION_FIELDS)) float32
        :data:`MISSION_FIELDS`.
    mask : (episodes, actions) bool
        Legal actions.
    legal : (episodes,) int32
        Number of legal actions.
    """

    moves: np.ndarray
    mission: np.ndarray
    mask: np.ndarray
    legal: np.ndarray


class BodyCounts(NamedTuple):
    """Numbers of bodies in the field, of unvisited targets and of legal moves."""

    bodies: int
    unvisited: int
    legal: int


@inlined
def _cheapest_ahead(line, visited, left, hours):
    """The two cheapest onward moves from a target, given ΔV and hours that are sufficient.

    Returns
    -------
    needed, taken, cost, second : float
        ΔV [km/s], time [10 h] and cost [10 h] of the cheapest, and cost of the next; ``FAR`` where
        there is none.
    """
    needed, taken, best, second = FAR, FAR, FAR, FAR
    found = False
    for place in range(AHEAD):
        k = line[3 * place]
        if k == NOBODY:
            break
        if visited[k]:
            continue
        next_v = line[3 * place + 1] * DELTA_V_UNIT_M_S
        next_h = line[3 * place + 2] * HOUR_UNIT
        if next_v > left or next_h > hours:
            continue
        cost = (next_h + next_v * HOURS_PER_M_S) * PER_TEN
        if found:
            second = clip(cost, 0.0, LIMIT)
            break
        found = True
        needed, taken = clip(next_v * PER_KM_S, 0.0, LIMIT), next_h * PER_TEN
        best = clip(cost, 0.0, LIMIT)
    return needed, taken, best, second


@inlined
def _open_nearby(outlook, visited, j):
    """Number of the nearest targets that are still open, and the sum of the angles to them."""
    near, angle = 0, 0.0
    for place in range(NEAR):
        k = outlook.near[j, place]
        if k >= 0 and not visited[k]:
            near += 1
            angle += outlook.near_angle[j, place]
    return near, angle


@inlined
def _write_mission(row, rules, home, orbit, now, left, remaining, counts):
    """Write the remaining mission, and the chaser's orbit relative to the station's."""
    bodies, unvisited, legal = counts
    row[LEFT] = clip(left * PER_KM_S, 0.0, LIMIT)
    row[LEFT_OF_BUDGET] = clip(left / max(rules.budget, 1.0), 0.0, LIMIT)
    row[BUDGET] = clip(rules.budget * PER_KM_S, 0.0, LIMIT)
    row[TIME] = clip(remaining / WEEK_S, 0.0, LIMIT)
    row[TIME_OF_DURATION] = clip(remaining / max(rules.duration, 1.0), 0.0, LIMIT)
    row[DURATION] = clip(rules.duration / WEEK_S, 0.0, LIMIT)
    row[OPEN_SHARE] = unvisited / max(bodies - 1, 1)
    row[OPEN_TARGETS] = clip(unvisited / TARGET_SCALE, 0.0, LIMIT)
    row[LEGAL_SHARE] = legal / max(bodies, 1)
    radius = radius_at(orbit, now) - radius_at(home, now)
    row[CHASER_RADIUS] = clip(radius * PER_50_KM, -LIMIT, LIMIT)
    home_inclination = inclination_at(home, now)
    inclination = inclination_at(orbit, now) - home_inclination
    row[CHASER_INCLINATION] = clip(inclination * DEGREES, -LIMIT, LIMIT)
    node_scale = DEGREES * math.sin(home_inclination)
    raan = node_at(orbit, now) - node_at(home, now)
    row[CHASER_RAAN] = clip(turned(raan) * node_scale, -LIMIT, LIMIT)
    row[TIME_PER_TARGET] = clip(remaining * PER_HOUR / max(unvisited, 1) * PER_TEN, 0.0, LIMIT)


@kernel
def observe_transfer(pool, episodes, order, first, last, into, prized):
    """Observations ``transfer`` of the episodes ``order[first:last]``.

    Those of one field side by side are quicker: their table is then in the cache.

    Parameters
    ----------
    order : (episodes,) int32
    into : ObservationArrays
        Written.
    prized : bool
        Write the prize of every move, into column :data:`PRIZE`.
    """
    pool, episodes = borrowed(pool), borrowed(episodes)
    moves, mission, mask, legal = borrowed(into)
    targets = mask.shape[1] - 1
    costs, ends, lefts = np.empty(targets + 1), np.empty(targets + 1), np.empty(targets + 1)
    fits = np.empty(targets + 1, dtype=np.bool_)
    home_costs, home_times = np.empty(targets + 1), np.empty(targets + 1)
    places = np.empty(targets + 1, dtype=np.int64)
    for place in range(first, last):
        e = order[place]
        slot = episodes.slot[e]
        rules = rules_of(pool, episodes, e)
        outlook = outlook_of(pool, slot)
        orbits = pool.orbits[slot]
        bodies = pool.counts[slot, BODIES]
        visited = episodes.visited[e]
        out = moves[e]
        state = state_of(episodes, e)
        body, has = state.body, state.resources
        now, left, since = has.time, has.left, has.since
        duration, refuelling = rules.duration, rules.service[HOME]
        remaining = duration - now
        # Costs first, in the order of the table's memory.
        for j in range(bodies):
            costs[j], ends[j], lefts[j], fits[j] = math.inf, math.inf, -math.inf, False
            # The rules that make a move also say whether it is legal, so that no mask differs from
            # them.
            if rule_kernels.may_go(rules, state, visited, j):
                fits[j], costs[j], after_move = rule_kernels.step(rules, state, j)
                ends[j], lefts[j] = after_move.resources.time, after_move.resources.left
        # Then everything that lies scattered, in a loop so short that its reads overlap.
        for j in range(bodies):
            if ends[j] <= duration:
                end = ends[j]
                begun = steps_begun(rules.table, j, end)
                home_costs[j], home_times[j] = lookup_in_column(outlook.home, rules.table, j, end)
                places[j] = min(begun, outlook.ahead.shape[1] - 1)
                fetch(outlook.ahead, (j, places[j], 0))
        # A budget or a time of zero must not divide.
        per_left = 1.0 / max(left, 1.0)
        per_time = 1.0 / max(remaining, 1.0)
        orbit, home = orbits[body], orbits[HOME]
        radius, inclination = radius_at(orbit, now), inclination_at(orbit, now)
        raan = node_at(orbit, now)
        home_radius, home_inclination = radius_at(home, now), inclination_at(home, now)
        home_raan = node_at(home, now)
        node_scale = DEGREES * math.sin(home_inclination)
        cosine = math.cos(home_inclination)
        phase = latitude_at(orbit, now) + cosine * raan
        count, unvisited = 0, 0
        station_reachable = False
        for j in range(bodies):
            is_station = j == HOME
            row = targets if is_station else j - 1
            if not is_station and visited[j]:
                mask[e, row] = False
                for column in range(out.shape[1]):
                    out[row, column] = 0.0
                continue
            allowed = since > 0 and j != body if is_station else j != body
            unvisited += 0 if is_station else 1
            delta_v, end, after = costs[j], ends[j], lefts[j]
            in_time = end <= duration
            is_legal = fits[j]
            mask[e, row] = is_legal
            count += is_legal
            if is_station:
                station_reachable = is_legal or body == HOME
                after = rules.budget
            hours = (end - now) * PER_HOUR
            after_scaled = clip(after * PER_KM_S, -LIMIT, LIMIT)
            out[row, LEGAL] = 1.0 if is_legal else 0.0
            out[row, IS_STATION] = 1.0 if is_station else 0.0
            out[row, IS_OPEN] = 1.0 if allowed else 0.0
            out[row, NEEDED] = clip(delta_v * PER_KM_S, 0.0, LIMIT)
            out[row, NEEDED_OF_LEFT] = clip(delta_v * per_left, 0.0, LIMIT)
            out[row, TAKEN] = clip(hours * PER_TEN, 0.0, LIMIT)
            out[row, TAKEN_OF_LEFT] = clip((end - now) * per_time, 0.0, LIMIT)
            out[row, COST] = clip((hours + delta_v * HOURS_PER_M_S) * PER_TEN, 0.0, LIMIT)
            out[row, LEFT_AFTER] = after_scaled
            out[row, TIME_AFTER] = clip((duration - end) * PER_HOUR * PER_TEN, -LIMIT, LIMIT)
            back, margin, safe, back_hours = 0.0, after_scaled, is_legal, 0.0
            best_v, best_h, best, second = FAR, FAR, FAR, FAR
            if in_time:
                if not is_station:
                    back_end = end + home_times[j] + refuelling
                    back = clip(home_costs[j] * PER_KM_S, 0.0, LIMIT)
                    margin = clip((after - home_costs[j]) * PER_KM_S, -LIMIT, LIMIT)
                    safe = home_costs[j] <= after and back_end <= duration
                    back_hours = clip((back_end - end) * PER_HOUR * PER_TEN, 0.0, LIMIT)
                best_v, best_h, best, second = _cheapest_ahead(
                    outlook.ahead[j, places[j]], visited, after, (duration - end) * PER_HOUR
                )
            out[row, BACK] = back
            out[row, LEFT_AFTER_BACK] = margin
            out[row, SAFE] = 1.0 if safe else 0.0
            out[row, BACK_TIME] = back_hours
            out[row, NEXT_NEEDED] = best_v
            out[row, NEXT_TAKEN] = clip(best_h, 0.0, LIMIT)
            out[row, NEXT_COST] = best
            out[row, SECOND_COST] = second
            near, angle = _open_nearby(outlook, visited, j)
            out[row, NEAR_OPEN] = near * (1.0 / NEAR)
            out[row, NEAR_ANGLE] = clip(DEGREES * angle / near, 0.0, LIMIT) if near > 0 else LIMIT
            there = orbits[j]
            r, i, o = radius_at(there, now), inclination_at(there, now), node_at(there, now)
            out[row, RADIUS_FROM_CHASER] = clip((r - radius) * PER_50_KM, -LIMIT, LIMIT)
            out[row, INCLINATION_FROM_CHASER] = clip((i - inclination) * DEGREES, -LIMIT, LIMIT)
            out[row, RAAN_FROM_CHASER] = clip(turned(o - raan) * node_scale, -LIMIT, LIMIT)
            out[row, ANGLE_FROM_CHASER] = clip(outlook.angle[body, j] * DEGREES, 0.0, LIMIT)
            out[row, RADIUS_FROM_HOME] = clip((r - home_radius) * PER_50_KM, -LIMIT, LIMIT)
            out[row, INCLINATION_FROM_HOME] = clip((i - home_inclination) * DEGREES, -LIMIT, LIMIT)
            out[row, RAAN_FROM_HOME] = clip(turned(o - home_raan) * node_scale, -LIMIT, LIMIT)
            out[row, ANGLE_FROM_HOME] = clip(outlook.angle[HOME, j] * DEGREES, 0.0, LIMIT)
            ahead = latitude_at(there, now) + cosine * o
            out[row, PHASE] = turned(ahead - phase) * (1.0 / math.pi)
            if prized:
                out[row, PRIZE] = clip(rules.prize[j], 0.0, LIMIT)
        for row in range(bodies - 1, targets):
            mask[e, row] = False
            for column in range(out.shape[1]):
                out[row, column] = 0.0
        legal[e] = count
        _write_mission(
            mission[e],
            rules,
            home,
            orbit,
            now,
            left,
            remaining,
            BodyCounts(bodies, unvisited, count),
        )
        mission[e, DOCKED] = 1.0 if body == HOME else 0.0
        mission[e, EARNED] = 1.0 if since > 0 else 0.0
        mission[e, HOME_REACHABLE] = 1.0 if station_reachable else 0.0
