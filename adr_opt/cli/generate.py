"""``generate``: draw an instance of a family."""

from __future__ import annotations

import click

from ..wording import counted
from .output import emit, say
from .parameters import check_out, json_option, quiet_option


@click.command("generate", short_help="Draw an instance of a family.")
@click.argument("family")
@click.option("--seed", type=int, default=0, show_default=True, help="Same seed, same file.")
@click.option("--targets", type=int, metavar="N", help="Targets, instead of the family's.")
@click.option("--zones", type=int, default=0, metavar="N", help="Keep-out zones to draw.")
@click.option("--chasers", type=int, metavar="N", help="Chasers, instead of the family's.")
@click.option("--stations", type=int, metavar="M", help="Stations, instead of the family's.")
@click.option("--out", metavar="FILE", help="Instance file to write; else it is printed.")
@json_option
@quiet_option
def command(
    family: str,
    seed: int,
    targets: int | None,
    zones: int,
    chasers: int | None,
    stations: int | None,
    out: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Draw an instance of FAMILY.

    One of tiny, nominal, reduced-time, reduced-fuel, campaign, cloud, large,
    sso, rocket-bodies, removal and fragment-cloud.
    """
    from ..files import write_text
    from ..generator import generate

    check_out(out)
    instance = generate(
        family, seed, targets=targets, zones=zones, chasers=chasers, stations=stations
    )
    text = instance.to_json()
    if out is not None:
        write_text(out, text)
        if not quiet:
            count = counted(len(instance.targets), "target")
            say(f"wrote {out}: {instance.name}, {count}")
    if out is None or as_json:
        emit(text)
    return 0
