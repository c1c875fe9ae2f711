"""The least ΔV of a leg by free impulses: linear in relative elements, and flown without that.

Between two nearly circular orbits the changes of the elements are linear in the impulses. With
latitudes u from the line of nodes, L the last one, and impulses (r, t, n) along the radius, ahead
and along the normal, in shares of the circular speed (D'Amico, PhD thesis, TU Delft, 2010, chapter
2):

    Δa/a = 2 t              Δe_x = r sin u + 2 t cos u        Δi_x = n cos u
    Δλ = −2 r − 3 (L − u) t      Δe_y = −r cos u + 2 t sin u       Δi_y = n sin u

The least sum of magnitudes that makes six given changes is a cone programme, and its dual has six
unknowns: the most that λ·Δ can be if the primer vector Bᵀ(u) λ is nowhere longer than 1. A barrier
method solves it and gives impulses, whose sum is an upper bound, and λ, which is a lower one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.common.constants import MU_M3_S2
from adr_opt.fly.trajectory.kepler import propagate

Array = npt.NDArray[np.float64]

GAP, MOST_STEPS = 1e-3, 60
"""Upper and lower bound differ by no more than this share; steps of Newton's method at a weight."""

GRID = 24
"""Latitudes in a revolution at which an impulse may be given."""


class Case(NamedTuple):
    """A leg: what there is to change, and the co-elliptic sequence that it is planned with.

    Attributes
    ----------
    climb, phasing : float
        (a_j − a_i) and (r_x − a_i) in shares of the mean radius.
    turn : float
        θ, the angle between the planes [rad].
    across : complex
        Δe, counted from where the chaser leaves on the line of nodes.
    laps : int
        k.
    speed : float
        Circular speed at the mean radius [m/s].
    """

    climb: float
    phasing: float
    turn: float
    across: complex
    laps: int
    speed: float

    @property
    def last(self) -> float:
        """Latitude of the last burn [rad]."""
        return (3 + 2 * self.laps) * math.pi

    @property
    def places(self) -> Array:
        """Latitudes of the burns of the sequence, (5,) [rad]."""
        return np.array([0.0, 1.0, 1 + 2 * self.laps, 2 + 2 * self.laps, 3 + 2 * self.laps]) * (
            math.pi
        )

    def ahead(self, fraction: float = 0.75) -> Array:
        """Burns of the sequence along the velocity, in shares of the speed, (5,)."""
        rest = self.climb - self.phasing
        shares = [self.phasing, self.phasing, fraction * rest, rest, (1.0 - fraction) * rest]
        return 0.25 * np.array(shares)

    def changes(self) -> Array:
        """Changes made by the leg: (a, λ, e_x, e_y, i_x, i_y)."""
        phase = float(-3.0 * (self.ahead() * (self.last - self.places)).sum())
        e = self.across
        return np.array([self.climb, phase, e.real, e.imag, self.turn, 0.0])

    def between_circles(self) -> float:
        """ΔV of the sequence between circles, to first order [m/s]."""
        burns = list(self.ahead())
        if self.laps == 0:
            burns[1:3] = [burns[1] + burns[2]]
        whole = sum(abs(burn) for burn in burns) - abs(burns[1]) + math.hypot(burns[1], self.turn)
        return whole * self.speed

    def anywhere(self) -> Array:
        """Latitudes all along the leg, evenly spaced [rad]."""
        return np.linspace(0.0, self.last, round(self.last / (2.0 * math.pi) * GRID) + 1)


def effects(latitudes: Array, last: float) -> Array:
    """Changes that unit impulses make, (places, 6, 3)."""
    cosine, sine = np.cos(latitudes), np.sin(latitudes)
    matrix = np.zeros((latitudes.size, 6, 3))
    matrix[:, 0, 1], matrix[:, 1, 0], matrix[:, 1, 1] = 2.0, -2.0, -3.0 * (last - latitudes)
    matrix[:, 2, 0], matrix[:, 2, 1] = sine, 2.0 * cosine
    matrix[:, 3, 0], matrix[:, 3, 1] = -cosine, 2.0 * sine
    matrix[:, 4, 2], matrix[:, 5, 2] = cosine, sine
    return matrix


