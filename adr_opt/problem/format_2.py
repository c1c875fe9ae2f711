"""Conversion of instance files between ``adr-opt-instance/2`` and ``/3``.

In memory there is the newest format alone. A file is written in the oldest one that can say it, so
that what sets no newer field keeps its bytes, and with them its digest.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, Literal, TypeVar

from pydantic import BaseModel

from ..common.json_text import loaded, model_of, refused

Model = TypeVar("Model", bound=BaseModel)

FORMAT: Literal["adr-opt-instance/3"] = "adr-opt-instance/3"
FORMER: Literal["adr-opt-instance/2"] = "adr-opt-instance/2"

ORBIT = (
    "semi_major_axis_m eccentricity inclination_deg raan_deg argument_of_perigee_deg "
    "true_anomaly_deg"
)

_RECORDS = {
    "": "format name epoch frame dynamics stations targets chasers mission transfer objective "
    "keep_out_zones ephemerides",
    "frame": "name axes_epoch",
    "stations": "name orbit max_refuellings max_propellant_kg object_id",
    "stations.orbit": ORBIT,
    "targets": "name orbit prize required window_s mass_kg removal object_id decay_m_per_day fit "
    "prize_until success",
    "targets.orbit": ORBIT,
    "targets.fit": "eccentricity_offset",
    "chasers": "name start available_s end max_targets max_visits_between_refuels tank kits "
    "kit_mass_kg expense thrust_n duty_cycle",
    "chasers.start": "station orbit decay_m_per_day",
    "chasers.start.orbit": ORBIT,
    "chasers.end": "station",
    "chasers.tank": "delta_v_m_s initial_delta_v_m_s dry_mass_kg propellant_kg isp_s "
    "initial_propellant_kg",
    "chasers.expense": "fixed per_kg per_kg_squared",
    "mission": "duration_s service_revolutions service_s refuel_revolutions disposal_altitude_m "
    "launch_separation_s mission_separation_s",
    "transfer": "first_leg_fraction standoff_m safety_ellipse_revolutions max_phasing_revolutions "
    "min_altitude_m max_altitude_m delta_v_resolution_m_s departure_spacing_s drift_step_s "
    "max_drift_s mass_class max_leg_s given",
    "transfer.given": "file sha256 functions functions_sha256",
    "objective": "cost time_m_s_per_day",
    "keep_out_zones": "min_altitude_m max_altitude_m start_s end_s",
    "ephemerides": "kind file sha256",
}
FIELDS = {place: fields.split() for place, fields in _RECORDS.items()}
"""All fields of ``/2`` by their place, in the order of its files."""

LAPS, ALTITUDE = "safety_ellipse_revolutions", "disposal_altitude_m"


def _newer(content: Any, place: str = "") -> Iterator[str]:
    """Fields of an instance that ``/2`` does not have, as paths."""
    for each in content if isinstance(content, list) else [content]:
        if isinstance(each, dict):
            for name, value in each.items():
                path = f"{place}.{name}".lstrip(".")
                if name not in FIELDS.get(place, ()):
                    yield path
                elif path in FIELDS:
                    yield from _newer(value, path)


def read(kind: type[Model], text: str) -> Model:
    """Read an instance from a JSON text of ``/2`` or ``/3``.

    Raises
    ------
    pydantic.ValidationError
        As for :meth:`.Record.from_json`; or ``/2`` has inspection laps, or no such field.
    """
    try:
        content = loaded(text)
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict) or content.get("format", FORMER) != FORMER:
        return model_of(kind, text)
    newer = next(_newer(content), None)
    mission, transfer = content.get("mission"), content.get("transfer")
    if isinstance(transfer, dict) and LAPS in transfer:
        if (laps := transfer.pop(LAPS)) != 0.5:
            raise refused(
                kind.__name__,
                f"field transfer.{LAPS} = {json.dumps(laps)}: the path meets the target at each "
                f'half lap; leave it out and choose transfer.approach, in the format "{FORMAT}"',
                "former_field",
            )
    if isinstance(mission, dict) and (altitude := mission.pop(ALTITUDE, None)) is not None:
        mission["disposal"] = {"circle_m": altitude}
    made = model_of(kind, json.dumps(content | {"format": FORMAT}))
    if newer is not None:  # and known today
        raise refused(
            kind.__name__,
            f'field {newer}: not in the format "{FORMER}"; leave it out, or write "{FORMAT}"',
            "newer_field",
        )
    return made


def written(content: dict[str, Any]) -> dict[str, Any]:
    """The content of an instance's file, in the oldest format that can express it."""
    mission, transfer = dict(content["mission"]), content["transfer"] | {LAPS: 0.5}
    if "circle_m" in mission.get("disposal", ()):
        mission[ALTITUDE] = mission.pop("disposal")["circle_m"]
    former = content | {"format": FORMER, "mission": mission, "transfer": transfer}
    if any(_newer(former)):
        return content
    for part in ("mission", "transfer"):
        former[part] = {name: former[part][name] for name in FIELDS[part] if name in former[part]}
    return former


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """The JSON Schema of files of ``/3`` with the fields that ``/2`` has in their place."""
    parts = schema["$defs"]
    schema["properties"]["format"] = {"enum": [FORMER, FORMAT], "default": FORMER}
    parts["TransferSettings"]["properties"][LAPS] = {"const": 0.5, "deprecated": True}
    altitude = parts["DisposalCircle"]["properties"]["circle_m"] | {"deprecated": True}
    parts["MissionSettings"]["properties"][ALTITUDE] = {"anyOf": [altitude, {"type": "null"}]}
    return schema
