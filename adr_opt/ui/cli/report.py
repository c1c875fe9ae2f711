"""``report``: a mission as one HTML page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ...common.errors import InputError, MissingExtra
from ...common.wording import counted
from . import param
from .output import emit_json, say
from .parameters import about, admitted_plan, check_out

if TYPE_CHECKING:
    from ...fly.flight import Flight, RefinedFlight
    from ...judge.admit import Admitted
    from ...plan.plan import Plan
    from ...plan.refined_plan import RefinedPlan


@click.command("report", short_help="Write PLAN as an interactive page that works offline.")
@param.instance
@param.plan
@param.file("--out", "HTML file to write.", required=True)
@param.file(
    "--refined",
    "Refined version of PLAN; flown ΔV is shown beside planned ΔV.",
    name="refined_path",
)
@param.flag(
    "--fly",
    "Fly PLAN, and its refined version, as 'fly' does, and show the miss of each leg ([astro]).",
    name="wants_flight",
)
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    out: str,
    refined_path: str | None,
    wants_flight: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Write PLAN on INSTANCE as one self-contained HTML page: charts, tables, bound and gap.

    A plan with violations is reported too: they head the page and are counted in the output. So are
    tanks that break when flown, on the true orbits or under J2; with --refined, only those that
    break with the refined legs. Exit status 1: there are such tanks, or the refined plan lacks a
    leg or, with --fly, misses.
    """
    from ...judge.admit import admit
    from ...plan.refined_plan import RefinedPlan
    from ..report import write_report

    admitted = admitted_plan(instance_path, plan_path, unjudged=True)
    instance, plan, refined = admitted.instance, admitted.plan, None
    if refined_path is not None:
        refined_plan = RefinedPlan.load(refined_path)
        with about(refined_path):
            refined = admit(instance, refined_plan, refined_from=plan)
    check_out(out, instance_path, plan_path, refined_path)
    if not out.lower().endswith((".html", ".htm")):
        raise InputError(f"{out}: the page is HTML; give a file that ends in .html")
    flight, refined_flight = None, None
    try:
        if wants_flight:
            flight, refined_flight = _flown(admitted, refined)
        written = write_report(
            instance, admitted, out, refined, flight=flight, refined_flight=refined_flight
        )
    except MissingExtra:
        raise
    except InputError as error:
        said = str(error)
        raise InputError(said if said.startswith(f"{out}: ") else f"{plan_path}: {said}") from None
    # Those of a refined plan that break are among its complaints.
    flown = () if refined is not None else written.tanks or ()
    broken = [tank for tank in flown if not tank.holds]
    if as_json:
        tanks = None if written.tanks is None else [tank.to_dict() for tank in written.tanks]
        emit_json(
            {
                "instance": instance.name,
                "path": written.path,
                "bytes": written.size_bytes,
                "legs": len(plan.legs),
                "objective": plan.objective,
                "violations": [violation.to_dict() for violation in written.violations],
                "tanks": tanks,
                "trouble": written.trouble,
                "refined": None if refined is None else list(written.complaints),
            }
        )
    if not quiet:
        legs = counted(len(plan.legs), "leg")
        say(f"wrote {out}: {legs}, {written.size_bytes / 1e6:.2f} MB")
        if count := len(written.violations):
            say(
                f"{plan_path}: the plan has {counted(count, 'violation')}; "
                f"the page begins with {'them' if count > 1 else 'it'}"
            )
        for tank in broken:
            where = "when flown" if instance.nodes_drift else "on the true orbits"
            say(f"{plan_path}: {where} {tank}")
        for complaint in written.complaints:
            say(f"{refined_path}: {complaint}")
    return 1 if broken or written.complaints else 0


def _flown(
    admitted: Admitted[Plan], refined: Admitted[RefinedPlan] | None
) -> tuple[Flight | None, RefinedFlight | None]:
    """Flight of a plan, and of its refined version by another integrator.

    Plans of low thrust have no burns: where there is a refined one it is flown alone.
    """
    from ...fly.flight import fly, fly_refined

    instance = admitted.instance
    refined_flight = None if refined is None else fly_refined(instance, refined)
    if refined is not None and instance.has_low_thrust:
        return None, refined_flight
    return fly(instance, admitted), refined_flight
