"""Files of the formats 1: read everywhere, their plans still hold, never written."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli
from former import content_of, drawn

import adr_opt
from adr_opt import Instance, Plan, formats_1
from adr_opt.files import to_text
from adr_opt.result import certify
from adr_opt.settings import Objective

FOLDER = Path(__file__).parent / "data" / "formats-1"
CIRCLES = ("tiny-003", "hand-made")
NAMES = (*CIRCLES, "odd")
"""The orbits of the last one are eccentric."""

PLANNED = json.loads((FOLDER / "planned.json").read_text(encoding="utf-8"))
"""What the last version of the program that wrote format 1 planned for drawn instances."""


def both(name: str) -> tuple[Path, Path]:
    """Files of an instance and of its plan, as that version wrote them."""
    return FOLDER / f"{name}-instance.json", FOLDER / f"{name}-plan.json"


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("name", CIRCLES)
def test_plans_of_format_1_still_pass(cli: Cli, name: str) -> None:
    """Between circles `check` takes both files as they are, and either of them written anew."""
    instance, plan = both(name)
    assert cli("check", instance, plan).status == 0
    assert cli("check", instance, plan, "--json").status == 0
    Path("new.json").write_text(adr_opt.load(instance).to_json(), encoding="utf-8")
    assert cli("check", "new.json", plan).status == 0
    adr_opt.load_plan(plan).save("plan.json")
    assert json.loads(Path("plan.json").read_text())["format"] == "adr-opt-plan/2"
    assert cli("check", instance, "plan.json").status == 0


def test_plans_of_format_1_charged_eccentricity_otherwise() -> None:
    """Between eccentric orbits they put v·|Δe|/2 beside the sequence: legs hold but for that.

    `check` names the ΔV and the share of every such leg. At the ΔV of their burns, which are enough
    to match the eccentricities on the way, it finds nothing.
    """
    instance_file, plan_file = both("odd")
    instance, plan = adr_opt.load(instance_file), adr_opt.load_plan(plan_file)
    found = [(violation.leg, violation.rule) for violation in adr_opt.check(instance, plan)]
    numbers = range(1, len(plan.legs) + 1)
    assert found == [(number, rule) for number in numbers for rule in ("cost", "eccentricity")]

    legs, left = [], instance.chaser.tank.delta_v_m_s
    for leg in plan.legs:
        assert leg.eccentricity_delta_v_m_s > 3.0
        burned = leg.delta_v_m_s - leg.eccentricity_delta_v_m_s
        assert burned == pytest.approx(leg.burns_delta_v_m_s, abs=1e-6)
        full = leg.destination == instance.stations[0].name
        left = instance.chaser.tank.delta_v_m_s if full else left - burned
        legs.append(
            leg.replace(delta_v_m_s=burned, delta_v_left_m_s=left, eccentricity_delta_v_m_s=0.0)
        )
    route = plan.routes[0].replace(legs=tuple(legs))
    cost = math.fsum(leg.delta_v_m_s for leg in legs)
    assert adr_opt.check(instance, plan.replace(routes=(route,), cost=cost)) == ()


@pytest.mark.parametrize("name", NAMES)
def test_every_verb_reads_format_1(cli: Cli, name: str) -> None:
    """Planning from an old file and an old plan gives a new plan, in format 2, that passes."""
    instance, plan = both(name)
    priced_anew = [] if name in CIRCLES else ["--repair"]
    begun = cli(
        "solve", instance, "--method", "local-search", "--iterations", "3", "--start", plan,
        *priced_anew, "--out", "new.json",
    )  # fmt: skip
    assert begun.status == 0, begun.err
    assert json.loads(Path("new.json").read_text())["format"] == "adr-opt-plan/2"
    assert cli("check", instance, "new.json").status == 0
    done, begun_with = (adr_opt.load_plan(path).objective for path in ("new.json", plan))
    assert done >= begun_with
    assert cli("bound", instance, "--method", "routing-bound", "--time-limit", "5").status == 0
    assert cli("export", instance, plan, "--out", "plan.oem").status == 0
    assert cli("matrix", instance, "--at", "0", "--out", "costs.npz").status == 0


@pytest.mark.parametrize("name", NAMES)
def test_what_is_read_is_what_the_file_says(name: str) -> None:
    """Station, targets, limits and legs are those of the file, under their new names."""
    instance_file, plan_file = both(name)
    stated: Any = json.loads(instance_file.read_text(encoding="utf-8"))
    instance = adr_opt.load(instance_file)
    assert instance.names == (
        stated["station"]["name"],
        *(target["name"] for target in stated["targets"]),
    )
    assert [target.prize for target in instance.targets] == [
        target["prize"] for target in stated["targets"]
    ]
    assert instance.chaser.start_name == stated["station"]["name"]
    assert instance.chaser.name == ("chaser-1" if name == "odd" else "chaser")
    assert instance.chaser.tank.delta_v_m_s == stated["mission"]["delta_v_m_s"]
    assert instance.mission.duration_s == stated["mission"]["duration_s"]
    assert instance.mission.service_revolutions == stated["mission"]["service_revolutions"]
    assert instance.time_value_m_s_per_h == stated["transfer"]["time_value_m_s_per_h"]
    assert len(instance.keep_out_zones) == len(stated["keep_out_zones"])

    told: Any = json.loads(plan_file.read_text(encoding="utf-8"))
    plan = adr_opt.load_plan(plan_file)
    assert [route.chaser for route in plan.routes] == [instance.chaser.name]
    legs = [leg.model_dump(mode="json") for leg in plan.legs]
    assert all(leg.pop("kind") == "short" for leg in legs)
    assert legs == told["legs"]
    assert plan.cost == pytest.approx(sum(leg["delta_v_m_s"] for leg in told["legs"]))
    assert (plan.cost_bound, plan.cost_gap, plan.cost_status) == (None, None, None)
    for field in ("instance", "method", "status", "objective", "upper_bound", "gap", "unvisited"):
        assert plan.to_dict()[field] == told[field]


@pytest.mark.parametrize("name", NAMES)
def test_the_digest_of_format_1_is_known(name: str) -> None:
    """An instance knows the digest of its file in format 1, which its old plans carry."""
    instance_file, plan_file = both(name)
    instance, plan = adr_opt.load(instance_file), adr_opt.load_plan(plan_file)
    assert formats_1.sha256_1(instance) == digest(instance_file) == plan.instance.sha256
    assert instance.sha256 != plan.instance.sha256
    assert formats_1.is_of(plan.instance, instance)
    assert formats_1.is_of(plan.instance.replace(sha256=instance.sha256), instance)
    assert not formats_1.is_of(plan.instance.replace(name="other"), instance)
    changed = instance.with_limits(delta_v_m_s=1.0)
    assert not formats_1.is_of(plan.instance, changed)
    with pytest.raises(adr_opt.InputError, match="belongs to"):
        adr_opt.check(changed, plan)


@pytest.mark.parametrize("entry", PLANNED, ids=lambda entry: str(entry["seed"]))
def test_what_was_planned_in_format_1_can_be_flown(entry: dict[str, Any], tmp_path: Path) -> None:
    """A drawn file of format 1 has its digest, and its old plans still hold, at no more ΔV.

    They never let a departure go by; who may do so finds as good a schedule at least.
    """
    content = drawn(entry["seed"])
    path = tmp_path / "former.json"
    path.write_text(to_text(content), encoding="utf-8")
    assert digest(path) == entry["sha256"]
    instance = adr_opt.load(path)
    assert formats_1.sha256_1(instance) == entry["sha256"]
    mission = adr_opt.Mission(instance)
    for method in ("greedy", "greedy-guarded"):
        known = entry[method]
        schedule = mission.time(known["sequence"])
        assert schedule.made == len(known["sequence"])
        assert schedule.objective == pytest.approx(known["objective"])
        assert schedule.delta_v <= known["delta_v_m_s"] * (1.0 + 1e-12)
        result = certify(mission, method, known["sequence"], seed=0, runtime_s=0.0)
        assert result.plan is not None
        assert result.plan.instance.sha256 == instance.sha256
        assert adr_opt.check(instance, result.plan) == ()


def test_the_drawn_files_have_missions() -> None:
    """The plans of the drawn files are no empty missions, and refuel now and then."""
    sequences = [entry["greedy-guarded"]["sequence"] for entry in PLANNED]
    assert sum(len(sequence) >= 3 for sequence in sequences) >= len(sequences) / 3
    assert any(0 in sequence for sequence in sequences)


def test_the_time_value_of_a_file_stays_with_its_instance() -> None:
    """Variants keep it; files, digests and equality do not know it."""
    instance = adr_opt.load(both("odd")[0])
    assert instance.time_value_m_s_per_h == 20.0
    assert instance.replace(name="other").time_value_m_s_per_h == 20.0
    assert instance.with_limits(duration_s=1e5).time_value_m_s_per_h == 20.0
    assert instance.part([0, 1, 2]).time_value_m_s_per_h == 20.0
    usual = instance.with_time_value(75.0)
    assert usual == instance
    assert hash(usual) == hash(instance)
    assert usual.sha256 == instance.sha256
    assert usual.to_json() == instance.to_json()
    assert "time_value" not in instance.to_json()
    assert Instance.from_json(instance.to_json()).time_value_m_s_per_h == 75.0
    assert instance.transfer_rule().time_value == 20.0 / 3600.0
    assert instance.transfer_rule(50.0).time_value == 50.0 / 3600.0
    assert formats_1.sha256_1(usual) != formats_1.sha256_1(instance)
    assert instance.same(instance.replace())
    assert not usual.same(instance)
    for wrong in (-1.0, math.nan, math.inf):
        with pytest.raises(adr_opt.InputError, match="time_value_m_s_per_h"):
            instance.with_time_value(wrong)
    with pytest.raises(adr_opt.InputError, match="belongs to another instance"):
        adr_opt.Mission(usual, adr_opt.Timetable(instance))


def test_a_file_without_its_format_is_recognised(tmp_path: Path) -> None:
    """The format may be left out of files of both formats, as ever."""
    for name in NAMES:
        for path, load in zip(both(name), (adr_opt.load, adr_opt.load_plan), strict=True):
            content = json.loads(path.read_text(encoding="utf-8"))
            del content["format"]
            bare = tmp_path / "bare.json"
            bare.write_text(json.dumps(content), encoding="utf-8")
            assert load(bare) == load(path)
            content = json.loads(load(path).to_json())
            del content["format"]
            bare.write_text(json.dumps(content), encoding="utf-8")
            assert load(bare) == load(path)


@pytest.mark.parametrize(
    ("which", "path", "value", "named"),
    [
        (0, ("station",), None, "field station = null: must be a JSON object"),
        (0, ("colour",), "red", "field colour: unknown; remove it"),
        (0, ("chasers",), [], "field chasers: unknown; remove it"),
        (0, ("mission", "delta_v_m_s"), -1.0, "field mission.delta_v_m_s = -1.0: must be greater"),
        (0, ("transfer", "time_value_m_s_per_h"), -1.0, "transfer.time_value_m_s_per_h = -1.0: mu"),
        (0, ("transfer", "max_drift_s"), 0.0, "field transfer.max_drift_s: unknown"),
        (0, ("transfer", "max_altitude_m"), 2e5, "max_altitude_m = 200000.0 must be greater"),
        (0, ("targets", 1, "name"), "debris-001", "field targets[1].name = 'debris-001': another"),
        (0, ("targets", 1, "required"), True, "field targets[1].required: unknown"),
        (0, ("epoch",), 0, "field epoch = 0: must be a time like"),
        (1, ("legs", 0, "kind"), "short", "field legs[0].kind: unknown"),
        (1, ("legs", 0, "arrival_s"), "late", 'field legs[0].arrival_s = "late": must be a'),
        (1, ("routes",), [], "field routes: unknown"),
        (1, ("status",), "great", 'field status = "great"'),
    ],
)
def test_broken_files_of_format_1_are_refused(
    cli: Cli, which: int, path: tuple[Any, ...], value: Any, named: str
) -> None:
    """They are held to their own format, by the same kind of sentence."""
    texts = [file.read_text(encoding="utf-8") for file in both("tiny-003")]
    content = json.loads(texts[which])
    place = content
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    texts[which] = json.dumps(content)
    for name, text in zip(("i.json", "p.json"), texts, strict=True):
        Path(name).write_text(text, encoding="utf-8")
    outcome = cli("check", "i.json", "p.json")
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert named in outcome.err


def test_what_format_1_cannot_say_has_no_digest_in_it() -> None:
    """Everything that is new in format 2 leaves an instance without a digest in format 1."""
    instance = adr_opt.generate("tiny", 3)
    text = to_text(content_of(instance))
    assert formats_1.sha256_1(instance) == hashlib.sha256(text.encode()).hexdigest()
    target, chaser = instance.targets[0], instance.chaser
    changes: list[dict[str, Any]] = [
        {"targets": (target.replace(required=True),)},
        {"targets": (target.replace(window_s=(0.0, 1e5)),)},
        {"targets": (target.replace(mass_kg=9.0),)},
        {"chasers": (chaser.replace(name="tug"),)},
        {"chasers": (chaser.replace(max_targets=2),)},
        {"chasers": (chaser.replace(available_s=(1.0, None)),)},
        {"chasers": (chaser.replace(end={"station": "station"}),)},
        {"chasers": (chaser.replace(start={"orbit": target.orbit.model_dump()}),)},
        {"stations": (*instance.stations, instance.stations[0].replace(name="second"))},
        {"mission": instance.mission.replace(service_s=60.0, service_revolutions=None)},
        {"transfer": instance.transfer.replace(departure_spacing_s=60.0)},
        {"transfer": instance.transfer.replace(delta_v_resolution_m_s=1.0)},
        {"objective": Objective(cost="duration")},
    ]
    for change in changes:
        assert formats_1.sha256_1(instance.replace(**change)) is None, change


def test_a_plan_without_legs_is_one_of_no_chaser() -> None:
    """A plan of format 1 that stays at the station has no route, and costs nothing."""
    content = json.loads(both("tiny-003")[1].read_text(encoding="utf-8"))
    content |= {"legs": [], "objective": 0.0, "status": "unknown"}
    plan = Plan.from_json(json.dumps(content))
    assert (plan.routes, plan.legs, plan.cost) == ((), (), 0.0)
