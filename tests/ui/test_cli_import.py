"""``import``: files in, an instance out; bad rows, filters and stations told in one sentence."""

from __future__ import annotations

import builtins
import json
import re
import runpy
from pathlib import Path
from typing import Any

import pytest
from catalogue_files import (
    SPELLINGS,
    as_csv,
    as_json,
    as_kvn,
    as_tle,
    as_xml,
    field,
    omm_fields,
    tle_lines,
)
from conftest import Cli

import adr_opt
from adr_opt.sources.catalogue import reading
from adr_opt.ui.cli import import_

sgp4_io = pytest.importorskip("sgp4.io")

ROOT = Path(__file__).parents[2]
RECORDS = field(12)


def write(name: str, content: str) -> str:
    Path(name).write_text(content, encoding="utf-8")
    return name


def refused(outcome: Any, *named: str) -> None:
    """One line on standard error that names what it should, nothing written, exit 2."""
    assert outcome.status == 2, outcome
    assert outcome.out == ""
    assert outcome.err.count("\n") == 1, outcome.err
    for text in named:
        assert text in outcome.err
    assert not Path("out.json").exists()


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_every_spelling_is_imported(cli: Cli, spelling: str) -> None:
    """A file of any spelling, whatever its suffix, becomes an instance that loads."""
    path = write("catalogue.dat", SPELLINGS[spelling](RECORDS))
    outcome = cli("import", path, "--out", "out.json")
    assert outcome.status == 0, outcome
    assert outcome.out == ""
    assert "12 of 12 objects as targets, mean elements (SGP4, TEME) at 2025-03-01T" in outcome.err
    instance = adr_opt.load("out.json")
    assert instance.name == "catalogue-n12"
    assert instance.epoch == max(record.epoch for record in RECORDS)
    assert instance.mission.duration_s == 7 * 86400.0
    assert instance.chaser.tank.delta_v_m_s == 3000.0


def test_options_reach_the_instance(cli: Cli) -> None:
    """Epoch, filters, station and limits are those of the call; the rest is accounted for."""
    path = write("a.csv", as_csv(field(200)))
    outcome = cli(
        f"import {path} --out out.json --epoch 2025-03-05T12:00:00 --json --altitude :900 "
        "--inclination 80:100 --raan 270:90 --name deb --max-targets 9 --station "
        "750,86.4,10,20 --duration-days 3 --delta-v 1500 --dynamics two-body"
    )
    assert outcome.status == 0
    told = json.loads(outcome.out)
    instance = adr_opt.load("out.json")
    assert told["epoch"] == "2025-03-05T12:00:00Z" == json.loads(instance.to_json())["epoch"]
    assert instance.mission.duration_s == 3 * 86400.0
    assert instance.chaser.tank.delta_v_m_s == 1500.0
    assert instance.stations[0].orbit.semi_major_axis_m == 6378137.0 + 750e3
    assert instance.stations[0].orbit.true_anomaly_deg == 20.0
    assert told["targets"] == len(instance.targets) == 9
    assert told["read"] == 200
    counts = told["dropped_counts"]
    assert set(counts) == {"altitude", "inclination", "raan", "max-targets"}
    assert sum(counts.values()) == 191 == len(told["dropped"])
    assert all(
        {"source", "line", "object", "reason", "detail"} <= set(drop) for drop in told["dropped"]
    )
    assert told["formats"] == {"a.csv": "OMM CSV"}
    assert told["elements"] == "mean elements of SGP4, TEME of the epoch"
    assert [warning[:11] for warning in told["warnings"]] == ["nodes drift"]


def test_quiet_says_nothing(cli: Cli) -> None:
    """With --quiet only the file is written."""
    outcome = cli("import", write("a.csv", as_csv(RECORDS)), "--out", "out.json", "--quiet")
    assert (outcome.status, outcome.out, outcome.err) == (0, "", "")


