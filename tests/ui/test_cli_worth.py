"""``worth``: prizes that ``import`` takes, details, page, and bad input in one sentence."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from catalogue_files import as_csv, field
from conftest import Cli

import adr_opt
from adr_opt.sources.worth.prizes import DETAILS

RECORDS = field(30)

SATCAT = (
    "#JCAT\tSatcat\tPiece\tType\tName\tMass\tMassFlag\tDryMass\tDryFlag\tLength\tLFlag\tDiameter\t"
    "DFlag\n# Updated 2019 May  1\n"
    "S10000\t10000\t1960-001A\tR2\tSTAGE\t30000\t \t 8900\t?\t10.4\t \t 3.9\t \n"
)


@pytest.fixture
def rated(cli: Cli):
    """`worth` of a catalogue of thirty, with more options."""
    Path("a.csv").write_text(as_csv(RECORDS), encoding="utf-8")
    Path("satcat.tsv").write_text(SATCAT, encoding="utf-8")
    return lambda *more: cli("worth", "a.csv", "--out", "p.csv", *more)


def test_import_reads_the_prizes_of_worth(rated, cli: Cli) -> None:
    """The prizes and masses of all objects reach the targets of an instance as written."""
    assert rated("--satcat", "satcat.tsv", "--candidates", 0).status == 0
    rows = {
        row["object"]: row for row in csv.DictReader(Path("p.csv").read_text("utf-8").splitlines())
    }
    assert len(rows) == len(RECORDS)
    outcome = cli("import", "a.csv", "--prizes", "p.csv", "--out", "i.json")
    assert outcome.status == 0, outcome
    targets = {target.name: target for target in adr_opt.load("i.json").targets}
    for record in RECORDS:
        row, target = rows[str(record.number)], targets[record.label]
        assert target.prize == float(row["prize"]) == int(row["prize"])
        assert target.mass_kg == pytest.approx(float(row["mass"]))
    assert targets[RECORDS[0].label].mass_kg == 8900.0


def test_details_page_and_answer_agree(rated) -> None:
    """Details have their columns and units, the page its sections, the answer what both say."""
    outcome = rated(
        "--satcat",
        "satcat.tsv",
        "--candidates",
        12,
        "--details",
        "d.csv",
        "--page",
        "w.html",
        "--json",
        "--quiet",
    )
    assert outcome.status == 0, outcome
    told = json.loads(outcome.out)
    rows = list(csv.DictReader(Path("d.csv").read_text("utf-8").splitlines()))
    assert tuple(rows[0]) == DETAILS
    assert len(rows) == told["candidates"] == 12
    assert [row["object"] for row in rows[:10]] == [each["object"] for each in told["best"]]
    alone = [float(row["worth_alone"]) for row in rows]
    assert alone == sorted(alone, reverse=True)
    for row in rows:
        floor, unit = float(row["floor"]), told["unit"]["value"]
        assert row["unit"] == f"{unit:g} fragment-years"
        assert float(row["prize"]) * unit <= floor * (1.0 + 1e-6)
        assert floor <= float(row["worth_alone"])
    assert told["satcat"] == {"objects": 1, "updated": "2019 May  1", "matched": 1}
    assert sum(told["masses"].values()) == told["objects"] == 30
    page = Path("w.html").read_text(encoding="utf-8")
    for title in ("Most worth removing", "Who is dangerous to whom", "Sources", "Assumptions"):
        assert f"<h2>{title}</h2>" in page
    assert "<script" not in page
    assert "http" not in page.replace("http-equiv", "")


def test_default_masses_are_named(rated) -> None:
    """Without a satcat a note says how many masses are defaults, and which; `--json` has them."""
    outcome = rated()
    assert "note: 30 of 30 masses are defaults: " in outcome.err
    assert " kg " in outcome.err
    told = json.loads(rated("--json").out)
    assert sum(told["default_masses"].values()) == 30
    assert "defaults" not in rated("--satcat", "satcat.tsv", "--quiet").err
    Path("t.csv").write_text("object,mass\n10001,5\n99999,7\n", encoding="utf-8")
    outcome = rated("--table", "t.csv")
    assert outcome.status == 0
    assert "note: t.csv: 1 object not in the catalogue, '99999' for one; left out" in outcome.err
    assert "note: 29 of 30 masses are defaults: " in outcome.err


def test_a_satcat_of_another_year_is_counted(rated) -> None:
    """Objects that the satcat lacks have defaults, and a sentence says how many it has."""
    outcome = rated("--satcat", "satcat.tsv")
    assert outcome.status == 0
    assert "the file of 2019 May  1 has 1 of 30 objects" in outcome.err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--years", 201), "--years 201: must be more than 0 and at most 200"),
        (("--years", -1), "--years -1: must be"),
        (("--years", "nan"), "--years nan: must be"),
        (("--candidates", -1), "--candidates -1: must be at least 0"),
        (("--unit", 0), "--unit 0: must be positive"),
        (("--jobs", -1), "--jobs -1: must be at least 0"),
        (("--exclude", ""), "--exclude '': give a part"),
        (("--exclude", "OBJECT"), "0 objects in orbit: a collision needs two"),
        (("--page", "w.txt"), "the page is HTML"),
        (("--details", "p.csv"), "the name of another result"),
        (("--satcat", "none.tsv"), "no such file"),
        (("--satcat", "p.csv"), "this is the input"),
        (("--table", "t.csv"), "t.csv: line 2: mass = -4: must be positive"),
    ],
)
def test_bad_calls_are_refused_in_a_sentence(rated, more: tuple[object, ...], said: str) -> None:
    """Exit status 2, one sentence, and nothing written."""
    Path("t.csv").write_text("object,mass\n10000,-4\n", encoding="utf-8")
    outcome = rated(*more)
    assert outcome.status == 2
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert not Path("p.csv").exists()
