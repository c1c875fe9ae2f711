"""Free motion about the Earth by numerical integration: Gauss's collocation of order 16.

With eight stages a step and equal steps the method is symplectic (E. Hairer, C. Lubich and G.
Wanner, Geometric Numerical Integration, 2nd edition, 2006, sections II.1.3 and VIII.6): its energy
does not drift, so that a phase is known to centimetres after a year. For that rounding must not
lean to one side: sums are compensated, and coefficients are twice as exact as a float
(:mod:`.collocation`). Because the pull depends on the place alone, stages are solved for in the
form for second-order equations, r_i = r + c_i h v + h² Σ_j (A²)_ij a_j, by simple iteration, which
gains a digit and a half a round.
"""

import math

import numpy as np

from ...common.constants import MU_M3_S2
from ..core.compile import inlined, kernel
from .collocation import (
    AHEAD,
    NODES,
    NODES_SHORT,
    SQUARED,
    SQUARED_SHORT,
    SQUARED_WEIGHTS,
    SQUARED_WEIGHTS_SHORT,
    STAGES,
    WEIGHTS,
    WEIGHTS_SHORT,
)
from .gravity import gradient, pull

STEP_RAD = 0.7
"""Length of a step at the perigee, as an angle on the circle there."""

MOST_ROUNDS = 40
"""Maximum number of iterations for the stages; about ten are needed."""


@inlined
def step_length(state):
    """Step length for an orbit; negative if it is not closed or passes through the centre [s]."""
    r = math.sqrt(state[0] ** 2 + state[1] ** 2 + state[2] ** 2)
    inverse = 2.0 / r - (state[3] ** 2 + state[4] ** 2 + state[5] ** 2) / MU_M3_S2
    if not inverse > 0.0:
        return -1.0
    towards = state[0] * state[3] + state[1] * state[4] + state[2] * state[5]
    e_sine = towards * math.sqrt(inverse / MU_M3_S2)
    e = math.sqrt((1.0 - r * inverse) ** 2 + e_sine * e_sine)
    perigee = (1.0 - e) / inverse
    if not perigee > 1e6:
        return -1.0
    return STEP_RAD * math.sqrt(perigee**3 / MU_M3_S2)


@kernel
def _stages(state, lost, h, zonals, place, force, short, spare):
    """Solve for the places of the stages; ``force`` comes with a guess and leaves with the pull."""
    # What the rounded state and coefficients are short of; the guess is good enough for that.
    for i in range(STAGES):
        for axis in range(3):
            total = 0.0
            for j in range(STAGES):
                total += SQUARED_SHORT[i, j] * force[j, axis]
            ahead = NODES[i] * lost[3 + axis] + NODES_SHORT[i] * state[3 + axis]
            short[i, axis] = lost[axis] + h * (ahead + h * total)
    last = math.inf
    for _ in range(MOST_ROUNDS):
        change = 0.0
        for i in range(STAGES):
            for axis in range(3):
                total = 0.0
                for j in range(STAGES):
                    total += SQUARED[i, j] * force[j, axis]
                ahead = h * (NODES[i] * state[3 + axis] + h * total)
                found = state[axis] + (ahead + short[i, axis])
                change = max(change, abs(found - place[i, axis]))
                place[i, axis] = found
        for i in range(STAGES):
            spare[0], spare[1], spare[2] = pull(place[i, 0], place[i, 1], place[i, 2], zonals)
            for axis in range(3):
                force[i, axis] = spare[axis]
        # Until nothing is gained any more: what is left is rounding.
        if change < 1e-3 and change >= last:
            return
        last = change


@kernel
def _carry(matrix, h, zonals, place, columns, pulled, slope):
    """Multiply a state-transition matrix by that of a step with known stages."""
    for i in range(STAGES):
        gradient(place[i, 0], place[i, 1], place[i, 2], zonals, slope[i])
    for column in range(6):
        for i in range(STAGES):
            for axis in range(3):
                pulled[i, axis] = 0.0
        for _ in range(MOST_ROUNDS):
            change = size = 0.0
            for i in range(STAGES):
                for axis in range(3):
                    total = 0.0
                    for j in range(STAGES):
                        total += SQUARED[i, j] * pulled[j, axis]
                    found = matrix[axis, column] + h * (
                        NODES[i] * matrix[3 + axis, column] + h * total
                    )
                    change = max(change, abs(found - columns[i, axis]))
                    size = max(size, abs(found))
                    columns[i, axis] = found
            for i in range(STAGES):
                for axis in range(3):
                    total = 0.0
                    for other in range(3):
                        total += slope[i, axis, other] * columns[i, other]
                    pulled[i, axis] = total
            if change <= 1e-14 * size:
                break
        for axis in range(3):
            far = near = 0.0
            for i in range(STAGES):
                far += SQUARED_WEIGHTS[i] * pulled[i, axis]
                near += WEIGHTS[i] * pulled[i, axis]
            matrix[axis, column] += h * (matrix[3 + axis, column] + h * far)
            matrix[3 + axis, column] += h * near


