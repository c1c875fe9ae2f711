"""Fields of forms, from the JSON Schema of the instance."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple, get_args

from ....common.constants import DAY_S
from ....problem.instance import Instance
from ..drafts import Part
from .options import meaning_of_empty


class FieldWords(NamedTuple):
    """Label and description of a field in a form."""

    label: str
    help: str = ""


UNITS = (
    ("_m_s_per_day", "m/s per day"),
    ("_m_s", "m/s"),
    ("_kg_squared", "per kg²"),
    ("per_kg", "per kg"),
    ("_kg", "kg"),
    ("_deg", "°"),
    ("_revolutions", "revolutions"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
)
"""Units by the end of a field's name, the first that fits."""

WORDS = {
    "name": FieldWords("Name"),
    "prize": FieldWords("Prize"),
    "start": FieldWords("Start", "at a station, in an orbit of its own, or launched"),
    "end": FieldWords("End", "anywhere, or at a station"),
    "station": FieldWords("Station", "its name"),
    "orbit": FieldWords("Orbit"),
    "altitude_m": FieldWords("Altitude of the orbit launched into"),
    "semi_major_axis_m": FieldWords("Semi-major axis", "from the centre of the Earth"),
    "eccentricity": FieldWords("Eccentricity"),
    "inclination_deg": FieldWords("Inclination"),
    "raan_deg": FieldWords("Right ascension of the node"),
    "argument_of_perigee_deg": FieldWords("Argument of perigee"),
    "true_anomaly_deg": FieldWords("True anomaly"),
    "available_s": FieldWords(
        "Available", "earliest and latest time since the epoch; empty latest time: no end"
    ),
    "max_targets": FieldWords("Most targets", "empty for no limit"),
    "max_visits_between_refuels": FieldWords("Most targets on a tank", "empty for no limit"),
    "tank": FieldWords("Tank", "counted in ΔV, or by mass"),
    "delta_v_m_s": FieldWords("ΔV of a full tank"),
    "initial_delta_v_m_s": FieldWords("ΔV at the start", "empty for a full tank"),
    "dry_mass_kg": FieldWords("Dry mass", "without propellant and kits"),
    "propellant_kg": FieldWords("Propellant of a full tank"),
    "isp_s": FieldWords("Specific impulse"),
    "initial_propellant_kg": FieldWords("Propellant at the start", "empty for a full tank"),
    "kits": FieldWords("Kits aboard", "the most; empty for no limit"),
    "kit_mass_kg": FieldWords("Mass of a kit", "needs a tank by mass"),
    "expense": FieldWords("Expense", "of using the chaser, where the objective counts it"),
    "fixed": FieldWords("Fixed expense"),
    "per_kg": FieldWords("Expense per kilogram", "needs a tank by mass"),
    "per_kg_squared": FieldWords("Expense per kilogram squared", "needs a tank by mass"),
    "thrust_n": FieldWords("Low thrust", "in place of impulses; needs a tank by mass"),
    "duty_cycle": FieldWords("Duty cycle", "share of the time with thrust; empty for always"),
    "max_refuellings": FieldWords("Most refuellings", "of all chasers; empty for no limit"),
    "max_propellant_kg": FieldWords("Propellant in stock", "empty for no limit"),
    "object_id": FieldWords("Designator", "international, such as 1997-051C"),
    "start_s": FieldWords("Closed from"),
    "end_s": FieldWords("Closed until"),
    "duration_s": FieldWords("Duration", "latest end of all services"),
    "service_revolutions": FieldWords("Time at a target", "in its periods; empty for minutes"),
    "service_s": FieldWords("Time at a target", "empty for revolutions"),
    "refuel_revolutions": FieldWords("Time to refuel", "in periods of the station"),
    "disposal": FieldWords("Disposal orbit", "to which objects are towed"),
    "circle_m": FieldWords("Altitude of the circle"),
    "perigee_m": FieldWords("Altitude of the perigee", "the apogee stays"),
    "max_lifetime_years": FieldWords("Longest lifetime", "of released objects; empty for no limit"),
    "max_uncontrolled_kg": FieldWords(
        "Controlled re-entry above", "mass of a released object; empty for no limit"
    ),
    "end_of_life_m_s": FieldWords(
        "Kept for its disposal", "never burnt on the mission; empty for nothing"
    ),
    "area_to_mass_m2_kg": FieldWords("Area over mass", "m²/kg, for the lifetime once released"),
    "launch_separation_s": FieldWords("Time between launches", "the least, in their order"),
    "mission_separation_s": FieldWords(
        "Time between missions", "from the last service to the next launch, the least"
    ),
    "first_leg_fraction": FieldWords(
        "First part of the climb", "share of the difference in radius"
    ),
    "standoff_m": FieldWords("Stand-off", "distance behind the target"),
    "approach": FieldWords(
        "Approach", "half a lap into the target, or round it on a safety ellipse"
    ),
    "keep_out_m": FieldWords("Kept out of", "around the target, whichever burn is missed"),
    "approach_revolutions": FieldWords("Revolutions of the approach"),
    "inspection_revolutions": FieldWords("Inspection", "revolutions on the safety ellipse"),
    "burns": FieldWords("Burns", "of a planned sequence, or free"),
    "max_phasing_revolutions": FieldWords("Most revolutions of phasing"),
    "min_altitude_m": FieldWords("Lowest altitude"),
    "max_altitude_m": FieldWords("Highest altitude"),
    "delta_v_resolution_m_s": FieldWords("Least saving of a transfer"),
    "departure_spacing_s": FieldWords("Time between departures", "the least"),
    "drift_step_s": FieldWords("Time step of drifts"),
    "max_drift_s": FieldWords("Longest drift", "0 for none"),
    "mass_class": FieldWords("Width of classes of mass", "as a share"),
    "max_leg_s": FieldWords("Longest leg", "from arrival to arrival; empty for no limit"),
    "dynamics": FieldWords("Dynamics", "with j2 planes drift; two-body for short missions"),
    "window_s": FieldWords(
        "Window", "earliest start and latest end of the service; empty latest end: no limit"
    ),
    "removal": FieldWords("Service", "a visit, a kit that stays, or a tow, which needs a mass"),
    "mass_kg": FieldWords("Mass"),
    "cost": FieldWords("Cost", "that decides between plans of equal prizes"),
    "time_m_s_per_day": FieldWords("Price of a day", "in ΔV"),
}
"""Labels and descriptions of fields, by the last name of a field's path."""

