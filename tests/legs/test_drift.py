"""The drift of the nodes: its rates, and the sentence that import and solve say about it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from hand_made import PERIOD_S, RADIUS_M, hand_made
from plans import with_legs

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.plan.plane_drift import drift_warning, node_rates
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue

CLOUD = Path(__file__).parents[2] / "examples/catalogue/cloud.tle"


def numbers(sentence: str | None) -> list[float]:
    """The numbers with a unit of a sentence, in order."""
    assert sentence is not None
    return [float(text) for text in re.findall(r"([\d.]+)(?:°| and| of its| m/s| days)", sentence)]


def alike(instance: Instance) -> Instance:
    """The instance with all bodies at one altitude and inclination: their nodes drift together."""
    orbit = instance.stations[0].orbit
    kept = {name: getattr(orbit, name) for name in ("semi_major_axis_m", "inclination_deg")}
    return instance.replace(
        targets=tuple(
            target.replace(orbit=target.orbit.replace(**kept)) for target in instance.targets
        )
    )


def test_rates_are_those_of_sgp4() -> None:
    """The rates are the secular ones of SGP4 to a hundredth; what it has besides is smaller."""
    api = pytest.importorskip("sgp4.api")
    lines = [line for line in CLOUD.read_text(encoding="utf-8").splitlines() if line[:2] == "1 "]
    seconds = [line for line in CLOUD.read_text(encoding="utf-8").splitlines() if line[:2] == "2 "]
    known = [api.Satrec.twoline2rv(*pair) for pair in zip(lines, seconds, strict=True)]
    made = catalogue.to_instance(catalogue.read([CLOUD]))
    rates = node_rates(made.instance)[1:]
    assert rates.size == len(known) == 60
    assert rates == pytest.approx([satellite.nodedot / 60.0 for satellite in known], rel=0.01)


def test_a_sun_synchronous_orbit_keeps_up_with_the_sun() -> None:
    """At 800 km and 98.6° the node goes around once a year, eastwards; prograde ones go west."""
    instance = hand_made()
    orbit = instance.stations[0].orbit.replace(semi_major_axis_m=7178137.0, inclination_deg=98.603)
    station = instance.stations[0].replace(orbit=orbit)
    rates = node_rates(instance.replace(stations=(station,)))
    assert rates[0] * 365.2422 * 86400.0 == pytest.approx(2.0 * math.pi, rel=1e-3)
    assert rates[4] < 0.0  # far, at 36°


def test_the_sentence_of_a_plan_adds_its_legs_up() -> None:
    """Degrees are the largest of the legs and m/s the sum of V sin i times drift, by hand."""
    instance = hand_made()
    speed = 2.0 * math.pi * RADIUS_M / PERIOD_S
    factor = -1.5 * 1.08262668e-3 * 2.0 * math.pi / PERIOD_S * (EARTH_RADIUS_M / RADIUS_M) ** 2
    plan = adr_opt.solve(instance, "exact").plan
    assert plan is not None
    inclinations = dict(
        zip(instance.names, np.radians([96.0, 97.0, 98.0, 95.0, 36.0]), strict=True)
    )
    most, worth = 0.0, 0.0
    for leg in plan.legs:
        first, second = inclinations[leg.origin], inclinations[leg.destination]
        apart = abs(factor * (math.cos(first) - math.cos(second))) * leg.departure_s
        most = max(most, math.degrees(apart))
        worth += speed * (math.sin(first) + math.sin(second)) / 2.0 * apart
    told = numbers(drift_warning(instance, plan))
    assert told == pytest.approx([most, worth, plan.delta_v_m_s], rel=0.05)
    assert drift_warning(instance, plan) in plan.notes


def test_the_sentence_of_an_instance_is_of_all_pairs() -> None:
    """Without a plan: days, median and tenth of the pairs in degrees and m/s."""
    instance = adr_opt.generate("nominal", 0)
    rates = node_rates(instance)
    pairs = [abs(a - b) for at, a in enumerate(rates) for b in rates[:at]]
    middle, high = np.quantile(pairs, [0.5, 0.9]) * instance.mission.duration_s
    worth = 7480.0 * math.sin(math.radians(96.0))
    told = numbers(drift_warning(instance))
    expected = [7.0, math.degrees(middle), math.degrees(high), middle * worth, high * worth]
    assert told == pytest.approx(expected, rel=0.05)


def test_what_does_not_matter_is_not_warned_of() -> None:
    """Planes that drift together, hours instead of days, and a plan without legs."""
    instance = adr_opt.generate("nominal", 0)
    assert drift_warning(alike(instance)) is None
    short = instance.with_limits(duration_s=3600.0)
    assert drift_warning(short) is None
    assert drift_warning(instance.replace(targets=())) is None
    plan = adr_opt.solve(alike(instance), "greedy").plan
    assert plan is not None
    assert drift_warning(alike(instance), plan) is None
    assert all("drift" not in note for note in plan.notes)
    assert drift_warning(instance, with_legs(plan, ())) is None


def test_many_bodies_are_as_quick_as_few() -> None:
    """Of thousands of bodies some stand for all pairs, and say nearly the same."""
    instance = adr_opt.generate("nominal", 0)
    many = instance.replace(
        targets=tuple(
            target.replace(name=f"{target.name} {copy}")
            for copy in range(60)
            for target in instance.targets
        )
    )
    assert numbers(drift_warning(many)) == pytest.approx(numbers(drift_warning(instance)), rel=0.1)


def test_import_and_solve_warn(cli: Cli) -> None:
    """Both say it with the numbers of their instance, and neither over minutes."""
    pytest.importorskip("sgp4")
    two_body = ("--dynamics", "two-body", "--out", "my.json")
    said = cli("import", CLOUD, *two_body).err
    instance = adr_opt.load("my.json")
    assert f"warning: {drift_warning(instance)}" in said
    said = cli("solve", "my.json", "--method", "greedy-guarded", "--out", "plan.json").err
    plan = adr_opt.load_plan("plan.json")
    assert f"note: {drift_warning(instance, plan)}" in said
    assert drift_warning(instance, plan) in plan.notes
    said = cli("import", CLOUD, "--duration-days", "0.02", *two_body).err
    assert "nodes drift" not in said


def test_what_the_model_knows_is_not_warned_of(cli: Cli) -> None:
    """Under J2 neither import nor solve warns of the drift that they plan with."""
    pytest.importorskip("sgp4")
    said = cli("import", CLOUD, "--max-targets", "5", "--duration-days", "2", "--out", "my.json")
    assert "nodes drift" not in said.err
    instance = adr_opt.load("my.json")
    assert instance.dynamics == "j2"
    assert drift_warning(instance) is None
    solved = cli("solve", "my.json", "--method", "greedy-guarded", "--out", "plan.json")
    assert solved.status == 0
    assert "nodes drift" not in solved.err
    assert drift_warning(instance, adr_opt.load_plan("plan.json")) is None


def test_the_page_on_importing_states_the_drift_of_its_cloud() -> None:
    """The figures of docs/importing.md are those that its example is warned with."""
    pytest.importorskip("sgp4")
    page = " ".join((CLOUD.parents[2] / "docs/importing.md").read_text(encoding="utf-8").split())
    still = catalogue.MissionOutline(dynamics="two-body")
    made = catalogue.to_instance(catalogue.read([CLOUD]), mission=still)
    _, *told = numbers(drift_warning(made.instance))
    stated = re.search(
        r"([\d.]+)° in the median and ([\d.]+)° or more .* worth (\d+) and (\d+) m/s a leg", page
    )
    assert stated is not None
    assert [float(text) for text in stated.groups()] == told
