"""``refine``: turn a plan into a trajectory that holds in true dynamics."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from ...common.wording import counted
from .output import emit, emit_json, emit_rich, say, terminal_width
from .parameters import (
    check_out,
    cluster_option,
    instance_argument,
    json_option,
    plan_argument,
    quiet_option,
)
from .signals import signals_to

if TYPE_CHECKING:
    from rich.table import Table

    from ...fly.refine import RefinedPlan
    from ...plan.refined_plan import Freedom, Gravity

GRAVITIES = ("two-body", "j2", "j3", "j4")
FREEDOMS = ("free", "planned")

gravity_option = click.option(
    "--gravity",
    type=click.Choice(GRAVITIES),
    help="Field to fly in, with zonal harmonics up to this one; by default that of INSTANCE.",
)
freedom_option = click.option(
    "--burns",
    "freedom",
    type=click.Choice(FREEDOMS),
    help="free: least ΔV, at any times; planned: the plan's own, kept near what they were. By "
    "default free, and planned where there are keep-out zones.",
)


@click.command("refine", short_help="Lead the legs of PLAN to their stand-offs in true dynamics.")
@instance_argument
@plan_argument
@click.option("--out", required=True, metavar="FILE", help="Refined plan file to write.")
@gravity_option
@freedom_option
@click.option("--jobs", type=int, metavar="N", help="Cores to use; 0 for all.")
@cluster_option
@json_option
@quiet_option
def command(
    instance_path: str,
    plan_path: str,
    out: str,
    gravity: Gravity | None,
    freedom: Freedom | None,
    jobs: int | None,
    cluster: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Lead each leg of PLAN to its stand-off and its target in numerically integrated motion.

    Ctrl-C writes the legs that are done. Exit status 1: some leg is missing, because it was not
    reached in time or no trajectory was found.
    """
    from ...fly.refine import refine
    from ...plan.plan import load_plan
    from ...problem.instance import load
    from .leg_bar import leg_bar
    from .live import wanted

    check_out(out, instance_path, plan_path)
    instance, plan, stopped = load(instance_path), load_plan(plan_path), threading.Event()
    try:
        with signals_to(stopped.set), leg_bar(wanted(as_json, quiet), "refining") as show:
            refined = refine(
                instance, plan, gravity=gravity, freedom=freedom, jobs=jobs, cluster=cluster,
                enough=stopped.is_set, report=show,
            )  # fmt: skip
    except InputError as error:
        raise InputError(f"{plan_path}: {error}") from None
    refined.save(out)
    if not quiet:
        say(f"wrote {out}: {counted(len(refined.legs), 'leg')}, {refined.status}")
    if as_json:
        emit_json(_told(refined, out))
    else:
        if refined.legs:
            emit_rich(*_tables(refined, terminal_width()))
        for sentence in _by_chaser(refined):
            emit(sentence)
        emit(_summary(refined))
        for missing in refined.missing:
            emit(f"leg {missing.leg} is missing: {missing.reason}")
    return 1 if refined.missing else 0


def _summary(refined: RefinedPlan) -> str:
    planned, flown = refined.planned_delta_v_m_s, refined.flown_delta_v_m_s
    own = refined.retargeted_delta_v_m_s
    kept = f", and {own:.1f} m/s with the plan's own burns" if _is_free(refined) else ""
    return (
        f"{counted(len(refined.legs), 'leg')} in the field {refined.gravity}: planned with "
        f"{planned:.1f} m/s, flown with {flown:.1f} m/s{kept}"
    )


def _is_free(refined: RefinedPlan) -> bool:
    return refined.freedom == "free"


def _by_chaser(refined: RefinedPlan) -> Iterator[str]:
    """What the legs of each of several chasers take."""
    for chaser in dict.fromkeys(leg.chaser for leg in refined.legs if leg.chaser is not None):
        legs = [leg for leg in refined.legs if leg.chaser == chaser]
        yield (
            f"{chaser}: {counted(len(legs), 'leg')}, planned with "
            f"{sum(leg.planned_delta_v_m_s + leg.removal_m_s for leg in legs):.1f} m/s, flown with "
            f"{sum(leg.flown_delta_v_m_s + leg.removal_m_s for leg in legs):.1f} m/s"
        )


def _tables(refined: RefinedPlan, width: int | None) -> list[Table]:
    from .tables import Row, leg_tables

    towed = any(leg.removal_m_s for leg in refined.legs)
    tow = ["tow\nm/s"] if towed else []
    headings = ["kind", "planned\nm/s", "own burns\nm/s", "flown\nm/s", *tow, "burns", "lowest\nkm"]
    rows = [
        Row(
            leg.leg,
            leg.origin,
            leg.destination,
            [
                leg.kind,
                f"{leg.planned_delta_v_m_s:.1f}",
                f"{leg.retargeted_delta_v_m_s:.1f}",
                f"{leg.flown_delta_v_m_s:.1f}",
                *([f"{leg.removal_m_s:.1f}"] if towed else []),
                str(len(leg.burns)),
                f"{leg.lowest_altitude_m / 1e3:.0f}",
            ],
        )
        for leg in refined.legs
    ]
    whose = {leg.leg: leg.chaser for leg in refined.legs if leg.chaser is not None}
    return leg_tables(headings, rows, width, whose)


def _told(refined: RefinedPlan, out: str) -> dict[str, object]:
    legs = [leg.model_dump(mode="json", exclude={"burns", "states"}) for leg in refined.legs]
    return {
        "path": out,
        "gravity": refined.gravity,
        "burns": refined.freedom,
        "status": refined.status,
        "runtime_s": refined.runtime_s,
        "planned_delta_v_m_s": refined.planned_delta_v_m_s,
        "flown_delta_v_m_s": refined.flown_delta_v_m_s,
        "missing": [missing.model_dump() for missing in refined.missing],
        "legs": legs,
    }
