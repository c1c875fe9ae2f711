"""Files of an earlier state of the package are read, and those of the former model told apart."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from drifting_plans import drifting_instance, drifting_plan
from hand_made import hand_made

import adr_opt
from adr_opt.fly.flight.refined import fly_refined
from adr_opt.judge.admit import admit
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.plan.certificate import Certificate, sha256_of
from adr_opt.plan.plan import MODEL, Plan


def without_model(text: str) -> str:
    content = json.loads(text)
    del content["model"]
    return json.dumps(content)


def certificate_from(text: str) -> Certificate:
    return Certificate.model_validate_json(text)


def test_new_plans_name_their_model():
    """A plan that is made now names version 3 of the model, in its file too."""
    plan = drifting_plan()
    assert plan.model == MODEL
    assert json.loads(plan.to_json())["model"] == MODEL


def test_former_plans_keep_their_digest():
    """A plan that names no model is written as it was read, so that its sha256 stays."""
    plan = Plan.from_json(without_model(drifting_plan().to_json()))
    assert plan.model == 2
    assert "model" not in json.loads(plan.to_json())
    assert sha256_of(Plan.from_json(plan.to_json())) == sha256_of(plan)
    assert sha256_of(plan) != sha256_of(drifting_plan())


def test_former_drifts_have_to_be_planned_anew():
    """`check` says once that drift legs of the former model are to be planned anew."""
    plan = drifting_plan().replace(model=2)
    (said,) = [v for v in adr_opt.check(drifting_instance(), plan) if v.rule == "model"]
    assert "plan again" in said.message
    assert not adr_opt.check(drifting_instance(), drifting_plan())


def test_former_plans_without_drifts_stand():
    """A plan of the former model without drift legs, when days cost nothing, breaks nothing."""
    instance = hand_made()
    plan = adr_opt.solve(instance, "exact").plan
    assert plan is not None
    assert not adr_opt.check(instance, plan.replace(model=2, cost=plan.delta_v_m_s))


@pytest.mark.slow
def test_former_certificates_of_drifts_are_refused():
    """`verify` refuses what was proven of drift legs of the former model, and no other proof."""
    mission = adr_opt.Mission(drifting_instance())
    certificate = certificate_of(mission.instance, adr_opt.solve(mission, "exact"))
    assert certificate.model == MODEL
    former = certificate_from(without_model(certificate.to_json()))
    assert former.model == 2
    assert "model" not in json.loads(former.to_json())
    (reason,) = verify(mission.instance, None, former).reasons
    assert "prove again" in reason
    assert verify(mission.instance, None, certificate).verified

    short = adr_opt.Mission(hand_made())
    proof = certificate_of(short.instance, adr_opt.solve(short, "exact"))
    former = certificate_from(without_model(proof.to_json()))
    assert verify(short.instance, None, former).verified


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
    with pytest.raises(adr_opt.InputError, match="does not contain the plan that it refines"):
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
