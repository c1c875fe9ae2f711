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
from brute_force import brute_force
from conftest import Cli
from hand_made import OPTIMAL_PLAN, PERIOD_S, hand_made

import adr_opt
from adr_opt.mission.certified import certify
from adr_opt.mission.mission import Mission
from adr_opt.plan.expense import cost_of_routes
from adr_opt.plan.plan import Plan, load_plan
from adr_opt.problem.instance import Instance

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


def ends_of(plan: Plan) -> dict[str, float]:
    """When the last service at each body ends, in periods."""
    return {leg.destination: leg.end_s / PERIOD_S for leg in plan.legs}


def write(change: Change, path: str = "instance.json") -> None:
    content = json.loads(hand_made().to_json())
    change(content)
    Path(path).write_text(json.dumps(content), encoding="utf-8")


def solved(cli: Cli, change: Change) -> tuple[Instance, Plan]:
    """A variant as a file, planned, checked, and as good as enumeration says."""
    write(change)
    outcome = cli("solve", "instance.json", "--time-limit", 20, "--out", "plan.json", "--quiet")
    assert outcome.status == 0, outcome.err
    assert cli("check", "instance.json", "plan.json").status == 0
    instance, plan = adr_opt.load("instance.json"), load_plan("plan.json")
    assert plan.status == "optimal"
    assert plan.objective == pytest.approx(brute_force(Mission(instance))[0])
    return instance, plan


def test_a_window_closes(cli: Cli) -> None:
    """A target whose window closes early is serviced first, and the others as far as they fit."""
    _, plan = solved(cli, lambda content: target(content, NORTH, window_s=[0.0, 3.1 * PERIOD_S]))
    # Without the window all three fit, but north comes third.
    assert plan.objective == 2.0
    # Worth more than both others, it is in the plan.
    _, plan = solved(
        cli, lambda content: target(content, NORTH, window_s=[0.0, 3.1 * PERIOD_S], prize=5.0)
    )
    assert plan.objective == 6.0
    assert plan.legs[0].destination == "north"
    assert ends_of(plan)["north"] <= 3.1


def test_a_window_opens(cli: Cli) -> None:
    """Service at a target waits for its window; a chaser that arrives earlier stays there."""
    _, plan = solved(cli, lambda content: target(content, SOUTH, window_s=[12.9 * PERIOD_S, None]))
    assert plan.objective == 2.0
    _, plan = solved(
        cli, lambda content: target(content, SOUTH, window_s=[12.9 * PERIOD_S, None], prize=5.0)
    )
    assert plan.legs[-1].destination == "south"
    assert plan.legs[-1].arrival_s < 12.9 * PERIOD_S
    assert ends_of(plan)["south"] == pytest.approx(13.9)


def test_a_required_target(cli: Cli) -> None:
    """A required target is serviced even if it has no prize and costs others."""

    def change(content: Content) -> None:
        target(content, BEYOND, prize=0.0, required=True)
        content["mission"]["duration_s"] = 7.0 * PERIOD_S

    _, plan = solved(cli, change)
    assert "beyond" in plan.destinations
    assert plan.objective == 1.0


def test_a_chaser_is_available(cli: Cli) -> None:
    """A chaser leaves no earlier, and has serviced all no later, than it is available."""
    available = [0.9 * PERIOD_S, 10.0 * PERIOD_S]
    _, plan = solved(cli, lambda content: chaser(content, available_s=available))
    assert plan.objective == 2.0
    assert plan.legs[0].departure_s >= available[0]
    assert plan.legs[-1].end_s <= available[1]


def test_most_targets(cli: Cli) -> None:
    """A chaser that may service two targets services the best two."""
    _, plan = solved(
        cli, lambda content: (target(content, SOUTH, prize=3.0), chaser(content, max_targets=2))[0]
    )
    assert plan.objective == 4.0
    assert sum(leg.destination != "station" for leg in plan.legs) == 2


def test_a_mission_ends_at_a_station(cli: Cli) -> None:
    """A chaser that has to end at a station is there in the end, at the price of a target."""
    _, plan = solved(cli, lambda content: chaser(content, end={"station": "station"}))
    assert plan.legs[-1].destination == "station"
    assert plan.objective == 2.0


def test_service_in_seconds(cli: Cli) -> None:
    """A service in seconds takes these, whatever the orbit; refuelling takes revolutions still."""
    _, plan = solved(cli, lambda content: service(content, service_s=100.0))
    assert plan.objective == 3.0
    for leg in plan.legs:
        expected = PERIOD_S if leg.destination == "station" else 100.0
        assert leg.end_s - leg.arrival_s == pytest.approx(expected, abs=1e-3)


def test_several_stations(cli: Cli) -> None:
    """A second station near a target makes another one affordable."""
    _, plan = solved(cli, little)
    assert plan.objective == 1.0
    _, plan = solved(cli, depot)
    assert plan.objective == 2.0
    assert "depot" in plan.destinations


def test_no_station(cli: Cli) -> None:
    """Without a station a chaser begins in an orbit and has one tank."""
    instance, plan = solved(cli, adrift)
    assert plan.legs[0].origin == instance.chaser.start_name
    assert plan.objective == 2.0
    assert plan.legs[-1].delta_v_left_m_s < 300.0 - 2.0 * 130.0


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
