"""Flight with arcs of low thrust about the Earth, integrated in longitude.

Modified equinoctial elements (M. Walker, B. Ireland and J. Owens, Celestial Mechanics 36, 1985,
409) and the time change along the true longitude L, by Gauss's collocation of order 16. With L as
the variable thrust is switched exactly at places of the orbit. The rates are small, so that a few
iterations of the stages suffice.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ..core.compile import inlined, kernel
from .collocation import BEFORE, NODES, STAGES, WEIGHTS
from .gravity import pull
from .primer import length, pushed
from .sunlight import sun_direction

STEP_RAD, PUSHED_STEP_RAD = 0.7, 0.35
"""Longest steps without and with thrust, whose direction turns faster than the orbit."""

MOST_ROUNDS = 12
"""Maximum number of iterations for the stages; four to five are needed."""

SCAN_RAD = 2.0 * math.pi / 90.0
"""Spacing of places at which thrust is tested for being on [rad]."""

NEAR_RAD = 0.05
"""Distance before a switch at which its place is computed again [rad]."""

CLEAR_M = 5e3
"""Clearance from the shadow: change of an osculating orbit over that distance [m]."""

GRAZED_M, BESIDE_RAD = 3e4, 0.15
"""Clearance below which the darkest place is looked at once more, from twice that distance, and
half the width of a short shadow."""

MOST_LANDINGS = 30
"""Maximum number of steps to a given time."""


class Push(NamedTuple):
    """Thrust of a chaser over a leg.

    Attributes
    ----------
    force : float
        When it is on, the mean over the duty cycle [N].
    exhaust : float
        g₀ Isp [m/s].
    mass : float
        At the beginning [kg].
    since_j2000 : float
        The epoch [s].
    """

    force: float
    exhaust: float
    mass: float
    since_j2000: float


class ThrustArcs(NamedTuple):
    """Arcs of thrust in time order.

    Attributes
    ----------
    laws : (arcs, 5) float64
        As :mod:`.primer` has them.
    least : (arcs,) float64
        Shortest p with which thrust is on.
    starts : (arcs,) float64
        Beginnings [s].
    spans : (arcs,) float64
        Time in which thrust is on in each [s].
    """

    laws: np.ndarray
    least: np.ndarray
    starts: np.ndarray
    spans: np.ndarray


class Engine(NamedTuple):
    """An engine over a part of an orbit, off where there is no force.

    Attributes
    ----------
    mass, flow, force : float
        At the beginning [kg], [kg/s], [N].
    law : (5,) float64
    """

    mass: float
    flow: float
    force: float
    law: np.ndarray


@inlined
def _frame(h, k, c, s):
    """Outward and across unit vectors at a longitude of cosine c and sine s."""
    square, apart = 1.0 + h * h + k * k, h * h - k * k
    return (
        (c + apart * c + 2.0 * h * k * s) / square,
        (s - apart * s + 2.0 * h * k * c) / square,
        2.0 * (h * s - k * c) / square,
        2.0 * k / square,
        -2.0 * h / square,
        (1.0 - h * h - k * k) / square,
    )


@inlined
def _rates(of, longitude, acceleration, law, zonals):
    """Rates of p, f, g, h, k and the time by the longitude; no thrust where it is 0 [m/s²]."""
    p, f, g, h, k = of[0], of[1], of[2], of[3], of[4]
    c, s = math.cos(longitude), math.sin(longitude)
    w = 1.0 + f * c + g * s
    r = p / w
    ox, oy, oz, nx, ny, nz = _frame(h, k, c, s)
    ax, ay, az = ny * oz - nz * oy, nz * ox - nx * oz, nx * oy - ny * ox
    px, py, pz = pull(r * ox, r * oy, r * oz, zonals)
    point = MU_M3_S2 / (r * r)
    px, py, pz = px + point * ox, py + point * oy, pz + point * oz
    radial = px * ox + py * oy + pz * oz
    along = px * ax + py * ay + pz * az
    across = px * nx + py * ny + pz * nz
    if acceleration > 0.0:
        u = longitude - math.atan2(k, h)
        p_r, p_t, p_n = pushed(law, u)
        scale = acceleration / math.sqrt(p_r * p_r + p_t * p_t + p_n * p_n)
        radial, along, across = radial + scale * p_r, along + scale * p_t, across + scale * p_n
    pace = math.sqrt(p / MU_M3_S2)
    tilt = h * s - k * c
    square = 1.0 + h * h + k * k
    turn = math.sqrt(MU_M3_S2 * p) / (r * r) + pace * tilt * across / w
    per = pace / turn
    return (
        2.0 * r * per * along,
        per * (radial * s + ((w + 1.0) * c + f) * along / w - tilt * g * across / w),
        per * (-radial * c + ((w + 1.0) * s + g) * along / w + tilt * f * across / w),
        0.5 * per * square * across / w * c,
        0.5 * per * square * across / w * s,
        1.0 / turn,
    )


@kernel
def _advance(now, end, engine, zonals, work, rates):
    """Integrate elements and time, ``now``, to a longitude, in place; the mass there [kg]."""
    mass, flow, force, law = engine.mass, engine.flow, engine.force, engine.law
    longest = PUSHED_STEP_RAD if force > 0.0 else STEP_RAD
    steps = max(1, math.ceil(abs(end - now[6]) / longest))
    step = (end - now[6]) / steps
    began = now[5]
    for _ in range(steps):
        first = _rates(now, now[6], force / (mass - flow * (now[5] - began)), law, zonals)
        for stage in range(STAGES):
            for axis in range(6):
                rates[stage, axis] = first[axis]
        for _round in range(MOST_ROUNDS):
            change = 0.0
            for stage in range(STAGES):
                for axis in range(6):
                    total = 0.0
                    for other in range(STAGES):
                        total += BEFORE[stage, other] * rates[other, axis]
                    work[stage, axis] = now[axis] + step * total
            for stage in range(STAGES):
                found = _rates(
                    work[stage],
                    now[6] + NODES[stage] * step,
                    force / (mass - flow * (work[stage, 5] - began)),
                    law,
                    zonals,
                )
                change = max(change, abs(found[5] - rates[stage, 5]))
                for axis in range(6):
                    rates[stage, axis] = found[axis]
            if change < 1e-10:
                break
        for axis in range(6):
            total = 0.0
            for stage in range(STAGES):
                total += WEIGHTS[stage] * rates[stage, axis]
            now[axis] += step * total
        now[6] += step
    return mass - flow * (now[5] - began)


@inlined
def _pace(now):
    """Rate of the longitude [rad/s]."""
    w = 1.0 + now[1] * math.cos(now[6]) + now[2] * math.sin(now[6])
    return math.sqrt(MU_M3_S2 / now[0] ** 3) * w * w


@kernel
def _land(now, time, engine, zonals, work, rates):
    """Integrate to a time, at which ``now`` then is to the rounding of a float; the mass [kg]."""
    mass = engine.mass
    for _ in range(MOST_LANDINGS):
        left = time - now[5]
        if abs(left) < 1e-9 * max(1.0, abs(time) * 1e-6):
            break
        rest = Engine(mass, engine.flow, engine.force, engine.law)
        mass = _advance(now, now[6] + left * _pace(now), rest, zonals, work, rates)
    return mass


@inlined
def _clearance(now, longitude, sun):
    """Distance of a place of the orbit from the shadow; infinite before the Earth [m]."""
    c, s = math.cos(longitude), math.sin(longitude)
    r = now[0] / (1.0 + now[1] * c + now[2] * s)
    x, y, z, _, _, _ = _frame(now[3], now[4], c, s)
    towards = x * sun[0] + y * sun[1] + z * sun[2]
    return math.inf if towards > 0.0 else r * math.sqrt(1.0 - towards * towards) - EARTH_RADIUS_M


@inlined
def _is_on(now, longitude, law, least, sun):
    """Whether thrust is on at a place."""
    u = longitude - math.atan2(now[4], now[3])
    return length(law, u) >= least and _clearance(now, longitude, sun) > CLEAR_M


@inlined
def _darkest(now, sun):
    """The next longitude that is farthest from the Sun."""
    x, y, z, _, _, _ = _frame(now[3], now[4], 1.0, 0.0)
    along = x * sun[0] + y * sun[1] + z * sun[2]
    x, y, z, _, _, _ = _frame(now[3], now[4], 0.0, 1.0)
    ahead = x * sun[0] + y * sun[1] + z * sun[2]
    return now[6] + (math.atan2(-ahead, -along) - now[6]) % (2.0 * math.pi)


@kernel
def _next_switch(now, is_on, law, least, sun):
    """Longitude at which thrust is switched next, at most half a revolution on; whether it is."""
    before = now[6]
    here, darkest = before + 0.5 * SCAN_RAD, _darkest(now, sun)
    beside = darkest - 2.0 * BESIDE_RAD
    while here < now[6] + math.pi:
        # The shortest shadow has a place that is asked for.
        if before < darkest < here:
            here = darkest
        if _is_on(now, here, law, least, sun) != is_on:
            low, high = before, here
            while high - low > 1e-13 * max(1.0, abs(high)):
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if _is_on(now, middle, law, least, sun) == is_on:
                    low = middle
                else:
                    high = middle
            # From afar it is known to some kilometres only, which move edges of a short shadow far.
            if abs(high - darkest) < BESIDE_RAD and beside - now[6] > NEAR_RAD:
                return beside, False
            far = high - now[6] > 2.0 * NEAR_RAD
            return (high - NEAR_RAD, False) if far else (high, True)
        before = here
        here += SCAN_RAD
    # From afar an edge may be nearer than it seems: short of the last place that was asked for, and
    # not past a shadow that may be grazed.
    if now[6] + NEAR_RAD < beside < before and _clearance(now, darkest, sun) < GRAZED_M:
        return beside, False
    return before - NEAR_RAD, False


@kernel
def fly(now, until, push, arcs, zonals, windows):
    """Fly arcs of thrust and the coasts between them.

    Parameters
    ----------
    now : (7,) float64
        p, f, g, h, k, the time [s] and the true longitude [rad]; written to.
    until : float
        Time of the end [s].
    push : Push
    arcs : ThrustArcs
    zonals : (3,) float64
        One of :data:`.gravity.FIELDS`.
    windows : (windows, 3) float64
        Beginning and end of each window of thrust, and the number of its arc; written to.

    Returns
    -------
    count : int
        Number of windows; more than there is room for are not written.
    mass : float
        At the end [kg].
    left : float
        Time of thrust that has not been flown by the end [s].
    """
    work, rates, kept = np.empty((STAGES, 6)), np.empty((STAGES, 6)), np.empty(7)
    off = np.zeros(5)
    mass, flow, count, missing = push.mass, push.force / push.exhaust, 0, 0.0
    for arc in range(arcs.starts.size):
        law, least = arcs.laws[arc], arcs.least[arc]
        latest = arcs.starts[arc + 1] if arc + 1 < arcs.starts.size else until
        if now[5] < arcs.starts[arc]:
            _land(now, arcs.starts[arc], Engine(mass, 0.0, 0.0, off), zonals, work, rates)
        left = arcs.spans[arc]
        is_on = left > 0.0
        is_on = is_on and _is_on(now, now[6], law, least, sun_direction(push.since_j2000 + now[5]))
        while left > 0.0 and now[5] < latest:
            sun = sun_direction(push.since_j2000 + now[5])
            # Steps end at switches, so that rates are smooth within each. An edge that is far away
            # is approached first and asked for again from there: what perturbs the orbit moves it.
            edge, switches = _next_switch(now, is_on, law, least, sun)
            kept[:] = now
            engine = Engine(mass, flow if is_on else 0.0, push.force if is_on else 0.0, law)
            mass = _advance(now, edge, engine, zonals, work, rates)
            end = min(latest, kept[5] + left) if is_on else latest
            is_over = now[5] > end
            if is_over:
                now[:] = kept
                mass = _land(now, end, engine, zonals, work, rates)
            if is_on:
                left = 0.0 if is_over and end < latest else left - (now[5] - kept[5])
                if count > 0 and windows[count - 1, 1] == kept[5] and windows[count - 1, 2] == arc:
                    windows[count - 1, 1] = now[5]
                elif count < windows.shape[0]:
                    windows[count, 0], windows[count, 1], windows[count, 2] = kept[5], now[5], arc
                    count += 1
            if is_over:
                break
            if switches:
                is_on = not is_on
        missing += max(left, 0.0)
    _land(now, until, Engine(mass, 0.0, 0.0, off), zonals, work, rates)
    return count, mass, missing


@kernel
def follow(now, times, windows, laws, push, zonals):
    """States at times of a flight with known windows of thrust, shape (times, 6) [m, m/s].

    Parameters
    ----------
    now : (7,) float64
        As of :func:`fly`; written to.
    times : (times,) float64
        In order, not before the first [s].
    windows : (windows, 3) float64
        As :func:`fly` writes them.
    laws : (arcs, 5) float64
    push : Push
    zonals : (3,) float64
    """
    work, rates, found = np.empty((STAGES, 6)), np.empty((STAGES, 6)), np.empty((times.size, 6))
    off = np.zeros(5)
    mass, flow, window = push.mass, push.force / push.exhaust, 0
    for at in range(times.size):
        while now[5] < times[at]:
            end, engine = times[at], Engine(mass, 0.0, 0.0, off)
            if window < windows.shape[0]:
                if now[5] < windows[window, 0]:
                    end = min(end, windows[window, 0])
                else:
                    end = min(end, windows[window, 1])
                    engine = Engine(mass, flow, push.force, laws[int(windows[window, 2])])
            mass = _land(now, end, engine, zonals, work, rates)
            now[5] = end
            if window < windows.shape[0] and end >= windows[window, 1]:
                window += 1
        found[at] = state_of(now)
    return found


@kernel
def elements_of(state, time):
    """p, f, g, h, k, the time and the true longitude of a state at a time, shape (7,)."""
    x, y, z, u, v, w = state[0], state[1], state[2], state[3], state[4], state[5]
    mx, my, mz = y * w - z * v, z * u - x * w, x * v - y * u
    square = mx * mx + my * my + mz * mz
    size = math.sqrt(square)
    h, k = -my / (size + mz), mx / (size + mz)
    whole, apart = 1.0 + h * h + k * k, h * h - k * k
    x1, y1, z1 = (1.0 + apart) / whole, 2.0 * h * k / whole, -2.0 * k / whole
    x2, y2, z2 = 2.0 * h * k / whole, (1.0 - apart) / whole, 2.0 * h / whole
    r = math.sqrt(x * x + y * y + z * z)
    ex = (v * mz - w * my) / MU_M3_S2 - x / r
    ey = (w * mx - u * mz) / MU_M3_S2 - y / r
    ez = (u * my - v * mx) / MU_M3_S2 - z / r
    return np.array(
        [
            square / MU_M3_S2,
            ex * x1 + ey * y1 + ez * z1,
            ex * x2 + ey * y2 + ez * z2,
            h,
            k,
            time,
            math.atan2(x * x2 + y * y2 + z * z2, x * x1 + y * y1 + z * z1),
        ]
    )


@kernel
def state_of(now):
    """Inertial state of the elements of :func:`elements_of`, shape (6,) [m, m/s]."""
    p, f, g, h, k = now[0], now[1], now[2], now[3], now[4]
    c, s = math.cos(now[6]), math.sin(now[6])
    whole, apart = 1.0 + h * h + k * k, h * h - k * k
    r, pace = p / (1.0 + f * c + g * s), math.sqrt(MU_M3_S2 / p)
    x, y, u, v = r * c, r * s, -pace * (g + s), pace * (f + c)
    return np.array(
        [
            ((1.0 + apart) * x + 2.0 * h * k * y) / whole,
            (2.0 * h * k * x + (1.0 - apart) * y) / whole,
            (-2.0 * k * x + 2.0 * h * y) / whole,
            ((1.0 + apart) * u + 2.0 * h * k * v) / whole,
            (2.0 * h * k * u + (1.0 - apart) * v) / whole,
            (-2.0 * k * u + 2.0 * h * v) / whole,
        ]
    )
