"""``rehearse``: answers, page, replays, and bad input in one sentence."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from conftest import Cli

import adr_opt
from adr_opt.analysis.rehearse.sampling import rehearse
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.ui.plot.studies import delta_v_spread, visits_spread

UNCERTAIN = '{"legs": {"delta_v_factor": {"lognormal_sigma": 0.2}}, "capture": {"success": 0.7}}'


@pytest.fixture
def rehearsed(cli: Cli, tiny_file: Path):
    """`rehearse` of a small plan, with more options."""
    assert cli("solve", tiny_file, "--method", "beam", "--out", "p.json").status == 0
    Path("u.json").write_text(UNCERTAIN, encoding="utf-8")
    return lambda *more: cli("rehearse", tiny_file, "p.json", "--uncertainty", "u.json", *more)


def test_the_answer_has_distributions_bounds_and_gaps(rehearsed) -> None:
    """The JSON answer has what the contract names."""
    outcome = rehearsed("--samples", 40, "--bounds", 4, "--json")
    assert outcome.status == 0, outcome
    told = json.loads(outcome.out)
    assert set(told["prize"]) == {"mean", "standard_error", "quantiles"}
    assert told["samples"] == 40
    assert told["bounds"]["samples"] == told["bounds"]["proven"] == 4
    assert told["bounds"]["required_met"] is told["required_met"] is None
    assert told["bounds"]["perfect"]["mean"] <= told["planned_prize"]
    for gap in told["gaps"].values():
        assert gap["low"] <= gap["gap"] <= gap["high"]


def test_the_page_needs_nothing_from_elsewhere(rehearsed) -> None:
    """The page has fans, losses and tanks, no scripts, and no addresses."""
    outcome = rehearsed("--samples", 30, "--bounds", 2, "--out", "fan.html")
    assert outcome.status == 0, outcome
    page = Path("fan.html").read_text("utf-8")
    for words in ("Prize over time", "5% to 95% of rehearsals", "Bounds on every policy", "Tanks"):
        assert words in page
    assert "<script" not in page
    assert "http" not in page.replace("http-equiv", "")
    assert "by follow: prize" in outcome.out


def test_all_rehearsals_are_in_both_distributions() -> None:
    """Each rehearsal is counted once by its visits and once by its ΔV, within their ends."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    unsure = Uncertainty.model_validate(
        {"legs": {"delta_v_factor": {"lognormal_sigma": 0.2}}, "capture": {"success": 0.7}}
    )
    made = rehearse(instance, plan, unsure, policy="follow", samples=40)
    for chart, ends in (
        (visits_spread(made), [len(each.course) for each in made.outcomes]),
        (delta_v_spread(made), [each.delta_v_m_s for each in made.outcomes]),
    ):
        counted, planned = chart.series
        assert sum(counted.y) == 40
        assert counted.x[0] <= min(ends) < max(ends) <= counted.x[-1]
        assert len(set(planned.x)) == 1


def test_a_replay_is_a_plan_of_its_world(rehearsed, cli: Cli) -> None:
    """`check` finds nothing against the plan of a replay."""
    outcome = rehearsed("--replay", 2, "--out", "r.json", "--out-instance", "w.json", "--json")
    assert outcome.status == 0, outcome
    assert cli("check", "w.json", "r.json").status == 0
    # Not under the name that instances of given connections commonly use, which may be there.
    assert Path("w.connections.parquet").exists()
    assert not Path("connections.parquet").exists()
    assert adr_opt.load_plan("r.json").objective == json.loads(outcome.out)["prize"]


def test_a_required_target_that_is_gone_is_an_answer_of_no(cli: Cli) -> None:
    """Where no rehearsal services all required targets the exit status is 1."""
    instance = adr_opt.generate("tiny", 0)
    first, *others = instance.targets
    instance.replace(targets=(first.replace(required=True), *others)).save("i.json")
    assert cli("solve", "i.json", "--method", "beam", "--out", "p.json").status == 0
    Path("u.json").write_text(json.dumps({"targets": {first.name: {"gone": 1.0}}}))
    outcome = cli("rehearse", "i.json", "p.json", "--uncertainty", "u.json", "--samples", 3)
    assert outcome.status == 1
    assert "all required targets serviced in 0.0%" in outcome.out


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--policy", "none"), "policy 'none' is unknown"),
        (("--samples", 0), "samples = 0"),
        (("--bounds", -1), "--bounds -1"),
        (("--seed", -1), "seed = -1"),
        (("--out", "fan.json"), "the page is HTML"),
        (("--out", "u.json"), "this is the input"),
        (("--out-instance", "w.json"), "only --replay writes an instance"),
        (("--replay", 1), "give --out for the plan and --out-instance"),
        (("--resume", "u.json"), "this is the input"),
        (("--jobs", -1), "jobs = -1"),
        (("--jobs", 2, "--cluster", "tcp://nowhere:1"), "exclude each other"),
        (("--bounds", 1, "--bound-method", "none"), "'none'"),
        (("--bounds", 2_000_000), "samples = 2000000"),
        (("--replay", 1, "--resume", "r.jsonl"), "--resume: --replay flies one world"),
        (("--replay", 1, "--bounds", 2), "--bounds: --replay flies one world"),
        (("--replay", 1, "--samples", 5), "--samples: --replay flies one world"),
        (("--replay", 1, "--jobs", 2), "--jobs: --replay flies one world"),
        (("--replay", 1, "--cluster", "tcp://nowhere:1"), "--cluster: --replay flies one world"),
        (("--resume", "r", "--bounds", 1, "--out", "r.bounds"), "the name of another result"),
    ],
)
def test_a_wrong_call_is_one_sentence(rehearsed, more: tuple[object, ...], said: str) -> None:
    """Bad input ends with status 2, one sentence, and nothing written."""
    before = set(Path().iterdir())
    outcome = rehearsed(*more)
    assert outcome.status == 2
    assert said in outcome.err
    assert outcome.err.count("\n") == 1
    assert set(Path().iterdir()) == before


