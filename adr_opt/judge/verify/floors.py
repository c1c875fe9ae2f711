"""The bound that *floors* prove, in exact arithmetic: least times and least ΔV of all services.

The legs of a plan follow one another, and so do its services. With t_j the least time from a
departure to the end of the stay at target j, c_j the least ΔV of a leg to it, t_s the least time
from a departure to the end of a refuelling, T the time and b the tank, a plan that services a set J
and refuels r times keeps to

    Σ t_j + r t_s ≤ T,      Σ c_j ≤ b (1 + r).

So at prices τ of time and λ of ΔV with τ t_s ≥ λ b it is worth no more than

    Σ_J w_j ≤ Σ_J (w_j − τ t_j − λ c_j) + τ T + λ b ≤ τ T + λ b + Σ_j max(0, w_j − τ t_j − λ c_j).

Of several chasers the times and tanks are added up, and each target takes what it takes the chaser
that comes off best; or each chaser is taken alone, and what it collects rounded down to steps.

Of a tank by mass, ΔV is c ln(m + s) with the mass m of the chaser without kits, c = g₀ Isp, and a
ballast s. What a service takes of that is least for the lightest or the heaviest chaser, since
masses before it are α m + β by those after it. A launch gives a chaser a leg for nothing. A tank
that is not full at the start counts as full: a plan that keeps to less keeps to more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, SLACK_M_S, SLACK_S
from ...common.errors import InputError
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...legs.families.registry import registered_of
from ...plan.certificate import Certificate
from ...problem.approach import approach_of
from ...problem.chasers import Chaser, TankByMass
from ...problem.drives import drive_of
from ...problem.instance import Instance
from ..check.towed import Towed, towed_bodies
from .openings import openings_of
from .terms import services_s

FloatArray = npt.NDArray[np.float64]

GUARD, BEYOND = 1e-9, Fraction(1, 10**7)
"""Relative reduction of floors to cover rounding, and the relative excess over the floors' proof
beyond which a worth counts as larger."""

UNSTEADY_S = 300.0
"""Largest reduction of flight times where planes drift, below those of the least radius [s]."""


class _Share(NamedTuple):
    """Time and ΔV of one chaser, or of all together, and the least that services take of both.

    Attributes
    ----------
    took, cost : (bodies,) float64
        Least times [s] and ΔV [m/s]; +inf of targets that cannot be serviced.
    time_s, budget, tank : Fraction
        Time [s], ΔV at first, and of a full tank [m/s].
    refuelling_s : float
    """

    took: FloatArray
    cost: FloatArray
    time_s: Fraction
    budget: Fraction
    tank: Fraction
    refuelling_s: float


def worth_of_floors(instance: Instance, certificate: Certificate, missed: Fraction) -> Fraction:
    """Strict upper bound on the worth of every plan.

    Parameters
    ----------
    instance : Instance
    certificate : Certificate
    missed : Fraction
        By how much sums of prizes may miss multiples of the step.

    Raises
    ------
    InputError
        There are walks, too, or the instance has rules for which no floors are known.
    """
    prices = certificate.floors
    assert prices is not None
    if certificate.walks or certificate.multipliers:
        raise InputError("field floors: a bound rests on walks or on floors; leave one out")
    _refuse(instance)
    shares = [_share(instance, chaser, prices.ballast_kg) for chaser in instance.chasers]
    if not prices.alone:
        return _worth(instance, certificate, _together(shares))
    if certificate.prize_step is None:
        raise InputError("field floors.alone: each chaser is rounded down to a prize_step; give it")
    step, extra = Fraction(certificate.prize_step), Fraction(certificate.required_worth)
    required = sum(target.required for target in instance.targets)
    missed += required * abs(extra - step * round(extra / step))
    if 4 * missed > step:
        raise InputError("field floors.alone: required_worth misses multiples of prize_step")
    parts = (_worth(instance, certificate, share) + missed for share in shares)
    # Whole steps of each; what all together miss them by, and less than a step that is left of it.
    return step * sum(math.ceil(part / step) - 1 for part in parts) + missed + step / 4


def _together(shares: Sequence[_Share]) -> _Share:
    return _Share(
        np.min([share.took for share in shares], axis=0),
        np.min([share.cost for share in shares], axis=0),
        sum((share.time_s for share in shares), Fraction(0)),
        sum((share.budget for share in shares), Fraction(0)),
        max(share.tank for share in shares),
        min(share.refuelling_s for share in shares),
    )


def _worth(instance: Instance, certificate: Certificate, share: _Share) -> Fraction:
    """Worth of a chaser's time and ΔV at the prices of a certificate."""
    prices = certificate.floors
    assert prices is not None
    per_s, per_m_s = Fraction(prices.worth_per_s), Fraction(prices.worth_per_m_s)
    if share.refuelling_s < math.inf:
        # A refuelling may give no more than it takes: any higher price of time proves something.
        if share.refuelling_s <= 0.0:
            per_m_s = Fraction(0)
        else:
            per_s = max(per_s, per_m_s * share.tank / Fraction(share.refuelling_s))
    worth = per_s * share.time_s + per_m_s * share.budget
    for body, target in enumerate(instance.targets, start=instance.first_target):
        if not math.isfinite(share.cost[body]):
            continue
        extra = certificate.required_worth if target.required else 0.0
        own = Fraction(target.greatest_prize) + Fraction(extra)
        own -= per_s * Fraction(float(share.took[body])) + per_m_s * Fraction(
            float(share.cost[body])
        )
        worth += max(own, Fraction(0))
    return worth * (1 + BEYOND) + BEYOND * BEYOND  # which no plan is worth, be it worth nothing