def optimum(latitudes: Array, last: float, changes: Array, gap: float = GAP) -> tuple[float, Array]:
    """The least sum of impulses at given places that makes the changes, all in shares of the speed.

    Returns
    -------
    least : float
        A lower bound of it, within the gap of the sum of the impulses.
    impulses : (places, 3) float64
        They make the changes.
    """
    matrix = effects(latitudes, last)
    scale = np.abs(matrix).max(axis=(0, 2))
    matrix /= scale[None, :, None]
    size = float(np.linalg.norm(changes / scale))
    if size == 0.0:
        return 0.0, np.zeros((latitudes.size, 3))
    wanted = changes / scale / size
    dual, weight = np.zeros(6), float(latitudes.size)

    def merit(at: Array) -> float:
        left = 1.0 - (np.einsum("kij,i->kj", matrix, at) ** 2).sum(axis=1)
        return -math.inf if left.min() <= 0.0 else float(weight * at @ wanted + np.log(left).sum())

    while True:
        for _ in range(MOST_STEPS):
            primer = np.einsum("kij,i->kj", matrix, dual)
            left = 1.0 - (primer**2).sum(axis=1)
            pulled = np.einsum("kij,kj->ki", matrix, primer)
            slope = weight * wanted - 2.0 * (pulled / left[:, None]).sum(axis=0)
            bend = 2.0 * np.einsum("kij,klj,k->il", matrix, matrix, 1.0 / left)
            bend += 4.0 * np.einsum("ki,kl,k->il", pulled, pulled, left**-2)
            step = np.linalg.lstsq(bend, slope, rcond=1e-14)[0]
            gain = float(slope @ step)
            if gain < 1e-6:
                break
            # A damped step always gains; a longer one is taken where it gains too.
            sure, share, before = 1.0 / (1.0 + math.sqrt(gain)), 1.0, merit(dual)
            while share > sure and merit(dual + share * step) < before + 0.1 * share * gain:
                share *= 0.5
            dual = dual + max(share, sure) * step
        primer = np.einsum("kij,i->kj", matrix, dual)
        left = 1.0 - (primer**2).sum(axis=1)
        impulses = 2.0 * primer / (weight * left[:, None])
        above = float(np.linalg.norm(impulses, axis=1).sum())
        below = float(dual @ wanted) / math.sqrt(1.0 - left.min())
        if above - below < gap * above or weight > 1e9 * latitudes.size:
            # What rounding has left undone is spread over all of them.
            flat = matrix.transpose(1, 0, 2).reshape(6, -1)
            rest = wanted - flat @ impulses.ravel()
            impulses += np.linalg.lstsq(flat, rest, rcond=None)[0].reshape(impulses.shape)
            return below * size, impulses * size
        weight *= 8.0


def free(case: Case) -> float:
    """The least ΔV with impulses anywhere on the way [m/s]."""
    return optimum(case.anywhere(), case.last, case.changes())[0] * case.speed


def elements(position: Array, velocity: Array) -> Array:
    """Elements of a state without singularities, (a [m], λ, e_x, e_y, i_x, i_y)."""
    distance = float(np.linalg.norm(position))
    normal = np.cross(position, velocity)
    momentum = float(np.linalg.norm(normal))
    normal /= momentum
    axis = 1.0 / (2.0 / distance - float(velocity @ velocity) / MU_M3_S2)
    q, p = -normal[1] / (1.0 + normal[2]), normal[0] / (1.0 + normal[2])
    first = np.array([1.0 - p * p + q * q, 2.0 * p * q, -2.0 * p]) / (1.0 + p * p + q * q)
    second = np.array([2.0 * p * q, 1.0 + p * p - q * q, 2.0 * q]) / (1.0 + p * p + q * q)
    vector = np.cross(velocity, normal * momentum) / MU_M3_S2 - position / distance
    ex, ey = float(vector @ first), float(vector @ second)
    true = math.atan2(float(position @ second), float(position @ first))
    # Kepler's equation in the eccentric longitude F: λ = F − e_x sin F + e_y cos F.
    root = math.sqrt(1.0 - ex * ex - ey * ey)
    shared = 1.0 / (1.0 + root)
    x, y = distance * math.cos(true) / axis, distance * math.sin(true) / axis
    cosine = ex + ((1.0 - shared * ex * ex) * x - shared * ex * ey * y) / root
    sine = ey + ((1.0 - shared * ey * ey) * y - shared * ex * ey * x) / root
    longitude = math.atan2(sine, cosine) - ex * sine + ey * cosine
    return np.array([axis, longitude, ex, ey, 2.0 * q, 2.0 * p])


