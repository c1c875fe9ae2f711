"""``scenario``: decades of campaigns in an environment that decays and breaks up."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit_json, emit_rich, say, say_written
from .parameters import check_outs

if TYPE_CHECKING:
    from rich.table import Table

    from ...analysis.scenario.settings import AltitudeShells

ROWS = 11
"""Maximum number of years in the printed table."""


@click.command("scenario", short_help="Simulate decades of campaigns, with removals and without.")
@param.files
@param.file("--campaign", "Instance of a campaign, repeated on objects in orbit.", "campaign_path")
@click.option("--years", type=int, default=30, show_default=True, help="Years, at most 200.")
@param.count(
    "--every", "YEARS", "Years from one campaign to the next.", default=1, show_default=True
)
@param.count("--targets", "N", "Objects offered to each campaign.", default=20, show_default=True)
@param.word("--altitude", "LO:HI", "Mean altitudes of targets [km].")
@param.word("--inclination", "LO:HI", "Inclinations of targets [deg].")
@param.number(
    "--worth-years", "YEARS", "Horizon of the worth of targets.", default=50.0, show_default=True
)
@param.number("--campaign-failure", "P", "Chance that a campaign is lost at launch.", default=0.0)
@param.number("--capture-failure", "P", "Chance that a capture fails.", default=0.0)
@param.number("--explosions", "P", "Yearly chance that an intact object explodes.", default=0.0)
@param.flag("--no-collisions", "Draw no collisions; report their rates only.")
@param.flag("--no-drag", "No drag: no object re-enters.")
@param.file("--launches", "CSV of objects launched later; see docs/scenarios.md.", "launches_path")
@param.count("--seeds", "N", "Number of futures drawn.", default=1, show_default=True)
@param.satcat
@param.measures
@param.activity
@param.exclude
@param.method
@param.time_limit("Wall-clock limit of each planning.", default=5.0, show_default=True)
@param.word(
    "--shells", "LO:HI:N", "Altitude shells [km].", default="200:2000:36", show_default=True
)
@param.many("--species", "KIND=NAME", "Name of a species in --removals; repeatable.")
@param.word("--folder", "DIR", "Folder for a file of all years, to resume from.")
@param.file("--out", "CSV file of objects by year, case, species and shell.")
@param.file("--removals", "CSV file of removals by year, species and shell.", "removals_path")
@param.page
@param.count("--jobs", "N", "Number of processes, a seed in each; 0 for all cores.", default=1)
@param.skip_bad
@param.spoken
def command(
    files: tuple[str, ...],
    campaign_path: str | None,
    years: int,
    every: int,
    targets: int,
    altitude: str | None,
    inclination: str | None,
    worth_years: float,
    campaign_failure: float,
    capture_failure: float,
    explosions: float,
    no_collisions: bool,
    no_drag: bool,
    launches_path: str | None,
    seeds: int,
    satcat_path: str | None,
    table_path: str | None,
    activity: str,
    exclude: tuple[str, ...],
    method: str | None,
    time_limit: float,
    shells: str,
    species: tuple[str, ...],
    folder: str | None,
    out: str | None,
    removals_path: str | None,
    page_path: str | None,
    jobs: int,
    skip_bad: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Draw the future of the objects in FILE..., with repeated campaigns and without.

    Each campaign is planned on what is there that year: decayed, broken up, launched, not yet
    removed. Both futures share their draws. With --folder, an interrupted run
    resumes.
    """
    from ...analysis.scenario.answer import outside, removals_csv, scenario_answer, yearly_csv
    from ...analysis.scenario.launches import read_launches
    from ...analysis.scenario.settings import ScenarioSettings
    from ...analysis.scenario.study import scenario
    from ...common.files import write_text
    from ...problem.instance import load
    from ...run.front import DEFAULT_METHOD
    from ...sources import catalogue, worth
    from ..report.plain import check_page, write_page
    from ..report.scenario import scenario_page
    from .bars import counting_bar, wanted
    from .worth import measured_bodies

    read = (*files, satcat_path, table_path, campaign_path, launches_path)
    results = (out, removals_path, page_path)
    check_outs(results, *read)
    check_page(page_path)
    if any(not pattern.strip() for pattern in exclude):
        raise InputError("--exclude '': give a part of a name or a pattern")
    settings = ScenarioSettings(
        years=years,
        every=every,
        seeds=seeds,
        targets=targets,
        worth_years=worth_years,
        activity=activity,
        drag=not no_drag,
        collisions=not no_collisions,
        explosions=explosions,
        capture_failure=capture_failure,
        campaign_failure=campaign_failure,
        method=method or DEFAULT_METHOD,
        time_limit_s=time_limit,
        altitude_km=_range(altitude, "--altitude", 1e6),
        inclination_deg=_range(inclination, "--inclination", 180.0),
        shells=parse_shells(shells),
    )
    names = parse_species(species)
    template = None if campaign_path is None else load(campaign_path)
    launches = () if launches_path is None else read_launches(launches_path)
    satcat = None if satcat_path is None else worth.read_satcat(satcat_path)
    found = catalogue.read(files, skip_bad=skip_bad)
    bodies, notes = measured_bodies(found.records, satcat, satcat_path, table_path, exclude)
    with counting_bar(wanted(as_json, quiet), "years") as show:
        made = scenario(
            bodies, template, settings, launches=launches, folder=folder, jobs=jobs, show=show
        )
    told = scenario_answer(made) | {"removed_outside_shells": outside(made)}
    page = None if page_path is None else scenario_page(made, told)
    if out is not None:
        write_text(out, yearly_csv(made))
    if removals_path is not None:
        write_text(removals_path, removals_csv(made, names))
    if page_path is not None and page is not None:
        write_page(page_path, page)
    for note in notes:
        say(note, unless=quiet)
    say_written(*results, quiet=quiet)
    if as_json:
        emit_json(told)
    else:
        _tell(told, quiet)
        emit_rich(_table(told))
    return 0