def _refuse(instance: Instance) -> None:
    """Refuse instances without known floors."""
    for without, why in (
        (instance.given is not None, "given connections"),
        (registered_of(instance), "legs of a registered family"),
    ):
        if without:
            raise InputError(f"floors cannot be verified yet for an instance with {why}")


def _share(instance: Instance, chaser: Chaser, ballast_kg: float) -> _Share:
    """Time and ΔV of one chaser, and the least that services take of both."""
    drive, first = drive_of(chaser, instance.targets), instance.first_target
    towed = towed_bodies(instance, instance.orbits(), drive)
    tows_s = np.zeros(len(instance.names))
    for name, tow in towed.items():
        tows_s[instance.names.index(name)] = tow.time_s
    stays_s, least_m_s = services_s(instance) + tows_s, _least_m_s(instance, chaser, towed)
    took, (cost, alone) = (
        _least_s(instance, stays_s),
        (_used(instance, chaser, towed, ballast_kg, each) for each in (least_m_s, 0.0 * least_m_s)),
    )
    tank, most_kg = chaser.usable, 0.0
    full = tank.delta_v_m_s + SLACK_M_S
    if isinstance(tank, TankByMass):
        most_kg = _most_kg(tank)
        full = _counted(tank, ballast_kg, most_kg) - _counted(tank, ballast_kg, tank.dry_mass_kg)
    if chaser.is_launched:  # what no leg leads to may be the first
        cost = np.where(cost <= full, cost, alone)
    begin_s, end_s = chaser.available_s
    last_s = min(instance.mission.duration_s, math.inf if end_s is None else end_s)
    openings = openings_of(instance, stays_s - tows_s)
    for body in range(first, len(instance.names)):
        soonest_s = float(openings[body].begins(begin_s - SLACK_S)) + stays_s[body]
        if soonest_s > last_s + SLACK_S or cost[body] > full:
            took[body] = cost[body] = math.inf
    time_s, budget = max(0.0, last_s + SLACK_S - begin_s), full
    if chaser.is_launched:
        can = np.isfinite(cost)
        can[:first] = False
        time_s += float(took[can].max(initial=0.0))
        budget += float((cost[can] - alone[can]).max(initial=0.0))
    refuelling_s = float(took[: len(instance.stations)].min(initial=math.inf))
    return _Share(took, cost, Fraction(time_s), Fraction(budget), Fraction(full), refuelling_s)


def _most_kg(tank: TankByMass) -> float:
    """Mass of a full chaser without kits, with the slack."""
    return (tank.dry_mass_kg + tank.propellant_kg) * math.exp(SLACK_M_S / tank.exhaust_m_s)


def _counted(tank: TankByMass, ballast_kg: float, mass_kg: float) -> float:
    """ΔV of a mass with a ballast, from any zero [m/s]."""
    return tank.exhaust_m_s * math.log(mass_kg + ballast_kg)


def _used(
    instance: Instance,
    chaser: Chaser,
    towed: dict[str, Towed],
    ballast_kg: float,
    legs_m_s: FloatArray,
) -> FloatArray:
    """Least ΔV that services take, after legs of some ΔV; +inf beyond any tank [m/s]."""
    tank = chaser.usable
    if not isinstance(tank, TankByMass):
        return legs_m_s.copy()
    most, used = _most_kg(tank), np.zeros_like(legs_m_s)
    for body, target in enumerate(instance.targets, start=instance.first_target):
        leg = math.exp(legs_m_s[body] / tank.exhaust_m_s)
        rise, more = leg, 0.0
        if target.removal == "kit":
            more = chaser.kit_mass_kg * (leg - 1.0)
        elif target.name in towed:
            tow = towed[target.name]
            docked = math.exp((tow.delta_v_m_s - tow.back_m_s) / tank.exhaust_m_s)
            rise = leg * docked * math.exp(tow.back_m_s / tank.exhaust_m_s)
            more = leg * tow.mass_kg * (docked - 1.0)
        if rise * tank.dry_mass_kg + more > most:
            used[body] = math.inf
            continue
        masses = tank.dry_mass_kg, (most - more) / rise
        taken = (
            _counted(tank, ballast_kg, rise * mass + more) - _counted(tank, ballast_kg, mass)
            for mass in masses
        )
        used[body] = (1.0 - GUARD) * max(0.0, min(taken) - 1e-9)
    return used


