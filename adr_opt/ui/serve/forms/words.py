"""Labels, units and explanations of the fields of an instance, for forms."""

from __future__ import annotations

from typing import NamedTuple


class FieldWords(NamedTuple):
    """How a form calls a field, and what it says of it."""

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
    "start": FieldWords("Start", "at a station, in an orbit of its own, or launched anywhere"),
    "end": FieldWords("End", "anywhere, or at a station"),
    "station": FieldWords("Station", "its name"),
    "orbit": FieldWords("Orbit"),
    "semi_major_axis_m": FieldWords("Semi-major axis", "from the centre of the Earth"),
    "eccentricity": FieldWords("Eccentricity"),
    "inclination_deg": FieldWords("Inclination"),
    "raan_deg": FieldWords("Right ascension of the node"),
    "argument_of_perigee_deg": FieldWords("Argument of perigee"),
    "true_anomaly_deg": FieldWords("True anomaly"),
    "available_s": FieldWords(
        "Available", "earliest and latest time since the epoch; no latest one: for ever"
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
    "duty_cycle": FieldWords("Duty cycle", "share of the time in which the thrust is on"),
    "max_refuellings": FieldWords("Most refuellings", "of all chasers; empty for no limit"),
    "max_propellant_kg": FieldWords("Propellant in stock", "empty for no limit"),
    "object_id": FieldWords("Designator", "international, such as 1997-051C"),
    "duration_s": FieldWords("Duration", "latest end of all services"),
    "service_revolutions": FieldWords("Time at a target", "in its periods; or in seconds below"),
    "service_s": FieldWords("Time at a target", "in place of revolutions"),
    "refuel_revolutions": FieldWords("Time to refuel", "in periods of the station"),
    "disposal_altitude_m": FieldWords("Disposal altitude", "to which objects are towed"),
    "launch_separation_s": FieldWords("Time between launches", "the least, in their order"),
    "mission_separation_s": FieldWords(
        "Time between missions", "from the last service to the next launch, the least"
    ),
    "first_leg_fraction": FieldWords(
        "First part of the climb", "share of the difference in radius"
    ),
    "standoff_m": FieldWords("Stand-off", "distance behind the target"),
    "safety_ellipse_revolutions": FieldWords("Inspection", "0.5 and whole laps more"),
    "max_phasing_revolutions": FieldWords("Most revolutions of phasing"),
    "min_altitude_m": FieldWords("Lowest altitude of phasing"),
    "max_altitude_m": FieldWords("Highest altitude of phasing"),
    "delta_v_resolution_m_s": FieldWords("Least saving of a transfer"),
    "departure_spacing_s": FieldWords("Time between departures", "the least"),
    "drift_step_s": FieldWords("Time step of drifts"),
    "max_drift_s": FieldWords("Longest drift", "0 for none"),
    "mass_class": FieldWords("Width of classes of mass", "as a share"),
    "max_leg_s": FieldWords("Longest leg", "from arrival to arrival; empty for no limit"),
    "dynamics": FieldWords("Dynamics", "with j2 planes drift; two-body for short missions"),
    "window_s": FieldWords(
        "Window", "earliest begin and latest end of the service; no latest one: for ever"
    ),
    "removal": FieldWords("Service", "a visit, a kit that stays, or a tow, which needs a mass"),
    "mass_kg": FieldWords("Mass"),
    "cost": FieldWords("Cost", "that decides between plans of equal prizes"),
    "time_m_s_per_day": FieldWords("Price of a day", "in ΔV"),
}
"""By the last name of a field's path."""

VARIANTS = {"Tank": "delta-v", "TankByMass": "mass"}
"""What forms call the kinds of a field, where not after its only name."""

NOT_EDITED = {"given", "decay_m_per_day"}
"""Fields that no form shows: they refer to files, or come from fits."""


def unit_of(name: str) -> str:
    """Unit of a field by its name; empty if it has none."""
    return next((unit for end, unit in UNITS if name.endswith(end)), "")