def test_several_files_make_one_catalogue(cli: Cli) -> None:
    """Files of different spellings are imported together."""
    first, second = write("a.tle", as_tle(RECORDS[:5])), write("b.xml", as_xml(RECORDS[5:]))
    assert cli("import", first, second, "--out", "out.json").status == 0
    assert len(adr_opt.load("out.json").targets) == 12


def spoilt(change: Any) -> str:
    """Three-line elements with the lines of the second object changed."""
    texts = [line for record in RECORDS[:3] for line in (record.name, *tle_lines(record))]
    texts[3:6] = change(*texts[3:6])
    return "\n".join(texts) + "\n"


def csv_with(key: str, value: Any) -> str:
    """CSV whose second object has another value."""
    fields = [omm_fields(record) for record in RECORDS[:3]]
    fields[1][key] = value
    return "\n".join(
        [",".join(fields[0]), *(",".join(str(item) for item in row.values()) for row in fields)]
    )


BAD_ROWS = {
    "checksum": (
        spoilt(lambda name, one, two: [name, one[:68] + str((int(one[68]) + 1) % 10), two]),
        "line 5",
        "checksum",
        "OBJECT 1 DEB 10001",
    ),
    "second checksum": (
        spoilt(lambda name, one, two: [name, one, two.replace("2 10001", "2 10002")]),
        "line 6",
        "checksum",
    ),
    "truncated": (
        spoilt(lambda name, one, two: [name, one, two[:60]]),
        "line 6",
        "60 of 69 characters",
    ),
    "truncated first": (
        spoilt(lambda name, one, two: [name, one[:7], two]),
        "line 5",
        "7 of 69 characters",
    ),
    "missing second": (spoilt(lambda name, one, two: [name, one]), "line 5", "without its line 2"),
    "missing first": (spoilt(lambda name, one, two: [name, two]), "line 5", "without its line 1"),
    "name only": (spoilt(lambda name, one, two: [name]), "line 4", "'OBJECT 1 DEB' has no TLE"),
    "other object": (
        spoilt(lambda name, one, two: [name, one, tle_lines(RECORDS[5])[1]]),
        "line 6",
        "about object 10005, line 1 about 10001",
    ),
    "letters": (
        spoilt(lambda name, one, two: [name, one, sgp4_io.fix_checksum(two[:10] + "x" + two[11:])]),
        "line 6",
        "breaks its format",
    ),
    "inclination": (
        spoilt(lambda name, one, two: [name, one, sgp4_io.fix_checksum(f"2 10001 19{two[10:]}")]),
        "line 6",
        "inclination 19",
        "not 0 to 180",
    ),
    "not ascii": (
        spoilt(lambda name, one, two: [name, one[:40] + "é" + one[41:], two]),
        "line 5",
        "checksum",
    ),
    "hyperbolic": (
        csv_with("ECCENTRICITY", 1.2),
        "line 3 (OBJECT 1 DEB 10001)",
        "ECCENTRICITY = 1.2: no closed orbit",
    ),
    "no number": (csv_with("BSTAR", "small"), "line 3", "field BSTAR = small: must be a number"),
    "not finite": (csv_with("BSTAR", "nan"), "line 3", "field BSTAR = nan: must be a number"),
    "missing": (csv_with("INCLINATION", ""), "line 3", "field INCLINATION: missing"),
    "range": (
        csv_with("INCLINATION", "-3"),
        "line 3",
        "INCLINATION = -3: must be between 0 and 180",
    ),
    "epoch": (csv_with("EPOCH", "yesterday"), "line 3", "field EPOCH = yesterday: must be a time"),
    "no such day": (csv_with("EPOCH", "2025-02-30T00:00:00"), "line 3", "there is no such time"),
    "columns": (csv_with("OBJECT_NAME", "A,B"), "line 3", "18 values under 17 columns"),
    "cut row": (as_csv(RECORDS)[:-30], "line 13", "values under 17 columns"),
    "quote": (csv_with("OBJECT_NAME", '"A'), "line 3", "not a line of CSV"),
    "json cut": (as_json(RECORDS)[:-30], "line 1, record 12", "not JSON"),
    "json item": ("[1,\n2]", "line 1, record 1", "'1' is not a JSON object"),
    "json behind": (as_json(RECORDS) + "]", "line 1", "not JSON: ']' after record 12"),
    "json depth": ("[" + '{"a":' * 100_000, "line 1", "not JSON"),
    "json bool": (
        as_json(RECORDS).replace('"EPHEMERIS_TYPE": 0', '"EPHEMERIS_TYPE": true', 1),
        "EPHEMERIS_TYPE = True: must be a whole number",
    ),
    "json twice": (
        as_json(RECORDS).replace('"EPHEMERIS_TYPE": 0', '"INCLINATION": 9', 1),
        "line 1, record 1",
        "field INCLINATION is given twice in one object",
    ),
    "json spelt twice": (
        as_json(RECORDS).replace('"EPHEMERIS_TYPE": 0', '" bstar ": 0', 1),
        "field BSTAR is given twice in one object",
    ),
    "kvn line": (
        as_kvn(RECORDS).replace("MEAN_MOTION          =", "MEAN_MOTION", 1),
        "line 12 (OBJECT 0 DEB 1960-001A)",
        "is not KEYWORD = value",
    ),
    "kvn unit": (
        as_kvn(RECORDS).replace("[deg]", "[rad]", 1),
        "field INCLINATION: its unit is 'rad'",
    ),
    "kvn twice": (
        as_kvn(RECORDS).replace("REV_AT_EPOCH", "BSTAR", 1),
        "field BSTAR is given twice",
    ),
    "xml cut": (as_xml(RECORDS)[:-30], "not well-formed XML"),
    "xml unit": (
        as_xml(RECORDS).replace("<BSTAR>", '<BSTAR units="m">', 1),
        "field BSTAR: its unit is 'm'",
    ),
    "duplicate": (
        as_csv([*RECORDS, RECORDS[3]]),
        "line 14 (OBJECT 3 DEB 10003)",
        "the object is also in bad.txt, line 5",
    ),
}


