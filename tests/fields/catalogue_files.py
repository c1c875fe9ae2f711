"""Records written in the five spellings that the readers take, by other means than the readers."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import pytest

from adr_opt.sources.catalogue import ElementSet
from adr_opt.sources.catalogue.reading import read_bytes

sgp4_alpha5 = pytest.importorskip("sgp4.alpha5")
sgp4_io = pytest.importorskip("sgp4.io")


def field(count: int, seed: int = 0) -> list[ElementSet]:
    """A synthetic catalogue of low orbits, about as spread as the real one."""
    random = np.random.default_rng(seed)
    begin = datetime(2025, 3, 1, tzinfo=UTC)
    records = []
    for number in range(count):
        records.append(
            ElementSet(
                name=f"OBJECT {number % 97} DEB",
                object_id=f"{1960 + number % 60}-{1 + number % 120:03d}{chr(65 + number % 24)}",
                number=10_000 + number,
                # whole 1e-8 days, which is what a TLE can say
                epoch=begin + timedelta(microseconds=864 * int(random.integers(0, 10**8))),
                mean_motion_rev_day=round(random.uniform(13.8, 14.9), 8),
                eccentricity=round(random.uniform(0.0001, 0.004), 7),
                inclination_deg=round(random.choice([52.0, 65.0, 82.9, 86.4, 98.2]), 4),
                raan_deg=round(random.uniform(0.0, 359.0), 4),
                argument_of_perigee_deg=round(random.uniform(0.0, 359.0), 4),
                mean_anomaly_deg=round(random.uniform(0.0, 359.0), 4),
                bstar=float(f"0.{random.integers(10_000, 99_999)}e-3"),
                mean_motion_dot_rev_day2=round(random.uniform(0.0, 1e-4), 8),
                element_set=999,
                revolution=1 + number,
            )
        )
    return records


def omm_fields(record: ElementSet) -> dict[str, Any]:
    """The fields of a record as OMM JSON of CelesTrak has them."""
    return {
        "OBJECT_NAME": record.name,
        "OBJECT_ID": record.object_id,
        "EPOCH": record.epoch.strftime("%Y-%m-%dT%H:%M:%S.%f"),
        "MEAN_MOTION": record.mean_motion_rev_day,
        "ECCENTRICITY": record.eccentricity,
        "INCLINATION": record.inclination_deg,
        "RA_OF_ASC_NODE": record.raan_deg,
        "ARG_OF_PERICENTER": record.argument_of_perigee_deg,
        "MEAN_ANOMALY": record.mean_anomaly_deg,
        "EPHEMERIS_TYPE": record.ephemeris_type,
        "CLASSIFICATION_TYPE": record.classification,
        "NORAD_CAT_ID": record.number,
        "ELEMENT_SET_NO": record.element_set,
        "REV_AT_EPOCH": record.revolution,
        "BSTAR": record.bstar,
        "MEAN_MOTION_DOT": record.mean_motion_dot_rev_day2,
        "MEAN_MOTION_DDOT": record.mean_motion_ddot_rev_day3,
    }


METADATA = {
    "CENTER_NAME": "EARTH",
    "REF_FRAME": "TEME",
    "TIME_SYSTEM": "UTC",
    "MEAN_ELEMENT_THEORY": "SGP4",
}


def as_json(records: Iterable[ElementSet]) -> str:
    """CelesTrak's JSON: one line."""
    return json.dumps([omm_fields(record) for record in records])


def as_space_track_json(records: Iterable[ElementSet]) -> str:
    """Space-Track's JSON: numbers as text, keys of its own, nulls."""
    return json.dumps(
        [
            {"CCSDS_OMM_VERS": "3.0", "COMMENT": "GENERATED VIA SPACE-TRACK.ORG API"}
            | METADATA
            | {key: str(value) for key, value in omm_fields(record).items()}
            | {"PERIOD": "100.1", "DECAY_DATE": None, "RCS_SIZE": "SMALL", "GP_ID": "1"}
            for record in records
        ],
        indent=1,
    )


