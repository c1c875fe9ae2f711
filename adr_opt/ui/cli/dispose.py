"""``dispose``: fates of a plan's objects and chasers, and compliance with licence rules."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from ...common.wording import counted
from . import param
from .output import emit_json, emit_rich, say, say_written
from .parameters import admitted_plan, check_outs

if TYPE_CHECKING:
    from ...analysis.disposal import Fate


@click.command("dispose", short_help="Report the fates of released objects and chasers.")
@param.instance
@param.plan
@param.number("--years", "YEARS", "Longest lifetime; by default the mission's, or 25.")
@param.number(
    "--uncontrolled",
    "KG",
    "Mass above which a re-entry has to be controlled; by default the mission's.",
    "most_uncontrolled_kg",
)
@param.number("--survives", "SHARE", "Share of a mass that reaches the ground; default 0.094.")
@param.number("--piece", "KG", "Mass of a surviving piece; default 20.5.", "piece_kg")
@param.number("--piece-area", "M2", "Area of a surviving piece; default 0.105.", "piece_m2")
@param.number("--fails", "SHARE", "Chance that a controlled re-entry fails; default 0.1.")
@param.number(
    "--kit-isp", "S", "Specific impulse of kits.", "kit_isp_s", default=220.0, show_default=True
)
@param.file("--out", "JSON file to write: all figures, with tracks.")
@param.page
@param.spoken
def command(
    instance_path: str,
    plan_path: str,
    years: float | None,
    most_uncontrolled_kg: float | None,
    survives: float | None,
    piece_kg: float | None,
    piece_m2: float | None,
    fails: float | None,
    kit_isp_s: float,
    out: str | None,
    page_path: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Report the fates of all objects that PLAN releases, and of all chasers.

    Exit status 1: a rule is not met.
    """
    from ...analysis.disposal import Debris, fates
    from ...common.files import to_text, write_text
    from ..report.disposal import disposal_page
    from ..report.plain import check_page, write_page
    from .tables import number_table

    check_outs((out, page_path), instance_path, plan_path)
    check_page(page_path)
    stated = {"survives": survives, "piece_kg": piece_kg, "piece_m2": piece_m2, "fails": fails}
    debris = Debris(**{name: value for name, value in stated.items() if value is not None})
    admitted = admitted_plan(instance_path, plan_path)
    found = fates(
        admitted.instance,
        admitted,
        years=years,
        most_uncontrolled_kg=most_uncontrolled_kg,
        debris=debris,
        kit_isp_s=kit_isp_s,
    )
    told = {
        "instance": admitted.instance.name,
        "debris": vars(debris),
        "fates": [fate.to_dict() for fate in found],
    }
    if out is not None:
        write_text(out, to_text(told))
    if page_path is not None:
        write_page(page_path, disposal_page(admitted.instance, found, debris))
    wrong = [fate for fate in found if not fate.meets]
    for fate in wrong:
        say(f"{fate.name!r}: {'; '.join(fate.broken)}", unless=quiet)
    met = counted(len(found) - len(wrong), "disposal")
    say(f"{met} of {len(found)} within all rules", unless=quiet)
    say_written(out, page_path, quiet=quiet)
    if as_json:
        emit_json(told)
    elif not quiet:
        headings = (
            *("by", "orbit [km]", "years, low", "mean", "high", "ΔV [m/s]", "propellant [kg]"),
            *("controlled", "casualties"),
        )
        rows = ((fate.name, *_texts(fate)) for fate in found)
        emit_rich(number_table("Disposals", headings, rows, first="object"))
    return 1 if wrong else 0


def _texts(fate: Fate) -> tuple[str, ...]:
    return (
        fate.how,
        f"{fate.perigee_m / 1e3:.0f} × {fate.apogee_m / 1e3:.0f}",
        *(f"{years:.3g}" for years in fate.lifetimes_years.values()),
        f"{fate.delta_v_m_s:.1f}",
        "" if fate.propellant_kg is None else f"{fate.propellant_kg:.1f}",
        "yes" if fate.controlled else "no",
        "" if fate.casualties is None else f"{fate.casualties:.1e}",
    )
