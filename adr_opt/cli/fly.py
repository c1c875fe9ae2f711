"""``fly``: fly a plan in two-body motion."""

from __future__ import annotations

import click

from ..errors import InputError, MissingExtra
from .output import emit, emit_json, emit_rich
from .parameters import instance_argument, json_option, plan_argument


@click.command("fly", short_help="Fly the burns of PLAN and measure the misses.")
@instance_argument
@plan_argument
@json_option
def command(instance_path: str, plan_path: str, as_json: bool) -> int:
    """Fly the burns of PLAN in two-body motion and measure how far each leg misses."""
    from ..flight import fly
    from ..instance import load
    from ..plan import load_plan

    instance, plan = load(instance_path), load_plan(plan_path)
    try:
        flight = fly(instance, plan)
    except MissingExtra:
        raise
    except InputError as error:
        raise InputError(f"{plan_path}: {error}") from None
    if as_json:
        emit_json(flight.to_dict())
        return 0
    from rich.table import Table
    from rich.text import Text

    table = Table()
    for heading in ("leg", "origin → destination", "miss m", "relative m/s", "arrival miss m"):
        table.add_column(heading, justify="left" if "→" in heading else "right", no_wrap=True)
    for leg in flight.legs:
        table.add_row(
            str(leg.leg),
            Text(f"{leg.origin} → {leg.destination}"),
            f"{leg.miss_m:.2g}",
            f"{leg.relative_speed_m_s:.2g}",
            f"{leg.arrival_miss_m:.2g}",
        )
    emit_rich(table)
    emit(f"worst miss {flight.worst_miss_m:.2g} m over {len(flight.legs)} legs")
    return 0
