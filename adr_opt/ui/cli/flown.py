"""Output on the flight of a plan, for ``solve`` and ``check``."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...common.errors import InputError
from . import param
from .output import say
from .signals import Aborted, signals_to

if TYPE_CHECKING:
    from ...fly.flight import Flight, RefinedFlight
    from ...fly.flight.mean_flight import MeanFlight
    from ...fly.forces import ForcedFlight
    from ...fly.refine.loop import RefinedResult
    from ...judge.admit import Admitted
    from ...plan.plan import Plan
    from ...plan.plan_flight import PlanFlight
    from ...plan.refined_plan import RefinedPlan
    from ...problem.instance import Instance

NOT_FLOWN = "not flown: "

no_fly_option = param.flag("--no-fly", "Do not fly the plan in mean motion on the true orbits.")


def flight_of(admitted: Admitted[Plan]) -> MeanFlight | str:
    """The flight of a plan in mean motion, or the reason why there is none.

    Ctrl-C or SIGTERM ends the flight and nothing else.
    """
    from ...fly.flight.mean_flight import fly_mean

    heard: list[bool] = []
    try:
        with signals_to(lambda: heard.append(True)):
            flight = fly_mean(admitted.instance, admitted, enough=lambda: bool(heard))
    except InputError as error:
        return str(error)
    except Aborted:
        flight = None
    return "interrupted" if flight is None else flight


def was_refined(plan: Plan) -> PlanFlight | None:
    """A plan's record of its refinement, if it concerns exactly these legs."""
    said = plan.own_flight
    return said if said is not None and said.how == "refined" else None


def flown_plan(admitted: Admitted[Plan]) -> tuple[Plan, MeanFlight | str]:
    """The plan with its flight recorded, and the flight, or the reason why there is none."""
    flight, plan = flight_of(admitted), admitted.plan
    return (plan if isinstance(flight, str) else plan.replace(flown=flight.record)), flight


def flight_line(flight: MeanFlight | str) -> str:
    """The outcome of a flight, on one line."""
    if isinstance(flight, str):
        return NOT_FLOWN + flight
    said = str(flight)
    return said if flight.holds else f"{said}; 'solve --refine' plans until the plan holds"


def save_noted(refined: RefinedPlan, what: str, said: str, out: str, quiet: bool) -> None:
    """Write a refined plan with a note on a flight, which replaces an earlier one of the kind."""
    kept = tuple(note for note in refined.notes if not note.startswith(what))
    refined.replace(notes=(*kept, f"{what}: {said}")).save(out)
    say(f"wrote {out}", unless=quiet)


def tanks_told(flight: Flight | RefinedFlight | ForcedFlight) -> list[str]:
    """Tanks that break, or else the fullest one; empty if no tank is used."""
    if flight.broken_tanks or not flight.tanks:
        return [str(tank) for tank in flight.broken_tanks]
    worst = max(flight.tanks, key=lambda tank: tank.over_m_s or 0.0)
    return [f"every tank holds: {worst}"]


def refined_plan(instance: Instance, looped: RefinedResult) -> RefinedResult:
    """The result of ``solve --refine`` with the refinement recorded in its plan."""
    from ...fly.flight.mean_flight import families_of, tanks_left
    from ...fly.flight.tanks import tanks_of
    from ...plan.plan_flight import PlanFlight

    plan, refined = looped.plan, looped.refined
    if plan is None or refined is None:
        return looped
    taken: dict[int, float | None] = dict.fromkeys(range(1, len(plan.legs) + 1))
    taken |= {leg.leg: leg.flown_delta_v_m_s for leg in refined.legs}
    record = PlanFlight.model_validate(
        {
            "how": "refined",
            "gravity": refined.gravity,
            "legs_sha256": plan.legs_sha256,
            "holds": looped.holds,
            "families": families_of(plan.legs, taken),
            "tanks": tanks_left(tanks_of(instance, refined)),
        }
    )
    plan = plan.replace(flown=record)
    return replace(looped, result=replace(looped.result, plan=plan), refined=refined.made_of(plan))