def test_a_wrong_uncertainty_file_is_one_sentence(rehearsed) -> None:
    """The sentence names the file and the field."""
    Path("u.json").write_text('{"capture": {"success": 2}}', encoding="utf-8")
    outcome = rehearsed()
    assert outcome.status == 2
    assert "u.json" in outcome.err
    assert "capture.success" in outcome.err
    Path("u.json").write_text('{"targets": {"nobody": {"gone": 0.5}}}', encoding="utf-8")
    assert "'nobody' is not a target" in rehearsed().err


def test_another_file_is_no_file_of_rehearsals(rehearsed) -> None:
    """A file that is there and has something else is refused, and stays as it is."""
    Path("other.jsonl").write_text("{}\n")
    outcome = rehearsed("--samples", 2, "--resume", "other.jsonl")
    assert outcome.status == 2
    assert "not a file of a study (rehearsals)" in outcome.err
    assert Path("other.jsonl").read_text() == "{}\n"


def test_a_foreign_file_of_bounds_is_told_before_the_rehearsals(rehearsed) -> None:
    """No rehearsal is written where their bounds cannot be."""
    Path("r.jsonl.bounds").write_text("{}\n")
    outcome = rehearsed("--samples", 2, "--bounds", 1, "--resume", "r.jsonl")
    assert outcome.status == 2
    assert "r.jsonl.bounds: not a file of a study (bounds)" in outcome.err
    assert not Path("r.jsonl").exists()


def _number_in(row: object) -> float:
    """A number of a row that one of the changes makes infinite or none; 0 where it has none."""
    number = row.get("prize", row.get("perfect")) if isinstance(row, dict) else 0.0
    return number if isinstance(number, float) else 0.0


@pytest.mark.parametrize("suffix", ["", ".bounds"])
@pytest.mark.parametrize(
    "changed",
    [
        lambda row: row | {"seed": "many"},
        lambda row: row | {next(iter(row.keys() - {"seed"})): {"a": [1]}},
        lambda row: {name: value for name, value in row.items() if name != "seed"},
        lambda row: row | {"unknown": 1},
        lambda row: row | ({"prize": math.nan} if "prize" in row else {"perfect": math.inf}),
        lambda row: row | ({"course": [[1.0]]} if "course" in row else {"proven": "no"}),
        lambda row: [row],
    ],
)
def test_a_row_that_is_none_is_one_sentence(rehearsed, suffix: str, changed) -> None:  # type: ignore[no-untyped-def]
    """A row of other types than those that are written is named by its line, and kept."""
    more = ("--samples", 2, "--bounds", 1, "--resume", "r.jsonl")
    assert rehearsed(*more).status == 0
    path = Path(f"r.jsonl{suffix}")
    head, row, *_ = path.read_text().splitlines()
    content = json.loads(row)
    content["value"] = changed(content["value"])
    text = f"{head}\n{json.dumps(content)}\n"
    path.write_text(text)
    outcome = rehearsed(*more)
    assert outcome.status == 2, outcome
    kind = "bounds" if suffix else "rehearsals"
    of = kind if math.isfinite(_number_in(content["value"])) else "a study"
    assert f"{path}: line 2: not a row of {of};" in outcome.err
    assert outcome.err.count("\n") == 1
    assert path.read_text() == text


def test_a_replay_writes_both_files_or_none(rehearsed) -> None:
    """Where connections of its instance cannot be written there is no instance, and no plan."""
    assert rehearsed("--samples", 1).status == 0
    Path("w.connections.parquet").mkdir()
    before = set(Path().iterdir())
    outcome = rehearsed("--replay", 1, "--out", "r.json", "--out-instance", "w.json")
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert set(Path().iterdir()) == before


def test_a_file_of_rehearsals_needs_a_plan(rehearsed, cli: Cli, tiny_file: Path) -> None:
    """A plan of `auto` may be another one at the next call, so that nothing could be resumed."""
    assert rehearsed("--samples", 1).status == 0
    outcome = cli(
        f"rehearse {tiny_file} --uncertainty u.json --policy replan --samples 1 --resume r.jsonl"
    )
    assert outcome.status == 2
    assert "need a given plan" in outcome.err
    assert not Path("r.jsonl").exists()
