"""Legs flown by the contest's own equations: the full pull of J2, impulses, and no estimate.

Between two debris a chaser is subject to the pull of the Earth with J2 and to its impulses. A
debris moves by the contest's ephemeris: a, e and i stay, node and perigee turn at their secular
rates, the mean anomaly grows by √(μ/a³), and position and velocity follow from these as from
osculating elements. A leg begins with the position and velocity of the one debris and must end with
those of the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from adr_opt.kernels import orbits
from adr_opt.kernels.constants import DAY_S, MU_M3_S2, OBLATENESS_M2
from adr_opt.refining.least import fewest, least_impulses
from adr_opt.refining.leg import Course, Flown, NoWay, close, fly, residual

from ..reading import FloatArray, filled_lines, numbers_of

MOST_IMPULSES = 5
"""Of a leg."""

CLOSE_M, CLOSE_M_S = 100.0, 1.0
"""How near a chaser must come to a debris to be with it."""

PER_REVOLUTION, MOST_TIMES = 12, 108
"""Times at which impulses are tried."""

MOST_STEPS, WORTH, MOST_NEWTON = 5, 5e-3, 6
"""Convex steps; the share of ΔV that the next one must be worth; steps that close one of them."""

REVOLUTIONS = 12
"""So many revolutions more and fewer than the least change asks for are tried."""

BEST, MOST_TRIED = 2, 8
"""So many numbers of revolutions are flown, and so many tried until they are."""

RELINEARISED = 3
"""Rounds of least impulses before the first is flown to the goal."""


@dataclass(frozen=True)
class Debris:
    """A debris as the contest has it: epoch [d], a [m], e, i, Ω, ω, M [rad] at it."""

    epoch_d: float
    axis: float
    eccentricity: float
    inclination: float
    raan: float
    perigee: float
    anomaly: float

    def state(self, time_s: float) -> FloatArray:
        """Inertial position and velocity at a time since MJD2000 0, shape (6,) [m, m/s]."""
        gone = time_s - self.epoch_d * DAY_S
        node, turning, _ = orbits.secular_rates(
            self.axis, self.eccentricity, self.inclination, OBLATENESS_M2
        )
        mean = self.anomaly + math.sqrt(MU_M3_S2 / self.axis**3) * gone
        e, centric = self.eccentricity, mean
        for _ in range(50):
            change = (centric - e * math.sin(centric) - mean) / (1.0 - e * math.cos(centric))
            centric -= change
            if abs(change) < 1e-14:
                break
        ascending, ahead, _ = orbits.frame(self.inclination, self.raan + node * gone)
        perigee = self.perigee + turning * gone
        along = math.cos(perigee) * ascending + math.sin(perigee) * ahead
        across = -math.sin(perigee) * ascending + math.cos(perigee) * ahead
        flat = math.sqrt(1.0 - e * e)
        place = self.axis * ((math.cos(centric) - e) * along + flat * math.sin(centric) * across)
        speed = math.sqrt(MU_M3_S2 / self.axis) / (1.0 - e * math.cos(centric))
        velocity = speed * (-math.sin(centric) * along + flat * math.cos(centric) * across)
        return np.r_[place, velocity]


def read_ephemeris(path: Path) -> tuple[Debris, ...]:
    """The debris of the contest's file."""
    lines = filled_lines(path)
    return tuple(
        Debris(*numbers_of(line, 8, f"{path}: line {number}")[1:]) for number, line in lines
    )


@dataclass(frozen=True)
class FlownLeg:
    """A leg as flown.

    Attributes
    ----------
    delta_v_m_s : float
    impulses : int
    miss_m, miss_m_s : float
        Off the debris on arrival.
    times_s, impulses_m_s : (impulses,), (impulses, 3) float64
        Since MJD2000 0, inertial.
    """

    delta_v_m_s: float
    impulses: int
    miss_m: float
    miss_m_s: float
    times_s: FloatArray
    impulses_m_s: FloatArray


