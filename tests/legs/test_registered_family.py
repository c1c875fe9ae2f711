"""A family of legs that is registered: planned, proven, judged, flown, priced and shown."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brute_force import brute_force, brute_force_campaign
from example_packages import project_of, put
from longer_phasing import LONGER, LongerPhasing
from random_rules import carrying, limited, random_campaign, random_mission, towing
from seeds import over_seeds

import adr_opt
from adr_opt import check
from adr_opt.fly.flight.fly import fly
from adr_opt.legs.families import registry
from adr_opt.mission.problem import problem_of
from adr_opt.plan.leg_kinds import kind_names
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance

EXAMPLE = Path(__file__).parents[2] / "examples" / "longer-phasing"

MOST = 12
FEWER = 1


def with_fewer(instance: Instance, most: int = FEWER) -> Instance:
    """An instance whose short legs may have few phasing revolutions."""
    return instance.replace(transfer=instance.transfer.replace(max_phasing_revolutions=most))


@pytest.fixture
def longer() -> Iterator[LongerPhasing]:
    """The family, registered while a test runs."""
    family = LongerPhasing(MOST)
    registry.register(family)
    yield family
    registry.unregister(family)


@pytest.fixture
def planned(longer: LongerPhasing) -> tuple[Instance, Plan]:
    """A small field with the plan of a proof over both families."""
    instance = with_fewer(adr_opt.generate("tiny", 1))
    return instance, adr_opt.solve(instance, "exact", time_limit=60.0).plan


@pytest.mark.parametrize("seed", range(5))
def test_connections_of_both_families_are_those_of_one_with_all_revolutions(
    seed: int, longer: LongerPhasing
) -> None:
    """Two families that share the revolutions of one find what it finds, and name their own."""
    whole = adr_opt.generate("tiny", seed)
    parted = adr_opt.Timetable(with_fewer(whole))
    registry.unregister(longer)
    try:
        one = adr_opt.Timetable(with_fewer(whole, MOST))
        expected = one.all_connections(resolution_m_s=0.0)
    finally:
        registry.register(longer)
    found = parted.all_connections(resolution_m_s=0.0)
    for name in ("origin", "destination", "departure", "arrival", "revolutions"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    assert np.allclose(found.delta_v, expected.delta_v, rtol=0.0, atol=1e-9)
    assert np.array_equal(found.family == longer.number, found.revolutions > FEWER)
    assert (found.family == longer.number).any()


def test_plans_of_a_registered_family_are_planned_proven_and_judged(
    planned: tuple[Instance, Plan], longer: LongerPhasing
) -> None:
    """The proof is that of the same field with all revolutions, and both judges agree."""
    instance, plan = planned
    kinds = {leg.kind for leg in plan.legs}
    assert longer.kind.name in kinds
    assert plan.status == "optimal"
    assert not check(instance, plan)
    registry.unregister(longer)
    try:
        whole = adr_opt.solve(with_fewer(instance, MOST), "exact", time_limit=60.0).plan
    finally:
        registry.register(longer)
    assert (plan.objective, plan.cost) == (whole.objective, pytest.approx(whole.cost, abs=1e-6))
    for method in ("greedy", "beam", "ortools", "auto"):
        other = adr_opt.solve(instance, method, time_limit=60.0, iterations=5).plan
        assert not check(instance, other), method
        assert other.objective <= plan.objective, method


@over_seeds(range(24), gate=3)
def test_proofs_over_a_registered_family_are_those_of_enumeration(
    seed: int, longer: LongerPhasing
) -> None:
    """Under rules of every kind, of one chaser and of several, no plan is better than proven."""
    instance = with_fewer(random_mission(seed))
    if seed % 4 == 1:
        instance = with_fewer(random_campaign(seed))
    elif seed % 4 == 2:
        instance = towing(carrying(instance, seed), seed)
    elif seed % 4 == 3:
        instance = limited(instance, seed)
    problem = problem_of(instance)
    assert longer in problem.missions[0].connecting.families
    if problem.alone is None:
        best = brute_force_campaign(problem)[0]
    else:
        best = brute_force(problem.alone)[0]
    plan = adr_opt.solve(instance, "exact", time_limit=60.0).plan
    if plan is None:
        assert best == -np.inf
        return
    assert not check(instance, plan)
    assert (plan.status, plan.objective) == ("optimal", pytest.approx(best))
    for method in ("lagrangian", "routing-bound") if seed % 4 == 0 else ():
        bounded = adr_opt.bound(instance, method, time_limit=60.0)
        assert bounded.upper_bound >= best - 1e-9, method


def test_a_judge_sees_what_is_wrong_with_a_registered_leg(
    planned: tuple[Instance, Plan], longer: LongerPhasing
) -> None:
    """Cheaper, later, turned burns, or in a field that has none of the family: each is refused."""
    instance, plan = planned
    number, leg = next((n, leg) for n, leg in enumerate(plan.legs) if leg.kind == longer.kind.name)
    assert any(burn.phase == LONGER.name for burn in leg.burns)

    def rules_of(**changes: object) -> set[str]:
        legs = list(plan.legs)
        legs[number] = leg.replace(**changes)
        spoilt = plan.replace(routes=(plan.routes[0].replace(legs=tuple(legs)),))
        return {violation.rule for violation in check(instance, spoilt)}

    assert "cost" in rules_of(delta_v_m_s=leg.delta_v_m_s - 1.0)
    assert "arrival" in rules_of(arrival_s=leg.arrival_s - 10.0)
    assert "departure" in rules_of(departure_s=leg.departure_s + 10.0)
    turned = leg.burns[0].replace(delta_v_m_s=tuple(-x for x in leg.burns[0].delta_v_m_s))
    assert "burns" in rules_of(burns=(turned, *leg.burns[1:]))
    assert rules_of(kind="short")
    given = adr_opt.Timetable.from_connections(
        instance, adr_opt.Timetable(instance).all_connections().columns()
    ).instance
    moved = plan.replace(instance=plan.instance.replace(name=given.name, sha256=given.sha256))
    assert {v.rule for v in check(given, moved)} >= {"given"}


def test_registered_legs_are_flown_refined_priced_exported_and_shown(
    planned: tuple[Instance, Plan], longer: LongerPhasing, cli, tmp_path: Path
) -> None:
    """Every door that a plan goes through takes the legs of a registered family."""
    pytest.importorskip("boinor")
    instance, plan = planned
    flight = fly(instance, plan)
    assert flight.worst_miss_m < 1.0
    instance.save(tmp_path / "field.json")
    plan.save(tmp_path / "plan.json")
    assert adr_opt.load_plan(tmp_path / "plan.json") == plan
    files = str(tmp_path / "field.json"), str(tmp_path / "plan.json")
    answered = json.loads(cli("price", files[0], *plan.destinations, "--json").out)
    kinds = [leg["kind"] for leg in answered["routes"][0]["legs"]]
    assert kinds == [leg.kind for leg in plan.legs]
    refined = str(tmp_path / "refined.json")
    assert cli("refine", *files, "--out", refined).status == 0
    assert longer.kind.name in Path(refined).read_text()
    for name in ("plan.oem", "plan.czml", "plan.script"):
        assert cli("export", *files, "--out", str(tmp_path / name)).status == 0, name
    page = tmp_path / "report.html"
    assert cli("report", *files, "--out", str(page)).status == 0
    assert LONGER.label in page.read_text()


def test_a_proof_over_a_registered_family_is_verified(
    planned: tuple[Instance, Plan], cli, tmp_path: Path
) -> None:
    """The verifier goes through the connections of both families, and samples both."""
    instance, _ = planned
    instance.save(tmp_path / "field.json")
    out = cli(
        "solve",
        str(tmp_path / "field.json"),
        "--method",
        "exact",
        "--time-limit",
        "60",
        "--out",
        str(tmp_path / "plan.json"),
        "--certificate",
        str(tmp_path / "certificate.json"),
    )
    assert out.status == 0
    judged = cli("verify", str(tmp_path / "field.json"), str(tmp_path / "certificate.json"))
    assert judged.status == 0, judged.out + judged.err


def test_names_of_families_and_phases_are_taken_once(longer: LongerPhasing) -> None:
    """A kind that there is already is refused, and what comes with the package stays."""
    with pytest.raises(ValueError, match="longer"):
        registry.register(LongerPhasing(MOST))
    other = LongerPhasing(MOST)
    other.kind = replace(longer.kind, name="other")
    with pytest.raises(ValueError, match=LONGER.name):
        registry.register(other)
    assert "other" not in kind_names()
    assert registry.families()[-1] is longer
    with pytest.raises(ValueError, match="registered last"):
        registry.unregister(registry.families()[0])


def test_plans_of_a_kind_that_nobody_registered_are_refused(tmp_path: Path) -> None:
    """Without its family a plan file with such legs is bad input, in one sentence."""
    family = LongerPhasing(MOST)
    registry.register(family)
    try:
        instance = with_fewer(adr_opt.generate("tiny", 1))
        adr_opt.solve(instance, "exact", time_limit=60.0).plan.save(tmp_path / "plan.json")
    finally:
        registry.unregister(family)
    with pytest.raises(adr_opt.InputError, match="'launch', 'given' or 'low-thrust'"):
        adr_opt.load_plan(tmp_path / "plan.json")


def with_packages(tmp_path: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A call of the command line where the packages in a folder are installed."""
    found = os.pathsep.join([str(tmp_path), str(EXAMPLE), *sys.path])
    return subprocess.run(
        [sys.executable, "-m", "adr_opt", *words],
        env={**os.environ, "PYTHONPATH": found},
        capture_output=True,
        check=False,
        text=True,
    )


def test_the_family_of_an_installed_package_is_known_at_once(tmp_path: Path) -> None:
    """Its kind and its phase are in the schema of plans, because an entry point registers it."""
    put(project_of(EXAMPLE), tmp_path)
    defined = json.loads(with_packages(tmp_path, "schema", "plan").stdout)["$defs"]
    assert "longer" in defined["Leg"]["properties"]["kind"]["enum"]
    assert LONGER.name in defined["Burn"]["properties"]["phase"]["enum"]


@pytest.mark.slow
def test_a_package_whose_family_cannot_be_registered_is_named_in_one_sentence(
    tmp_path: Path,
) -> None:
    """What is installed and broken ends a run with exit code 2, and says which package it is."""
    project = project_of(EXAMPLE)
    broken = {"adr_opt.leg_families": {"longer": "longer_phasing_of_old:register"}}
    put({**project, "entry-points": broken}, tmp_path)
    said = with_packages(tmp_path, "generate", "tiny", "--out", str(tmp_path / "field.json"))
    assert said.returncode == 0
    solved = with_packages(tmp_path, "solve", str(tmp_path / "field.json"), "--method", "greedy")
    assert solved.returncode == 2
    (line,) = solved.stderr.splitlines()
    assert "longer_phasing_of_old" in line
