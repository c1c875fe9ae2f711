"""Fields that catalogues may add to an element set: one meaning in every spelling."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from catalogue_files import METADATA, field, omm_fields, one

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue import Demands, ElementSet, MissionOutline, to_instance
from adr_opt.sources.worth.bodies import bodies_of

pytest.importorskip("sgp4.api")

RECORD = field(1)[0]
EPOCH = datetime(2026, 1, 1, 7, 46, 19, 150464, tzinfo=UTC)
OPTIONAL = {
    "MASS": "812.5",
    "DECAY_DATE": "2026-01-09",
    "RCS_SIZE": "LARGE",
    "EPOCH_MICROSECONDS": "150464",
}
OWN = ("DECAY_DATE", "RCS_SIZE", "EPOCH_MICROSECONDS")
"""Those that Space-Track writes as user-defined where there is a place for such."""


def fields_of(more: dict[str, str]) -> dict[str, Any]:
    return omm_fields(RECORD) | {"EPOCH": "2026-01-01T07:46:19"} | more


def in_json(more: dict[str, str]) -> str:
    return json.dumps([fields_of(more)])


def in_space_track_json(more: dict[str, str]) -> str:
    stated = METADATA | {key: str(value) for key, value in fields_of(more).items()}
    return json.dumps([{"RCS_SIZE": None, "DECAY_DATE": None, "FILE": "1"} | stated])


def in_csv(more: dict[str, str]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, quoting=csv.QUOTE_ALL)
    writer.writerows(zip(*fields_of(more).items(), strict=True))
    return out.getvalue()


def in_kvn(more: dict[str, str], own: str = "USER_DEFINED_") -> str:
    lines = ["CCSDS_OMM_VERS = 2.0"]
    for key, value in (METADATA | fields_of(more)).items():
        lines.append(f"{own if key in OWN else ''}{key} = {value}")
    return "\n".join(lines)


def in_xml(more: dict[str, str]) -> str:
    leaves = "".join(
        f'<USER_DEFINED parameter="{key}">{value}</USER_DEFINED>'
        if key in OWN
        else f"<{key}>{value}</{key}>"
        for key, value in (METADATA | fields_of(more)).items()
    )
    return f"<ndm><omm><body><segment><data>{leaves}</data></segment></body></omm></ndm>"


SPELLINGS = {
    "JSON": in_json,
    "JSON of Space-Track": in_space_track_json,
    "CSV": in_csv,
    "KVN": in_kvn,
    "KVN with plain keys": lambda more: in_kvn(more, ""),
    "XML": in_xml,
    "XML with plain keys": lambda more: as_xml_with(more),
}


def as_xml_with(more: dict[str, str]) -> str:
    leaves = "".join(f"<{key}>{value}</{key}>" for key, value in fields_of(more).items())
    return f"<omm><body><segment><data>{leaves}</data></segment></body></omm>"


def told(record: ElementSet) -> tuple[Any, ...]:
    """All that a record says but where it stands."""
    return record, record.mass_kg, record.size, record.decays


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_optional_fields_mean_the_same_in_every_spelling(spelling: str) -> None:
    """Every optional field is read alike, alone and with all others, and none is missed."""
    write = SPELLINGS[spelling]
    bare = replace(RECORD, epoch=EPOCH.replace(microsecond=0))
    meaning: dict[str, dict[str, Any]] = {
        "MASS": {"mass_kg": 812.5},
        "DECAY_DATE": {"decays": datetime(2026, 1, 9, tzinfo=UTC)},
        "RCS_SIZE": {"size": "LARGE"},
        "EPOCH_MICROSECONDS": {"epoch": EPOCH},
    }
    assert meaning.keys() == OPTIONAL.keys()
    assert told(one(write({}))) == told(bare)
    assert told(one(write(dict.fromkeys(OPTIONAL, "")))) == told(bare)
    everything = bare
    for key, value in OPTIONAL.items():
        assert told(one(write({key: value}))) == told(replace(bare, **meaning[key])), key
        everything = replace(everything, **meaning[key])
    assert told(one(write(OPTIONAL))) == told(everything)
    for key, bad in (
        ("DECAY_DATE", "soon"),
        ("DECAY_DATE", "2026-02-30"),
        ("EPOCH_MICROSECONDS", "1000000"),
        ("EPOCH_MICROSECONDS", "x"),
    ):
        with pytest.raises(InputError, match=f"field {key} = "):
            one(write({key: bad}))


@pytest.mark.parametrize(
    ("epoch", "apart", "read"),
    [
        ("2026-01-01 07:46:19", "150464", EPOCH),
        ("2026-01-01T07:46:19.000000", "150464", EPOCH),
        ("2026-01-01T07:46:19.150464", "150464", EPOCH),
        ("2026-01-01T07:46:19.15", "150464", EPOCH),
        ("2026-001T07:46:19Z", 150464, EPOCH),
        ("2026-01-01T07:46:19.25", "150464", None),
    ],
)
def test_microseconds_complete_an_epoch(epoch: str, apart: Any, read: datetime | None) -> None:
    """They complete whole seconds and decimals that say the same; others are refused."""
    text = json.dumps(fields_of({"EPOCH": epoch, "EPOCH_MICROSECONDS": apart}))
    if read is not None:
        assert one(text).epoch == read
        return
    with pytest.raises(InputError, match=r"EPOCH_MICROSECONDS = 150464: EPOCH = .* has them, too"):
        one(text)


def imported(days: float, duration_days: float = 7.0, **wanted: Any) -> Any:
    """Two objects, of which the first comes down some days after the epoch."""
    records = field(2)
    epoch = max(record.epoch for record in records)
    records[0] = replace(records[0], decays=epoch + timedelta(days=days))
    outline = MissionOutline(epoch=epoch, duration_s=duration_days * DAY_S)
    return to_instance(records, skip_bad=True, mission=outline, **wanted)


def test_a_decay_date_counts_against_the_epoch() -> None:
    """Before the epoch it is decayed, within the mission its window ends, after that nothing."""
    for days in (-1.0, 0.0):
        made = imported(days)
        assert made.counts == {"decayed": 1}
        assert len(made.instance.targets) == 1
    made, untouched = imported(4.0), imported(40.0)
    assert made.counts == untouched.counts == {}
    windows = [target.window_s for target in made.instance.targets]
    assert windows == [(0.0, 4.0 * DAY_S), (0.0, None)]
    assert any("1 target comes down within the mission" in said for said in made.warnings)
    assert all(target.window_s == (0.0, None) for target in untouched.instance.targets)
    assert not any("down within" in said for said in untouched.warnings)
    label = field(2)[0].label
    for deadline, closes in ((2.0, 2.0), (6.0, 4.0)):
        made = imported(4.0, demands=Demands(deadlines_s={label: deadline * DAY_S}))
        assert made.instance.targets[0].window_s == (0.0, closes * DAY_S)


def test_a_station_must_stay_up() -> None:
    """An object that comes down within the mission is no station."""
    label = field(2)[0].label
    assert imported(8.0, station=label).instance.stations
    with pytest.raises(InputError, match=r"comes down on .* within the mission"):
        imported(4.0, station=label)


def test_worths_count_what_is_up_at_the_latest_epoch() -> None:
    """An object is left out once the catalogue is later than its date, and not before."""
    records = field(3)
    latest = max(record.epoch for record in records)
    for apart, left_out in ((-1, {"decayed": 1}), (1, {})):
        records[0] = replace(records[0], decays=latest + timedelta(seconds=apart))
        assert bodies_of(records).left_out == left_out