def flown_leg(one: Debris, other: Debris, departure_d: float, arrival_d: float) -> FlownLeg:
    """Fly from a debris to another between two times [d].

    Raises
    ------
    NoWay
        No impulses were found.
    """
    start_s, end_s = departure_d * DAY_S, arrival_d * DAY_S
    course = Course(one.state(start_s), other.state(end_s), start_s, end_s, 0.0, "j2")
    revolution = math.tau * math.sqrt(other.axis**3 / MU_M3_S2)
    times = _times(start_s, end_s, revolution)
    free = fly(course, times, np.zeros((times.size, 3)))
    # With no angle asked for, the miss counts all revolutions; what they leave over is the phase.
    turns = round(free.miss[5] / math.tau)
    found: list[tuple[float, float, FloatArray]] = []
    for more in range(-REVOLUTIONS, REVOLUTIONS + 1):
        miss = free.miss.copy()
        miss[5] -= math.tau * (turns + more)
        least = least_impulses(free.effects, -miss, 1e-2)
        found.append((least.total, math.tau * (turns + more), least.impulses))
    found.sort(key=lambda item: item[0])
    best: Flown | None = None
    flights = 0
    for total, angle, impulses in found[:MOST_TRIED]:
        if flights == BEST:
            break
        if best is not None and total > 1.5 * best.delta_v_m_s:
            continue
        try:
            tried = _flown(replace(course, angle=angle), times, impulses)
        except NoWay:
            continue
        flights += 1
        if best is None or tried.delta_v_m_s < best.delta_v_m_s:
            best = tried
    if best is None:
        raise NoWay(f"no way from {departure_d:.3f} to {arrival_d:.3f}")
    miss = residual(course, best)
    return FlownLeg(best.delta_v_m_s, len(best.times), *miss, best.times, best.impulses)


def _times(start_s: float, end_s: float, revolution: float) -> FloatArray:
    """Times about both ends, and some between."""
    grid = np.arange(start_s, end_s, revolution / PER_REVOLUTION)
    if grid.size <= MOST_TIMES:
        return np.r_[grid, end_s]
    edge = MOST_TIMES // 3
    middle = np.linspace(edge, grid.size - edge, MOST_TIMES // 3).astype(int)
    places = np.unique(np.r_[np.arange(edge), middle, np.arange(grid.size - edge, grid.size)])
    return np.r_[grid[places], end_s]


def _flown(course: Course, times: FloatArray, impulses: FloatArray) -> Flown:
    """Closed, made cheaper, and with no more impulses than are allowed."""
    for _ in range(RELINEARISED):
        # About what was flown last: over weeks a first guess is thousands of kilometres off.
        now = fly(course, times, impulses)
        aimed = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
        impulses = least_impulses(now.effects, aimed, 1e-2).impulses
    if not np.isfinite(impulses).all() or not impulses.any():
        raise NoWay("the first guess leads nowhere")
    sizes = np.sqrt(np.sum(impulses**2, axis=1))
    kept = sizes > 1e-3 * sizes.max()
    now = _cheaper(course, close(course, times[kept], impulses[kept]), times)
    while len(now.times) > MOST_IMPULSES:
        sizes = np.sqrt(np.sum(now.impulses**2, axis=1))
        best: Flown | None = None
        for least in np.argsort(sizes)[:3]:
            left = np.arange(sizes.size) != least
            try:
                tried = close(course, now.times[left], now.impulses[left], MOST_NEWTON)
            except NoWay:
                continue
            if best is None or tried.delta_v_m_s < best.delta_v_m_s:
                best = tried
        if best is None:
            raise NoWay("the leg cannot be flown with so few impulses")
        now = best
    return now


def _cheaper(course: Course, flown: Flown, grid: FloatArray) -> Flown:
    """Successive convex steps, as :func:`adr_opt.refining.leg.cheapen` makes them, on few times.

    A leg of weeks has hundreds of revolutions, all of which cost time and few of which matter.
    """
    for _ in range(MOST_STEPS):
        apart = np.abs(grid[:, None] - flown.times[None, :]).min(axis=1)
        times = np.r_[grid[apart > 1.0], flown.times]
        impulses = np.vstack([np.zeros((times.size - flown.times.size, 3)), flown.impulses])
        order = np.argsort(times, kind="stable")
        times, impulses = times[order], impulses[order]
        now = fly(course, times, impulses)
        aimed = np.einsum("kij,kj->i", now.effects, now.impulses) - now.miss
        wanted = fewest(now.effects, least_impulses(now.effects, aimed, 1e-2).impulses)
        before, share = flown.delta_v_m_s, 1.0
        while share > 0.2:
            mixed = impulses + share * (wanted - impulses)
            kept = np.sqrt(np.sum(mixed**2, axis=1)) > 1e-4
            if kept.sum() < 2:
                break
            try:
                tried = close(course, times[kept], mixed[kept], MOST_NEWTON)
            except NoWay:
                share *= 0.5
                continue
            if tried.delta_v_m_s < flown.delta_v_m_s:
                flown = tried
                break
            share *= 0.5
        if before - flown.delta_v_m_s <= WORTH * before:
            break
    fewer = fewest(flown.effects, flown.impulses)
    kept = np.sqrt(np.sum(fewer**2, axis=1)) > 1e-4
    try:
        tried = close(course, flown.times[kept], fewer[kept], MOST_NEWTON)
    except NoWay:
        return flown
    return tried if tried.delta_v_m_s <= (1.0 + WORTH) * flown.delta_v_m_s else flown
