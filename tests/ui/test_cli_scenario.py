"""``scenario``: tables, page and answer agree, runs go on, and bad input in one sentence."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from catalogue_files import as_csv, field
from conftest import Cli

RECORDS = field(12)

LAUNCHES = (
    "year,count,kind,mass,size,perigee,apogee,inclination,every\n1,2,payload,500,2,700,710,98,2\n"
)


@pytest.fixture
def drawn(cli: Cli):
    """`scenario` of a catalogue of twelve with a campaign of two visits, with more options."""
    Path("a.csv").write_text(as_csv(RECORDS), encoding="utf-8")
    Path("l.csv").write_text(LAUNCHES, encoding="utf-8")
    made = cli(
        "import a.csv --max-targets 2 --launches 1 --kits 2 --duration-days 90 --out "
        "campaign.json --quiet"
    )
    assert made.status == 0, made
    return lambda line="", *more: cli(f"scenario a.csv --method greedy {line}", *more)


def test_tables_page_and_answer_agree(drawn) -> None:
    """The answer is JSON, the page has its sections and no scripts, tables sum up to the answer."""
    call = (
        "--campaign campaign.json --years 4 --every 2 --targets 4 --seeds 2 --launches "
        "l.csv --explosions 0.05 --time-limit 100 --folder years --out o.csv --removals "
        "r.csv --page p.html --species debris=Dx --altitude :1000 --json --quiet"
    )
    outcome = drawn(call)
    assert outcome.status == 0, outcome
    told = json.loads(outcome.out)
    assert told["years"] == [0, 1, 2, 3, 4]
    assert told["with"]["launched"]["mean"] == [0.0, 2.0, 0.0, 2.0, 0.0]
    removed = list(csv.DictReader(Path("r.csv").read_text("utf-8").splitlines()))
    assert removed
    assert sum(float(row["removed"]) for row in removed) == pytest.approx(told["removed"]["mean"])
    assert {row["species"] for row in removed} <= {"Dx", "S"}
    yearly = list(csv.DictReader(Path("o.csv").read_text("utf-8").splitlines()))
    ends = [
        float(row["number"])
        for row in yearly
        if (row["year"], row["case"]) == ("4", "with") and row["species"] != "fragment"
    ]
    assert sum(ends) == pytest.approx(told["with"]["objects"]["mean"][4])
    page = Path("p.html").read_text(encoding="utf-8")
    for title in (
        "Objects",
        "Expected catastrophic collisions of pairs",
        "Campaigns",
        "Assumptions",
    ):
        assert f"<h2>{title}</h2>" in page
    assert "a year × 10⁻" in page
    assert "<script" not in page
    assert "http" not in page.replace("http-equiv", "")
    again = drawn(call)
    assert json.loads(again.out) == told
    assert len(Path("years/years.jsonl").read_text("utf-8").splitlines()) == 11


def test_without_a_campaign_both_futures_are_told(drawn) -> None:
    """No campaign is no error: a table of years, the same in both columns."""
    outcome = drawn("--years 30 --no-drag --no-collisions --page p.html")
    assert outcome.status == 0, outcome
    assert "12 objects on 2025-03-01" in outcome.err
    rows = [line for line in outcome.out.splitlines() if line.strip().startswith(("│", "0", "30"))]
    assert rows
    page = Path("p.html").read_text(encoding="utf-8")
    assert "No campaign took place." in page
    assert "There are none in any year." in page


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (("--years", 201), "--years 201: must be at least 1 and at most 200"),
        (("--years", -3), "--years -3"),
        (("--worth-years", 500), "--worth-years 500"),
        (("--campaign-failure", 2), "--campaign-failure 2: must be a chance between 0 and 1"),
        (("--shells", "500"), "--shells '500'"),
        (("--shells", "900:200:3"), "--shells: from 900 to 200 km"),
        (("--species", "moon=M"), "--species 'moon=M'"),
        (("--altitude", "900:700"), "--altitude '900:700'"),
        (("--jobs", -1), "--jobs -1"),
        (("--method", "oracle"), "oracle"),
        (("--exclude", " "), "--exclude ''"),
        (("--out", "x.csv", "--removals", "x.csv"), "x.csv"),
        (("--page", "x.pdf"), "x.pdf"),
        (("--campaign", "a.csv"), "a.csv"),
        (("--folder", "a.csv"), "years.jsonl"),
    ],
)
def test_bad_options_are_refused_in_a_sentence(drawn, more: tuple[Any, ...], sentence: str) -> None:
    """One sentence names the option, and nothing is written."""
    before = sorted(Path().iterdir())
    outcome = drawn("--years 2", *more)
    assert outcome.status == 2, outcome
    assert sentence in outcome.err
    assert outcome.err.count("\n") == 1
    assert sorted(Path().iterdir()) == before


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "empty"),
        ("year,count\n", "line 1: give the columns"),
        (LAUNCHES.replace("mass", "weight"), "line 1: give the columns"),
        (LAUNCHES.replace("payload", "moon"), "line 2: kind = 'moon'"),
        (LAUNCHES.replace("1,2,", "1.5,2,"), "year = 1.5"),
        (LAUNCHES.replace("1,2,", "-1,2,"), "year = -1"),
        (LAUNCHES.replace("500,2", "-500,2"), "mass = -500"),
        (LAUNCHES.replace("700,710", "800,710"), "apogee 710 km is below the perigee"),
        (LAUNCHES.replace("98,2", "98,0.5"), "every = 0.5"),
        (LAUNCHES.replace(",98,2", ",98"), "line 2: 8 values under 9 columns"),
        (LAUNCHES.replace("payload", "p" * 131_073), "line 2: not a line of CSV"),
        (LAUNCHES.replace("payload", '"payload'), "line 2: not a line of CSV"),
    ],
)
def test_bad_tables_of_launches_are_refused(drawn, text: str, sentence: str) -> None:
    """File, line and value are named."""
    Path("l.csv").write_text(text, encoding="utf-8")
    outcome = drawn("--years 2 --launches l.csv")
    assert outcome.status == 2, outcome
    assert "l.csv" in outcome.err
    assert sentence in outcome.err
    assert outcome.err.count("\n") == 1
