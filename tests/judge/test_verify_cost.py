"""The cost part of certificates: what is verified is true, and what is not true is refused."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from conftest import Cli
from random_rules import drifting_mission, random_mission, towing_mission
from seeds import over_kinds

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.files import parse_model
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission
from adr_opt.plan.certificate import Certificate, ProvenCost
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import Objective

PRICES = [0.0, None, 50.0, 700.0]
"""Of a day [m/s]."""


WITH_PRIZES = (6, 7, 8, 10, 11)
"""Numbers of drawn missions that collect something."""


def visiting(instance: Instance, seed: int) -> Instance:
    """The same with a drawn price of time, if its cost can be verified."""
    price = PRICES[int(np.random.default_rng([17, seed]).integers(len(PRICES)))]
    targets = [target.model_copy(update={"removal": "visit"}) for target in instance.targets]
    return instance.replace(targets=targets, objective=Objective(time_m_s_per_day=price))


def proven(instance: Instance) -> tuple[Any, Certificate]:
    """A plan of least cost, and its certificate."""
    result = adr_opt.solve(instance, "exact", time_limit=60.0, cost=True)
    assert result.plan is not None
    return result.plan, certificate_of(instance, result)


@over_kinds(
    "draw, seeds",
    two_body=(random_mission, range(60), 9), j2=(drifting_mission, range(40), 4),
)  # fmt: skip
def test_a_verified_cost_is_that_of_enumeration(draw, seeds):
    """Least costs are verified, up to a millionth, and never above those of enumeration."""
    asked = closed = 0
    for seed in seeds:
        instance = visiting(draw(9000 + seed), seed)
        prizes, cost, _ = brute_force(Mission(instance))
        if not math.isfinite(prizes) or prizes <= 0.0:
            continue
        plan, certificate = proven(instance)
        assert certificate.cost is not None, seed
        verdict = verify(instance, plan, certificate, connections=50)
        assert verdict.reasons == (), seed
        assert verdict.cost_bound <= cost * (1.0 + 1e-9), seed
        asked, closed = asked + 1, closed + (verdict.cost_bound >= cost * (1.0 - 3e-6))
    assert closed >= 0.8 * asked > 0.1 * len(seeds)


def forged(draft: dict[str, Any], cost: float, random: np.random.Generator) -> None:
    """Change something that the cost rests on."""
    part = draft["cost"]
    kind = int(random.integers(4))
    if kind == 0:
        part["bound"] *= float(random.uniform(1.0, 1.3))
    elif kind == 1:
        part["per_prize"] *= float(random.uniform(0.0, 3.0))
    elif kind == 2:
        part["neighbourhoods"] = {}
    else:
        part["prize"] *= float(random.uniform(0.5, 1.5))
    if random.random() < 0.5:
        part["bound"] = max(part["bound"], cost * float(random.uniform(0.9, 1.1)))


@pytest.mark.parametrize("seed", WITH_PRIZES)
def test_whatever_is_changed_what_is_accepted_is_true(seed):
    """Of forged costs those are accepted that plans of so much prize keep to, and no others."""
    instance = visiting(random_mission(9000 + seed), seed)
    prizes, cost, _ = brute_force(Mission(instance))
    _, certificate = proven(instance)
    random, refused = np.random.default_rng(seed), 0
    for _ in range(12):
        draft = json.loads(certificate.to_json())
        forged(draft, cost, random)
        verdict = verify(
            instance, None, parse_model(json.dumps(draft), Certificate, "draft"), connections=5
        )
        part = draft["cost"]
        if verdict.cost_bound is not None and part["prize"] <= prizes:
            assert part["bound"] <= cost * (1.0 + 1e-9)
        refused += verdict.cost_bound is None
    assert refused > 0


def test_a_higher_bound_in_the_plan_is_refused():
    """A plan may not state more of its cost than its certificate shows."""
    instance = visiting(random_mission(9006), 6)
    plan, certificate = proven(instance)
    assert verify(instance, plan, certificate).verified
    lower = certificate.cost.model_copy(update={"bound": 0.9 * certificate.cost.bound})
    weaker = certificate.model_copy(update={"cost": lower})
    verdict = verify(instance, plan, weaker)
    assert any("bound" in reason and "cost" in reason for reason in verdict.reasons)
    assert verdict.cost_bound == lower.bound


def test_costs_that_are_not_yet_verifiable_are_refused():
    """Tows cost more than legs say: they have no cost part, and one is refused in a sentence."""
    instance = towing_mission(9002)
    result = adr_opt.solve(instance, "exact", time_limit=60.0, cost=True)
    certificate = certificate_of(instance, result)
    assert certificate.cost is None
    assert verify(instance, result.plan, certificate).reasons == ()
    part = ProvenCost(prize=result.objective, bound=1.0, per_prize=1.0)
    claiming = certificate.model_copy(update={"cost": part})
    verdict = verify(instance, result.plan, claiming)
    assert any("not yet verifiable" in reason for reason in verdict.reasons)


def test_strange_bodies_are_refused():
    """A cost part names bodies of the instance."""
    instance = visiting(random_mission(9006), 6)
    _, certificate = proven(instance)
    part = certificate.cost.model_copy(update={"neighbourhoods": {"nowhere": ("nobody",)}})
    with pytest.raises(InputError, match=r"cost\.neighbourhoods"):
        verify(instance, None, certificate.model_copy(update={"cost": part}))


def test_the_command_states_the_verified_cost(cli: Cli, tmp_path):
    """`solve` writes the cost part, and `verify` says what it shows."""
    instance = tmp_path / "tiny.json"
    adr_opt.generate("tiny", 0).save(instance)
    plan, certificate = tmp_path / "plan.json", tmp_path / "proof.json"
    cli("solve", instance, "--method", "exact", "--option", "cost=true", "--out", plan,
        "--certificate", certificate)  # fmt: skip
    said = cli("verify", instance, plan, certificate)
    assert "no plan that collects as much costs less than" in said.out