def _range(text: str | None, option: str, most: float) -> tuple[float, float] | None:
    """Two numbers given as ``LO:HI``, between 0 and a plausible maximum."""
    from ...sources.catalogue.filters import parse_range

    if text is None:
        return None
    low, high = parse_range(text, option)
    if low > high:
        raise InputError(f"{option} {text!r}: the range is empty; give the lower number first")
    return max(low, 0.0), min(high, most)


def parse_shells(text: str) -> AltitudeShells:
    """Altitude shells given as ``LO:HI:N``.

    Raises
    ------
    InputError
        They are not.
    """
    from ...analysis.scenario.settings import AltitudeShells

    try:
        low, high, number = text.split(":")
        ends, count = (float(low), float(high)), int(number)
    except ValueError:
        raise InputError(
            f"--shells {text!r}: give two altitudes in km and a number, as 200:2000:36"
        ) from None
    return AltitudeShells(*ends, count)


def parse_species(texts: Iterable[str]) -> dict[str, str]:
    """Names of species given as ``KIND=NAME``, and the usual ones.

    Raises
    ------
    InputError
        One is not of that form, or of an unknown kind.
    """
    from ...analysis.scenario.answer import SPECIES

    names = dict(SPECIES)
    for text in texts:
        kind, sign, name = (part.strip() for part in text.partition("="))
        if not sign or not name or kind not in names:
            raise InputError(
                f"--species {text!r}: give KIND=NAME, with one of the kinds {', '.join(names)}"
            )
        names[kind] = name
    return names


def _tell(told: dict[str, Any], quiet: bool) -> None:
    left = ", ".join(f"{reason} {count}" for reason, count in told["left_out"].items())
    say(
        f"{counted(told['objects'], 'object')} on {told['epoch'][:10]}; left out: "
        f"{left or 'nothing'}",
        unless=quiet,
    )
    flown = sum(each["flown"] for each in told["campaigns"])
    if flown:
        sums = {
            name: sum(each[name] for each in told["campaigns"])
            for name in ("captured", "missed", "failed", "replanned")
        }
        say(
            f"{counted(flown, 'campaign')}, {sums['failed']} lost at launch: "
            f"{counted(sums['captured'], 'object')} captured, {sums['missed']} missed, "
            f"planned anew {counted(sums['replanned'], 'time')}",
            unless=quiet,
        )
    if told["removed_outside_shells"]:
        say(
            f"{counted(told['removed_outside_shells'], 'removal')} outside all shells, not in any "
            "row of --removals",
            unless=quiet,
        )


def _table(told: dict[str, Any]) -> Table:
    from .tables import number_table

    years = told["years"]
    step = math.ceil((len(years) - 1) / (ROWS - 1))
    shown = sorted({*years[::step], years[-1]})
    headings = (
        "year",
        "objects without",
        "with",
        "fragments without",
        "with",
        "catastrophic a year without",
        "with",
        "removed",
    )
    removed = told["with"]["removed"]["mean"]
    rows = (
        (
            str(year),
            *(
                form.format(told[case][name]["mean"][year])
                for name, form in (
                    ("objects", "{:.1f}"),
                    ("fragments", "{:.1f}"),
                    ("catastrophic", "{:.3g}"),
                )
                for case in ("without", "with")
            ),
            f"{sum(removed[:year]):.1f}",
        )
        for year in shown
    )
    seeds = told["settings"]["seeds"]
    return number_table(f"means of {counted(seeds, 'future')}", headings, rows)
