"""Verification of a plan's certificate by an independent program.

Nothing here is shared with planners and proofs but the connections of the timetable, and some of
these are flown again by the physics of `check`.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from fractions import Fraction

from ...common.errors import InputError
from ...legs.connection_finder import ConnectionFinder
from ...plan.certificate import Certificate, ProvenWalks, sha256_of
from ...plan.plan import MODEL, Plan
from ...problem.chasers import Chaser
from ...problem.instance import AnyInstance, Instance
from ...problem.support import followed
from ..check.connections import Sampled, sample_connections
from ..check.verdict import check
from .claim import bound_of, difference_of, gains, remembered
from .cost import judged_cost
from .legs import legs_of, losses_of
from .lists import Lists
from .names import check_names
from .rules import FOLLOWS
from .steps import most_in_steps
from .terms import terms_of
from .walk_questions import WalkAnswer, refuted, walk_question, walks_reach

CONNECTIONS = 1000
"""Number of connections flown again."""

MOST_CONNECTIONS = 1_000_000
"""Maximum number of connections; more would take days, and must be a typing error."""


@dataclass(frozen=True)
class Verdict:
    """The outcome of :func:`verify`.

    Attributes
    ----------
    reasons : tuple of str
        Why the certificate is refused; none if it is verified.
    upper_bound : float
        Verified upper bound on all plans; −inf if there is no plan, +inf if nothing was verified.
    objective : float or None
        What the plan collects.
    labels : int
        Number of labels that verification took.
    connections, departures : int
        Number of connections flown again, and of departures at which all sequences were.
    legs : int
        Number of legs examined where walks are counted in steps of time.
    difference : float
        Difference up to which objectives count as equal: less than the common step of prizes.
    cost_bound : float or None
        Verified lower bound on the cost of plans that collect as much as the certificate states
        [m/s]; None if nothing was verified.
    """

    reasons: tuple[str, ...]
    upper_bound: float
    objective: float | None
    labels: int
    connections: int
    departures: int
    legs: int = 0
    difference: float = 0.0
    cost_bound: float | None = None

    @property
    def gap(self) -> float | None:
        """Largest possible gap of the plan to the optimum, as a share of the bound."""
        if self.objective is None or not math.isfinite(self.upper_bound):
            return None
        lacking = max(0.0, self.upper_bound - self.objective)
        return lacking / self.upper_bound if lacking > self.difference else 0.0

    @property
    def verified(self) -> bool:
        """Whether everything claimed is verified."""
        return not self.reasons


def verify(
    instance: AnyInstance,
    plan: Plan | None,
    certificate: Certificate,
    *,
    connections: int = CONNECTIONS,
    seed: int = 0,
    labels: str | os.PathLike[str] | None = None,
    save_labels: str | os.PathLike[str] | None = None,
) -> Verdict:
    """Verify a certificate, and a plan's statements about itself.

    Parameters
    ----------
    instance : Instance, path or dict
    plan : Plan or None
        None to verify the bound alone.
    certificate : Certificate
    connections : int
        Number of random connections flown again by the physics of `check`; at a tenth as many
        departures, better connections are searched for.
    seed : int
    labels : path, optional
        A file of closed labels to check, in place of generated ones.
    save_labels : path, optional
        File of closed labels to write if everything is verified.

    Raises
    ------
    InputError
        The plan or certificate belongs to another instance, or the instance has rules that cannot
        be verified yet; or ``connections`` exceeds :data:`MOST_CONNECTIONS`.
    """
    if not 0 <= connections <= MOST_CONNECTIONS:
        raise InputError(f"connections = {connections}: must be from 0 to {MOST_CONNECTIONS}")
    instance = followed(instance, FOLLOWS)
    check_names(instance, certificate)
    reasons = _of_former_model(instance, certificate)
    reasons += [] if plan is None else _judge(instance, plan, certificate)
    if reasons:  # no proof makes a wrong plan right
        return Verdict(tuple(reasons), math.inf, None, 0, 0, 0)
    connecting = ConnectionFinder(instance, relaxed=True)
    sampled = Sampled(0, 0, ())
    if certificate.walks or certificate.cost is not None:
        sampled = sample_connections(instance, connecting, connections, seed)
    reasons += sampled.faults
    lists = Lists() if labels is None else Lists.load(labels, certificate)
    labelled, legs, refuted = 0, 0, False
    for walks in certificate.walks:
        made, gone, reached = _searched(instance, connecting, certificate, walks, lists)
        labelled, legs = labelled + made, legs + gone
        if reached is not None:
            reasons.append(reached)
            refuted = True
    bound = math.inf if refuted else bound_of(instance, certificate)
    difference = difference_of(instance, certificate)
    if not refuted:
        reasons += _compare(plan, certificate, bound, difference)
    priced = judged_cost(instance, plan, certificate, connecting, lists)
    reasons += priced.reasons
    objective = None if plan is None else plan.objective
    if save_labels is not None and not reasons:
        lists.save(save_labels, certificate)
    return Verdict(
        tuple(reasons),
        bound,
        objective,
        labelled + priced.labels,
        sampled.connections,
        sampled.departures,
        legs,
        difference,
        priced.bound,
    )


def _of_former_model(instance: Instance, certificate: Certificate) -> list[str]:
    if certificate.model == MODEL or not instance.transfer.max_drift_s:
        return []
    return [
        f"it is for version {certificate.model} of the model, in which phasing of drift legs was "
        "free; prove again"
    ]


def _judge(instance: Instance, plan: Plan, certificate: Certificate) -> list[str]:
    """Violations of the plan itself."""
    reasons = [f"the plan is not legal: {violation}" for violation in check(instance, plan)[:1]]
    stated = certificate.plan_sha256
    if not reasons and stated is not None and stated != sha256_of(plan):
        reasons.append("the certificate belongs to another plan, or the plan was changed")
    return reasons


def _searched(
    instance: Instance,
    connecting: ConnectionFinder,
    certificate: Certificate,
    walks: ProvenWalks,
    lists: Lists,
) -> tuple[int, int, str | None]:
    """Number of labels and legs needed, and the error if a walk collects more than claimed."""
    worths, most = gains(instance, certificate), Fraction(walks.most)
    length_s, slot_m_s = certificate.time_step_s, certificate.delta_v_slot_m_s

    def answer(chaser: Chaser, own: ConnectionFinder) -> WalkAnswer:
        if length_s is None:
            legs, known = legs_of(instance, chaser, own), remembered(instance, walks.neighbourhoods)
            cuts, losses = certificate.cuts, losses_of(instance)
            return walks_reach(
                walk_question(legs, worths, known, most, slot_m_s, cuts, losses=losses), lists
            )
        price = None if walks.worth_per_m_s is None else Fraction(walks.worth_per_m_s)
        terms = terms_of(instance, chaser, own)
        found, count = most_in_steps(terms, own, worths, length_s, slot_m_s, price)
        return WalkAnswer(found is not None and found >= most, legs=count)

    said = f"a walk of {{}} collects {walks.most:g} less multipliers"
    return refuted(instance, walks.chasers, connecting, said, answer)


def _compare(
    plan: Plan | None, certificate: Certificate, bound: float, difference: float
) -> list[str]:
    """Claims beyond what was verified."""
    reasons = []
    said = "no plan exists" if bound == -math.inf else f"no plan collects more than {bound:.15g}"
    if _is_less(certificate.upper_bound, bound, difference):
        claim = certificate.upper_bound
        stated = "that there is no plan" if claim is None else f"{claim:.15g}"
        reasons.append(f"the certificate states {stated}; it only follows that {said}")
    if plan is None:
        return reasons
    if plan.upper_bound is not None and _is_less(plan.upper_bound, bound, difference):
        reasons.append(
            f"the plan states the bound {plan.upper_bound:.15g}; it only follows that {said}"
        )
    if plan.status in ("optimal", "feasible") and bound < plan.objective - difference:
        reasons.append(f"the plan collects {plan.objective:.15g}, but {said}: one of them is wrong")
    elif plan.status == "optimal" and plan.objective < bound - difference:
        reasons.append(f"the plan claims to be optimal; it only follows that {said}")
    return reasons


def _is_less(claim: float | None, bound: float, difference: float) -> bool:
    """Whether a claim exceeds what was verified."""
    if bound == -math.inf:
        return False
    return claim is None or claim < bound - difference
