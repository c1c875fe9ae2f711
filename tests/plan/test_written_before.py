"""Files that an earlier state of the package has written: they are read, and mean the same."""

from __future__ import annotations

from pathlib import Path

import pytest

import adr_opt
from adr_opt.fly.flight.refined import fly_refined
from adr_opt.judge.admit import admit

FOLDER = Path(__file__).parents[1] / "fields" / "written_before"


@pytest.mark.parametrize("field", ["tiny", pytest.param("rocket-bodies", marks=pytest.mark.slow)])
def test_files_that_were_written_before_are_read_and_hold(field: str) -> None:
    """An instance keeps its digest, its plan is legal and flown, all written the same."""
    instance = adr_opt.load(FOLDER / f"{field}.json")
    plan = adr_opt.load_plan(FOLDER / f"{field}.plan.json")
    refined = adr_opt.load_refined(FOLDER / f"{field}.refined.json")
    assert plan.instance.sha256 == instance.sha256
    assert adr_opt.check(instance, plan) == ()
    # It is of 1.0, whose files do not hold their plan.
    with pytest.raises(adr_opt.InputError, match="does not hold the plan that it was made of"):
        fly_refined(instance, refined)
    assert fly_refined(instance, admit(instance, refined, refined_from=plan)).holds
    for data, name in ((instance, "json"), (plan, "plan.json"), (refined, "refined.json")):
        assert data.to_json() == (FOLDER / f"{field}.{name}").read_text(encoding="utf-8"), name


@pytest.mark.parametrize("field", ["tiny", pytest.param("rocket-bodies", marks=pytest.mark.slow)])
def test_certificates_that_were_written_before_are_verified(field: str) -> None:
    """What was proven of a plan then is verified now."""
    instance = adr_opt.load(FOLDER / f"{field}.json")
    plan = adr_opt.load_plan(FOLDER / f"{field}.plan.json")
    certificate = adr_opt.load_certificate(FOLDER / f"{field}.cert.json")
    assert adr_opt.verify(instance, plan, certificate, connections=50).verified