def flown(case: Case, radius: float, start: complex) -> tuple[float, float]:
    """The optimum in two-body motion, its impulses corrected until they arrive.

    Parameters
    ----------
    case : Case
    radius : float
        Mean of the two semi-major axes [m].
    start : complex
        e_i, counted as Δe is.

    Returns
    -------
    delta_v : float
        [m/s].
    miss : float
        Largest error of an element on arrival, times the radius [m].
    """
    begin = radius * (1.0 - 0.5 * case.climb)
    waiting, end = begin + radius * case.phasing, radius * (1.0 + 0.5 * case.climb)
    corner = waiting + 0.75 * (end - waiting)
    arcs = [0.5 * (begin + waiting), waiting, 0.5 * (waiting + corner), 0.5 * (corner + end)]
    spans = [0.5, float(case.laps), 0.5, 0.5]
    duration = sum(
        2.0 * math.pi * share * math.sqrt(arc**3 / MU_M3_S2)
        for share, arc in zip(spans, arcs, strict=True)
    )
    latitudes = case.anywhere()
    times = duration * latitudes / case.last
    goal = start + case.across
    wanted = np.array([end, case.last, goal.real, goal.imag, 2.0 * math.tan(0.5 * case.turn), 0.0])
    home = _on_orbit(begin, start)
    changes, miss, total = case.changes(), math.inf, math.nan
    for _ in range(MOST_STEPS):
        impulses = optimum(latitudes, case.last, changes)[1] * math.sqrt(MU_M3_S2 / radius)
        position, velocity = home
        for place, impulse in enumerate(impulses):
            outward = position / np.linalg.norm(position)
            normal = np.cross(position, velocity)
            normal /= np.linalg.norm(normal)
            frame = np.array([outward, np.cross(normal, outward), normal])
            velocity = velocity + impulse @ frame
            if place + 1 < times.size:
                there = propagate(position, velocity, [times[place + 1] - times[place]])
                position, velocity = there[0][0], there[1][0]
        off = wanted - elements(position, velocity)
        off[0] /= radius
        off[1] = math.remainder(off[1], 2.0 * math.pi)
        miss, total = (
            radius * float(np.abs(off).max()),
            float(np.linalg.norm(impulses, axis=1).sum()),
        )
        if miss < 1.0:
            break
        changes = changes + off
    return total, miss


def _on_orbit(axis: float, vector: complex) -> tuple[Array, Array]:
    """State at mean latitude 0 of an orbit in the reference plane [m], [m/s]."""
    longitude = 0.0
    for _ in range(50):
        longitude = vector.real * math.sin(longitude) - vector.imag * math.cos(longitude)
    eccentricity, perigee = abs(vector), math.atan2(vector.imag, vector.real)
    anomaly = longitude - perigee
    x = axis * (math.cos(anomaly) - eccentricity)
    y = axis * math.sqrt(1.0 - eccentricity**2) * math.sin(anomaly)
    rate = math.sqrt(MU_M3_S2 / axis) / (1.0 - eccentricity * math.cos(anomaly))
    vx = -rate * math.sin(anomaly)
    vy = rate * math.sqrt(1.0 - eccentricity**2) * math.cos(anomaly)
    turn = np.array(
        [[math.cos(perigee), -math.sin(perigee)], [math.sin(perigee), math.cos(perigee)]]
    )
    return np.array([*(turn @ [x, y]), 0.0]), np.array([*(turn @ [vx, vy]), 0.0])
