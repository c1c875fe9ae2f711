"""Bound from the least time and the least ΔV of every service, at given prices.

The legs of a plan follow one another, and so do its services. With t_j the least time from a
departure to the end of the service of target j, c_j the least ΔV of a leg to it, t_s the least time
from a departure to the end of a refuelling, T the time and b the tank, a plan that services a set J
and refuels r times keeps to

    Σ t_j + r t_s ≤ T,      Σ c_j ≤ b (1 + r).

So at prices τ of time and λ of ΔV with τ t_s ≥ λ b it is worth no more than

    Σ_J w_j ≤ Σ_J (w_j − τ t_j − λ c_j) + τ T + λ b ≤ τ T + λ b + Σ_j max(0, w_j − τ t_j − λ c_j).
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, SLACK_M_S, SLACK_S
from ...common.errors import InputError
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...legs.families.registry import registered_of
from ...plan.certificate import Certificate
from ...problem.instance import Instance
from .terms import services_s

FloatArray = npt.NDArray[np.float64]

GUARD, BEYOND = 1e-9, Fraction(1, 10**7)
"""Relative reduction of floors to cover rounding, and the relative excess over the floors' proof
beyond which a worth counts as larger."""

UNSTEADY_S = 300.0
"""Largest reduction of flight times where planes drift, below those of the least radius [s]."""


def worth_of_floors(instance: Instance, certificate: Certificate) -> Fraction:
    """Strict upper bound on the worth of every plan.

    Raises
    ------
    InputError
        There are walks, too, or the instance has rules for which no floors are known.
    """
    prices = certificate.floors
    assert prices is not None
    if certificate.walks or certificate.multipliers:
        raise InputError("field floors: a bound rests on walks or on floors, and not on both")
    _refuse(instance)
    chaser, first = instance.chaser, instance.first_target
    stay_s, least_m_s = _least_s(instance), _least_m_s(instance)
    begin_s, end_s = chaser.available_s
    last_s = min(instance.mission.duration_s, math.inf if end_s is None else end_s)
    time_s = Fraction(max(0.0, last_s + SLACK_S - begin_s))
    tank = Fraction(chaser.tank.delta_v_m_s + SLACK_M_S)
    per_s, per_m_s = Fraction(prices.worth_per_s), Fraction(prices.worth_per_m_s)
    refuelling_s = float(stay_s[: len(instance.stations)].min(initial=math.inf))
    if refuelling_s < math.inf:
        # A refuelling may give no more than it takes: any higher price of time proves something.
        if refuelling_s <= 0.0:
            per_m_s = Fraction(0)
        else:
            per_s = max(per_s, per_m_s * tank / Fraction(refuelling_s))
    worth = per_s * time_s + per_m_s * tank
    service_s = services_s(instance)
    for body, target in enumerate(instance.targets, start=first):
        opens, closes = target.window_s
        closes = last_s if closes is None else min(closes, last_s)
        if opens + service_s[body] > closes + SLACK_S or least_m_s[body] > float(tank):
            continue
        extra = certificate.required_worth if target.required else 0.0
        own = Fraction(target.greatest_prize) + Fraction(extra)
        own -= per_s * Fraction(float(stay_s[body])) + per_m_s * Fraction(float(least_m_s[body]))
        worth += max(own, Fraction(0))
    return worth * (1 + BEYOND) + BEYOND * BEYOND  # which no plan is worth, be it worth nothing


def _refuse(instance: Instance) -> None:
    """Refuse instances without known floors."""
    why = None
    if len(instance.chasers) > 1:
        why = "several chasers"
    elif instance.given is not None:
        why = "given connections"
    elif registered_of(instance):
        why = "legs of a registered family"
    elif instance.chaser.is_launched:
        why = "a launch"
    elif any(target.removal == "tow" for target in instance.targets):
        why = "tows"
    elif instance.chaser.kit_mass_kg > 0.0 or instance.spent_m_s:
        why = "a tank whose full ΔV changes"
    if why is not None:
        raise InputError(f"not yet verifiable: floors of an instance with {why}")


def _half_s(axis: FloatArray, slower: FloatArray) -> FloatArray:
    """Half a period; J2 shortens it where ``slower``, 3/2 J2 R² (4 cos² i − 1), is > 0."""
    taken: FloatArray = math.pi * np.sqrt(axis**3 / MU_M3_S2) / (1.0 + slower / axis**2)
    return taken


def _least_s(instance: Instance) -> FloatArray:
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
    flown = flown + settings.safety_ellipse_revolutions * laps - 2.0 * SLACK_S
    if instance.dynamics == "j2":
        flown = flown - UNSTEADY_S
        if settings.max_drift_s > 0.0:
            flown = np.minimum(flown, settings.drift_step_s)
    return np.maximum(0.0, (1.0 - GUARD) * (flown + services_s(instance)) - 2.0 * SLACK_S)


def _least_m_s(instance: Instance) -> FloatArray:
    """Least ΔV of a leg to each body: the approach, and the turn into its plane [m/s].

    A turn by θ at a speed v takes at least v sin θ, and speeds are lowest at the
    highest phasing radius. Where planes drift no turn is certain.
    """
    rows, settings = instance.orbits(), instance.transfer
    if instance.dynamics == "j2":
        return np.zeros(len(rows))
    radius, high = elements.radii(rows, EPOCH_S), EARTH_RADIUS_M + settings.max_altitude_m
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
    least = 0.5 * settings.standoff_m * np.sqrt(MU_M3_S2 / radius**3)
    for body in range(len(rows)):
        across = np.linalg.norm(np.cross(normal, normal[body]), axis=1)
        turn = slowest * np.where(normal @ normal[body] > 0.0, across, 1.0)
        turn[body] = math.inf
        least[body] += max(0.0, float(turn.min(initial=math.inf)) - 1e-6)
    return np.maximum(0.0, (1.0 - GUARD) * least)
