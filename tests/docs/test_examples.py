"""The examples, run by the commands that they state, and right where that can be known."""

from __future__ import annotations

import re
import runpy
import shlex
import sys
from importlib import import_module
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli

import adr_opt
from adr_opt.export.tables import write_matrix, write_timetable
from adr_opt.mission.mission import Mission
from adr_opt.mission.order_repair import as_it_is, mended

FOLDER = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(path for path in FOLDER.glob("*.py") if path.stem != "coming_back")
PACKAGES = {
    "pyvrp_fuel_loads": ("pyvrp",),
    "ortools_orienteering": ("vrplib",),
    "lkh_tour": ("elkai", "vrplib"),
    "networkx_tour": ("networkx", "xarray", "h5netcdf"),
    "numpy_dynamic_programme": (),
    "highs_model": ("highspy", "pyomo"),
}
MOST_LINES = 40


@pytest.fixture(autouse=True)
def _beside_the_examples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the examples import what lies beside them."""
    monkeypatch.syspath_prepend(str(FOLDER))


def example(name: str):
    """Import an example, or skip the test where a package of it is missing."""
    for package in PACKAGES[name]:
        pytest.importorskip(package)
    return import_module(name)


QUICK = "lkh_tour", "networkx_tour", "numpy_dynamic_programme"


@pytest.mark.parametrize(
    "script",
    [pytest.param(path, marks=[pytest.mark.slow] * (path.stem not in QUICK)) for path in SCRIPTS],
    ids=lambda path: path.stem,
)
def test_the_commands_of_an_example_run(
    script: Path,
    cli: Cli,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """What its docstring says to type works, and no more visits survive than are promised."""
    for package in PACKAGES[script.stem]:
        pytest.importorskip(package)
    (tmp_path / "my.json").write_text(adr_opt.generate("nominal", 0, targets=9).to_json())
    text = script.read_text(encoding="utf-8")
    *prepare, run = re.findall(r"^    python (.+)$", text.partition('"""\n\n')[0], re.MULTILINE)
    assert prepare
    for command in prepare:
        module, package, *arguments = shlex.split(command)
        assert (module, package) == ("-m", "adr_opt")
        assert cli(*arguments).status == 0
    name, *arguments = shlex.split(run)
    assert name == f"examples/{script.name}"
    monkeypatch.setattr(sys, "argv", [str(script), *arguments])
    runpy.run_path(str(script), run_name="__main__")
    said = [int(n) for n in re.findall(r"^ *(\d+) visits", capsys.readouterr().out, re.MULTILINE)]
    promised, as_they_are, saved, own = said
    assert 0 < as_they_are <= saved <= promised
    assert own > 0


@pytest.mark.parametrize("script", [*SCRIPTS, FOLDER / "coming_back.py"], ids=lambda p: p.stem)
def test_an_example_is_short(script: Path) -> None:
    """Each example has fewer than 40 lines, and the page on examples lists it."""
    assert len(script.read_text(encoding="utf-8").splitlines()) < MOST_LINES
    assert script.name in (FOLDER / "README.md").read_text(encoding="utf-8")


def cycle_cost(weights: np.ndarray, order: tuple[int, ...]) -> int:
    """Cost of the cycle from the station through some bodies."""
    return sum(int(weights[a, b]) for a, b in zip((0, *order), (*order, 0), strict=True))


def test_lkh_finds_the_shortest_tour(tmp_path: Path) -> None:
    """On tiny fields LKH's tour costs as little as the best of all orders."""
    lkh, vrplib = example("lkh_tour"), pytest.importorskip("vrplib")
    for seed in range(3):
        instance = adr_opt.generate("tiny", seed, targets=6)
        write_matrix(instance, tmp_path / "costs.tsp", 0.0, scale=1.0)
        weights = vrplib.read_instance(tmp_path / "costs.tsp")["edge_weight"]
        order = tuple(lkh.solve(str(tmp_path / "costs.tsp")))
        best = min(cycle_cost(weights, other) for other in permutations(range(1, 7)))
        assert sorted(order) == list(range(1, 7))
        assert cycle_cost(weights, order) == best


def test_ortools_finds_the_best_cycle(tmp_path: Path) -> None:
    """On a tiny field OR-Tools visits as many targets as any cycle within the limit can."""
    module, vrplib = example("ortools_orienteering"), pytest.importorskip("vrplib")
    instance = adr_opt.generate("tiny", 3, targets=6)
    instance = instance.with_limits(delta_v_m_s=600.0)
    write_matrix(instance, tmp_path / "costs.oplib", 0.0)
    read = vrplib.read_instance(tmp_path / "costs.oplib")
    weights, limit = read["edge_weight"], read["cost_limit"]
    order = tuple(module.solve(str(tmp_path / "costs.oplib"), seconds=1))
    most = max(
        visits
        for visits in range(7)
        for other in permutations(range(1, 7), visits)
        if cycle_cost(weights, other) <= limit
    )
    assert 0 < most < 6
    assert len(order) == most
    assert cycle_cost(weights, order) <= limit


