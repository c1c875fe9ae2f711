"""Slips of units are noted once, usual instances are not, and names cannot move the cursor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli, refused

import adr_opt
from adr_opt.problem.plausible import USUAL, doubts
from adr_opt.sources.generator.families import FAMILIES
from adr_opt.sources.mission_options import by_option

DAY_S = 86400.0


def changed(path: tuple[Any, ...], value: Any) -> adr_opt.Instance:
    """The tiny instance with one value in its file changed."""
    content = json.loads(adr_opt.generate("tiny", 0).with_limits(duration_s=2 * DAY_S).to_json())
    here = content
    for key in path[:-1]:
        here = here.setdefault(key, {}) if isinstance(here, dict) else here[key]
    here[path[-1]] = value
    return adr_opt.load(content)


BY_MASS = {"dry_mass_kg": 500.0, "propellant_kg": 300.0, "isp_s": 300.0}
HIGH = {
    "semi_major_axis_m": 6378.9e3,
    "eccentricity": 0.0,
    "inclination_deg": 96.0,
    "raan_deg": 0.0,
    "argument_of_perigee_deg": 0.0,
    "true_anomaly_deg": 0.0,
}
SLIPS: dict[str, tuple[tuple[Any, ...], Any, str]] = {
    "tank": (("chasers", 0, "tank", "delta_v_m_s"), 3.0, "is it in km/s?"),
    "isp": (("chasers", 0, "tank"), BY_MASS | {"isp_s": 3000.0}, "is it an exhaust speed"),
    "phasing": (("transfer", "min_altitude_m"), 300.0, "is it in km?"),
    "station": (("stations", 0, "orbit"), HIGH, "is it in another unit?"),
    "duration": (("mission", "duration_s"), 7.0, "is it in days?"),
    "window": (("targets", 1, "window_s"), [0.0, 5.0], "is it in days?"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_units_is_noted_once(slip: str) -> None:
    """A value in another unit is named with its field, its value and the likely unit."""
    path, value, said = SLIPS[slip]
    found = doubts(changed(path, value))
    assert len(found) == 1
    assert said in str(found[0])
    assert found[0].field.startswith(f"{path[0]}")


def test_a_thrust_in_millinewtons_is_noted() -> None:
    """80 N on less than ten tonnes is taken for 80 mN; 0.08 N is usual."""
    instance = adr_opt.generate("electric", 0)
    (chaser, *others) = instance.chasers
    strong = instance.replace(chasers=(chaser.replace(thrust_n=80.0), *others))
    assert [str(doubt) for doubt in doubts(strong)] == [
        "chasers[0].thrust_n = 80: no electric engine has it; is it in mN? The field is in N"
    ]
    assert doubts(instance) == ()


@pytest.mark.parametrize("family", FAMILIES)
def test_generated_instances_raise_no_doubt(family: str) -> None:
    """What the generator makes lies in the usual ranges."""
    assert doubts(adr_opt.generate(family, 0)) == ()


def test_usual_ranges_hold_something() -> None:
    """Each row has a range."""
    assert all(usual.least < usual.most for usual in USUAL)


def test_solve_and_check_note_the_same(cli: Cli, tmp_path: Path) -> None:
    """Both say the note of the module, on standard error, and go on."""
    instance = changed(("targets", 1, "window_s"), [0.0, 5.0])
    (doubt,) = doubts(instance)
    path, plan = str(tmp_path / "i.json"), str(tmp_path / "p.json")
    instance.save(path)
    solved = cli("solve", path, "--method", "greedy", "--out", plan)
    assert (solved.status, f"note: {doubt}" in solved.err) == (0, True)
    checked = cli("check", path, plan)
    assert (checked.status, f"note: {doubt}" in checked.err) == (0, True)
    assert f"note: {doubt}" not in cli("solve", path, "--method", "greedy", "--quiet").err


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (
            "field chasers[0].tank.delta_v_m_s = -1.0: must be positive",
            "--delta-v (delta_v_m_s = -1.0): must be positive",
        ),
        ("targets[3].window_s[1] = 5: over", "--deadline (window_s[1] = 5): over"),
        ("field unknown = 3: odd", "field unknown = 3: odd"),
        ("a.tle: line 3: bad", "a.tle: line 3: bad"),
    ],
)
def test_messages_name_the_option(said: str, expected: str) -> None:
    """Fields that an option fills are named by it; other messages stay."""
    assert by_option(said) == expected


NAMES = ("a\x1b[31mred", "b\x9b2J", "c\nadr-opt: wrote it", "d\u202eabc", "e\x7f", "f\r", "g\x07")


@pytest.fixture
def odd_file(tmp_path: Path) -> Path:
    """A tiny instance whose name and targets hold control characters."""
    instance = adr_opt.generate("tiny", 0)
    targets = [
        target.replace(name=name) for target, name in zip(instance.targets, NAMES, strict=True)
    ]
    path = tmp_path / "odd.json"
    instance.replace(name="in\x1b[2Jstance", targets=targets).save(path)
    return path


def is_harmless(text: str) -> bool:
    """Whether a terminal shows it and does nothing else."""
    return all(each.isprintable() or each == "\n" for each in text)


def test_names_are_said_with_escapes(cli: Cli, odd_file: Path) -> None:
    """Tables, messages and errors show control characters as escapes."""
    solved = cli("solve", odd_file, "--method", "greedy-guarded", "--out", "plan.json")
    assert solved.status == 0
    visited = [leg.destination for leg in adr_opt.plan.plan.load_plan("plan.json").legs]
    assert set(visited) & set(NAMES)
    for call in (
        ("solve", odd_file, "--method", "greedy-guarded"),
        ("check", odd_file, "plan.json"),
        ("bound", odd_file, "--method", "none-such\x1b[2J"),
        ("check", "none\x1b[2J.json", "plan.json"),
    ):
        outcome = cli(*call)
        assert is_harmless(outcome.out + outcome.err), call
    assert "\\u" in solved.out
    refused(cli("price", odd_file, "nobody\nadr-opt: wrote it"), "nobody")


def test_json_is_the_same_json(cli: Cli, odd_file: Path) -> None:
    """What --json prints holds escapes of its own, and says the names as they are."""
    outcome = cli("solve", odd_file, "--method", "greedy-guarded", "--json", "--quiet")
    assert is_harmless(outcome.out)
    content = json.loads(outcome.out)
    left = {each["target"] for each in content["unvisited"]}
    gone = {leg["destination"] for leg in content["routes"][0]["legs"]} - {"station"}
    assert left | gone == set(NAMES)