@pytest.mark.parametrize("fault", BAD_ROWS)
def test_a_bad_row_is_named_with_its_line(cli: Cli, fault: str) -> None:
    """The first bad row ends the import with file, line and value, and the way to skip it."""
    text, *named = BAD_ROWS[fault]
    path = write("bad.txt", text)
    refused(cli("import", path, "--out", "out.json"), "bad.txt: ", "--skip-bad", *named)


@pytest.mark.parametrize(
    "fault", [key for key in BAD_ROWS if key not in ("json item", "json depth")]
)
def test_bad_rows_are_skipped_counted_and_listed(cli: Cli, fault: str) -> None:
    """With --skip-bad the good rows stay, and every other is listed and counted."""
    text, *named = BAD_ROWS[fault]
    outcome = cli("import", write("bad.txt", text), "--out", "out.json", "--skip-bad", "--json")
    assert outcome.status == 0, outcome
    told = json.loads(outcome.out)
    assert told["targets"] == told["read"] == len(adr_opt.load("out.json").targets) >= 2
    # JSON that only goes on behind its end has lost nothing
    lost = {"json behind": 0, "duplicate": 1}.get(fault, 1)
    whole = (
        3 if text.count("\n") < 12 and "[{" not in text else len(RECORDS) + (fault == "duplicate")
    )
    assert told["read"] == whole - lost
    assert 1 <= len(told["dropped"]) <= 2
    assert sum(told["dropped_counts"].values()) == len(told["dropped"])
    assert any(named[0].partition(" (")[0] in line for line in outcome.err.splitlines()) or any(
        named[0] in line for line in outcome.err.splitlines()
    )


