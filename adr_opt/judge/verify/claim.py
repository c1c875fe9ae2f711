"""The bound implied by a certificate once its walks are verified, in exact arithmetic.

Without walks it may be from *floors*: the least time and the least ΔV of every service, at given
prices. The legs of a plan follow one another, and so do its services. With t_j the least time from
a departure to the end of the service of target j, c_j the least ΔV of a leg to it, t_s the least
time from a departure to the end of a refuelling, T the time and b the tank, a plan that services a
set J and refuels r times keeps to

    Σ t_j + r t_s ≤ T,      Σ c_j ≤ b (1 + r).

So at prices τ of time and λ of ΔV with τ t_s ≥ λ b it is worth no more than

    Σ_J w_j ≤ Σ_J (w_j − τ t_j − λ c_j) + τ T + λ b ≤ τ T + λ b + Σ_j max(0, w_j − τ t_j − λ c_j).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, SLACK_M_S, SLACK_S
from ...common.errors import InputError
from ...kernels.orbits import elements
from ...kernels.orbits.ephemeris import EPOCH_S
from ...legs.families.registry import registered_of
from ...plan.certificate import Certificate
from ...problem.approach import approach_of
from ...problem.instance import Instance
from .openings import openings_of
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
    openings = openings_of(instance, service_s)
    for body, target in enumerate(instance.targets, start=first):
        soonest_s = float(openings[body].begins(-math.inf)) + service_s[body]
        if soonest_s > last_s + SLACK_S or least_m_s[body] > float(tank):
            continue
        extra = certificate.required_worth if target.required else 0.0
        own = Fraction(target.greatest_prize) + Fraction(extra)
        own -= per_s * Fraction(float(stay_s[body])) + per_m_s * Fraction(float(least_m_s[body]))
        worth += max(own, Fraction(0))
    return worth * (1 + BEYOND) + BEYOND * BEYOND  # which no plan is worth, be it worth nothing


def _refuse(instance: Instance) -> None:
    """Refuse instances without known floors."""
    chaser = instance.chasers[0]
    for without, why in (
        (len(instance.chasers) > 1, "several chasers"),
        (instance.given is not None, "given connections"),
        (registered_of(instance), "legs of a registered family"),
        (chaser.is_launched, "a launch"),
        (any(target.removal == "tow" for target in instance.targets), "tows"),
        (chaser.kit_mass_kg > 0.0 or instance.spent_m_s, "a tank whose full ΔV changes"),
    ):
        if without:
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
    flown = flown + approach_of(settings).revolutions * laps - 2.0 * SLACK_S
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
    least = approach_of(settings).length_m * np.sqrt(MU_M3_S2 / radius**3)
    for body in range(len(rows)):
        across = np.linalg.norm(np.cross(normal, normal[body]), axis=1)
        turn = slowest * np.where(normal @ normal[body] > 0.0, across, 1.0)
        turn[body] = math.inf
        least[body] += max(0.0, float(turn.min(initial=math.inf)) - 1e-6)
    return np.maximum(0.0, (1.0 - GUARD) * least)


Mask = npt.NDArray[np.bool_]

SHARE = 1e-11
"""Relative tolerance between objectives where prizes have no common step."""


def how_often(instance: Instance) -> dict[str, int]:
    """Maximum number of visits of all chasers to a body, by name, if limited."""
    often = {target.name: 1 for target in instance.targets}
    for station in instance.stations:
        if station.max_refuellings is not None:
            often[station.name] = station.max_refuellings
    return often


def worths_of(instance: Instance, certificate: Certificate) -> list[Fraction]:
    """Worth of the service of each body, before its prize falls."""
    worths = [Fraction(0)] * instance.first_target
    for target in instance.targets:
        extra = certificate.required_worth if target.required else 0.0
        worths.append(Fraction(target.greatest_prize) + Fraction(extra))
    return worths


def gains(instance: Instance, certificate: Certificate) -> list[Fraction]:
    """Gain of each body for walks: its worth minus its multiplier."""
    worths = worths_of(instance, certificate)
    multipliers = (Fraction(certificate.multipliers.get(name, 0.0)) for name in instance.names)
    return [worth - less for worth, less in zip(worths, multipliers, strict=True)]


def remembered(instance: Instance, neighbourhoods: Mapping[str, Sequence[str]]) -> Mask:
    """Whether a walk that comes to a body (row) still remembers another one (column)."""
    number = {name: body for body, name in enumerate(instance.names)}
    found = np.zeros((len(number), len(number)), dtype=np.bool_)
    for at, names in neighbourhoods.items():
        found[number[at], [number[name] for name in names]] = True
    return found


def trivial_bound(instance: Instance) -> float:
    """Sum of prizes within the maximum number of targets, required ones first; or −inf."""
    targets = sorted(
        instance.targets, key=lambda each: (each.required, each.greatest_prize), reverse=True
    )
    only_kits = all(target.removal == "kit" for target in instance.targets)
    together = 0
    for chaser in instance.chasers:
        limits = [len(targets), chaser.max_targets, chaser.kits if only_kits else None]
        together += min(limit for limit in limits if limit is not None)
    if any(target.required for target in targets[together:]):
        return -math.inf
    return math.fsum(target.greatest_prize for target in targets[:together])


def bound_of(instance: Instance, certificate: Certificate) -> float:
    """Upper bound on plans if the walks' claims hold; −inf if there is no plan.

    Every plan is worth less than the sum of the multipliers, each as often as its body may be gone
    to, of those of the cuts, and, for each chaser, of the most of its walks. What its required
    targets are worth beyond their prizes goes off that. Or it is what floors prove.
    """
    trivial = trivial_bound(instance)
    if certificate.floors is not None:
        return _shown(instance, certificate, worth_of_floors(instance, certificate), trivial)
    if not certificate.walks:
        return trivial
    often = how_often(instance)
    paid = (often[name] * Fraction(each) for name, each in certificate.multipliers.items())
    below = sum(paid, Fraction(0))
    below += sum((Fraction(cut.multiplier) for cut in certificate.cuts), Fraction(0))
    below += sum(
        (len(walks.chasers) * Fraction(walks.most) for walks in certificate.walks), Fraction(0)
    )
    return _shown(instance, certificate, below, trivial)


def _shown(instance: Instance, certificate: Certificate, below: Fraction, trivial: float) -> float:
    """The prizes of plans with less than a worth."""
    required = sum(target.required for target in instance.targets)
    below -= required * Fraction(certificate.required_worth)
    if below <= 0:
        return -math.inf
    prizes = (prize for target in instance.targets for prize in target.prizes if prize)
    least = min(prizes, default=0.0)
    if below <= Fraction(least):
        return min(trivial, 0.0)  # parts of a prize cannot be collected
    if certificate.prize_step is None:
        return min(trivial, math.nextafter(float(below), math.inf))
    step = Fraction(certificate.prize_step)
    # The largest whole number of steps that is less, however prizes miss their multiples.
    steps = math.ceil((below + missed_by(instance, step)) / step) - 1
    return min(trivial, float(steps * step))


def missed_by(instance: Instance, step: Fraction) -> Fraction:
    """Largest deviation of sums of prizes from multiples of a step."""
    prizes = [
        max(abs(prize - step * round(prize / step)) for prize in map(Fraction, target.prizes))
        for target in instance.targets
    ]
    return sum(prizes, Fraction(0))


def difference_of(instance: Instance, certificate: Certificate) -> float:
    """Difference up to which objectives count as equal.

    Half a step of what the certificate shows that all prizes are multiples of; without one, a share
    of the sum of all prizes.
    """
    total = math.fsum(target.greatest_prize for target in instance.targets)
    if certificate.prize_step is None:
        return SHARE * total
    return 0.5 * certificate.prize_step
