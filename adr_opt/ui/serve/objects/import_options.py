"""Options of an import as fields of a form, and the request that they make."""

from __future__ import annotations

from typing import Any, NamedTuple

from ....common.errors import InputError
from ....sources import catalogue
from ....sources.catalogue.filters import parse_range
from ....sources.crew_options import CrewOptions, Fitting
from ....sources.mission_options import MissionOptions, check_objects
from ..forms.options import JobOption, choice, flag, number, sign_of, text


class ImportWanted(NamedTuple):
    """Request for an import.

    Attributes
    ----------
    filters : Filters
    max_targets : int or None
    station : str or None
    mission : MissionOutline
    crew : Crew
    demands : Demands
        Without a table of prizes.
    ephemerides : bool
        Whether element sets are kept, and orbits fitted to their states.
    """

    filters: catalogue.Filters
    max_targets: int | None
    station: str | None
    mission: catalogue.MissionOutline
    crew: catalogue.Crew
    demands: catalogue.Demands
    ephemerides: bool


RANGE = "two numbers as LOW:HIGH; one may be left out"
BY_MASS = "for a tank by mass"

LONGEST_LIST = 20_000
"""Maximum length of a list of objects [characters]."""


def _list(name: str, label: str, unit: str = "", help: str = "") -> JobOption:
    return text(name, label, unit, help, longest=LONGEST_LIST)


OPTIONS: tuple[JobOption, ...] = (
    text("epoch", "Epoch", "UTC", "as 2026-01-01T00:00:00; empty for the latest of the elements"),
    number("duration_days", "Mission duration", "d", default=7.0),
    choice("dynamics", "Dynamics", ("j2", "two-body"), "j2", "with j2 planes drift"),
    text("altitude", "Altitudes kept", "km", RANGE),
    text("inclination", "Inclinations kept", "deg", RANGE),
    text("raan", "Nodes kept", "deg", "two numbers as LOW:HIGH; 350:10 goes through 0"),
    text("name", "Names kept", "", "a part of a name, or a pattern with * and ?"),
    _list("exclude", "Objects left out", "", "numbers or names between commas"),
    number("max_targets", "Most targets", "", "nearest planes first", whole=True),
    text(
        "station",
        "Station",
        "km, °, °, °",
        "ALTITUDE,INCLINATION,NODE[,U] or an object; empty for the densest plane",
    ),
    flag("no_refuelling", "No station", "the chaser starts in its place"),
    number("delta_v", "ΔV of a full tank", "m/s", "3000 by default"),
    number("dry_mass", "Dry mass", "kg", BY_MASS),
    number("propellant", "Propellant of a full tank", "kg", BY_MASS),
    number("isp", "Specific impulse", "s", BY_MASS),
    number("thrust", "Low thrust", "N", "in place of impulses; needs a tank by mass"),
    number("duty_cycle", "Duty cycle", "", "share of the time in which the thrust is on"),
    number("kits", "Kits aboard", "", "each target needs one", whole=True),
    number("kit_mass", "Mass of a kit", "kg"),
    number("kit_isp", "Specific impulse of kits", "s", "they lead to the disposal orbit"),
    number("tow", "Mass of a towed target", "kg", "each target is towed"),
    number("disposal_altitude", "Disposal altitude", "km", "to which targets are towed"),
    number("disposal_perigee", "Disposal perigee", "km", "instead, apogees stay"),
    number("max_lifetime", "Longest lifetime", "a", "of released targets, in orbit"),
    number("max_uncontrolled", "Controlled re-entry above", "kg", "of a released target"),
    number("end_of_life", "Kept for own disposal", "m/s", "of each chaser"),
    number("launches", "Launches", "", "chasers launched, each to its first target", whole=True),
    number("launch_every", "Interval between launches", "d", "365 by default; 0 for one rocket"),
    number("launch_separation", "Least interval between launches", "d", "times are optimised"),
    text("launch_into", "Orbit launched into", "", "km,°; empty: onto first targets"),
    text("launcher", "Launcher", "", "KM=KG,KM=KG…: what it lifts to altitudes"),
    text("expense", "Expense of a chaser", "", "FIXED[,PER_KG[,PER_KG2]]; the least is best"),
    number("service_days", "Time at a target", "d", "empty for one revolution"),
    _list("deadline", "Deadlines", "d", "OBJECT=DAYS, several between semicolons"),
    _list("require", "Required objects", "", "numbers or names between semicolons"),
    number("max_drift_days", "Longest drift", "d", "0 for none; empty for that of the mission"),
    number("drift_step_days", "Time step of drifts", "d"),
    number("departure_spacing_days", "Time between departures", "d", "the least"),
    number("resolution", "Least saving of a transfer", "m/s"),
    choice("burns", "Burns of short legs", ("sequence", "free"), None, "empty: by eccentricity"),
    choice("approach", "Approach", ("half-lap", "safety-ellipse"), "half-lap", "to targets"),
    number("keep_out", "Distance kept", "m", "by a safety ellipse; 200 by default"),
    flag("ephemerides", "Fit orbits to the element sets", "which are kept beside the instance"),
)
"""All options except files; dropped files are used."""

NAMED = (*OPTIONS, text("prizes", "Prizes"), text("oem", "OEM"))
"""What sentences on an import may name."""


def wanted_of(given: dict[str, Any], *, messages: bool = False) -> ImportWanted:
    """The request made by values of the options.

    Parameters
    ----------
    given : dict
        Values by the names of :data:`OPTIONS`; what is missing has its default.
    messages : bool
        Whether OEM files were dropped.

    Raises
    ------
    InputError
        There is no such option, or a value is not valid.
    """
    value = _checked(given)
    several = {
        name: tuple(part.strip() for part in (value.pop(name) or "").split(";") if part.strip())
        for name in ("deadline", "require")
    }
    names, excluded = value.pop("name"), value.pop("exclude")
    check_objects(() if names is None else (names,), value["max_targets"])
    fitting = Fitting(**{name: value[name] for name in Fitting._fields})
    crew_options = CrewOptions(
        fitting,
        **{name: value[name] for name in CrewOptions._fields if name in value},
        deadlines=several["deadline"],
        required=several["require"],
        musts=(),
        excluded=() if excluded is None else (excluded,),
        prizes_path=None,
    )
    crew = crew_options.crew()
    mission = MissionOptions(**{name: value[name] for name in MissionOptions._fields})
    fitted_by = "--oem" if messages else "--ephemerides" if value["ephemerides"] else None
    ranges = {
        field: None
        if value[name] is None
        else parse_range(value[name], sign_of(name), open_ended=name != "raan")
        for name, field in (
            ("altitude", "altitude_km"),
            ("inclination", "inclination_deg"),
            ("raan", "raan_deg"),
        )
    }
    filters = catalogue.Filters(**ranges, names=() if names is None else (names,))
    return ImportWanted(
        filters,
        value["max_targets"],
        value["station"],
        mission.outline(thrust=crew.thrust_n is not None, fitted_by=fitted_by),
        crew,
        crew_options.demands(),
        bool(value["ephemerides"]),
    )


def _checked(given: dict[str, Any]) -> dict[str, Any]:
    """Values of all options, of their types."""
    strange = sorted(given.keys() - {option.name for option in OPTIONS})
    if strange:
        raise InputError(f"{strange[0][:40]!r} is not an option of an import")
    found = {}
    for option in OPTIONS:
        value = given.get(option.name, option.default)
        if option.word(value) is None and option.kind != "flag":
            value = option.default
        found[option.name] = int(value) if option.whole and value is not None else value
    return found
