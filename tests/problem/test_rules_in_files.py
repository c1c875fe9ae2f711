"""The rules of a mission as users state them: in an instance file, planned and checked by commands.

All variants are of the hand-made instance, whose costs and times can be worked out on paper.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli
from hand_made import OPTIMAL_PLAN, PERIOD_S, hand_made

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.plan.expense import cost_of_routes

Content = dict[str, Any]
Change = Callable[[Content], None]

NORTH, BEYOND, SOUTH, FAR = range(4)


def target(content: Content, number: int, **changes: Any) -> None:
    content["targets"][number].update(changes)


def depot(content: Content) -> None:
    """A second station next to north, a tank for one leg and back, and more time."""
    beside = copy.deepcopy(content["stations"][0])
    beside.update(name="depot", orbit=content["targets"][NORTH]["orbit"])
    content["stations"].append(beside)
    little(content)


def little(content: Content) -> None:
    content["chasers"][0]["tank"]["delta_v_m_s"] = 200.0
    content["mission"]["duration_s"] = 25.0 * PERIOD_S


def adrift(content: Content) -> None:
    """No station: the chaser begins in the orbit where it was."""
    content["chasers"][0]["start"] = {"orbit": content["stations"][0]["orbit"]}
    content["stations"] = []


def chaser(content: Content, **changes: Any) -> None:
    content["chasers"][0].update(changes)


def service(content: Content, **given: float) -> None:
    del content["mission"]["service_revolutions"]
    content["mission"].update(given)


def write(change: Change, path: str = "instance.json") -> None:
    content = json.loads(hand_made().to_json())
    change(content)
    Path(path).write_text(json.dumps(content), encoding="utf-8")


@pytest.mark.parametrize(
    ("method", "status"), [("auto", "infeasible"), ("exact", "infeasible"), ("beam", "unknown")]
)
def test_a_required_target_out_of_reach(cli: Cli, method: str, status: str) -> None:
    """Without a plan for all required targets the answer is no, and it says which one lacks."""
    write(lambda content: target(content, FAR, required=True))
    call = ("solve", "instance.json", "--method", method, "--time-limit", 20)
    outcome = cli(*call)
    assert outcome.status == 1
    assert f"no plan: {method} ended with status {status}" in outcome.err
    assert "'far'" in outcome.err
    outcome = cli(*call, "--json", "--quiet")
    assert outcome.status == 1
    stated = json.loads(outcome.out)
    assert stated["status"] == status
    assert stated["objective"] is None
    assert any("'far'" in note for note in stated["notes"])


def two_services(content: Content) -> None:
    content["mission"]["service_s"] = 60.0


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda c: target(c, SOUTH, window_s=[10.0, 5.0]), "window_s = [10.0, 5.0]"),
        (lambda c: target(c, SOUTH, window_s=[0.0]), "window_s"),
        (lambda c: target(c, SOUTH, required="yes"), "required"),
        (lambda c: chaser(c, available_s=[10.0, 5.0]), "available_s = [10.0, 5.0]"),
        (lambda c: chaser(c, end={"station": "nowhere"}), "'nowhere'"),
        (lambda c: chaser(c, start={"station": "nowhere"}), "'nowhere'"),
        (lambda c: chaser(c, max_targets=-1), "max_targets"),
        (lambda c: service(c, service_s=-1.0), "service_s"),
        (two_services, "service_s"),
        (lambda c: c["stations"].append(c["stations"][0]), "'station'"),
        (lambda c: c.update(stations=[]), "'station'"),
        (lambda c: c.update(objective={"cost": "expense"}), "no chaser has one"),
    ],
)
def test_what_makes_no_sense_is_refused(cli: Cli, change: Change, named: str) -> None:
    """A rule that cannot be meant is refused in one sentence that names file and field."""
    write(change)
    outcome = cli("solve", "instance.json", "--time-limit", 5)
    assert outcome.status == 2
    assert outcome.out == ""
    (line,) = outcome.err.splitlines()
    assert "instance.json" in line
    assert named in line


@pytest.mark.parametrize(
    ("change", "rule", "leg"),
    [
        (lambda c: target(c, NORTH, window_s=[0.0, 3.1 * PERIOD_S]), "window", 3),
        (lambda c: target(c, SOUTH, window_s=[5.0 * PERIOD_S, None]), "service", 1),
        (lambda c: target(c, FAR, required=True), "required", None),
        (lambda c: chaser(c, available_s=[0.0, 12.0 * PERIOD_S]), "availability", 4),
        (lambda c: chaser(c, available_s=[1.0, None]), "departure", 1),
        (lambda c: chaser(c, max_targets=2), "targets", None),
        (lambda c: chaser(c, end={"station": "station"}), "end", None),
        (lambda c: service(c, service_s=100.0), "service", 1),
        (depot, "delta-v", 4),
        (adrift, "body", 1),
    ],
)
def test_check_names_the_rule_that_a_plan_breaks(
    cli: Cli, change: Change, rule: str, leg: int | None
) -> None:
    """The plan of the mission without a rule breaks just that rule, and `check` says where."""
    plain = certify(Mission(hand_made()), "by-hand", OPTIMAL_PLAN, seed=0, runtime_s=0.0).plan
    assert plain is not None
    write(change)
    instance = adr_opt.load("instance.json")
    reference = plain.instance.replace(sha256=instance.sha256)
    cost = cost_of_routes(instance, plain.routes)
    plain.replace(instance=reference, cost=cost).save("plan.json")
    outcome = cli("check", "instance.json", "plan.json", "--json")
    assert outcome.status == 1
    found = [(one["leg"], one["rule"]) for one in json.loads(outcome.out)["violations"]]
    assert (leg, rule) in found, outcome.out
    # Nothing else is wrong but what follows from it.
    follows = {
        "service": {"ready", "service", "departure"},
        "departure": {"ready", "departure"},
        "targets": {"targets", "status", "objective"},
        "delta-v": {"delta-v", "delta-v-left"},
    }
    assert {one for _, one in found} <= follows.get(rule, {rule})
