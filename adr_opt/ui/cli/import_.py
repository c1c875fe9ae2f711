"""``import``: make an instance from a catalogue of real objects."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit_json, say, say_doubts
from .param import fitting_options
from .parameters import check_out

if TYPE_CHECKING:
    from ...problem.instance import Instance
    from ...problem.orbit import Orbit
    from ...sources.catalogue import Imported
    from ...sources.ephemerides.imported import WithEphemerides


crew_options = param.together(
    fitting_options("default 3000"),
    param.count("--launches", "N", "Launch N chasers, each to its first target."),
    param.number(
        "--launch-every", "DAYS", "Interval between launches; default 365; 0 for a shared rocket."
    ),
    param.number(
        "--launch-separation",
        "DAYS",
        "Least interval between launches, whose times are then optimised.",
    ),
    param.word("--launch-into", "KM,DEG", "Altitude and inclination of the launch orbit."),
    param.word("--launcher", "KM=KG,...", "Mass lifted to each altitude, with kits."),
    param.number("--end-of-life", "M_S", "ΔV kept by each for its own disposal; no default."),
    param.word(
        "--expense",
        "FIXED[,PER_KG[,PER_KG2]]",
        "Cost of each chaser used; the least total decides between equal plans.",
    ),
    param.number("--thrust", "N", "Low thrust of each chaser, in place of impulses."),
    param.number("--duty-cycle", "SHARE", "Share of the time with thrust on; default 1."),
    param.number(
        "--service-days", "D", "Duration of each service; by default one revolution of the target."
    ),
    param.many(
        "--deadline", "OBJECT=DAYS", "Latest end of a service; repeatable.", name="deadlines"
    ),
    param.many(
        "--require",
        "OBJECT",
        "Object that must be serviced; an error if filters omit it; repeatable.",
        name="required",
    ),
    param.many(
        "--must", "OBJECT[,OBJECT...]", "Required objects, regardless of filters.", name="musts"
    ),
    param.many(
        "--exclude", "OBJECT[,OBJECT...]", "Objects to exclude; repeatable.", name="excluded"
    ),
    param.file(
        "--prizes",
        "CSV: object, prize, required, window, mass, removal, prize_until.",
        name="prizes_path",
    ),
)
"""The options of chasers and of single objects, for ``import``."""


def told(instance: Instance) -> str | None:
    """A sentence on the launches of an instance; None if there are none."""
    every = zip(instance.chasers, instance.available_s, strict=True)
    since_s = [since for chaser, (since, _) in every if chaser.awaits_launch]
    days = ", ".join(f"{each / DAY_S:g}" for each in since_s)
    return f"{counted(len(since_s), 'launch', 'launches')}, on day {days}" if since_s else None


MOST_LISTED = 20
"""Maximum number of bad rows listed on standard error; --json lists all."""

FILTERS = ("name", "exclude", "only-prized", "altitude", "inclination", "raan", "max-targets")
"""Reasons due to user-requested filters, which are counted but not listed."""


@click.command("import", short_help="Make an instance from catalogue files (TLE, OMM).")
@param.files
@param.file("--out", "Instance file to write.", required=True)
@param.word("--epoch", "TIME", "Epoch (ISO, UTC); by default the latest of the elements.")
@param.word("--altitude", "LO:HI", "Mean altitudes to keep [km].")
@param.word("--inclination", "LO:HI", "Inclinations to keep [deg].")
@param.word("--raan", "LO:HI", "RAANs to keep [deg]; 350:10 goes through 0.")
@param.many("--name", "PATTERN", "Names to keep; repeatable.", name="names")
@param.count("--max-targets", "N", "Maximum number of targets; nearest planes first.")
@param.word(
    "--station",
    "ORBIT|OBJECT",
    "ALTITUDE_KM,INCLINATION,RAAN[,U], or an object; by default the densest plane.",
)
@param.number("--duration-days", "D", "Mission duration.", default=7.0, show_default=True)
@crew_options
@param.choice(
    "--dynamics",
    ("j2", "two-body"),
    "Motion of planes; with j2 they drift.",
    default="j2",
    show_default=True,
)
@param.flag("--no-refuelling", "No station; the chaser starts where it would be.")
@param.number(
    "--drift-step-days", "D", "Time step of long transfers; by default 1/150 of the mission."
)
@param.number(
    "--max-drift-days",
    "D",
    "Maximum duration of long transfers, 0 for none; by default the mission's.",
)
@param.number("--departure-spacing-days", "D", "Least time between departures.")
@param.number("--resolution", "M_S", "Least ΔV saving of a transfer to be kept.")
@param.burns
@param.approach
@param.keep_out
@param.flag("--only-prized", "Only objects with a row in --prizes.")
@param.flag("--criticality", "Prizes from 1 to 100, ranked by mass, altitude and crowding.")
@param.flag("--ephemerides", "Keep element sets beside the instance; fit orbits to their states.")
@param.many(
    "--oem",
    "FILE",
    "Ephemerides of targets: CCSDS OEM, STK or Modified ITC; repeatable.",
    name="messages",
)
@param.flag("--skip-bad", "Skip bad rows and objects, and list them.")
@param.spoken
def command(
    files: tuple[str, ...],
    out: str,
    altitude: str | None,
    inclination: str | None,
    raan: str | None,
    names: tuple[str, ...],
    max_targets: int | None,
    station: str | None,
    only_prized: bool,
    criticality: bool,
    ephemerides: bool,
    messages: tuple[str, ...],
    skip_bad: bool,
    as_json: bool,
    quiet: bool,
    **given: Any,
) -> int:
    """Make an instance from the objects in FILE..., propagated by SGP4 to one epoch.

    Formats are recognised by content: TLE, three-line sets, and OMM as XML, KVN, JSON or CSV.
    Orbits are mean elements in TEME; with --ephemerides or --oem, those that fit the states best.
    """
    from ...common.files import write_text
    from ...sources import catalogue
    from ...sources.catalogue.filters import parse_range
    from ...sources.crew_options import CrewOptions
    from ...sources.mission_options import MissionOptions, check_objects, naming_options
    from .bars import busy_bar, wanted

    check_out(out, *files, *messages, given["prizes_path"])
    check_objects(names, max_targets)
    options = param.taken(MissionOptions, given)
    crew_asked = CrewOptions.of(given)
    with naming_options():
        crew = crew_asked.crew()
    if only_prized and crew_asked.prizes_path is None:
        raise InputError("--only-prized: there are no rows without --prizes; give a file")
    demands = replace(crew_asked.demands(), by_criticality=criticality, only_wished=only_prized)
    filters = catalogue.Filters(
        altitude_km=None if altitude is None else parse_range(altitude, "--altitude"),
        inclination_deg=None if inclination is None else parse_range(inclination, "--inclination"),
        raan_deg=None if raan is None else parse_range(raan, "--raan", open_ended=False),
        names=names,
    )
    fitted_by = "--oem" if messages else "--ephemerides" if ephemerides else None
    mission = options.outline(thrust=crew.thrust_n is not None, fitted_by=fitted_by)
    with naming_options(), busy_bar(wanted(as_json, quiet), "reading objects"):
        found = catalogue.read(files, skip_bad=skip_bad)
        made = catalogue.to_instance(
            found,
            filters=filters,
            max_targets=max_targets,
            station=station,
            skip_bad=skip_bad,
            mission=mission,
            crew=crew,
            demands=demands,
        )
    if not (ephemerides or messages):
        write_text(out, made.instance.to_json())
        if as_json:
            emit_json({"path": out, "formats": found.formats, **made.to_dict()})
        if not quiet:
            _tell(made, out)
        return 0
    from ...sources.ephemerides.imported import with_ephemerides

    with busy_bar(wanted(as_json, quiet), "fitting orbits"):
        fitted = with_ephemerides(made, out, messages)
    fitted.write(out)
    if as_json:
        emit_json({"path": out, "formats": found.formats, **fitted.to_dict()})
    if not quiet:
        _tell(fitted.imported, out, fitted)
    return 0


def _tell(made: Imported, out: str, fitted: WithEphemerides | None = None) -> None:
    from ...sources.mission_options import by_option

    bad = [drop for drop in made.dropped if drop.reason not in FILTERS]
    for drop in bad[:MOST_LISTED]:
        say(f"left out: {drop}")
    if len(bad) > MOST_LISTED:
        more = counted(len(bad) - MOST_LISTED, "more bad row or object", "more bad rows or objects")
        say(f"left out: {more}; --json lists all")
    for warning in made.warnings:
        say(f"warning: {warning}")
    say_doubts(made.instance, reword=by_option)
    from ...problem.transfer_sizes import told as transfers_told

    listed = ", ".join(f"{reason} {count}" for reason, count in made.counts.items())
    instance = made.instance
    count = len(instance.targets)
    taken = f"{count} of {counted(made.read, 'object')} as target{'' if count == 1 else 's'}"
    say(
        f"wrote {out}: {instance.name}, {taken}, "
        f"mean elements ({'SGP4' if fitted is None else 'fitted'}, TEME) at "
        f"{instance.epoch:%Y-%m-%dT%H:%M:%SZ}"
    )
    if fitted is not None:
        from ...sources.ephemerides.left_over import told as left_told

        say(f"ephemerides beside it: {', '.join(fitted.contents)}")
        say(left_told(fitted.left))
    left_out = f"left out: {listed or 'nothing'}"
    placed = f"start {made.station}" if made.home is None else _placed(made, made.home)
    say(f"{placed}; {left_out}")
    launches = told(instance)
    if launches is not None:
        say(launches)
    say(f"dynamics {instance.dynamics}: {transfers_told(instance.transfer)}")


def _placed(made: Imported, orbit: Orbit) -> str:
    """Position of the station, or of the chaser's start."""
    altitude_km = (orbit.semi_major_axis_m - EARTH_RADIUS_M) / 1e3
    return (
        f"{'station' if made.instance.stations else 'start'} {made.station}: altitude "
        f"{altitude_km:.1f} km, inclination {orbit.inclination_deg:.3f}°, "
        f"RAAN {orbit.raan_deg:.3f}°"
    )
