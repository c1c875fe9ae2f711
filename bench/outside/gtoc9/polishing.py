"""Few impulses made cheaper: their times and components together, by sequential programming.

The miss depends on an impulse u at a time t by J Φ [0; u], and on the time itself by −J Φ [u; 0]:
before the impulse a chaser moves on without it, and after it with it. Φ leads from there to the
end, and J from states to equinoctial elements.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import minimize

from adr_opt.fly.refine.least import least_impulses
from adr_opt.fly.refine.leg import FlownImpulses, LegEnds, NoWay, close
from adr_opt.kernels.orbits import coast, equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS

from ..reading import FloatArray

UNIT_S, UNIT_M = 200.0, 1e3
"""Scales of times and of misses in the program."""

STEPS, WORTH_M_S = 25, 0.02
"""Maximum number of steps of the program, and least ΔV gain for another one."""

ROOM_S, ROOM_M_S = 3000.0, 100.0
"""Trust region of times and components: half a revolution, and no wild orbits on the way."""

APART_S = 1.0
"""Impulses do not come nearer to each other."""

MOST_NEWTON = 12


def sensitive(
    course: LegEnds, times: FloatArray, impulses: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The miss of a flight, and its derivatives by times and impulses.

    Returns
    -------
    miss : (6,) float64
        In equinoctial elements; NaN where the impulses lead away from the Earth.
    derivatives : (6, 4 · impulses) float64
        By all times, then by all components.
    """
    states, arcs, angle = coast.fly(
        course.start,
        np.r_[course.start_s, times],
        np.vstack([np.zeros(3), impulses]),
        course.end_s,
        FIELDS[course.gravity],
        True,
    )
    frame = equinoctial.own_frame(course.goal)
    miss = equinoctial.elements(states[-1], frame) - equinoctial.elements(course.goal, frame)
    if not np.isfinite(miss).all():
        return np.full(6, np.nan), np.full((6, 4 * times.size), np.nan)
    miss[5] = math.remainder(miss[5], math.tau)
    miss[5] += math.tau * round((angle - course.angle - miss[5]) / math.tau)
    effects = equinoctial.jacobian(states[-1], frame) @ arcs[1:]
    by_time = -np.einsum("kij,kj->ik", effects[:, :, :3], impulses)
    by_impulse = effects[:, :, 3:].transpose(1, 0, 2).reshape(6, -1)
    return miss, np.hstack([by_time, by_impulse])


def polished(course: LegEnds, times: FloatArray, impulses: FloatArray) -> FlownImpulses:
    """The same number of impulses at better times, with less ΔV.

    Raises
    ------
    NoWay
        What came out cannot be closed.
    """
    count, radius = times.size, math.hypot(*course.goal[:3])
    weights = np.array([1.0, *([radius] * 5)]) / UNIT_M
    kept: dict[bytes, tuple[FloatArray, FloatArray]] = {}

    def parts(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        return course.start_s + UNIT_S * x[:count], x[count:].reshape(count, 3)

    def missed(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        key = x.tobytes()
        if key not in kept:
            kept.clear()
            kept[key] = sensitive(course, *parts(x))
            if not np.isfinite(kept[key][0]).all():
                raise NoWay("the burns lead away from the Earth or into its centre")
        return kept[key]

    def sizes(x: FloatArray) -> FloatArray:
        # Smooth at zero.
        found: FloatArray = np.sqrt(np.sum(parts(x)[1] ** 2, axis=1) + 1e-8)
        return found

    def slopes(x: FloatArray) -> FloatArray:
        return np.r_[np.zeros(count), (parts(x)[1] / sizes(x)[:, None]).ravel()]

    scale = np.r_[np.full(count, UNIT_S), np.ones(3 * count)]
    order = np.eye(count, 4 * count, 1)[:-1] - np.eye(count, 4 * count)[:-1]
    span = (course.end_s - course.start_s) / UNIT_S
    begin = (times - course.start_s) / UNIT_S
    found = minimize(
        lambda x: sizes(x).sum(),
        np.r_[begin, impulses.ravel()],
        jac=slopes,
        method="SLSQP",
        bounds=[
            *((max(at - ROOM_S / UNIT_S, 0.0), min(at + ROOM_S / UNIT_S, span)) for at in begin),
            *((part - ROOM_M_S, part + ROOM_M_S) for part in impulses.ravel()),
        ],
        constraints=[
            {
                "type": "eq",
                "fun": lambda x: missed(x)[0] * weights,
                "jac": lambda x: missed(x)[1] * scale * weights[:, None],
            },
            {"type": "ineq", "fun": lambda x: order @ x - APART_S / UNIT_S, "jac": lambda x: order},
        ],
        options={"maxiter": STEPS, "ftol": WORTH_M_S},
    ).x
    if not np.isfinite(found).all():
        raise NoWay("no better impulses")
    times, impulses = parts(found)
    times = np.maximum.accumulate(np.clip(times, course.start_s, course.end_s))
    return close(course, times, impulses, MOST_NEWTON)


def without_one(
    times: FloatArray, impulses: FloatArray, effects: FloatArray
) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """All but one of some impulses, for each one, the cheapest first: times, impulses, effects.

    They are those of least size that do to first order what all of them did.
    """
    aimed = np.einsum("kij,kj->i", effects, impulses)
    found = []
    for place in range(times.size):
        left = np.arange(times.size) != place
        least = least_impulses(effects[left], aimed, 1e-2)
        if np.isfinite(least.total) and least.impulses.any():
            found.append((least.total, (times[left], least.impulses, effects[left])))
    return [way for _, way in sorted(found, key=lambda item: item[0])]
