"""``fly``: fly a plan in two-body motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ..errors import InputError, MissingExtra
from .output import emit, emit_json, emit_rich, say
from .parameters import check_out, instance_argument, json_option, plan_argument

if TYPE_CHECKING:
    from rich.table import Table

    from ..flight import Flight
    from ..plan import Plan

FLOWN = "flown in two-body motion: "
"""How the note begins that ``--out`` puts into a plan, so that the next one takes its place."""


@click.command("fly", short_help="Fly the burns of PLAN and measure the misses.")
@instance_argument
@plan_argument
@click.option("--out", metavar="FILE", help="Write the plan again with the result in its notes.")
@json_option
def command(instance_path: str, plan_path: str, out: str | None, as_json: bool) -> int:
    """Fly the burns of PLAN in two-body motion and measure how far each leg misses.

    Legs with an eccentric orbit are flown on the true orbits as well, and a corrected last arc is
    solved for: a Lambert arc to the true stand-off.
    """
    from ..flight import fly
    from ..instance import load
    from ..plan import load_plan

    check_out(out, instance_path)
    instance, plan = load(instance_path), load_plan(plan_path)
    try:
        flight = fly(instance, plan)
    except MissingExtra:
        raise
    except InputError as error:
        raise InputError(f"{plan_path}: {error}") from None
    if out is not None:
        annotated(plan, flight).save(out)
        say(f"wrote {out}")
    if as_json:
        emit_json(flight.to_dict())
        return 0
    emit_rich(_misses(flight))
    emit(f"worst miss {flight.worst_miss_m:.2g} m over {len(flight.legs)} legs")
    if flight.eccentric:
        emit_rich(_eccentric(flight))
        emit("on the true orbits: " + _truth(flight))
    return 0


def annotated(plan: Plan, flight: Flight) -> Plan:
    """The plan with a note of what its flight measured, in place of such a note from before."""
    note = f"{FLOWN}worst miss {flight.worst_miss_m:.2g} m"
    if flight.eccentric:
        note += " between the circles planned with; on the true orbits " + _truth(flight)
    kept = tuple(other for other in plan.notes if not other.startswith(FLOWN))
    return plan.replace(notes=(*kept, note))


def _truth(flight: Flight) -> str:
    return (
        f"worst miss {_or_unknown(flight.worst_true_miss_m, '.4g')} m, and corrected last arcs "
        f"cost {_or_unknown(flight.correction_delta_v_m_s, '.2f')} m/s beyond the burns of the "
        f"plan, which sets {flight.eccentricity_delta_v_m_s:.2f} m/s aside for it"
    )


def _misses(flight: Flight) -> Table:
    from rich.text import Text

    table = _table("leg", "origin → destination", "miss m", "relative m/s", "arrival miss m")
    for leg in flight.legs:
        table.add_row(
            str(leg.leg),
            Text(f"{leg.origin} → {leg.destination}"),
            f"{leg.miss_m:.2g}",
            f"{leg.relative_speed_m_s:.2g}",
            f"{leg.arrival_miss_m:.2g}",
        )
    return table


def _eccentric(flight: Flight) -> Table:
    from rich.text import Text

    table = _table(
        "leg",
        "origin → destination",
        "true miss\nm",
        "set aside\nm/s",
        "correction\nm/s",
        "last arc\nm/s",
        "Lambert arc\nm/s",
    )
    for leg in flight.legs:
        true = leg.eccentric
        if true is not None:
            table.add_row(
                str(leg.leg),
                Text(f"{leg.origin} → {leg.destination}"),
                _or_unknown(true.true_miss_m, ".4g"),
                f"{true.eccentricity_delta_v_m_s:.2f}",
                _or_unknown(true.correction_delta_v_m_s, ".2f"),
                f"{true.last_arc_delta_v_m_s:.2f}",
                _or_unknown(true.lambert_delta_v_m_s, ".2f"),
            )
    return table


def _table(*headings: str) -> Table:
    from rich.table import Table

    table = Table()
    for heading in headings:
        table.add_column(heading, justify="left" if "→" in heading else "right", no_wrap=True)
    return table


def _or_unknown(value: float | None, form: str) -> str:
    return "unknown" if value is None else f"{value:{form}}"