def as_csv(records: Iterable[ElementSet]) -> str:
    """CelesTrak's CSV."""
    out = io.StringIO()
    rows = [omm_fields(record) for record in records]
    writer = csv.DictWriter(out, list(rows[0]))
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def as_kvn(records: Iterable[ElementSet]) -> str:
    """KVN with units, one message after the other."""
    units = {"MEAN_MOTION": "[rev/day]", "INCLINATION": "[deg]", "BSTAR": "[1/ER]"}
    text = ""
    for record in records:
        text += "CCSDS_OMM_VERS = 2.0\nCOMMENT synthetic\nORIGINATOR = NOBODY\n\n"
        for key, value in (METADATA | omm_fields(record)).items():
            text += f"{key:<20} = {value} {units.get(key, '')}\n"
    return text


def as_xml(records: Iterable[ElementSet]) -> str:
    """XML, a list of messages."""

    def leaves(values: dict[str, Any]) -> str:
        return "".join(f"<{key}>{escape(str(value))}</{key}>\n" for key, value in values.items())

    text = '<?xml version="1.0" encoding="UTF-8"?>\n<ndm>\n'
    for record in records:
        values = omm_fields(record)
        named = {key: values.pop(key) for key in ("OBJECT_NAME", "OBJECT_ID")}
        text += (
            '<omm id="CCSDS_OMM_VERS" version="2.0"><header/><body><segment><metadata>'
            f"{leaves(named | METADATA)}</metadata><data><meanElements>{leaves(values)}"
            "</meanElements></data></segment></body></omm>\n"
        )
    return text + "</ndm>\n"


def escape(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def as_tle(records: Iterable[ElementSet], *, space_track: bool = False) -> str:
    """Three lines for each object, with Alpha-5 numbers."""
    text = ""
    for record in records:
        first, second = tle_lines(record)
        text += f"{'0 ' if space_track else ''}{record.name}\n{first}\n{second}\n"
    return text


def tle_lines(record: ElementSet) -> tuple[str, str]:
    """The two element lines of a record that fits into them."""
    number = sgp4_alpha5.to_alpha5(record.number)
    year, _, piece = record.object_id.partition("-")
    begin = datetime(record.epoch.year, 1, 1, tzinfo=UTC)
    ticks = (record.epoch - begin) // timedelta(microseconds=864)
    days = f"{1 + ticks // 10**8:03d}.{ticks % 10**8:08d}"
    dot = f"{record.mean_motion_dot_rev_day2:+.8f}".replace("+0.", " .").replace("-0.", "-.")
    first = (
        f"1 {number}{record.classification} {year[2:] + piece:<8} {record.epoch:%y}{days} {dot} "
        f"{power(record.mean_motion_ddot_rev_day3)} {power(record.bstar)} "
        f"{record.ephemeris_type} {record.element_set:4d}"
    )
    second = (
        f"2 {number} {record.inclination_deg:8.4f} {record.raan_deg:8.4f} "
        f"{round(record.eccentricity * 1e7):07d} {record.argument_of_perigee_deg:8.4f} "
        f"{record.mean_anomaly_deg:8.4f} {record.mean_motion_rev_day:11.8f}{record.revolution:5d}"
    )
    return sgp4_io.fix_checksum(first), sgp4_io.fix_checksum(second)


def power(value: float) -> str:
    """A number as ``±NNNNN±N``, with the point assumed before the digits."""
    if value == 0.0:
        return " 00000+0"
    exponent = math.floor(math.log10(abs(value))) + 1
    digits = round(abs(value) * 10.0 ** (5 - exponent))
    if digits == 100_000:
        digits, exponent = 10_000, exponent + 1
    return f"{'-' if value < 0.0 else ' '}{digits:05d}{exponent:+d}"


SPELLINGS = {"tle": as_tle, "xml": as_xml, "kvn": as_kvn, "json": as_json, "csv": as_csv}


def one(text: str) -> ElementSet:
    """The record of a text that holds one."""
    (record,) = read_bytes(text.encode(), "file").records
    return record
