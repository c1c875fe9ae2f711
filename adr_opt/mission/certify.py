"""Certificates of proofs."""

from __future__ import annotations

import math
from itertools import chain

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError
from ..plan.certificate import (
    Certificate,
    ProvenCost,
    ProvenCut,
    ProvenFloors,
    ProvenWalks,
    sha256_of,
)
from ..plan.plan import MODEL, InstanceReference
from ..plan.station_limits import StationLimits
from ..problem.instance import Instance
from .evidence import USUAL_SLOT_M_S, CostEvidence, Cut, Evidence, Walks
from .prizes import Prizes
from .result import Result


def certificate_of(instance: Instance, result: Result) -> Certificate:
    """The certificate of a method's proof.

    Where the last step of a proof could only be verified by repeating it, the certificate is
    that of the bound before.

    Parameters
    ----------
    instance : Instance
    result : Result
        Of the whole instance.

    Raises
    ------
    InputError
        Nothing was proven, or the method does not say what its bound rests on.
    """
    prizes, evidence = Prizes(instance), result.evidence
    # Of as many targets as may be serviced the required ones are worth most: a bound that says no
    # more than that needs no evidence.
    most = prizes.shown(prizes.total_worth)
    bound = prizes.rounded_down(result.upper_bound)
    if result.status == "optimal":
        bound = min(bound, most)
    if bound == math.inf:
        raise InputError(f"{result.method} has proven no bound, so there is no certificate")
    walks: tuple[ProvenWalks, ...] = ()
    multipliers: dict[str, float] = {}
    floors: ProvenFloors | None = None
    cuts: tuple[ProvenCut, ...] = ()
    if not prizes.meets(bound, most):
        if evidence is None or not (evidence.walks or evidence.floors):
            raise InputError(
                f"{result.method} gives no evidence for its bound, so there is no certificate"
            )
        proven = _proven(prizes, evidence)
        bound = bound if prizes.meets(bound, proven) else proven
        walks = tuple(_stated(instance, each) for each in evidence.walks)
        cuts = tuple(_named(instance, each) for each in evidence.cuts)
        if evidence.floors is not None:
            floors = ProvenFloors(
                worth_per_s=evidence.floors.per_s,
                worth_per_m_s=evidence.floors.per_m_s,
                ballast_kg=evidence.floors.ballast_kg,
                alone=evidence.floors.alone,
            )
        multipliers = _multipliers(instance, evidence.multipliers)
    return Certificate(
        model=MODEL,
        instance=InstanceReference(name=instance.name, sha256=prizes.sha256),
        plan_sha256=None if result.plan is None else sha256_of(result.plan),
        method=result.method,
        upper_bound=max(float(bound), 0.0) if bound > -math.inf else None,
        required_worth=float(prizes.bonus) if prizes.required else 0.0,
        prize_step=prizes.prize_step or None,
        delta_v_slot_m_s=USUAL_SLOT_M_S if evidence is None else float(evidence.delta_v_slot_m_s),
        time_step_s=evidence.time_step_s if walks and evidence is not None else None,
        multipliers=multipliers,
        walks=walks,
        floors=floors,
        cuts=cuts,
        cost=None if evidence is None or evidence.cost is None else _priced(prizes, evidence.cost),
    )


def _priced(prizes: Prizes, cost: CostEvidence) -> ProvenCost:
    """The proven cost, with names of bodies."""
    instance = prizes.instance
    proven = ProvenCost(
        prize=max(prizes.shown(cost.worth), 0.0),
        bound=max(float(cost.bound), 0.0),
        per_prize=float(cost.per_worth),
    )
    if cost.neighbourhoods is not None:
        return proven.replace(neighbourhoods=_remembered(instance, cost.neighbourhoods))
    assert cost.multipliers is not None
    return proven.replace(
        multipliers=_multipliers(instance, cost.multipliers),
        walks=tuple(_stated(instance, each) for each in cost.walks),
        cuts=tuple(_named(instance, each) for each in cost.cuts),
    )


def _multipliers(instance: Instance, multipliers: npt.NDArray[np.float64]) -> dict[str, float]:
    """Multipliers other than 0, by name of the body."""
    return {instance.names[j]: float(multipliers[j]) for j in np.flatnonzero(multipliers)}


def _named(instance: Instance, cut: Cut) -> ProvenCut:
    """A cut, with names of bodies."""
    a, b, c = (instance.names[body] for body in cut.rows)
    memory = tuple(instance.names[body] for body in sorted(cut.memory))
    return ProvenCut(targets=(a, b, c), memory=memory, multiplier=float(cut.multiplier))


def _stated(instance: Instance, walks: Walks) -> ProvenWalks:
    """The proven walks, with names of bodies and chasers."""
    chasers = tuple(instance.chasers[number].name for number in walks.chasers)
    return ProvenWalks(
        chasers=chasers,
        most=float(walks.most),
        neighbourhoods=_remembered(instance, walks.neighbourhoods),
        worth_per_m_s=walks.per_m_s,
    )


def _remembered(
    instance: Instance, neighbourhoods: npt.NDArray[np.bool_]
) -> dict[str, tuple[str, ...]]:
    """Names of what walks remember, by name of the body."""
    names = instance.names
    return {
        names[i]: tuple(names[j] for j in np.flatnonzero(row))
        for i, row in enumerate(neighbourhoods)
        if row.any()
    }


def _proven(prizes: Prizes, evidence: Evidence) -> float:
    """The bound implied by evidence."""
    parts = [len(each.chasers) * each.most for each in evidence.walks]
    paid = StationLimits(prizes.instance).total(evidence.multipliers)
    parts += [cut.multiplier for cut in evidence.cuts]
    below = math.fsum([paid, *parts]) if evidence.floors is None else evidence.floors.most
    worth = prizes.rounded_down(below)
    shown = prizes.shown(worth)
    worths = chain.from_iterable(each.prizes for each in prizes.instance.targets)
    least = min((worth for worth in worths if worth), default=0.0)
    if 0.0 <= shown < least:
        return 0.0
    return shown if shown >= 0.0 else -math.inf