def test_of_duplicates_the_newest_is_kept(cli: Cli) -> None:
    """With --skip-bad an object that is given twice has its newer elements."""
    late = omm_fields(RECORDS[3]) | {"EPOCH": "2025-03-02T00:00:00.000000", "OBJECT_NAME": "NEW"}
    first = write("a.json", json.dumps([late]))
    second = write("b.csv", as_csv(RECORDS))
    for files in ((first, second), (second, first)):
        outcome = cli("import", *files, "--out", "out.json", "--skip-bad", "--json")
        assert json.loads(outcome.out)["dropped_counts"] == {"duplicate": 1}
        assert "NEW 10003" in adr_opt.load("out.json").names
        assert len(adr_opt.load("out.json").targets) == 12


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("", "empty; download the catalogue again"),
        (" \n\n", "empty"),
        ("No GP data found", "begins with 'No GP data found'"),
        (
            "<!DOCTYPE html>\n<html><head><title>503 Service Unavailable</title></head></html>",
            "a web page ('503 Service Unavailable'), not a catalogue",
        ),
        ("\n<html lang='en'>", "a web page, not a catalogue"),
        ('<?xml version="1.0"?><!DOCTYPE html PUBLIC "">', "a web page"),
        ('{"error": "You must be logged in"}', "You must be logged in"),
        (
            '<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY b "c"><!ENTITY d "&b;&b;">]>\n<a>&d;</a>',
            "line 2: a document type (DOCTYPE)",
        ),
        ("<a>" * 1000, "line 1: elements nested 50 deep"),
        ("<opm></opm>", "an OPM, not an OMM"),
        ("<ndm></ndm>", "no element set in it (OMM XML)"),
        ("[]", "no element set in it (OMM JSON)"),
        ("CCSDS_OEM_VERS = 2.0\n", "an OEM, not an OMM"),
        ('{"format": "adr-opt-instance/3", "epoch": "2026"}', "a JSON object that is not an OMM"),
        ("CCSDS_OMM_VERS = 2.0\n", "field "),
        ("EPOCH,MEAN_MOTION,INCLINATION\n", "line 1: no column ECCENTRICITY"),
        ("NORAD_CAT_ID;EPOCH\n", "no column EPOCH"),
        ("EPOCH,MEAN_MOTION,ECCENTRICITY,INCLINATION,EPOCH\n", "two columns EPOCH"),
        (as_csv(RECORDS).partition("\n")[0], "no element set in it (OMM CSV)"),
        ("\0\1\2", "not a text file"),
        ("hello, world\n" * 10, "neither TLE nor OMM, it begins with 'hello, world'"),
    ],
)
@pytest.mark.parametrize("more", [[], ["--skip-bad"]])
def test_files_that_are_no_catalogue(cli: Cli, content: str, named: str, more: list[str]) -> None:
    """What servers send instead of a catalogue is told in one sentence, also with --skip-bad."""
    refused(
        cli("import", write("bad.txt", content), "--out", "out.json", *more), "bad.txt: ", named
    )


def test_files_in_other_wrappings(cli: Cli) -> None:
    """Compressed files and UTF-16 are named as such."""
    Path("a.gz").write_bytes(b"\x1f\x8b\x08\0\0")
    refused(cli("import", "a.gz", "--out", "out.json"), "a.gz: compressed; unpack it first")
    Path("a.csv").write_text(as_csv(RECORDS), encoding="utf-16")
    refused(cli("import", "a.csv", "--out", "out.json"), "a.csv: a text in UTF-16")
    refused(cli("import", "none", "--out", "out.json"), "none: no such file")
    refused(cli("import", ".", "--out", "out.json"), ".: this is a folder")