VARIANTS = {"Tank": "delta-v", "TankByMass": "mass"}
"""Labels of the kinds of a field, where they differ from its only name."""

NOT_EDITED = {"given", "decay_m_per_day", "launcher"}
"""Fields that no form shows: they refer to files, or come from fits."""


DAYS, MINUTES, KILOMETRES = ("d", DAY_S), ("min", 60.0), ("km", 1000.0)
SHOWN = {
    "available_s": DAYS,
    "duration_s": DAYS,
    "start_s": DAYS,
    "end_s": DAYS,
    "window_s": DAYS,
    "launch_separation_s": DAYS,
    "mission_separation_s": DAYS,
    "drift_step_s": DAYS,
    "max_drift_s": DAYS,
    "max_leg_s": DAYS,
    "service_s": MINUTES,
    "departure_spacing_s": MINUTES,
    "semi_major_axis_m": KILOMETRES,
    "altitude_m": KILOMETRES,
    "circle_m": KILOMETRES,
    "perigee_m": KILOMETRES,
    "min_altitude_m": KILOMETRES,
    "max_altitude_m": KILOMETRES,
}
"""Units for display in place of those of files, with their values."""

SELDOM = {
    *("argument_of_perigee_deg", "true_anomaly_deg", "available_s", "max_targets", "expense"),
    *("max_visits_between_refuels", "initial_delta_v_m_s", "initial_propellant_kg", "fixed"),
    *("kit_mass_kg", "per_kg", "per_kg_squared", "thrust_n", "duty_cycle", "object_id"),
    *("service_s", "refuel_revolutions", "launch_separation_s", "mission_separation_s"),
    *("first_leg_fraction", "standoff_m", "delta_v_resolution_m_s", "departure_spacing_s"),
    *("drift_step_s", "mass_class", "max_leg_s", "inspection_revolutions"),
}
"""Fields that forms show only on request."""


def unit_of(name: str) -> str:
    """Unit of a field by its name; empty if it has none."""
    return next((unit for end, unit in UNITS if name.endswith(end)), "")


Schema = dict[str, Any]

OF_TARGETS = ("window_s", "removal", "mass_kg")
"""Fields of targets in a form, beside prize and requirement, which stand in their table."""

KINDS = {
    "number": "number",
    "integer": "number",
    "string": "text",
    "boolean": "flag",
    "array": "list",
}
"""Kinds of fields by types of the schema."""


