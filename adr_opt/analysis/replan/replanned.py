"""The result of replanning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...common.card import Shown
from ...common.clock import now_s
from ...mission.result import Result
from ...plan.plan import Plan, Route
from ...problem.instance import Instance
from .chaser_states import ChaserState
from .deviations import Deviations

Orders = tuple[tuple[str, ...], ...]


@dataclass(frozen=True, repr=False)
class Replanned(Shown):
    """What remains of a mission, replanned.

    Attributes
    ----------
    instance : Instance
        What is left to do: chasers where they are, with what they have; without what is done or
        lost, but for objects that are still to be towed; with the new zones.
    result : Result
        Of planning that; its plan belongs to that instance.
    states : tuple of ChaserState
        What is flown or fixed, and from where it goes on.
    former : tuple of tuple of str
        What the plan was about to do, for each chaser.
    gained, dropped, lost : tuple of str
        Targets that only the new plan visits; that only the former one would have visited, though
        they could still be; and those that are lost.
    missed, given_up : tuple of str
        Targets that were reached and not serviced, and those of them that are not tried again.
    prize_before, prize_after : float
        Of what remained of the former plan, and of the new one.
    kept : int
        Legs at the beginning of the new plan that lead where the former ones led.
    notes : tuple of str
    runtime_s : float
        Of replanning, timetables included.
    """

    instance: Instance
    result: Result
    states: tuple[ChaserState, ...]
    former: Orders
    gained: tuple[str, ...]
    dropped: tuple[str, ...]
    lost: tuple[str, ...]
    missed: tuple[str, ...]
    given_up: tuple[str, ...]
    prize_before: float
    prize_after: float
    kept: int
    notes: tuple[str, ...]
    runtime_s: float

    @property
    def plan(self) -> Plan | None:
        """The new plan; None if there is none."""
        return self.result.plan

    def whole(self) -> tuple[Route, ...]:
        """Complete flight of each chaser: fixed legs, then those of the new plan.

        Of legs that went otherwise than planned it has the times and costs that they had, and a
        target that was missed is tried again by a second leg to it.
        """
        plan = self.plan
        new = {} if plan is None else {route.chaser: route.legs for route in plan.routes}
        routes = []
        for state in self.states:
            legs, onward = list(state.legs), new.get(state.chaser.name, ())
            if state.is_put and onward:
                legs[-1] = legs[-1].replace(tow=onward[0].tow)
            for leg in state.onward(onward):
                where = legs[-1].destination if legs else state.chaser.start_name
                free_s = legs[-1].free_s if legs else state.since_s
                legs.append(leg.replace(origin=where, ready_s=free_s))
            routes.append(Route(chaser=state.chaser.name, legs=tuple(legs)))
        return tuple(routes)

    def to_dict(self) -> dict[str, Any]:
        """The changes as JSON data."""
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "fixed": [
                {
                    "chaser": state.chaser.name,
                    "legs": len(state.legs),
                    "at": state.body,
                    "free_s": state.free_s,
                    "delta_v_left_m_s": state.left_m_s,
                }
                for state in self.states
            ],
            "prize_before": self.prize_before,
            "prize_after": self.prize_after,
            "upper_bound": self.result.to_dict()["upper_bound"],
            "gained": list(self.gained),
            "dropped": list(self.dropped),
            "lost": list(self.lost),
            "missed": list(self.missed),
            "given_up": list(self.given_up),
            "kept_legs": self.kept,
            "notes": list(self.notes),
            "runtime_s": self.runtime_s,
        }


class RemainingPlan(NamedTuple):
    """The remaining instance with a plan.

    Attributes
    ----------
    instance : Instance
        What is left.
    states : tuple of ChaserState
        Where chasers go on from.
    result : Result
        Of planning it.
    """

    instance: Instance
    states: tuple[ChaserState, ...]
    result: Result


def compared(
    instance: Instance,
    found: RemainingPlan,
    former: Orders,
    lost: tuple[str, ...],
    went: Deviations,
    notes: tuple[str, ...],
    began: float,
) -> Replanned:
    """Gains and losses of the new plan against what remained of the former one.

    Parameters
    ----------
    instance : Instance
        The whole mission.
    found : RemainingPlan
    former : tuple of tuple of str
        What the plan was about to do, for each chaser.
    lost : tuple of str
    went : Deviations
    notes : tuple of str
    began : float
        When replanning began, by the performance counter [s].
    """
    remaining, states, result = found
    prizes = {target.name: target.prize for target in instance.targets}
    before = [name for order in former for name in order if name in prizes]
    plan = result.plan
    after, kept = list[str](), 0
    routes = {} if plan is None else {route.chaser: route.legs for route in plan.routes}
    for state, order in zip(states, former, strict=True):
        new = [leg.destination for leg in state.onward(routes.get(state.chaser.name, ()))]
        after += [name for name in new if name in prizes]
        kept += _common(new, order)
    return Replanned(
        instance=remaining,
        result=result,
        states=states,
        former=former,
        gained=tuple(name for name in after if name not in before),
        dropped=tuple(name for name in before if name not in after and name not in lost),
        lost=lost,
        missed=went.missed,
        given_up=went.given_up,
        prize_before=sum(prizes[name] for name in before),
        prize_after=sum(prizes[name] for name in after),
        kept=kept,
        notes=notes,
        runtime_s=now_s() - began,
    )


def _common(one: Sequence[str], two: Sequence[str]) -> int:
    for at, (left, right) in enumerate(zip(one, two, strict=False)):
        if left != right:
            return at
    return min(len(one), len(two))
