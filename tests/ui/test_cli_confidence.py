"""``solve --confidence``: a plan that other verbs take, notes, and bad input in one sentence."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import Cli

UNCERTAIN = '{"legs": {"delta_v_factor": {"lognormal_sigma": 0.1}}}'


@pytest.fixture
def planned(cli: Cli, tiny_file: Path):
    """`solve` of a small field, with more options."""
    Path("u.json").write_text(UNCERTAIN, encoding="utf-8")
    return lambda *more: cli("solve", tiny_file, "--method", "beam", *more)


def test_a_plan_with_a_confidence_is_one_of_the_instance(planned, cli: Cli, tiny_file) -> None:
    """`check` and `rehearse` take the plan, and a note says how often it was kept."""
    made = planned(
        "--confidence", 0.9, "--uncertainty", "u.json", "--time-limit", 20, "--out", "p.json"
    )
    assert made.status == 0, made
    assert "kept with a confidence of 0.9" in made.err
    notes = json.loads(Path("p.json").read_text(encoding="utf-8"))["notes"]
    assert any("rehearsals were as planned" in note for note in notes)
    assert cli("check", tiny_file, "p.json").status == 0
    rehearsed = cli(
        "rehearse", tiny_file, "p.json", "--uncertainty", "u.json", "--samples", 300, "--json"
    )
    assert json.loads(rehearsed.out)["as_planned"]["share"] > 0.85


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (("--confidence", 0.9), "--confidence needs --uncertainty"),
        (("--uncertainty", "u.json"), "--uncertainty needs --confidence"),
        (("--confidence", 1.0, "--uncertainty", "u.json"), "confidence = 1.0"),
        (("--confidence", 0.9, "--uncertainty", "none.json"), "none.json"),
        (
            ("--confidence", 0.9, "--uncertainty", "u.json", "--margin", 0.1),
            "--margin does not go with --confidence",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(planned, more: tuple[object, ...], sentence) -> None:
    """Exit status 2 and one sentence, before anything is planned."""
    refused = planned(*more)
    assert refused.status == 2
    assert sentence in refused.err
    assert refused.err.count("\n") <= 2
