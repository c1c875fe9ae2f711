"""Programmes of thrust that lead to the goal of a leg, by averaged motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...kernels.orbits.short_periods import Array
from ...plan.plan import LowThrustArc
from .thrust_guess import LARGEST_THRESHOLD, LEAST_THRESHOLD, first_guess
from .thrust_task import Integration, Programme, ThrustTask

STEP_M_S = 0.02
"""Step of finite differences [m/s]."""

CLOSED_M_S, EXACT_M_S = 1e-2, 1e-5
"""Misses at which a prediction reaches its goal, and at which no further step is taken [m/s]."""

MOST_STEPS, MOST_ROUNDS, MOST_HALVINGS = 10, 3, 6
"""Maximum numbers of Newton steps, of rounds of them, and of halvings of a step."""

LEAST_STEPS = 60
"""Maximum number of steps towards the least ΔV."""

SPARE, SPARE_S = 0.03, 9000.0
"""Time between the second arc and the end, as a share of the arc, and at least [s]."""

WIDER = 0.75
"""Factor on thresholds that widens windows."""

SCALE, SCALE_S, STEP = 100.0, 5.0 * 86400.0, 2e-4
"""Units of laws [m/s] and times [s] in the search for the least ΔV, and step of its differences."""

LATE = 2.0
"""Assumed time of an arc beyond the end, as a multiple of the time of thrust left undone."""

RANK = 1e-6
"""Relative size of singular values that are taken for 0."""


def candidates(task: ThrustTask, arcs: tuple[LowThrustArc, ...]) -> Iterator[Programme]:
    """Programmes that meet the goal by averaged motion, the cheapest first.

    From two first guesses, with and without laws that make up for the eccentricity, those of the
    two numbers of laps next to that of the guess; after them the same with wider windows, and with
    thrust nearly wherever there is sunlight.
    """
    found = []
    for shaped in (False, True):
        guess = first_guess(task, arcs, shaped=shaped)
        laps = task.laps_to(task.predict(guess).mean)
        nearer = float(round(laps))
        for number in (nearer, nearer + 1.0 if laps > nearer else nearer - 1.0):
            made = _led(task, guess, number)
            if made is not None:
                found.append(made)
    yield from sorted(found, key=_cost)
    for share in (WIDER, 0.0):
        lower = np.maximum(share * guess.thresholds, LEAST_THRESHOLD)
        wider = Programme(guess.steered, lower, guess.second_s)
        for way in (_led, _led_in_steps):
            made = way(task, wider, nearer)
            if made is not None:
                yield made


def minimum_norm(derivative: Array, wanted: Array) -> Array:
    """The least change of laws that changes a miss by a given amount, shape (10,) [m/s]."""
    step: Array = np.asarray(np.linalg.lstsq(derivative, wanted, rcond=RANK)[0], dtype=np.float64)
    return step


def derivative_of(task: ThrustTask, programme: Programme, laps: float) -> Array:
    """Derivative of the predicted miss by the laws, shape (6, 10)."""
    found = np.empty((6, 10))
    for column in range(10):
        change = np.zeros(10)
        change[column] = STEP_M_S
        above, below = (
            task.off(task.predict(programme.steered_by(programme.steered + side)).mean, laps)
            for side in (change, -change)
        )
        found[:, column] = (above - below) / (2.0 * STEP_M_S)
    return found


def _cost(programme: Programme) -> float:
    return float(programme.costs_m_s.sum())


def _led(task: ThrustTask, guess: Programme, laps: float) -> Programme | None:
    """A programme that meets the goal, near the cheapest one; None if there is none."""
    begun = _in_time(task, guess)
    direct = _closed(task, _least(task, begun, laps), laps)
    if _is_closed(task, direct, laps):
        return direct
    return _led_in_steps(task, guess, laps)


def _led_in_steps(task: ThrustTask, guess: Programme, laps: float) -> Programme | None:
    """A programme that meets the goal, in two steps: first the goal, then the least ΔV."""
    near = _in_time(task, guess)
    for _ in range(MOST_ROUNDS):
        near = _in_time(task, _closed(task, near, laps))
    near = _closed(task, near, laps)
    ways = (_closed(task, _least(task, near, laps), laps), near)
    return min((way for way in ways if _is_closed(task, way, laps)), key=_cost, default=None)


def _is_closed(task: ThrustTask, programme: Programme, laps: float) -> bool:
    end = task.predict(programme)
    return end.left_s < 1.0 and bool(np.abs(task.off(end.mean, laps)).max() < CLOSED_M_S)


def _in_time(task: ThrustTask, programme: Programme) -> Programme:
    """A programme whose second arc ends some time before the goal."""
    told = task.predict(programme)
    lasts = (told.ends_s[1] - programme.second_s) * (1.1 if told.left_s > 0.0 else 1.0)
    begins = task.end_s - lasts - max(SPARE * lasts, SPARE_S)
    return Programme(
        programme.steered, programme.thresholds, max(begins, float(told.ends_s[0]) + 60.0)
    )


def _closed(task: ThrustTask, programme: Programme, laps: float) -> Programme:
    """The programme after Newton steps of least change."""
    off = task.off(task.predict(programme).mean, laps)
    for _ in range(MOST_STEPS):
        if np.abs(off).max() < EXACT_M_S or not np.isfinite(off).all():
            break
        step = minimum_norm(derivative_of(task, programme, laps), -off)
        for _ in range(MOST_HALVINGS):
            tried = programme.steered_by(programme.steered + step)
            found = task.off(task.predict(tried).mean, laps)
            if np.linalg.norm(found) < np.linalg.norm(off):
                programme, off = tried, found
                break
            step = 0.5 * step
        else:
            break
    return programme


def closed_again(task: ThrustTask, programme: Programme) -> Programme:
    """A programme near one that met the goal before predictions were corrected."""
    return _closed(task, programme, float(round(task.laps_to(task.predict(programme).mean))))


def _least(task: ThrustTask, programme: Programme, laps: float) -> Programme:
    """A programme of less ΔV that meets the goal, by sequential quadratic programming.

    Thresholds and the beginning of the second arc are free, too: where a shadow leaves thrust on
    one side of the orbit alone, narrower windows that keep it round cost time in place of ΔV.
    """
    began = np.r_[
        programme.steered / SCALE,
        programme.thresholds,
        (programme.second_s - task.start_s) / SCALE_S,
    ]

    def made(unknown: Array) -> Programme:
        return Programme(SCALE * unknown[:10], unknown[10:12], task.start_s + SCALE_S * unknown[12])

    def told(unknown: Array) -> Array:
        """Misses, and the time left after both arcs."""
        tried = made(unknown)
        found = task.predict(tried)
        late = found.ends_s + LATE * found.left_s
        spare = max(SPARE * float(late[1] - tried.second_s), SPARE_S)
        rest = np.array([tried.second_s - late[0], task.end_s - spare - late[1]])
        both: Array = np.r_[task.off(found.mean, laps) / 10.0, rest / SCALE_S]
        return both

    known: dict[bytes, tuple[Array, Array]] = {}

    def linear(unknown: Array) -> tuple[Array, Array]:
        """Misses and time left, with their derivatives by differences."""
        key = unknown.tobytes()
        if key not in known:
            here, slope = told(unknown), np.empty((8, began.size))
            for column in range(began.size):
                moved = unknown.copy()
                moved[column] += STEP
                slope[:, column] = (told(moved) - here) / STEP
            known.clear()
            known[key] = here, slope
        return known[key]

    def cost_slope(unknown: Array) -> Array:
        arcs = unknown[:10].reshape(2, 5)
        sizes = np.maximum(np.linalg.norm(arcs, axis=1), 1e-12)
        slopes: Array = np.r_[(arcs / sizes[:, None]).ravel(), np.zeros(3)]
        return slopes

    reach = 0.5 * np.abs(programme.steered).max() / SCALE + 0.1
    limits = [(one - reach, one + reach) for one in began[:10]]
    limits += [(LEAST_THRESHOLD, LARGEST_THRESHOLD)] * 2
    limits.append((0.0, (task.end_s - task.start_s) / SCALE_S))
    from scipy.optimize import minimize

    found = minimize(
        lambda unknown: _cost(made(unknown)) / SCALE,
        began,
        jac=cost_slope,
        method="SLSQP",
        bounds=limits,
        constraints=(
            {
                "type": "eq",
                "fun": lambda unknown: told(unknown)[:6],
                "jac": lambda unknown: linear(unknown)[1][:6],
            },
            {
                "type": "ineq",
                "fun": lambda unknown: told(unknown)[6:],
                "jac": lambda unknown: linear(unknown)[1][6:],
            },
        ),
        options={"maxiter": LEAST_STEPS, "ftol": 1e-6},
    )
    return made(found.x) if np.isfinite(found.x).all() else programme


POSITION_M, SPEED_M_S = 1e-2, 1e-5
"""Tolerances at the goal."""

GOOD_M, GOOD_M_S = 0.2, 2e-4
"""Misses that are good enough if no step makes them smaller."""

MOST_NEWTON_STEPS, MOST_DERIVATIVES = 30, 6
"""Maximum numbers of steps, and of derivatives from integrated flights."""

DIFFERENCE_M_S, LEAST_DIFFERENCE_M_S = 0.02, 1e-3
"""First and last step of the differences between integrated flights."""


class _Flight(NamedTuple):
    """A programme with its integrated flight and the miss of that flight."""

    programme: Programme
    flown: Integration
    off: Array


def closed(task: ThrustTask, programme: Programme) -> Programme | None:
    """A programme near a predicted one whose integrated flight meets the goal; None if none does.

    Newton's steps of least change, with the derivative of the prediction, improved by what each
    flight shows (C. G. Broyden, Mathematics of Computation 19, 1965, 577), or taken anew of
    integrated flights where a step does not help.
    """
    mean = task.predict(programme).mean
    turned = float(mean[4] + mean[5] - task.origin[4] - task.origin[5])

    def fly(one: Programme) -> _Flight:
        flown = task.integrate(one)
        return _Flight(one, flown, task.off_integrated(flown, turned))

    now = fly(programme)
    slope = derivative_of(task, programme, task.laps_to(mean))
    step_m_s, anew = DIFFERENCE_M_S, 0
    for _ in range(MOST_NEWTON_STEPS):
        if _within(task, now.flown, POSITION_M, SPEED_M_S):
            return now.programme
        change = minimum_norm(slope, -now.off)
        tried = fly(now.programme.steered_by(now.programme.steered + change))
        before, after = float(np.linalg.norm(now.off)), float(np.linalg.norm(tried.off))
        if after < before:
            wrong = tried.off - now.off - slope @ change
            slope = slope + np.outer(wrong, change) / float(change @ change)
            now = tried
        if after < 0.5 * before:
            continue
        if anew == MOST_DERIVATIVES or not math.isfinite(before):
            break
        anew += 1
        slope = np.empty((6, 10))
        for column in range(10):
            side = np.zeros(10)
            side[column] = step_m_s
            steered = now.programme.steered
            above, below = (
                fly(now.programme.steered_by(steered + each)).off for each in (side, -side)
            )
            slope[:, column] = (above - below) / (2.0 * step_m_s)
        step_m_s = max(0.5 * step_m_s, LEAST_DIFFERENCE_M_S)
    return now.programme if _within(task, now.flown, GOOD_M, GOOD_M_S) else None


def _within(task: ThrustTask, flown: Integration, most_m: float, most_m_s: float) -> bool:
    apart = flown.end - task.goal
    return math.hypot(*apart[:3]) < most_m and math.hypot(*apart[3:]) < most_m_s
