"""The gate: plans, refined plans and certificates are judged before anything uses them.

Verbs, exports, pages, flights, rehearsals and replanning take an :class:`Admitted`, which only
:func:`admit` makes. Public functions take a plan as well, and admit it first. What was let in
without being legal is called *unjudged* wherever its figures are told.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Generic, TypeVar

from ..common.errors import InputError
from ..plan.certificate import Certificate
from ..plan.plan import Plan
from ..plan.refined_plan import RefinedPlan
from ..problem.instance import AnyInstance, Instance, instance_of
from ..problem.support import refuse
from .check.verdict import check
from .check.violation import Violation

What = TypeVar("What", Plan, RefinedPlan, Certificate)

TANK = frozenset({"delta-v"})
"""Rules that do not keep a plan from being flown: whether tanks last is what a flight finds out."""

MODEL_TANK = frozenset({"delta-v", "delta-v-left"})
"""Rules of the model's tanks, which plans may break that spend ΔV saved in flight.

Tanks of refined plans are judged as flown.
"""

_BY_THE_GATE = object()
"""Token known to :func:`admit` alone, so that nothing else can make an :class:`Admitted`."""

NAMES: dict[type, str] = {Plan: "plan", RefinedPlan: "refined plan", Certificate: "certificate"}


@dataclass(frozen=True)
class Admitted(Generic[What]):
    """A plan, a refined plan or a certificate that has been judged, with its instance.

    Attributes
    ----------
    instance : Instance
    plan : Plan, RefinedPlan or Certificate
    violations : tuple of Violation
        Empty, unless violations were tolerated.
    """

    instance: Instance
    plan: What
    violations: tuple[Violation, ...]
    _by: object

    def __post_init__(self) -> None:
        if self._by is not _BY_THE_GATE:
            raise TypeError("only adr_opt.judge.admit.admit makes an Admitted")

    @property
    def holds(self) -> bool:
        """Whether the judge has found nothing."""
        return not self.violations


AnyPlan = Plan | Admitted[Plan]
"""A plan, judged or not yet."""

AnyRefined = RefinedPlan | Admitted[RefinedPlan]
"""A refined plan, judged or not yet."""


def admit(
    instance: AnyInstance,
    plan: What | Admitted[What],
    *,
    unjudged: bool = False,
    excused: Collection[str] = (),
    refined_from: Plan | None = None,
) -> Admitted[What]:
    """Judge a plan, a refined plan or a certificate before it is used.

    Parameters
    ----------
    instance : Instance, path or dict
    plan : Plan, RefinedPlan or Certificate
        Or one that is already admitted, over the same instance.
    unjudged : bool
        Whether one with violations is let in with them, where it belongs to the instance and can
        be read at all.
    excused : collection of str
        Rules whose violations do not count here, because the caller handles them.
    refined_from : Plan, optional
        The plan that a refined one was made of, by default the one in its file.

    Returns
    -------
    Admitted

    Raises
    ------
    InputError
        It belongs to another instance; or, unless ``unjudged``, there is a violation, of which the
        sentence names leg and rule.
    """
    instance = instance_of(instance)
    if isinstance(plan, Admitted):
        if plan.instance.sha256 == instance.sha256:
            return plan
        plan = plan.plan
    found = _violations(instance, plan, refined_from)
    wrong = tuple(each for each in found if each.rule not in excused)
    if wrong and not unjudged:
        raise InputError(refusal(NAMES[type(plan)], wrong))
    return Admitted(instance, plan, found, _BY_THE_GATE)


def admit_made(instance: Instance, plan: Plan, *, excused: Collection[str] = ()) -> Admitted[Plan]:
    """Judge a plan that a planner has just made.

    Parameters
    ----------
    instance : Instance
    plan : Plan
    excused : collection of str
        Rules that the planner was told not to keep.

    Raises
    ------
    RuntimeError
        It breaks another one: the planner is wrong, and not the input.
    """
    made = admit(instance, plan, unjudged=True)
    wrong = tuple(each for each in made.violations if each.rule not in excused)
    if wrong:
        raise RuntimeError(f"method {plan.method!r} made a plan that breaks a rule: {wrong[0]}")
    return made


def refusal(name: str, violations: tuple[Violation, ...]) -> str:
    """The sentence that refuses something with violations."""
    more = f" (and {len(violations) - 1} more)" if len(violations) > 1 else ""
    return f"the {name} is not legal: {violations[0]}{more}; 'check' lists all violations"


def _violations(
    instance: Instance, plan: Plan | RefinedPlan | Certificate, refined_from: Plan | None
) -> tuple[Violation, ...]:
    if isinstance(plan, Plan):
        return check(instance, plan)
    if isinstance(plan, RefinedPlan):
        return _of_refined(instance, plan, refined_from)
    from .verify.names import check_names  # what verifies is slow to import
    from .verify.rules import FOLLOWS

    check_names(instance, plan)
    refuse(instance, FOLLOWS)
    return ()


def _of_refined(
    instance: Instance, refined: RefinedPlan, plan: Plan | None
) -> tuple[Violation, ...]:
    from .refined.verdict import UNJUDGED, check_refined  # what flies is slow to import

    refined.instance.refuse_other(instance, NAMES[RefinedPlan])
    planned = refined.planned if plan is None else plan
    if planned is None:
        said = "it does not contain the plan that it refines; refine that plan again"
        return (Violation(None, UNJUDGED, said),)
    if refined.planned not in (None, planned):
        return (Violation(None, "plan", "it refines another plan than the one given"),)
    of_plan = (each for each in check(instance, planned) if each.rule not in MODEL_TANK)
    return (*of_plan, *check_refined(instance, planned, refined))
