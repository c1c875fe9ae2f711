"""``tradeoff`` over designs: table, JSON and page agree, and bad calls are one sentence."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from catalogue_files import as_csv, field
from conftest import Cli, Outcome, refused
from rated_fields import pairs_text, rated, worths_of_sets

import adr_opt
from adr_opt.common.errors import InputError, MissingExtra

COSTS = ("--launch-cost", "10e6", "--kit-cost", "2e6", "--kg-cost", "50000")
VARY = ("--vary", "launches=1", "--vary", "kits=1,2")


class Addresses(HTMLParser):
    """All that a page names: addresses, identities, rows of designs."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.hrefs: list[str] = []
        self.sources: list[str] = []
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what may lead somewhere."""
        found = dict(attrs)
        self.tags.append(tag)
        self.hrefs += [found["href"] or ""] if "href" in found else []
        self.ids += [found["id"] or ""] if "id" in found else []
        self.sources += [found[name] or "" for name in ("src", "srcset", "data") if name in found]


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """An instance and the worths of its targets, in the folder where ``cli`` runs."""
    whole = rated(targets=3)
    (tmp_path / "i.json").write_text(whole.to_json(), encoding="utf-8")
    (tmp_path / "w.json").write_text(pairs_text(worths_of_sets(whole)), encoding="utf-8")
    return tmp_path


def rows_of(outcome: Outcome) -> list[list[str]]:
    """The cells of the table that is printed."""
    lines = [line for line in outcome.out.splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in line.strip("│").split("│")] for line in lines]


def test_table_json_and_page_say_the_same(cli: Cli, files: Path) -> None:
    """Each number of the table is that of `--json` and of the page, which has a dot for each."""
    call = ("tradeoff", "i.json", *VARY, *COSTS, "--worth", "w.json", "--out", "d.jsonl")
    first = cli(*call, "--page", "d.html", "--plot", "d.svg")
    assert first.status == 0
    rows = rows_of(first)
    told = json.loads(cli(*call, "--json", "--quiet").out)
    assert (told["unit"], told["designs"], len(rows)) == ("fragment-years", 2, 2)
    assert told["varied"] == {"launches": [1.0], "kits": [1.0, 2.0]}
    text = (files / "d.html").read_text(encoding="utf-8")
    for number, (point, row) in enumerate(zip(told["points"], rows, strict=True), start=1):
        assert row[0] == str(number)
        assert [float(cell) for cell in row[1:3]] == [
            point["design"]["launches"],
            point["design"]["kits"],
        ]
        for name, cell in zip(("floor", "worth", "bound"), row[3:6], strict=True):
            assert float(cell) == pytest.approx(point[name], rel=1e-3)
        assert row[6] == f"{point['gap']:.1%}"
        assert float(row[7]) == pytest.approx(point["euros"] / 1e6, abs=0.006)
        assert [int(cell) for cell in row[9:11]] == [point["launches_used"], point["removals"]]
        assert (row[11] == "yes") == point["on_front"]
        written = re.search(rf'<tr data-design="{number}">(.*?)</tr>', text)
        assert written is not None
        assert [re.sub("<.*?>", "", cell) for cell in written[1].split("</td>")[:-1]] == row
    page = Addresses(text)
    assert page.tags.count("circle") == 4 + 2  # of the designs and of the legend
    for number in (1, 2):
        assert page.hrefs.count(f"#design-{number}") == 2  # of the dot and of the row
        assert page.ids.count(f"design-{number}") == 1


@pytest.mark.parametrize("drawn", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_page_asks_for_nothing_and_leads_to_plans(
    drawn: bool, cli: Cli, files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No address leads away, no script runs, and files of plans are there and hold."""
    if drawn:
        pytest.importorskip("plotly")
    else:
        monkeypatch.setattr(
            "adr_opt.ui.report.write_report", lambda instance, plan, path: path.touch()
        )
    call = ("tradeoff", "i.json", *VARY, *COSTS, "--worth", "w.json", "--quiet")
    assert cli(*call, "--page", "d.html", "--plans", "plans").status == 0
    text = (files / "d.html").read_text(encoding="utf-8")
    page = Addresses(text)
    assert not page.sources
    assert {"script", "iframe", "object", "img", "form"}.isdisjoint(page.tags)
    assert "url(" not in text
    assert "@import" not in text
    assert "//" not in re.sub(r"<style>.*?</style>", "", text, flags=re.DOTALL)
    linked = [href for href in page.hrefs if not href.startswith(("#", "data:,"))]
    assert len(linked) == len(set(linked)) == 6
    for href in linked:
        assert (files / href).is_file()
    for number in (1, 2):
        stem = files / "plans" / f"design-{number}"
        found = cli("check", stem.with_suffix(".instance.json"), stem.with_suffix(".plan.json"))
        assert found.status == 0


