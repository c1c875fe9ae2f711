"""Check of names in a certificate: bodies and chasers of its instance, each chaser once."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from fractions import Fraction

from ...common.errors import InputError
from ...plan.certificate import Certificate, ProvenCost, ProvenCut, ProvenWalks
from ...problem.instance import Instance
from .claim import how_often, missed_by

WHOLE = Fraction(1, 10**12)
"""Relative tolerance for prizes as multiples of the step."""


def check_names(instance: Instance, certificate: Certificate) -> None:
    """Check that a certificate names the bodies and chasers of an instance, each chaser once.

    Raises
    ------
    InputError
        It does not, or belongs to another instance.
    """
    certificate.instance.refuse_other(instance, "certificate")
    faults = [
        *_of_names("multipliers", certificate.multipliers, how_often(instance), STATIONS_TOO),
        *_of_walks(instance, "", certificate.walks, certificate.cuts),
        *_of_steps(certificate),
        *(() if certificate.cost is None else _of_cost(instance, certificate.cost)),
        *(() if certificate.prize_step is None else _of_prizes(instance, certificate.prize_step)),
    ]
    if faults:
        raise InputError(f"field {faults[0]}")


BODY, TARGET = "not a body of the instance", "not a target of the instance"
STATIONS_TOO = "neither a target of the instance nor a station with max_refuellings"


def _of_names(field: str, named: Iterable[str], known: Iterable[str], what: str) -> Iterator[str]:
    """Names that are not known."""
    for name in sorted(set(named).difference(known)):
        yield f"{field}: {name!r} is {what}"


def _of_walks(
    instance: Instance, part: str, stated: Collection[ProvenWalks], cuts: Collection[ProvenCut]
) -> Iterator[str]:
    """Faults of the names in walks and cuts."""
    for number, walks in enumerate(stated):
        named = set(walks.neighbourhoods).union(*walks.neighbourhoods.values())
        yield from _of_names(f"{part}walks[{number}].neighbourhoods", named, instance.names, BODY)
    chasers = sorted(name for walks in stated for name in walks.chasers)
    if stated and chasers != sorted(chaser.name for chaser in instance.chasers):
        yield f"{part}walks: must name every chaser of the instance once"
    targets = [target.name for target in instance.targets]
    for number, cut in enumerate(cuts):
        where = f"{part}cuts[{number}]"
        yield from _of_names(f"{where}.targets", cut.targets, targets, TARGET)
        if len(set(cut.targets)) < len(cut.targets):
            yield f"{where}.targets: must be three different targets"
        yield from _of_names(f"{where}.memory", cut.memory, instance.names, BODY)


def _of_steps(certificate: Certificate) -> Iterator[str]:
    """Faults of fields that walks in steps, or walks by labels, do not have."""
    in_steps = certificate.time_step_s is not None
    for number, walks in enumerate(certificate.walks):
        if in_steps and walks.neighbourhoods:
            said = "walks in steps remember only the previous body; leave it out"
            yield f"walks[{number}].neighbourhoods: {said}"
        if not in_steps and walks.worth_per_m_s is not None:
            said = "walks pay for ΔV only in steps; give time_step_s, or leave it out"
            yield f"walks[{number}].worth_per_m_s: {said}"
    if in_steps and certificate.cuts:
        yield "cuts: walks in steps do not pay for cuts; leave them out"


def _of_cost(instance: Instance, cost: ProvenCost) -> Iterator[str]:
    """Faults of the cost part."""
    named, targets = cost.neighbourhoods, [target.name for target in instance.targets]
    everywhere = set(named).union(*named.values())
    yield from _of_names("cost.neighbourhoods", everywhere, instance.names, BODY)
    yield from _of_names("cost.multipliers", cost.multipliers, targets, TARGET)
    if not cost.walks and len(instance.chasers) > 1:
        yield "cost.walks: must be given where there are several chasers"
    if not cost.walks and (cost.multipliers or cost.cuts):
        yield "cost.walks: missing, but multipliers or cuts are given, which walks pay for"
    if cost.walks and named:
        yield "cost.neighbourhoods: state them in cost.walks instead"
    yield from _of_walks(instance, "cost.", cost.walks, cost.cuts)
    for number, walks in enumerate(cost.walks):
        if walks.worth_per_m_s is not None:
            yield f"cost.walks[{number}].worth_per_m_s: walks pay for ΔV anyway; leave it out"


def _of_prizes(instance: Instance, stated: float) -> Iterator[str]:
    """Faults of prizes that are not multiples of their step, up to rounding."""
    step = Fraction(stated)
    if 4 * missed_by(instance, step) > step:
        said = "the prizes together deviate from its multiples by more than a quarter of it"
        yield f"prize_step = {stated!r}: {said}"
    for target in instance.targets:
        for prize in map(Fraction, target.prizes):
            if abs(prize - step * round(prize / step)) > WHOLE * prize:
                said = f"the prize of {target.name!r}, {float(prize)!r}, is no multiple of it"
                yield f"prize_step = {stated!r}: {said}"