def _half_s(axis: FloatArray, slower: FloatArray) -> FloatArray:
    """Half a period; J2 shortens it where ``slower``, 3/2 J2 R² (4 cos² i − 1), is > 0."""
    taken: FloatArray = math.pi * np.sqrt(axis**3 / MU_M3_S2) / (1.0 + slower / axis**2)
    return taken


def _least_s(instance: Instance, stays_s: FloatArray) -> FloatArray:
    """Least time from a departure to the end of the stay at each body, shape (bodies,) [s].

    Three half ellipses from the lowest origin over the lowest phasing radius, and the approach.
    """
    rows, settings = instance.orbits(), instance.transfer
    radius = elements.radii(rows, EPOCH_S)
    cosine = np.cos(elements.inclinations(rows, EPOCH_S))
    slower = 1.5 * instance.oblateness_m2 * (4.0 * cosine**2 - 1.0)
    low = EARTH_RADIUS_M + settings.min_altitude_m
    coelliptic = low + settings.first_leg_fraction * (radius - low)
    flown = _half_s(np.array(0.5 * (radius.min() + low)), slower.max())
    flown = flown + _half_s(0.5 * (low + coelliptic), slower)
    flown = flown + _half_s(0.5 * (coelliptic + radius), slower)
    laps = 2.0 * math.pi / elements.latitude_rates(rows, EPOCH_S)
    flown = flown + approach_of(settings).revolutions * laps - 2.0 * SLACK_S
    if instance.dynamics == "j2":
        flown = flown - UNSTEADY_S
        if settings.max_drift_s > 0.0:
            flown = np.minimum(flown, settings.drift_step_s)
    return np.maximum(0.0, (1.0 - GUARD) * (flown + stays_s) - 2.0 * SLACK_S)


def _least_m_s(instance: Instance, chaser: Chaser, towed: dict[str, Towed]) -> FloatArray:
    """Least ΔV of a leg to each body: the approach, and the turn into its plane [m/s].

    A turn by θ at a speed v takes at least v sin θ, and speeds are lowest at the
    highest phasing radius. Where planes drift no turn is certain, but the way to another altitude:
    two burns between circles, or the difference of their speeds with low thrust.
    """
    rows, settings = instance.orbits(), instance.transfer
    radius, high = elements.radii(rows, EPOCH_S), EARTH_RADIUS_M + settings.max_altitude_m
    if instance.dynamics == "j2":
        if settings.burns != "sequence":
            return np.zeros(len(rows))
        return _climbs_m_s(instance, chaser, towed, radius)
    inclination, node = elements.inclinations(rows, EPOCH_S), elements.nodes(rows, EPOCH_S)
    normal = np.stack(
        [
            np.sin(inclination) * np.sin(node),
            -np.sin(inclination) * np.cos(node),
            np.cos(inclination),
        ],
        axis=1,
    )
    slowest = np.sqrt(2.0 * MU_M3_S2 * radius / (high * (high + radius)))
    least = approach_of(settings).length_m * np.sqrt(MU_M3_S2 / radius**3)
    for body in range(len(rows)):
        across = np.linalg.norm(np.cross(normal, normal[body]), axis=1)
        turn = slowest * np.where(normal @ normal[body] > 0.0, across, 1.0)
        turn[body] = math.inf
        least[body] += max(0.0, float(turn.min(initial=math.inf)) - 1e-6)
    return np.maximum(0.0, (1.0 - GUARD) * least)


def _climbs_m_s(
    instance: Instance, chaser: Chaser, towed: dict[str, Towed], radius: FloatArray
) -> FloatArray:
    leaves, least = radius.copy(), np.zeros_like(radius)
    for name, tow in towed.items():
        leaves[instance.names.index(name)] = tow.left_on[0]
    home = instance.names.index(chaser.start_name)
    origins = [*range(len(instance.stations)), *range(instance.first_target, radius.size)]
    if home not in origins and not chaser.is_launched:
        origins.append(home)
    for body, r in enumerate(radius):
        q = leaves[[origin for origin in origins if origin != body]]
        axis, speed, other = 0.5 * (r + q), math.sqrt(MU_M3_S2 / r), np.sqrt(MU_M3_S2 / q)
        climb = np.abs(speed - other)
        if chaser.thrust_n is None:
            at_r, at_q = (np.sqrt(MU_M3_S2 * (2.0 / each - 1.0 / axis)) for each in (r, q))
            climb = np.minimum(climb, np.abs(at_r - speed) + np.abs(at_q - other))
        least[body] = climb.min(initial=math.inf) if climb.size else 0.0
    return np.maximum(0.0, (1.0 - GUARD) * least - 1e-6)