@kernel
def coast(state, duration, zonals, matrix):
    """Propagate a state in free motion, in place.

    Parameters
    ----------
    state : (6,) float64
        Inertial position and velocity [m, m/s]; replaced by those at the end, NaN where the orbit
        is not closed or passes the centre of the Earth.
    duration : float
        Of either sign [s].
    zonals : (3,) float64
        One of :data:`.gravity.FIELDS`.
    matrix : (6, 6) or (0, 0) float64
        Multiplied from the left by the derivative of the end by the beginning.

    Returns
    -------
    float
        The angle that the position has run through [rad].
    """
    if duration == 0.0:
        return 0.0
    longest = step_length(state)
    if not longest > 0.0:
        for axis in range(6):
            state[axis] = math.nan
        return 0.0
    steps = math.ceil(abs(duration) / longest)
    h = duration / steps
    place, force, guess = np.zeros((STAGES, 3)), np.empty((STAGES, 3)), np.empty((STAGES, 3))
    short, spare = np.empty((STAGES, 3)), np.empty(3)
    columns, pulled = np.zeros((STAGES, 3)), np.empty((STAGES, 3))
    slope = np.empty((STAGES, 3, 3))
    # What rounding takes from the sums is kept: without it a year costs decimetres.
    lost = np.zeros(6)
    spare[0], spare[1], spare[2] = pull(state[0], state[1], state[2], zonals)
    for i in range(STAGES):
        for axis in range(3):
            force[i, axis] = spare[axis]
    angle = 0.0
    # Equal steps: with others the method would not be symplectic, and the energy would drift.
    for _ in range(steps):
        _stages(state, lost, h, zonals, place, force, short, spare)
        if matrix.shape[0] > 0:
            _carry(matrix, h, zonals, place, columns, pulled, slope)
        x, y, z = state[0], state[1], state[2]
        for axis in range(3):
            far = near = 0.0
            for i in range(STAGES):
                far += SQUARED_WEIGHTS_SHORT[i] * force[i, axis]
                near += WEIGHTS_SHORT[i] * force[i, axis]
            for i in range(STAGES):
                far += SQUARED_WEIGHTS[i] * force[i, axis]
                near += WEIGHTS[i] * force[i, axis]
            add = h * (state[3 + axis] + h * far) + lost[axis]
            total = state[axis] + add
            lost[axis] = add - (total - state[axis])
            state[axis] = total
            add = h * near + lost[3 + axis]
            total = state[3 + axis] + add
            lost[3 + axis] = add - (total - state[3 + axis])
            state[3 + axis] = total
        cross_x = y * state[2] - z * state[1]
        cross_y = z * state[0] - x * state[2]
        cross_z = x * state[1] - y * state[0]
        cross = math.sqrt(cross_x * cross_x + cross_y * cross_y + cross_z * cross_z)
        angle += math.atan2(cross, x * state[0] + y * state[1] + z * state[2])
        # The polynomial through the pull at this step's stages, continued, is the guess of the
        # next.
        for i in range(STAGES):
            for axis in range(3):
                total = 0.0
                for j in range(STAGES):
                    total += AHEAD[i, j] * force[j, axis]
                guess[i, axis] = total
        for i in range(STAGES):
            for axis in range(3):
                force[i, axis] = guess[i, axis]
    return angle


@kernel
def chain(arcs):
    """Derivatives of the final state by each arc's start, in place of those of each arc's end.

    Parameters
    ----------
    arcs : (arcs, 6, 6) float64
        Written to.
    """
    product = np.empty((6, 6))
    for b in range(arcs.shape[0] - 2, -1, -1):
        for i in range(6):
            for j in range(6):
                total = 0.0
                for k in range(6):
                    total += arcs[b + 1, i, k] * arcs[b, k, j]
                product[i, j] = total
        for i in range(6):
            for j in range(6):
                arcs[b, i, j] = product[i, j]


@kernel
def fly(start, times, impulses, end, zonals, with_matrices):
    """Fly from burn to burn.

    Parameters
    ----------
    start : (6,) float64
        State at the first time, before the burn [m, m/s].
    times : (burns,) float64
        In order [s].
    impulses : (burns, 3) float64
        [m/s].
    end : float
        Not before the last burn [s].
    zonals : (3,) float64
    with_matrices : bool

    Returns
    -------
    states : (burns + 1, 6) float64
        Before each burn, and at the end.
    matrices : (burns, 6, 6) float64
        Derivatives of the state at the end by that after each burn; none where not asked for.
    angle : float
        That the position has run through from the first burn to the end [rad].
    """
    count = times.size
    states = np.empty((count + 1, 6))
    arcs = np.zeros((count if with_matrices else 0, 6, 6))
    none = np.empty((0, 0))
    now = start.copy()
    angle = 0.0
    for b in range(count):
        for axis in range(6):
            states[b, axis] = now[axis]
        for axis in range(3):
            now[3 + axis] += impulses[b, axis]
        until = times[b + 1] if b + 1 < count else end
        # Arcs are flown from identity, and multiplied from the end: each product is used again.
        if with_matrices:
            for axis in range(6):
                arcs[b, axis, axis] = 1.0
            angle += coast(now, until - times[b], zonals, arcs[b])
        else:
            angle += coast(now, until - times[b], zonals, none)
    for axis in range(6):
        states[count, axis] = now[axis]
    if with_matrices:
        chain(arcs)
    return states, arcs, angle