def test_a_point_without_a_plan_is_said(cli: Cli, files: Path) -> None:
    """Below the price of a launch there is no plan: exit status 1, and its section says why."""
    call = ("tradeoff", "i.json", "--vary", "budget=1e6,40e6", *COSTS, "--page", "d.html")
    found = cli(*call, "--json", "--quiet")
    assert found.status == 1
    first, second = json.loads(found.out)["points"]
    assert (first["bound"], first["routes"]) == (0.0, {})
    assert second["euros"] <= 40e6
    assert "No launch is within the budget." in (files / "d.html").read_text(encoding="utf-8")


def test_plans_are_written_without_reports_where_charts_are_not_installed(
    cli: Cli, files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Instances and plans are there, and a message says what is lacking."""

    def refuse(*_: object) -> None:
        raise MissingExtra("a report", "plotly", "viz")

    monkeypatch.setattr("adr_opt.ui.report.write_report", refuse)
    found = cli("tradeoff", "i.json", *VARY, *COSTS, "--plans", "plans")
    assert found.status == 0
    assert found.err.count("plans without reports: ") == 1
    assert len(list((files / "plans").iterdir())) == 4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (VARY, "give --launch-cost, --kit-cost or --kg-cost"),
        ((*VARY, *COSTS, "--worth", "i.json"), "i.json: "),
        ((*VARY, *COSTS, "--worth", "none.json"), "none.json: no such file"),
        ((*VARY, *COSTS, "--worth", "w.json", "--out", "w.json"), "w.json: this is the input"),
        ((*VARY, *COSTS, "--frontier", "f.csv"), "--frontier: designs have none"),
        ((*VARY, *COSTS, "--page", "d.txt"), "d.txt: the page is HTML"),
        ((*VARY, *COSTS, "--plot", "d.txt"), "d.txt: pictures end in .svg"),
        ((*VARY, *COSTS, "--plans", "i.json"), "i.json: this is a file"),
        ((*VARY, *COSTS, "--plans", "no/where"), "no/where: the folder no does not exist"),
        ((*VARY, "--launch-cost", "-1"), "price of a launch: -1 euros"),
        ((*VARY, "--launch-cost", "nan"), "price of a launch: nan euros"),
        ((*COSTS, "--vary", "mass=1"), "'mass' is unknown"),
        (COSTS, "nothing is varied"),
        (("--vary", "duration=10,20", "--plans", "i.json"), "i.json: this is a file"),
        ((*VARY, *COSTS, "--method", "magic"), "magic"),
        ((*VARY, *COSTS, "--time-limit", "0"), "time limit"),
        ((*VARY, *COSTS, "--jobs", "-1"), "jobs = -1"),
    ],
)
def test_bad_calls_are_one_sentence(
    arguments: tuple[str, ...], said: str, cli: Cli, files: Path
) -> None:
    """Exit status 2, one sentence, and no file is written."""
    before = sorted(files.iterdir())
    refused(cli("tradeoff", "i.json", *arguments), said)
    assert sorted(files.iterdir()) == before


def test_candidates_of_worth_become_targets(cli: Cli, tmp_path: Path) -> None:
    """`worth --pairs` and `import --only-prized` make a campaign whose sets have worths."""
    (tmp_path / "a.csv").write_text(as_csv(field(30)), encoding="utf-8")
    call = ("worth", "a.csv", "--out", "p.csv", "--pairs", "w.json", "--candidates", "7")
    assert cli(*call, "--quiet").status == 0
    imported = ("import", "a.csv", "--launches", "1", "--out", "i.json", "--no-refuelling")
    found = cli(*imported, "--prizes", "p.csv", "--only-prized", "--json", "--quiet")
    assert found.status == 0
    assert json.loads(found.out)["dropped_counts"]["only-prized"] == 23
    from adr_opt.analysis.design.rating import rating_of
    from adr_opt.sources.worth import load_set_worths

    instance, worths = adr_opt.load("i.json"), load_set_worths("w.json")
    part, rating = rating_of(instance, worths)
    assert part == instance
    assert rating.worths is not None
    # Prizes of the file are the floors among the same candidates.
    assert rating.planned(instance) == instance
    refused(cli(*imported, "--only-prized"), "there are no rows without --prizes")
    refused(cli(*call, "--pairs", "p.csv"), "p.csv")


def test_a_broken_worth_file_names_its_field() -> None:
    """Errors of the format are sentences, too."""
    from adr_opt.common.files import parse_model
    from adr_opt.sources.worth.worth_file import WorthFile

    content: dict[str, Any] = json.loads(pairs_text(worths_of_sets(rated(targets=3))))
    content["prize_unit"] = 0.0
    with pytest.raises(InputError, match=r"w\.json: .*prize_unit"):
        parse_model(json.dumps(content), WorthFile, "w.json")
