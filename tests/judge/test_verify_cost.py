"""The cost part of certificates: what is verified is true, and what is not true is refused."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from conftest import Cli
from drawn_expenses import laden_campaign
from random_rules import (
    carrying,
    drifting_mission,
    falling,
    given_field,
    random_mission,
    towing_mission,
)
from seeds import first_of, over_kinds

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.files import parse_model
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.plan.certificate import Certificate, ProvenCost
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import Objective

PRICES = [0.0, None, 50.0, 700.0]
"""Of a day [m/s]."""


WITH_PRIZES = (6, 7, 8, 10, 11)
"""Numbers of drawn missions that collect something."""


def priced(instance: Instance, seed: int) -> Instance:
    """The same with a drawn price of time."""
    price = PRICES[int(np.random.default_rng([17, seed]).integers(len(PRICES)))]
    return instance.replace(objective=Objective(time_m_s_per_day=price))


def laden(seed: int) -> Instance:
    """A drawn mission with kits."""
    return carrying(random_mission(seed), seed)


def proven(instance: Instance) -> tuple[Any, Certificate]:
    """A plan of least cost, and its certificate."""
    result = adr_opt.solve(instance, "exact", time_limit=60.0, iterations=8, cost=True)
    assert result.plan is not None
    return result.plan, certificate_of(instance, result)


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(60), 9),
    j2=(drifting_mission, range(40), 3),
    tows=(towing_mission, range(30), 3),
    laden=(laden, range(30), 3),
)
def test_a_verified_cost_is_that_of_enumeration(draw, seeds):
    """Least costs are verified, up to a millionth, and never above those of enumeration."""
    asked = closed = 0
    for seed in seeds:
        instance = priced(draw(9000 + seed), seed)
        prizes, cost, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes) or prizes <= 0.0:
            continue
        plan, certificate = proven(instance)
        verdict = verify(instance, plan, certificate, connections=50)
        assert verdict.reasons == (), seed
        asked += 1
        # With tanks that services change, a last packing may have raised the bound.
        visits = all(target.removal == "visit" for target in instance.targets)
        assert certificate.cost is not None or not visits, seed
        if certificate.cost is not None:
            assert verdict.cost_bound <= cost * (1.0 + 1e-9), seed
            closed += verdict.cost_bound >= cost * (1.0 - 3e-6)
    assert closed >= 0.8 * asked > 0.1 * len(seeds)


def campaign(seed: int, draw: Callable[[int], Instance]) -> Instance:
    """A campaign with kits, tows, and a price of time."""
    return priced(laden_campaign(seed, draw), seed)


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(60), 10),
    j2=(drifting_mission, range(40), 3),
    given=(given_field, range(60), 12),
)
def test_verified_costs_of_several_chasers_are_those_of_enumeration(draw, seeds):
    """What is stated of campaigns is verified, is never above enumeration, and mostly stated."""
    asked = closed = 0
    for seed in seeds:
        certificate, instance = None, campaign(seed, draw)
        prizes, cost = brute_force_campaign(Problem(instance))
        if not math.isfinite(prizes) or prizes <= 0.0:
            continue
        with suppress(InputError):  # how the prize is proven may be in no certificate
            plan, certificate = proven(instance)
        if certificate is None:
            continue
        asked += 1
        if certificate.cost is not None:
            verdict = verify(instance, plan, certificate, connections=50)
            assert not any("cost" in reason for reason in verdict.reasons), seed
            assert verdict.cost_bound <= cost * (1.0 + 1e-9), seed
            closed += verdict.cost_bound >= cost * (1.0 - 3e-6)
    assert closed >= 0.5 * asked > 0.1 * len(seeds)


def forged(draft: dict[str, Any], cost: float, random: np.random.Generator) -> None:
    """Change something that the cost rests on."""
    part = draft["cost"]
    kind = int(random.integers(7 if "walks" in part else 4))
    if kind == 0:
        part["bound"] *= float(random.uniform(1.0, 1.3))
    elif kind == 1:
        part["per_prize"] *= float(random.uniform(0.0, 3.0))
    elif kind == 2:
        part["neighbourhoods"] = {}
        for walks in part.get("walks", ()):
            walks["neighbourhoods"] = {}
    elif kind == 4:
        walks = part["walks"][int(random.integers(len(part["walks"])))]
        walks["most"] -= float(random.uniform(0.0, 0.3)) * cost
    elif kind == 5 and part.get("multipliers"):
        name = sorted(part["multipliers"])[int(random.integers(len(part["multipliers"])))]
        part["multipliers"][name] *= float(random.uniform(0.0, 1.5))
    elif kind == 6 and part.get("cuts"):
        cut = part["cuts"][int(random.integers(len(part["cuts"])))]
        cut["multiplier"] *= float(random.uniform(0.0, 3.0))
    else:
        part["prize"] *= float(random.uniform(0.5, 1.5))
    if random.random() < 0.5:
        part["bound"] = max(part["bound"], cost * float(random.uniform(0.9, 1.1)))


def judge_forgeries(instance: Instance, prizes: float, cost: float, seed: int) -> int:
    """Of forged costs those are accepted that plans of so much prize keep to; how many are not."""
    certificate = None
    with suppress(InputError):
        _, certificate = proven(instance)
    if certificate is None or certificate.cost is None:
        return 0
    random, refused = np.random.default_rng(seed), 0
    for _ in range(12):
        draft = json.loads(certificate.to_json())
        forged(draft, cost, random)
        verdict = verify(
            instance, None, parse_model(json.dumps(draft), Certificate, "draft"), connections=5
        )
        part = draft["cost"]
        if verdict.cost_bound is not None and part["prize"] <= prizes:
            assert part["bound"] <= cost * (1.0 + 1e-9), seed
        refused += verdict.cost_bound is None
    return refused


@pytest.mark.parametrize("seed", first_of(WITH_PRIZES, gate=3))
def test_whatever_is_changed_what_is_accepted_is_true(seed):
    """No forged cost is accepted that a plan of so much prize undercuts."""
    instance = priced(random_mission(9000 + seed), seed)
    prizes, cost, _ = brute_force(Mission(instance))
    assert judge_forgeries(instance, prizes, cost, seed) > 0


@over_kinds(
    "draw, seeds", two_body=(random_mission, range(40), 12), j2=(drifting_mission, range(30), 3)
)
def test_whatever_is_changed_of_campaigns_what_is_accepted_is_true(draw, seeds):
    """No forged cost of several chasers is accepted that a plan of so much prize undercuts."""
    refused = 0
    for seed in seeds:
        instance = campaign(seed, draw)
        prizes, cost = brute_force_campaign(Problem(instance))
        if math.isfinite(prizes) and prizes > 0.0:
            refused += judge_forgeries(instance, prizes, cost, seed)
    assert refused > 0.2 * len(seeds)


def test_a_higher_bound_in_the_plan_is_refused():
    """A plan may not state more of its cost than its certificate shows."""
    instance = priced(random_mission(9006), 6)
    plan, certificate = proven(instance)
    assert verify(instance, plan, certificate).verified
    lower = certificate.cost.model_copy(update={"bound": 0.9 * certificate.cost.bound})
    weaker = certificate.model_copy(update={"cost": lower})
    verdict = verify(instance, plan, weaker)
    assert any("bound" in reason and "cost" in reason for reason in verdict.reasons)
    assert verdict.cost_bound == lower.bound


def test_costs_that_are_not_yet_verifiable_are_refused():
    """The cost part of anything but a ΔV is refused in a sentence."""
    instance = adr_opt.generate("tiny", 0).replace(objective=Objective(cost="duration"))
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    certificate = certificate_of(instance, result)
    part = ProvenCost(prize=result.objective, bound=1.0, per_prize=1.0)
    verdict = verify(instance, result.plan, certificate.model_copy(update={"cost": part}))
    assert any("cannot be verified yet: the cost is not ΔV" in reason for reason in verdict.reasons)


STRANGE = {
    "neighbourhoods": {"nowhere": ["nobody"]},
    "multipliers": {"nobody": 1.0},
    "walks": [{"chasers": ["nobody"], "most": 0.0}],
    "cuts": [{"targets": ["a", "b", "nobody"], "memory": [], "multiplier": 1.0}],
}


@pytest.mark.parametrize("field", sorted(STRANGE))
def test_strange_names_in_campaigns_are_refused(field):
    """The cost part of a campaign names its bodies and chasers, each chaser once."""
    instance = campaign(1, random_mission)
    draft = json.loads(proven(instance)[1].to_json())
    draft["cost"] = {
        "prize": 1.0,
        "bound": 0.0,
        "per_prize": 1.0,
        "walks": [{"chasers": [chaser.name for chaser in instance.chasers], "most": 0.0}],
    } | {field: STRANGE[field]}
    with pytest.raises(InputError, match=rf"cost\.{field}"):
        verify(instance, None, parse_model(json.dumps(draft), Certificate, "draft"))


def test_strange_bodies_are_refused():
    """A cost part names bodies of the instance."""
    instance = priced(random_mission(9006), 6)
    _, certificate = proven(instance)
    part = certificate.cost.model_copy(update={"neighbourhoods": {"nowhere": ("nobody",)}})
    with pytest.raises(InputError, match=r"cost\.neighbourhoods"):
        verify(instance, None, certificate.model_copy(update={"cost": part}))


def test_the_command_states_the_verified_cost(cli: Cli, tmp_path):
    """`solve` writes the cost part, and `verify` says what it shows."""
    instance = tmp_path / "tiny.json"
    adr_opt.generate("tiny", 0).save(instance)
    plan, certificate = tmp_path / "plan.json", tmp_path / "proof.json"
    cli(
        f"solve {instance} --method exact --option cost=true --out {plan} --certificate",
        certificate,
    )
    said = cli("verify", instance, plan, certificate)
    assert "no plan that collects as much costs less than" in said.out


def test_the_command_says_where_a_cost_is_unverified(cli: Cli, tmp_path):
    """Where prizes fall the bound on the cost is in no certificate, which `verify` says."""
    instance = tmp_path / "falling.json"
    falling(adr_opt.generate("tiny", 3), 0).save(instance)
    plan, certificate = tmp_path / "plan.json", tmp_path / "proof.json"
    cli(f"solve {instance} --iterations 20 --out {plan} --certificate", certificate)
    said = cli("verify", instance, plan, certificate)
    assert "the bound on cost is not in the certificate, and was not verified" in said.out