def test_the_dynamic_programme_keeps_its_own_limits(tmp_path: Path) -> None:
    """Its order fits the tank and the mission at the costs of the hours, and is not a bad one."""
    solve = example("numpy_dynamic_programme").solve
    mission = Mission(adr_opt.generate("nominal", 1, targets=8))
    matrices = write_matrix(mission, tmp_path / "costs.npz", np.arange(0.0, 604800.0, 3600.0))
    order = solve(str(tmp_path / "costs.npz"), 700.0, 200_000.0)
    left, now, body = 700.0, 0.0, 0
    for target in order:
        row = int(now // 3600.0)
        left -= matrices.delta_v[row, body, target]
        now += matrices.duration[row, body, target] + mission.rules.service[target]
        body = target
    assert len(set(order)) == len(order) >= 2
    assert left >= 0.0
    assert now <= 200_000.0
    shorter = solve(str(tmp_path / "costs.npz"), 300.0, 200_000.0)
    assert len(shorter) < len(order)


@pytest.mark.slow
def test_highs_loses_nothing(tmp_path: Path) -> None:
    """The exact model's order is legal as it is, so what is promised is kept."""
    module = example("highs_model")
    for seed in range(3):
        mission = Mission(adr_opt.generate("tiny", seed))
        write_timetable(mission, tmp_path / "model.lp")
        order = tuple(module.solve(str(tmp_path / "model.lp")))
        assert order
        assert as_it_is(mission, order) == order


def test_the_mission_with_deadlines_is_what_its_script_prints(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The committed file is that of the script, byte for byte."""
    runpy.run_path(str(FOLDER / "deadlines/make_mission.py"), run_name="__main__")
    assert capsys.readouterr().out == (FOLDER / "deadlines/mission.json").read_text("utf-8")


@pytest.mark.slow
def test_the_mission_with_deadlines_from_plan_to_export(cli: Cli, tmp_path: Path) -> None:
    """The commands of docs/rules.md work, one after the other, and the plan obeys every rule."""
    for package in ("boinor", "plotly"):
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(FOLDER)
    page = (FOLDER.parent / "docs/rules.md").read_text(encoding="utf-8")
    lines = re.findall(r"^    python -m adr_opt (.+)$", page, re.MULTILINE)
    assert [line.split()[0] for line in lines] == [
        "solve",
        "bound",
        "check",
        "fly",
        "report",
        "export",
        "export",
        "export",
    ]
    said = {}
    for line in lines:
        outcome = cli(*shlex.split(line))
        assert outcome.status == 0, (line, outcome.err)
        said[line.split()[0]] = outcome.out
    plan = adr_opt.load_plan("plan.json")
    assert (plan.status, plan.objective, plan.upper_bound) == ("optimal", 8.0, 8.0)
    assert "prize 8," in page
    assert "bound 8," in page
    assert "upper bound 8, optimal" in said["bound"]
    assert "every tank holds" in said["fly"]
    for suffix in ("html", "czml", "script", "oem"):
        assert (tmp_path / f"mission.{suffix}").stat().st_size > 0

    hour = 3600.0
    ends = {leg.destination: leg.end_s for leg in plan.legs}
    begins = {leg.destination: max(leg.arrival_s, 30.0 * hour) for leg in plan.legs}
    assert plan.legs[0].departure_s >= 6.0 * hour
    assert plan.legs[-1].end_s <= 66.0 * hour
    assert plan.legs[-1].destination == "station"
    assert "debris-015" in ends
    assert ends["debris-005"] <= 24.0 * hour
    assert ends["debris-007"] <= 40.0 * hour
    period = ends["debris-007"] - begins["debris-007"]
    assert 1.5 * hour < period < 1.8 * hour


def test_every_rule_of_the_deadlines_costs_something() -> None:
    """Without any one rule more is collected, or the required target left out and ΔV saved."""
    instance = adr_opt.load(FOLDER / "deadlines/mission.json")
    chaser = instance.chaser
    freed = {
        "windows": instance.replace(
            targets=tuple(target.replace(window_s=(0.0, None)) for target in instance.targets)
        ),
        "availability": instance.replace(chasers=(chaser.replace(available_s=(0.0, None)),)),
        "end": instance.replace(chasers=(chaser.replace(end="anywhere"),)),
    }
    for rule, free in freed.items():
        assert adr_opt.solve(free, "exact", time_limit=60).objective > 8.0, rule
    idle = instance.replace(
        targets=tuple(target.replace(required=False) for target in instance.targets)
    )
    asked, unasked = (adr_opt.solve(each, "exact", time_limit=60).plan for each in (instance, idle))
    assert asked is not None
    assert unasked is not None
    assert unasked.objective == asked.objective
    assert "debris-015" not in unasked.destinations
    assert unasked.cost < asked.cost


def test_any_order_comes_back_as_a_legal_plan(capsys: pytest.CaptureFixture[str]) -> None:
    """Random orders are mended to legal ones that keep at least their legal beginning."""
    come_back = import_module("coming_back").come_back
    mission = Mission(adr_opt.generate("nominal", 2, targets=10))
    rng = np.random.default_rng(0)
    for _ in range(20):
        order = tuple(int(j) for j in rng.permutation(11))
        saved = mended(mission, order)
        assert mission.time(saved).made == len(saved)
        kept = mission.time(as_it_is(mission, order)).objective
        assert mission.time(saved).objective >= kept
    plan = come_back("chance", mission, order)
    assert adr_opt.check(mission.instance, plan) == ()
    assert "10 visits promised by chance" in capsys.readouterr().out
