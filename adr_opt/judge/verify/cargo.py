"""Cargo of a chaser, the effect of services on cargo and tank, and what is counted of them.

What is left is counted as ΔV: what the propellant gives to the mass there is. A leg takes its ΔV
off that, whatever is aboard. A kit that stays behind leaves the propellant p and takes its mass off
the mass m without propellant; and with A = exp(−x / g₀ Isp) a tow of a mass D with the ΔV x makes
(m + p + D) A − D of m + p. As p = m (exp(v / g₀ Isp) − 1), both are

    exp(v' / g₀ Isp) − 1 = share · (exp(v / g₀ Isp) − 1) − lost .

So more ΔV before a service means more after it, among chasers with equal kits.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import SLACK_M_S
from ...kernels.core.compile import inlined
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


@inlined
def changes(cargo, body, kits):
    """Whether the service of a body changes the remaining ΔV."""
    return cargo.share[body, kits] != 1.0 or cargo.lost[body, kits] > 0.0


@inlined
def after_service(cargo, body, kits, left):
    """ΔV left after a service begun with a number of kits; negative if infeasible.

    Parameters
    ----------
    left : float
        On arrival, at least 0: with the slack of the model, to which no kit adds [m/s].
    """
    if not changes(cargo, body, kits) or (cargo.lost[body, kits] == 0.0 and left <= SLACK_M_S):
        return left
    ratio = cargo.share[body, kits] * math.expm1((left - SLACK_M_S) / cargo.exhaust)
    ratio -= cargo.lost[body, kits]
    if ratio <= -1.0:
        return -np.inf
    return cargo.exhaust * math.log1p(ratio) + SLACK_M_S


@inlined
def is_unused(cargo, kits):
    """Whether kits are aboard that should not have been taken along."""
    return cargo.heavy and kits > 0


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
    tank, kits_kg = chaser.tank, chaser.kit_mass_kg * np.arange(most + 1.0)
    full = np.array([tank.full_m_s(float(mass)) for mass in kits_kg]) + SLACK_M_S
    begun = full - [tank.spent_with_m_s(float(mass)) for mass in kits_kg]
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


COUNT_BITS, MOST_COUNTED = 15, (1 << 14) - 1
"""Bits of a count in a packed number, the highest of them always 0, and its greatest value. What
may be as great is not counted, which leaves more walks."""

GUARDS = sum(1 << COUNT_BITS * (at + 1) - 1 for at in range(4))
"""The highest bits of all counts."""


@inlined
def none_beyond(counts, most):
    """Whether none of the counts that are packed in a number is greater than in another one."""
    return (most | GUARDS) - counts & GUARDS == GUARDS


class StayCounts(NamedTuple):
    """What walks count of their stays, as far as it limits them: counts packed in one number.

    Attributes
    ----------
    adds : (bodies,) int64
        What a stay adds.
    keeps : (bodies,) int64
        Mask of the counts that it leaves as they are; it sets the others to nothing before.
    most : int
        The most of each count.
    """

    adds: npt.NDArray[np.int64]
    keeps: npt.NDArray[np.int64]
    most: int


def counting_of(instance: Instance, chaser: Chaser) -> StayCounts:
    """What is counted: services, at most so many, each with whether it begins anew at a station."""
    between = chaser.max_visits_between_refuels
    limits = [(_most_targets(instance, chaser), False), (between, True)]
    bodies, first, stations = len(instance.names), instance.first_target, len(instance.stations)
    adds, keeps, packed = np.zeros(bodies, np.int64), np.full(bodies, -1), 0
    for at, (most, is_anew) in enumerate(limits):
        if most is not None and most < min(len(instance.targets), MOST_COUNTED):
            adds[first:] |= 1 << COUNT_BITS * at
            packed |= most << COUNT_BITS * at
            if is_anew:
                keeps[:stations] &= ~(MOST_COUNTED << COUNT_BITS * at)
    return StayCounts(adds, keeps, packed)


def _most_targets(instance: Instance, chaser: Chaser) -> int | None:
    """Maximum number of targets; not where the kits aboard set the limit."""
    limits = [chaser.max_targets]
    if all(target.removal == "kit" for target in instance.targets):
        if chaser.kit_mass_kg > 0.0:
            return None
        limits.append(chaser.kits)
    return min((limit for limit in limits if limit is not None), default=None)
