"""Cargo of a chaser, the effect of services on cargo and tank, and counts of services.

What is left is counted as ΔV: what the propellant gives to the mass there is. A leg takes its ΔV
off that, whatever is aboard. A kit that stays behind leaves the propellant p and takes its mass off
the mass m without propellant; and with A = exp(−x / g₀ Isp) a tow of a mass D with the ΔV x makes
(m + p + D) A − D of m + p. As p = m (exp(v / g₀ Isp) − 1), both are

    exp(v' / g₀ Isp) − 1 = share · (exp(v / g₀ Isp) − 1) − lost .

So more ΔV before a service means more after it, among chasers with equal kits.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_M_S
from ...problem.chasers import Chaser, TankByMass
from ...problem.instance import Instance
from ..check.towed import Towed

FloatArray = npt.NDArray[np.float64]


class Cargo(NamedTuple):
    """Cargo where it makes a difference; otherwise empty, and unchanged by services.

    Attributes
    ----------
    takes : (bodies,) int64
        Kits that the service of each body takes.
    full : (most + 1,) float64
        ΔV of a full tank by number of kits aboard, with the slack of the model [m/s].
    begun : (most + 1,) float64
        ΔV at the start, likewise [m/s].
    exhaust : float
        g₀ Isp [m/s].
    share, lost : (bodies, most + 1) float64
        Effect of a service on the remaining ΔV, by number of kits aboard before it.
    heavy : bool
        Whether kits weigh something. Then a chaser takes along those that it leaves behind, and no
        others; otherwise all that it may.
    """

    takes: npt.NDArray[np.int64]
    full: FloatArray
    begun: FloatArray
    exhaust: float
    share: FloatArray
    lost: FloatArray
    heavy: bool


UP_M_S = 2.0**-30
"""Amount by which ΔV after a service is rounded up: far more than the rounding of its formula, and
far less than the slack of the model [m/s]."""


def left_after(
    cargo: Cargo, body: npt.NDArray[np.int64], kits: npt.NDArray[np.int64], left: npt.NDArray[Any]
) -> FloatArray:
    """ΔV left after services begun with a number of kits, rounded up; negative if infeasible.

    Parameters
    ----------
    cargo : Cargo
    body, kits : (services,) int64
    left : (services,) float64
        On arrival, with the slack of the model, to which no kit adds; what is negative already
        stays so [m/s].
    """
    at = body * cargo.full.size + kits
    share, lost = cargo.share.ravel()[at], cargo.lost.ravel()[at]
    same = (lost == 0.0) & ((share == 1.0) | (left <= SLACK_M_S)) | (left < 0.0)
    if same.all():
        return left.copy()
    ratio = share * np.expm1((left - SLACK_M_S) / cargo.exhaust) - lost
    after = cargo.exhaust * np.log1p(np.where(ratio > -1.0, ratio, 0.0)) + SLACK_M_S + UP_M_S
    return np.where(same, left, np.where(ratio > -1.0, after, -np.inf))


def cargo_of(instance: Instance, chaser: Chaser, towed: dict[str, Towed]) -> Cargo:
    """Cargo that a chaser may carry.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    towed : dict of str to Towed
        The targets that are towed, by name.
    """
    takes = np.zeros(len(instance.names), dtype=np.int64)
    takes[instance.first_target :] = [target.removal == "kit" for target in instance.targets]
    takers = int(takes.sum())
    limits = takers, chaser.kits, chaser.max_targets
    most = min(limit for limit in limits if limit is not None)
    heavy = takers > 0 and chaser.kit_mass_kg > 0.0
    short = chaser.kits is not None and chaser.kits < takers < len(instance.targets)
    if not (heavy or short):
        takes[:], most = 0, 0
    tank, kits_kg = chaser.usable, chaser.kit_mass_kg * np.arange(most + 1.0)
    full = np.array([tank.full_m_s(float(mass)) for mass in kits_kg]) + SLACK_M_S
    begun = full - [chaser.spent_with_m_s(float(mass)) for mass in kits_kg]
    share, lost = np.ones((takes.size, most + 1)), np.zeros((takes.size, most + 1))
    if isinstance(tank, TankByMass):
        empty_kg = tank.dry_mass_kg + kits_kg
        if heavy:
            share[takes == 1, 1:] = empty_kg[1:] / empty_kg[:-1]
        for name, tow in towed.items():
            body = instance.names.index(name)
            alone = math.exp(-tow.back_m_s / tank.exhaust_m_s)
            kept = -(tow.delta_v_m_s - tow.back_m_s) / tank.exhaust_m_s
            share[body] = alone * math.exp(kept)
            # What is left of an empty tank is less than nothing by so much.
            gone = -alone * math.expm1(kept) * (1.0 + tow.mass_kg / empty_kg)
            lost[body] = gone + (1.0 - alone)
    return Cargo(takes, full, begun, tank.exhaust_m_s, share, lost, heavy)


class StayCounts(NamedTuple):
    """Counts that limit walks; each kind of count is a row.

    Attributes
    ----------
    adds, keeps : (kinds, bodies) int64
        What a stay adds; 0 where it sets a count to nothing before, else 1.
    most : (kinds,) int64
        The most of each count.
    """

    adds: npt.NDArray[np.int64]
    keeps: npt.NDArray[np.int64]
    most: npt.NDArray[np.int64]


def counting_of(instance: Instance, chaser: Chaser) -> StayCounts:
    """The counts of services with their limits, and whether each is reset at a station."""
    between = chaser.max_visits_between_refuels
    limits = [(_most_targets(instance, chaser), False), (between, True)]
    kinds = [
        (most, anew) for most, anew in limits if most is not None and most < len(instance.targets)
    ]
    shape = len(kinds), len(instance.names)
    adds, keeps = np.zeros(shape, np.int64), np.ones(shape, np.int64)
    adds[:, instance.first_target :] = 1
    for kind, (_, anew) in enumerate(kinds):
        keeps[kind, : len(instance.stations)] = not anew
    return StayCounts(adds, keeps, np.array([most for most, _ in kinds], dtype=np.int64))


def _most_targets(instance: Instance, chaser: Chaser) -> int | None:
    """Maximum number of targets; not where the kits aboard set the limit."""
    limits = [chaser.max_targets]
    if all(target.removal == "kit" for target in instance.targets):
        if chaser.kit_mass_kg > 0.0:
            return None
        limits.append(chaser.kits)
    return min((limit for limit in limits if limit is not None), default=None)
