"""Comparison of plans of one instance, leg by leg."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from difflib import SequenceMatcher
from typing import Any, Literal

from ..common.card import Shown
from ..common.errors import InputError
from ..judge.admit import Admitted, AnyPlan, admit
from ..plan.plan import Leg, Plan
from ..plan.routes import Flown, routes_of
from ..problem.instance import Instance
from ..problem.rules import JUDGED, Follower
from ..problem.support import refuse

SAME_S, SAME_M_S = 1.0, 0.01
"""Differences in times and in ΔV up to which legs count as equal."""

What = Literal["same", "retimed", "only", "moved"]


@dataclass(frozen=True)
class Side:
    """Totals of one of the plans.

    Attributes
    ----------
    name, method, status : str
    objective : float
    visits, required, refuellings : int
        Targets, those of them that are required, and stops at stations.
    cost : float
        As the instance counts it.
    delta_v_m_s, end_s : float
        Of all legs; of the last service.
    upper_bound, gap, cost_bound, cost_gap : float or None
    cost_status : str or None
    violations : int
        What `check` finds.
    """

    name: str
    method: str
    status: str
    objective: float
    visits: int
    required: int
    refuellings: int
    cost: float
    delta_v_m_s: float
    end_s: float
    upper_bound: float | None
    gap: float | None
    cost_bound: float | None
    cost_gap: float | None
    cost_status: str | None
    violations: int


@dataclass(frozen=True)
class LegPair:
    """A leg of the first plan and its counterpart in another to the same body, or only one of them.

    Attributes
    ----------
    what : {"same", "retimed", "only", "moved"}
        The same leg; the same bodies at another time or cost; a leg of one plan to a target that
        the other one leaves out; or to one to which the other goes at another place of its order.
    chaser : str
    first, other : (int, Leg) or None
        With the number of the leg in its plan.
    """

    what: What
    chaser: str
    first: tuple[int, Leg] | None
    other: tuple[int, Leg] | None

    @property
    def destination(self) -> str:
        """Destination of the pair."""
        return self._legs[0][1].destination

    @property
    def _legs(self) -> tuple[tuple[int, Leg], ...]:
        return tuple(leg for leg in (self.first, self.other) if leg is not None)

    def to_dict(self) -> dict[str, Any]:
        """The pair as JSON data: number, times and ΔV of each leg."""
        sides: dict[str, dict[str, Any] | None] = {}
        for name, numbered in (("first", self.first), ("other", self.other)):
            sides[name] = None
            if numbered is not None:
                number, leg = numbered
                sides[name] = {
                    "leg": number,
                    "origin": leg.origin,
                    "departure_s": leg.departure_s,
                    "arrival_s": leg.arrival_s,
                    "end_s": leg.end_s,
                    "delta_v_m_s": leg.delta_v_m_s,
                }
        return {"what": self.what, "chaser": self.chaser, "destination": self.destination, **sides}


@dataclass(frozen=True)
class Difference:
    """Differences of a plan from the first one.

    Attributes
    ----------
    name : str
    pairs : tuple of LegPair
        All legs of both, in order, chaser by chaser.
    gained, lost : tuple of str
        Targets that this plan visits and the first one does not, and the other way round.
    """

    name: str
    pairs: tuple[LegPair, ...]
    gained: tuple[str, ...]
    lost: tuple[str, ...]

    @property
    def same(self) -> bool:
        """Whether the plans are the same."""
        return all(pair.what == "same" for pair in self.pairs)

    def to_dict(self) -> dict[str, Any]:
        """The differences as JSON data."""
        return {
            "name": self.name,
            "gained": list(self.gained),
            "lost": list(self.lost),
            "legs": [pair.to_dict() for pair in self.pairs],
        }


@dataclass(frozen=True, repr=False)
class Comparison(Shown):
    """Comparison of several plans of one instance.

    Attributes
    ----------
    instance : Instance
    plans : dict of str to Plan
    sides : tuple of Side
        Of each plan.
    differences : tuple of Difference
        Of each plan but the first, against that.
    """

    instance: Instance
    plans: Mapping[str, Plan]
    sides: tuple[Side, ...]
    differences: tuple[Difference, ...]

    def to_dict(self) -> dict[str, Any]:
        """The comparison as JSON data."""
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "plans": [asdict(side) for side in self.sides],
            "differences": [each.to_dict() for each in self.differences],
        }


FOLLOWS = Follower("compare", JUDGED)


def compare(instance: Instance, plans: Mapping[str, AnyPlan]) -> Comparison:
    """Compare plans of one instance, each with the first.

    Parameters
    ----------
    instance : Instance
    plans : mapping of str to Plan or Admitted
        What each is called. Violations are counted and do not stop the comparison.

    Raises
    ------
    InputError
        There are fewer than two plans, or one belongs to another instance.
    """
    refuse(instance, FOLLOWS)
    if len(plans) < 2:
        raise InputError("one plan only, which cannot be compared; give two or more")
    judged = dict[str, Plan]()
    sides = []
    for name, plan in plans.items():
        try:
            admitted = admit(instance, plan, unjudged=True)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        judged[name] = admitted.plan
        sides.append(_side(name, admitted))
    first, *others = judged.items()
    differences = tuple(_difference(instance, first[1], name, plan) for name, plan in others)
    return Comparison(instance, judged, tuple(sides), differences)


def _side(name: str, admitted: Admitted[Plan]) -> Side:
    instance, plan = admitted.instance, admitted.plan
    visited = set(plan.destinations)
    return Side(
        name=name,
        method=plan.method,
        status=plan.status,
        objective=plan.objective,
        visits=sum(target.name in visited for target in instance.targets),
        required=sum(target.required and target.name in visited for target in instance.targets),
        refuellings=sum(each in instance.station_names for each in plan.destinations),
        cost=plan.cost,
        delta_v_m_s=plan.delta_v_m_s,
        end_s=max((leg.end_s for leg in plan.legs), default=0.0),
        upper_bound=plan.upper_bound,
        gap=plan.gap,
        cost_bound=plan.cost_bound,
        cost_gap=plan.cost_gap,
        cost_status=plan.cost_status,
        violations=len(admitted.violations),
    )


def _difference(instance: Instance, first: Plan, name: str, other: Plan) -> Difference:
    routes = {flown.chaser.name: flown for flown in routes_of(instance, first)}
    pairs: list[LegPair] = []
    visited = _targets(instance, first), _targets(instance, other)
    for flown in routes_of(instance, other):
        pairs += _pairs(routes[flown.chaser.name], flown, visited)
    gained = tuple(body for body in visited[1] if body not in visited[0])
    lost = tuple(body for body in visited[0] if body not in visited[1])
    return Difference(name, tuple(pairs), gained, lost)


def _targets(instance: Instance, plan: Plan) -> list[str]:
    return [name for name in plan.destinations if name not in instance.station_names]


def _pairs(first: Flown, other: Flown, visited: tuple[list[str], list[str]]) -> list[LegPair]:
    """Legs of a chaser, aligned along the longest runs of bodies common to both plans."""
    chaser = other.chaser.name
    one, two = first.legs, other.legs
    matcher = SequenceMatcher(None, _order(one), _order(two), autojunk=False)

    def alone(legs: Sequence[tuple[int, Leg]], *, in_first: bool) -> list[LegPair]:
        found = []
        for leg in legs:
            is_in_both = leg[1].destination in visited[1 if in_first else 0]
            what: What = "moved" if is_in_both else "only"
            found.append(
                LegPair(what, chaser, leg if in_first else None, None if in_first else leg)
            )
        return found

    pairs: list[LegPair] = []
    for tag, i, i_end, j, j_end in matcher.get_opcodes():
        if tag == "equal":
            for left, right in zip(one[i:i_end], two[j:j_end], strict=True):
                what: What = "same" if _same(left[1], right[1]) else "retimed"
                pairs.append(LegPair(what, chaser, left, right))
        else:
            pairs += alone(one[i:i_end], in_first=True) + alone(two[j:j_end], in_first=False)
    return pairs


def _order(legs: Sequence[tuple[int, Leg]]) -> list[str]:
    return [leg.destination for _, leg in legs]


def _same(one: Leg, two: Leg) -> bool:
    times = ("departure_s", "arrival_s", "end_s")
    return (
        one.origin == two.origin
        and all(abs(getattr(one, each) - getattr(two, each)) <= SAME_S for each in times)
        and abs(one.delta_v_m_s - two.delta_v_m_s) <= SAME_M_S
    )
