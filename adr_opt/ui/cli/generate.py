"""``generate``: draw an instance of a family."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from ...common.wording import counted
from . import complete, param
from .output import emit, say
from .param import fitting_options
from .parameters import check_out

if TYPE_CHECKING:
    from ...problem.settings import ApproachName, BurnsName


@click.command("generate", short_help="Draw an instance of a family.")
@click.argument("family", shell_complete=complete.families)
@param.seeded("Seed; equal seeds draw equal files.")
@param.count("--targets", "N", "Number of targets; by default the family's.")
@param.count("--zones", "N", "Number of keep-out zones.", default=0)
@param.count("--chasers", "N", "Number of chasers; by default the family's.")
@param.count("--stations", "M", "Number of stations; by default the family's.")
@fitting_options("by default the family's")
@param.burns
@param.approach
@param.keep_out
@param.file("--out", "Instance file to write; by default it is printed.")
@param.spoken
def command(
    family: str,
    seed: int,
    targets: int | None,
    zones: int,
    chasers: int | None,
    stations: int | None,
    burns: BurnsName | None,
    approach: ApproachName | None,
    keep_out: float | None,
    out: str | None,
    as_json: bool,
    quiet: bool,
    **fitting_given: Any,
) -> int:
    """Draw an instance of FAMILY.

    FAMILY is tiny, nominal, reduced-time, reduced-fuel, campaign, cloud, large, sso,
    rocket-bodies, removal, electric or fragment-cloud. With other tanks, kits, tows or transfers
    the same field is drawn, and its name ends in -fitted.
    """
    from ...common.files import write_text
    from ...problem.chasers import TankByMass
    from ...sources.crew_options import Fitting
    from ...sources.generator import family as family_named
    from ...sources.generator import generate

    check_out(out)
    fitting, kind = Fitting(**fitting_given), family_named(family)
    usual = None if kind.draw_chaser is None else kind.draw_chaser(0)
    fitting.check(
        kits=usual is not None and usual.kits is not None,
        by_mass=usual is not None and isinstance(usual.tank, TankByMass),
    )
    instance = generate(
        family,
        seed,
        targets=targets,
        zones=zones,
        chasers=chasers,
        stations=stations,
        tank=fitting.tank(),
        kits=fitting.kits,
        kit_mass_kg=fitting.kit_mass,
        kit_isp_s=fitting.kit_isp,
        towed_kg=fitting.tow,
        disposal=fitting.disposal,
        max_lifetime_years=fitting.max_lifetime,
        max_uncontrolled_kg=fitting.max_uncontrolled,
        burns=burns,
        approach=approach,
        keep_out_m=keep_out,
    )
    text = instance.to_json()
    if out is not None:
        write_text(out, text)
        count = counted(len(instance.targets), "target")
        say(f"wrote {out}: {instance.name}, {count}", unless=quiet)
    if out is None or as_json:
        emit(text)
    return 0
