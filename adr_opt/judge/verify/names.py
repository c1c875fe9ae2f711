"""Names in a certificate: they are bodies and chasers of its instance, each chaser once."""

from __future__ import annotations

from collections.abc import Collection, Iterable
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
    often = how_often(instance)
    for name in certificate.multipliers:
        if name not in often:
            raise InputError(
                f"field multipliers: {name!r} is neither a target of the instance nor a station "
                "with max_refuellings"
            )
    _check_walks(instance, "", certificate.walks)
    for number, walks in enumerate(certificate.walks):
        if certificate.time_step_s is not None and walks.neighbourhoods:
            raise InputError(
                f"field walks[{number}].neighbourhoods: walks in steps remember where they come "
                "from, and nothing else"
            )
        if certificate.time_step_s is None and walks.worth_per_m_s is not None:
            raise InputError(
                f"field walks[{number}].worth_per_m_s: walks pay for ΔV only where time_step_s is "
                "given"
            )
    _check_cuts(instance, "", certificate.cuts)
    if certificate.cuts and certificate.time_step_s is not None:
        raise InputError("field cuts: walks in steps pay for none")
    if certificate.cost is not None:
        _check_cost(instance, certificate.cost)
    step = certificate.prize_step
    if step is not None and 4 * missed_by(instance, Fraction(step)) > Fraction(step):
        raise InputError(
            f"field prize_step = {step!r}: all prizes together miss multiples of it by more than a "
            "quarter of it"
        )
    for target in instance.targets:
        for prize in target.prizes:
            if step is not None and not _is_multiple(Fraction(prize), Fraction(step)):
                raise InputError(
                    f"field prize_step = {step!r}: the prize of {target.name!r}, {prize!r}, is no "
                    "multiple of it"
                )


def _check_cost(instance: Instance, cost: ProvenCost) -> None:
    """Check that the cost part does; that of several chasers has walks.

    Raises
    ------
    InputError
        It does not.
    """
    named = cost.neighbourhoods
    _check_known(instance.names, "cost.neighbourhoods", set(named).union(*named.values()))
    targets = [target.name for target in instance.targets]
    _check_known(targets, "cost.multipliers", cost.multipliers, "a target")
    if not cost.walks and len(instance.chasers) > 1:
        raise InputError("field cost.walks: must be given where there are several chasers")
    if not cost.walks and (cost.multipliers or cost.cuts):
        raise InputError("field cost.walks: without them nothing is paid for multipliers or cuts")
    if cost.walks and named:
        raise InputError("field cost.neighbourhoods: state them in cost.walks instead")
    _check_walks(instance, "cost.", cost.walks)
    for number, walks in enumerate(cost.walks):
        if walks.worth_per_m_s is not None:
            raise InputError(
                f"field cost.walks[{number}].worth_per_m_s: walks pay for ΔV anyway; leave it out"
            )
    _check_cuts(instance, "cost.", cost.cuts)


def _check_walks(instance: Instance, part: str, stated: Collection[ProvenWalks]) -> None:
    """Check that walks name bodies, and every chaser once if there are any."""
    for number, walks in enumerate(stated):
        named = set(walks.neighbourhoods).union(*walks.neighbourhoods.values())
        _check_known(instance.names, f"{part}walks[{number}].neighbourhoods", named)
    chasers = sorted(name for walks in stated for name in walks.chasers)
    if stated and chasers != sorted(chaser.name for chaser in instance.chasers):
        raise InputError(f"field {part}walks: must name every chaser of the instance once")


def _check_cuts(instance: Instance, part: str, cuts: Iterable[ProvenCut]) -> None:
    """Check that cuts name targets and bodies."""
    targets = [target.name for target in instance.targets]
    for number, cut in enumerate(cuts):
        where = f"{part}cuts[{number}]"
        _check_known(targets, f"{where}.targets", cut.targets, "a target")
        if len(set(cut.targets)) < len(cut.targets):
            raise InputError(f"field {where}.targets: must be three different targets")
        _check_known(instance.names, f"{where}.memory", cut.memory)


def _check_known(
    known: Iterable[str], field: str, named: Iterable[str], kind: str = "a body"
) -> None:
    """Check that names are known."""
    strange = set(named).difference(known)
    if strange:
        raise InputError(f"field {field}: {min(strange)!r} is not {kind} of the instance")


def _is_multiple(prize: Fraction, step: Fraction) -> bool:
    return abs(prize - step * round(prize / step)) <= WHOLE * prize
