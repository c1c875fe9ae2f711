"""The bound implied by a certificate once its walks are verified, in exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from ...plan.certificate import Certificate
from ...problem.instance import Instance
from .floors import worth_of_floors

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
        step = certificate.prize_step
        missed = Fraction(0) if step is None else missed_by(instance, Fraction(step))
        below = worth_of_floors(instance, certificate, missed)
        return _shown(instance, certificate, below, trivial)
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