@cache
def form_fields() -> list[dict[str, Any]]:
    """Fields of all parts that forms edit, as JSON data.

    Each has ``part``, ``path`` (names between points, within a chaser or a station for those
    parts), ``label``, ``unit``, ``by`` (what one of the unit is in that of the file), ``seldom``
    (whether it stands under *More*), ``kind``, ``least``, ``most``, ``default``, ``help``,
    ``optional`` (whether null is allowed), ``whole`` (of a number), ``choices`` (of a choice), and
    ``of``, the choice to which a field belongs: ``[PATH, VALUE]``, or null. ``absent`` is what an
    empty field means, where it is not nothing.
    """
    schema = Instance.model_json_schema()
    found: list[dict[str, Any]] = []
    for part in get_args(Part):
        content = _resolved(schema["properties"][part], schema)
        if content.get("type") == "array":
            content = _resolved(content["items"], schema)
        found += [{"part": part, **field} for field in _inside(content, schema, "", None)]
    dynamics = _field(schema["properties"]["dynamics"], schema, "dynamics", None, must=True)
    target = schema["$defs"]["Target"]["properties"]
    services = [
        field
        for name in OF_TARGETS
        for field in _field(target[name], schema, name, None, must=True)
    ]
    return [
        *found,
        *({"part": "dynamics", **field} for field in dynamics),
        *({"part": "targets", **field} for field in services),
    ]


def _inside(
    content: Schema, schema: Schema, path: str, of: list[str] | None
) -> Iterator[dict[str, Any]]:
    """Fields of an object."""
    required = content.get("required", ())
    for name, inner in content["properties"].items():
        if name not in NOT_EDITED:
            yield from _field(inner, schema, f"{path}{name}", of, must=name in required)


def _field(
    content: Schema, schema: Schema, path: str, of: list[str] | None, *, must: bool
) -> Iterator[dict[str, Any]]:
    """A field, or those within it."""
    kinds = [
        _resolved(inner, schema) for each in _kinds(content) for inner in _kinds(each) or [each]
    ]
    kept = [each for each in kinds if each.get("type") != "null"]
    optional = len(kept) < len(kinds)
    default = content.get("default")
    if len(kept) > 1:
        names = [_variant(each) for each in kept]
        yield _told(path, "choice", of, default=default, optional=optional, choices=names)
        for name, each in zip(names, kept, strict=True):
            if "properties" in each:
                yield from _inside(each, schema, f"{path}.", [path, name])
        return
    inner = _resolved(kept[0] if kept else content, schema)
    if "properties" in inner:
        if optional or not must:
            yield _told(path, "choice", of, default=None, optional=True, choices=["given"])
            of = [path, "given"]
        yield from _inside(inner, schema, f"{path}.", of)
        return
    limits = {
        "least": inner.get("minimum", inner.get("exclusiveMinimum")),
        "most": inner.get("maximum", inner.get("exclusiveMaximum")),
    }
    whole = {"whole": True} if inner.get("type") == "integer" else {}
    if "enum" in inner:
        yield _told(path, "choice", of, default=default, optional=optional, choices=inner["enum"])
    else:
        kind = KINDS[inner["type"]]
        yield _told(path, kind, of, default=default, optional=optional, **limits, **whole)


def _kinds(content: Schema) -> list[Schema]:
    """Alternatives of a field, if it has some."""
    found: list[Schema] = content.get("anyOf") or content.get("oneOf") or []
    return found


def _told(path: str, kind: str, of: list[str] | None, **more: Any) -> dict[str, Any]:
    name = path.rpartition(".")[2]
    words = WORDS[name]
    unit, by = SHOWN.get(name, (unit_of(name), 1.0))
    help, absent = meaning_of_empty(words.help)
    return {
        "path": path,
        "label": words.label,
        "unit": unit,
        "by": by,
        "seldom": name in SELDOM,
        "kind": kind,
        "least": None,
        "most": None,
        "help": help,
        "of": of,
        **absent,
        **more,
    }


def _variant(content: Schema) -> str:
    """Label of one of several kinds: a word, its only name, or from :data:`VARIANTS`."""
    if "const" in content:
        return str(content["const"])
    return VARIANTS.get(content["title"]) or next(iter(content["properties"]))


def _resolved(content: Schema, schema: Schema) -> Schema:
    reference = content.get("$ref")
    if reference is None:
        return content
    found: Schema = schema["$defs"][reference.rpartition("/")[2]]
    return found
