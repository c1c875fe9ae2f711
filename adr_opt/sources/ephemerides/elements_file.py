"""Files of element sets by body, ``adr-opt-elements/1``: JSON whose records are OMMs.

A record has the keywords of an Orbit Mean-Elements Message (CCSDS 502.0-B), as CelesTrak's JSON.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ...common.errors import InputError
from ...common.json_text import parse_json
from ...common.records import JSON_SCHEMA
from ..catalogue.omm import read_message
from ..catalogue.records import Dropped, ElementSet

FORMAT = "adr-opt-elements/1"


def to_text(records: Mapping[str, ElementSet]) -> str:
    """The file of bodies' element sets."""
    lines = [
        f"  {json.dumps(body, ensure_ascii=False)}: {json.dumps(_fields(record))}"
        for body, record in records.items()
    ]
    listed = ",\n".join(lines)
    return f'{{\n "format": "{FORMAT}",\n "bodies": {{\n{listed}\n }}\n}}\n'


def read_elements(content: bytes, source: str) -> dict[str, ElementSet]:
    """Element sets by body.

    Raises
    ------
    InputError
        Not such a file, an unknown field, two element sets of one body, or a bad element set.
    """
    data = parse_json(content, source)
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f'{source}: its format is not "{FORMAT}"; import the catalogue again')
    strange = sorted(data.keys() - {"format", "bodies"})
    if strange:
        raise InputError(f"{source}: field {strange[0][:40]}: unknown; remove it")
    bodies = data.get("bodies")
    if not isinstance(bodies, dict):
        raise InputError(f"{source}: field bodies: must be an object with element sets")
    found = {}
    for body, fields in bodies.items():
        if not isinstance(fields, dict):
            raise InputError(f"{source}: field bodies[{body!r}]: must be an element set")
        record = read_message(fields, source, 0)
        if isinstance(record, Dropped):
            raise InputError(f"{source}: {body!r}: {record.detail}")
        if record.not_sgp4:
            raise InputError(f"{source}: {body!r}: {record.not_sgp4}")
        found[body] = record
    return found


def json_schema() -> dict[str, Any]:
    """The JSON Schema of the file; for records only the required keywords."""
    needed = {
        "MEAN_MOTION",
        "ECCENTRICITY",
        "INCLINATION",
        "RA_OF_ASC_NODE",
        "ARG_OF_PERICENTER",
        "MEAN_ANOMALY",
        "EPOCH",
        "BSTAR",
    }
    return {
        "$schema": JSON_SCHEMA,
        "title": "ElementsFile",
        "type": "object",
        "properties": {
            "format": {"const": FORMAT, "type": "string"},
            "bodies": {
                "type": "object",
                "additionalProperties": {"type": "object", "required": sorted(needed)},
            },
        },
        "required": ["format", "bodies"],
        "additionalProperties": False,
    }


def _fields(record: ElementSet) -> dict[str, Any]:
    """A record under the keywords of OMM, from which it is read again without loss."""
    return {
        "OBJECT_NAME": record.name,
        "OBJECT_ID": record.object_id,
        "NORAD_CAT_ID": record.number,
        "EPOCH": record.epoch.strftime("%Y-%m-%dT%H:%M:%S.%f"),
        "MEAN_MOTION": record.mean_motion_rev_day,
        "ECCENTRICITY": record.eccentricity,
        "INCLINATION": record.inclination_deg,
        "RA_OF_ASC_NODE": record.raan_deg,
        "ARG_OF_PERICENTER": record.argument_of_perigee_deg,
        "MEAN_ANOMALY": record.mean_anomaly_deg,
        "BSTAR": record.bstar,
        "MEAN_MOTION_DOT": record.mean_motion_dot_rev_day2,
        "MEAN_MOTION_DDOT": record.mean_motion_ddot_rev_day3,
        "CLASSIFICATION_TYPE": record.classification,
        "EPHEMERIS_TYPE": record.ephemeris_type,
        "ELEMENT_SET_NO": record.element_set,
        "REV_AT_EPOCH": record.revolution,
    }