def test_files_of_gigabytes_are_refused(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file beyond the limit is refused by its size, and an endless one when it passes it."""
    with Path("huge.tle").open("wb") as file:
        file.truncate(3 * 2**30)
    refused(cli("import", "huge.tle", "--out", "out.json"), "huge.tle: larger than 256 MiB")
    monkeypatch.setattr(reading, "LARGEST_BYTES", 2**20)
    if Path("/dev/zero").exists():
        refused(cli("import", "/dev/zero", "--out", "out.json"), "/dev/zero: larger than 1 MiB")


@pytest.mark.parametrize(
    "begin", ["", "1 ", "CCSDS_OMM_VERS = 2\nEPOCH = ", "[", "EPOCH,MEAN_MOTION,"]
)
def test_a_line_of_megabytes_does_no_harm(cli: Cli, begin: str) -> None:
    """A line without end is one bad row or no catalogue, in seconds."""
    path = write("long.txt", begin + "7" * 5_000_000)
    refused(cli("import", path, "--out", "out.json"), "long.txt: ")
    assert len(cli("import", path, "--out", "out.json").err) < 400


def test_too_many_bad_rows(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file with nothing but bad rows ends before its list fills the memory."""
    monkeypatch.setattr(reading, "MOST_BAD_ROWS", 50)
    path = write("bad.tle", "1 00005\n" * 1000)
    refused(cli("import", path, "--out", "out.json", "--skip-bad"), "more than 50 bad rows")


def test_objects_that_sgp4_cannot_bring_to_the_epoch(cli: Cli) -> None:
    """A decayed object is named with SGP4's error; --skip-bad leaves it out and lists it."""
    fields = [omm_fields(record) for record in RECORDS]
    fields[4] |= {"MEAN_MOTION": 16.2, "BSTAR": 0.1, "ECCENTRICITY": 0.001}
    fields[7] |= {"DECAY_DATE": "2025-02-28"}
    path = write("a.json", json.dumps(fields))
    call = ("import", path, "--out", "out.json", "--epoch", "2025-03-06T00:00:00Z")
    refused(cli(*call), "record 5 (OBJECT 4 DEB 10004): SGP4 error 6", "1 more", "--skip-bad")
    outcome = cli(*call, "--skip-bad", "--json")
    told = json.loads(outcome.out)
    assert [(drop["object"], drop["reason"]) for drop in told["dropped"]] == [
        ("OBJECT 4 DEB 10004", "decayed"),
        ("OBJECT 7 DEB 10007", "decayed"),
    ]
    assert told["targets"] == 10
    assert "left out: a.json: line 1, record 8 (OBJECT 7 DEB 10007): decayed on 2025-02-28" in (
        outcome.err
    )
    refused_station = cli(*call, "--skip-bad", "--station", "10004")
    assert refused_station.status == 2
    assert "OBJECT 4 DEB 10004" in refused_station.err
    assert "give another --station or --epoch" in refused_station.err


def test_epochs_far_from_the_elements(cli: Cli) -> None:
    """Weeks are warned of with the days; decades are refused."""
    path = write("a.csv", as_csv(RECORDS))
    outcome = cli("import", path, "--out", "out.json", "--epoch", "2025-04-01")
    assert outcome.status == 0
    assert "warning: the elements of 12 of 12 objects are more than 7 days from the epoch; " in (
        outcome.err
    )
    assert " 31.0 days from it" in outcome.err or " 30." in outcome.err
    Path("out.json").unlink()
    refused(
        cli("import", path, "--out", "out.json", "--epoch", "2099-01-01"),
        "line 2 (OBJECT 0 DEB 10000): its elements are 269",
        "days from the epoch",
    )


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--altitude", "100:200"], "no object is left of 12 (left out: altitude 12); widen"),
        (["--name", "ROCKET"], "no object is left of 12 (left out: name 12); widen the filters"),
        (["--altitude", "800:700"], "altitude 800:700: the first must not exceed the second"),
        (["--altitude", "high"], "--altitude = 'high': give two numbers as LO:HI"),
        (["--altitude", ":"], "--altitude = ':'"),
        (["--inclination", "nan:90"], "--inclination = 'nan:90'"),
        (["--inclination", "0:1e999"], "--inclination = '0:1e999'"),
        (["--raan", "20:"], "--raan = '20:': give two numbers as LO:HI"),
        (["--name", " "], "--name '': give a part of a name"),
        (["--epoch", "soon"], "--epoch 'soon': give a time like 2026-01-01T00:00:00Z"),
        (["--epoch", "0001-01-01T00:00:00+10:00"], "--epoch '0001-01-01T00:00:00+10:00'"),
        (["--max-targets", "0"], "--max-targets = 0: must be a positive number"),
        (["--station", "700,96"], "--station '700,96': give ALTITUDE_KM,INCLINATION,RAAN"),
        (["--station", "700,96,nan"], "--station '700,96,nan'"),
        (["--station", "-10,96,0"], "--station: altitude -10 km: must be between 0 and 100000"),
        (["--station", "700,190,0"], "--station: inclination 190: must be between 0 and 180"),
        (["--station", "700,90,1e9"], "--station '700,90,1e9': angles"),
        (["--station", "MIR"], "--station 'MIR': no object has this number or name"),
        (["--station", ""], "--station ''"),
        (["--duration-days", "-1"], "--duration-days = -1: must be a positive number"),
        (["--duration-days", "1e308"], "--duration-days = 1e+308: must be at most 36525"),
        (["--delta-v", "nan"], "--delta-v = nan: must be a positive number"),
    ],
)
def test_options_out_of_range(cli: Cli, options: list[str], named: str) -> None:
    """Each option that makes no sense is named with its value and what would."""
    path = write("a.csv", as_csv(RECORDS))
    refused(cli("import", path, "--out", "out.json", *options), named)


