"""``fly``: fly a plan in the dynamics of its instance."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from ...common.wording import counted
from . import param
from .flown import tanks_told
from .fly_errors import Sampling, error_options
from .fly_forces import ForceOptions, force_options
from .output import emit, emit_json, say
from .parameters import (
    about,
    admitted_plan,
    admitted_refined,
    check_out,
    say_unjudged,
    unjudged_option,
)

if TYPE_CHECKING:
    from ...fly.flight import Flight
    from ...fly.flight.flights import LegFlight
    from ...plan.plan import Plan

MOTIONS = {"two-body": "two-body motion", "j2": "mean motion under J2"}
"""Names of an instance's dynamics."""

FLOWN = {dynamics: f"flown in {motion}: " for dynamics, motion in MOTIONS.items()}
"""Beginnings of notes written by ``--out``; a new note replaces the earlier one."""


@click.command("fly", short_help="Fly the burns of PLAN and measure the misses.")
@param.instance
@param.plan
@param.file("--out", "Plan file to write, with the result in its notes.")
@unjudged_option
@force_options
@error_options
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    out: str | None,
    unjudged: bool,
    as_json: bool,
    quiet: bool,
    **asked: Any,
) -> int:
    """Fly the burns of PLAN in the dynamics of INSTANCE and measure how far each leg misses.

    Legs with an eccentric orbit are also flown on the true orbits, with retargeted burns. Exit
    status 1: a tank does not suffice for the flown burns, those of drift legs included.

    A refined plan is flown in true dynamics, by a different integrator from the one that made it.
    Exit status 1: an arrival misses by more than 1 m or 1 mm/s, or onto ephemerides by more than
    10 m or 1 cm/s, low thrust is on in the Earth's shadow, a leg is missing, or a tank does not
    suffice. With --samples it is flown again with burn and navigation errors and corrections. Exit
    status 1 also if a tank does not suffice for 95 % of those flights.

    With --forces full, a refined plan is flown in brahe with gravity to degree 20, drag, Sun, Moon
    and radiation pressure. The output states how far off each leg arrives uncorrected, and the cost
    of a correction in the last revolution. Exit status 1: a tank does not suffice for burns and
    corrections, a leg is missing, or no correction is found.
    """
    from ...plan.refined_plan import is_refined
    from . import fly_forces
    from .fly_refined import fly_and_tell

    check_out(out, instance_path)  # the plan itself may be written again, with a note more
    forces = param.taken(ForceOptions, asked)
    sampling = Sampling(**asked)
    forces.refuse_stray(sampling.samples)
    sampling.refuse_stray()
    read = (instance_path, plan_path, sampling.target_errors, *sampling.element_sets)
    check_out(sampling.out_uncertainty, *read, results=(out,))
    if is_refined(plan_path):
        from ...judge.admit import TANK

        refined = admitted_refined(instance_path, plan_path, unjudged=unjudged, excused=TANK)
        if unjudged:
            say_unjudged(refined, plan_path, quiet=quiet)
        if forces.is_full:
            return fly_forces.fly_and_tell(refined, plan_path, out, as_json, quiet, forces)
        return fly_and_tell(refined, plan_path, out, as_json, quiet, sampling)

    from ...fly.flight import fly
    from ...fly.flight.flyable import off_circles

    admitted = admitted_plan(instance_path, plan_path, unjudged=unjudged)
    say_unjudged(admitted, plan_path, quiet=quiet)
    sampling.refuse_unrefined(plan_path)
    forces.refuse_unrefined(plan_path)
    with about(plan_path):
        flight = fly(admitted.instance, admitted)
    if out is not None:
        annotated(admitted.plan, flight).save(out)
        say(f"wrote {out}", unless=quiet)
    if as_json:
        emit_json(flight.to_dict())
    else:
        _tell_misses(flight)
        emit(
            f"worst miss {flight.worst_miss_m:.2g} m over {counted(len(flight.legs), 'leg')} in "
            f"{MOTIONS[flight.dynamics]}"
        )
        if flight.drifts:
            emit(_drifts(flight))
        if flight.true_legs:
            emit("on the true orbits: " + _truth(flight))
        off = off_circles(admitted.instance, admitted.plan)
        if off is not None:
            emit(str(off))
        for chaser in flight.chasers:
            emit(str(chaser))
        emit(_tanks(flight))
    return 0 if flight.holds else 1


def annotated(plan: Plan, flight: Flight) -> Plan:
    """The plan with a note on its flight, replacing any earlier one."""
    note = f"{FLOWN[flight.dynamics]}worst miss {flight.worst_miss_m:.2g} m"
    if flight.drifts:
        note += f"; {_drifts(flight)}"
    if flight.true_legs:
        note += " between the planned circles; on the true orbits: " + _truth(flight)
    note += f"; {_tanks(flight)}"
    kept = tuple(other for other in plan.notes if not other.startswith(tuple(FLOWN.values())))
    return plan.replace(notes=(*kept, note))


def _truth(flight: Flight) -> str:
    legs = flight.true_legs
    planned = sum(leg.planned_delta_v_m_s for leg in legs)
    return (
        f"{counted(len(legs), 'leg')} planned with {planned:.1f} m/s, and flown with "
        f"{_or_unknown(flight.true_delta_v_m_s, '.1f')} m/s by retargeted burns"
    )


def _drifts(flight: Flight) -> str:
    """Planned and burnt ΔV of drift legs."""
    legs = flight.drifts
    planned = sum(leg.planned_delta_v_m_s for leg in legs)
    burned = sum(leg.burns_delta_v_m_s for leg in legs)
    return (
        f"{counted(len(legs), 'leg')} that drift{'s' if len(legs) == 1 else ''}, planned with "
        f"{planned:.1f} m/s, {'burns' if len(legs) == 1 else 'burn'} {burned:.1f} m/s"
    )


def _tanks(flight: Flight) -> str:
    return "; ".join(tanks_told(flight)) or "no tank is used"


def _tell_misses(flight: Flight) -> None:
    from .tables import emit_legs, whose

    columns: list[tuple[str, Callable[[LegFlight], str]]] = [
        ("miss\nm", lambda leg: f"{leg.miss_m:.2g}"),
        ("relative\nm/s", lambda leg: f"{leg.relative_speed_m_s:.2g}"),
        ("arrival\nmiss m", lambda leg: f"{leg.arrival_miss_m:.2g}"),
    ]
    if flight.dynamics == "j2":
        columns += [
            ("kind", lambda leg: leg.kind),
            ("planned\nm/s", lambda leg: f"{leg.planned_delta_v_m_s:.1f}"),
            ("burns\nm/s", lambda leg: f"{leg.burns_delta_v_m_s:.1f}"),
        ]
    if flight.true_legs:
        columns.append(("true\nm/s", _true_delta_v))
    emit_legs(flight.legs, columns, whose(flight.tanks))


def _true_delta_v(leg: LegFlight) -> str:
    return _or_unknown(leg.true_delta_v_m_s, ".1f") if leg.on_true_orbits else ""


def _or_unknown(value: float | None, form: str) -> str:
    return "unknown" if value is None else f"{value:{form}}"