def test_a_name_of_several_objects_is_no_station(cli: Cli) -> None:
    """A station told by a name that several objects have asks for the number."""
    path = write("a.csv", as_csv(field(100)))
    outcome = cli("import", path, "--out", "out.json", "--station", "OBJECT 1 DEB")
    refused(outcome, "2 objects have this name; give the catalogue number, 10001 for the first")


def test_the_input_is_not_overwritten(cli: Cli) -> None:
    """--out must not name a file that is read."""
    path = write("a.csv", as_csv(RECORDS))
    outcome = cli("import", path, "--out", path)
    assert outcome.status == 2
    assert "a.csv: this is the input" in outcome.err
    assert cli("import", "--out", "out.json").status == 2


def test_without_sgp4_the_extra_is_named(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where sgp4 is not installed, the sentence says how to install it."""
    real = builtins.__import__

    def without(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name.partition(".")[0] == "sgp4":
            raise ImportError(name)
        return real(name, *arguments, **keywords)

    path = write("a.csv", as_csv(RECORDS))
    monkeypatch.setattr(builtins, "__import__", without)
    outcome = cli("import", path, "--out", "out.json")
    monkeypatch.undo()
    assert outcome.status == 2
    assert "sgp4: install the extra with pip install 'adr-opt[astro]'" in outcome.err


def test_the_example_cloud_is_what_its_script_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """examples/catalogue/cloud.tle is the output of the script beside it."""
    folder = ROOT / "examples" / "catalogue"
    runpy.run_path(str(folder / "make_cloud.py"), run_name="__main__")
    assert capsys.readouterr().out == (folder / "cloud.tle").read_text(encoding="utf-8")


def test_the_python_of_the_page_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The Python on docs/importing.md runs as it stands and finds targets."""
    monkeypatch.chdir(ROOT)
    page = (ROOT / "docs" / "importing.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    exec(page.partition("```python\n")[2].partition("```")[0], names)
    made = names["made"]
    assert len(made.instance.targets) == 40
    assert sum(made.counts.values()) == 20


def test_the_page_lists_every_reason() -> None:
    """docs/importing.md has every reason for which the code leaves something out."""
    page = (ROOT / "docs" / "importing.md").read_text(encoding="utf-8")
    stated = {
        reason
        for row in re.findall(r"^\| ((?:`[a-z0-9-]+`(?:, )?)+) \|", page, re.MULTILINE)
        for reason in re.findall(r"`([a-z0-9-]+)`", row)
    }
    used = {"malformed", *import_.FILTERS}
    for module in (ROOT / "adr_opt" / "sources" / "catalogue").glob("*.py"):
        text = module.read_text(encoding="utf-8")
        used |= set(re.findall(r'(?:return|why =) "([a-z0-9-]+)", ', text))
        used |= set(
            re.findall(r'(?:Dropped\.of\(\w+, |closed orbit", |characters", )"([a-z]+)"', text)
        )
    assert {"decayed", "not-sgp4", "far-epoch", "sgp4-error", "duplicate", "hyperbolic"} <= used
    assert used <= stated
