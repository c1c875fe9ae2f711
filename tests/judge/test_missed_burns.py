"""Safety ellipses: legal plans, refined ones, and their missed burns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import as_json, field
from conftest import Cli, refused
from fields import eccentric
from hypothesis import given, settings
from hypothesis import strategies as st
from seeds import over_seeds

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.common.errors import InputError
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.flight.fly import fly
from adr_opt.judge.check.missed import (
    CAPTURE_REVOLUTIONS,
    SPARE_M,
    begun,
    check_missed,
    nearest_m,
    rule_of,
)
from adr_opt.judge.refined import check_refined
from adr_opt.problem.approach import approach_of, relative
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import TransferSettings

ELLIPSE = TransferSettings(approach="safety-ellipse")


def mission(seed: int, dynamics: str = "j2", **changes: float) -> Instance:
    """A tiny field whose targets are approached on safety ellipses, and are not quite round."""
    drawn = eccentric(adr_opt.generate("tiny", seed, targets=6), 0.005, seed)
    transfer = drawn.transfer.replace(approach="safety-ellipse", **changes)
    return drawn.replace(dynamics=dynamics, transfer=transfer)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 8), st.integers(0, 12), st.floats(300.0, 5000.0), st.floats(0.05, 0.7))
def test_by_linear_motion_an_ellipse_ends_at_rest_at_the_target(
    laps: int, inspecting: int, standoff_m: float, share: float
) -> None:
    """By Clohessy and Wiltshire, whatever the stand-off, radius, drift and inspection."""
    approach = approach_of(
        ELLIPSE.replace(
            approach_revolutions=laps,
            inspection_revolutions=inspecting,
            standoff_m=standoff_m,
            keep_out_m=share * standoff_m,
        )
    )
    plane, side, now = np.array([0.0, -standoff_m, 0.0, 0.0]), np.zeros(2), 0.0
    for time, outward, ahead, across, behind in approach.burns:
        angle = math.tau * (time - now)
        c, s = math.cos(angle), math.sin(angle)
        plane, now = relative(plane, angle), time
        side = np.array([c * side[0] + s * side[1], c * side[1] - s * side[0]])
        assert behind == pytest.approx(-plane[1], abs=1e-6)
        plane += [0.0, 0.0, outward, ahead]
        side[1] += across
    assert np.abs([*plane, *side]).max() < 1e-6 * standoff_m
    assert approach.revolutions == laps + 2.5 + inspecting


def nearest(count: int, seed: int, transfer: TransferSettings) -> np.ndarray:
    """Least distances of drawn targets, each burn up to the capture missed in turn."""
    rng = np.random.default_rng(seed)
    e, perigee = rng.uniform(0.0, 0.02, count), EARTH_RADIUS_M + rng.uniform(3e5, 1.2e6, count)
    tilt, angles = np.arccos(rng.uniform(-1.0, 1.0, count)), rng.uniform(0.0, math.tau, (3, count))
    orbits = np.stack([perigee / (1.0 - e), e, tilt, *angles], axis=1)
    target, chaser, motion = begun(orbits, transfer.standoff_m)
    rows = approach_of(transfer).burns
    judged = int(np.sum(rows[:, 0] <= rows[-1, 0] - CAPTURE_REVOLUTIONS))
    revolution = math.tau / motion[:, 0]
    times = rows[:judged, :1] * revolution
    return nearest_m(target, chaser, times, rule_of(rows, motion), revolution)


@pytest.mark.parametrize(
    "changes",
    [{}, {"approach_revolutions": 5}, {"inspection_revolutions": 4}, {"keep_out_m": 720.0}],
    ids=str,
)
def test_no_missed_burn_leads_near_the_target(changes: dict[str, float]) -> None:
    """Nowhere about the Earth, for eccentricities up to 0.02, in eight revolutions."""
    transfer = ELLIPSE.replace(**changes)
    assert nearest(12, 1, transfer).min() > transfer.keep_out_m


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_no_missed_burn_leads_near_a_thousand_targets(seed: int) -> None:
    """The same of a thousand targets in all."""
    assert nearest(200, 100 + seed, ELLIPSE).min() > ELLIPSE.keep_out_m


@over_seeds(range(6), gate=1)
@pytest.mark.parametrize("dynamics", [pytest.param("two-body", marks=pytest.mark.slow), "j2"])
def test_plans_with_safety_ellipses_are_legal_and_fly(seed: int, dynamics: str) -> None:
    """Planned, proven, checked, flown; refined, and checked and flown again."""
    instance = mission(seed, dynamics)
    result = adr_opt.solve(instance, "exact", time_limit=60.0)
    plan = result.plan
    assert plan is not None
    assert adr_opt.check(instance, plan) == ()
    if not plan.legs:
        return
    assert all(
        sum(burn.phase == "approach" for burn in leg.burns) == len(approach_of(ELLIPSE).burns)
        for leg in plan.legs
    )
    assert max(leg.miss_m for leg in fly(instance, plan).legs) < 30.0
    refined = adr_opt.refine(instance, plan)
    assert check_refined(instance, plan, refined) == ()
    assert fly_refined(instance, refined).violations == ()


def test_a_shrunken_ellipse_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both judges name the burn whose miss leads within the distance that is kept."""
    instance = mission(1)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    refined = adr_opt.refine(instance, plan)
    wider = instance.replace(transfer=instance.transfer.replace(keep_out_m=200.0 + 60.0))
    # Files of the narrower ellipse under a wider promise, with nothing else changed.
    monkeypatch.setattr("adr_opt.judge.check.missed.approach_of", lambda _: approach_of(ELLIPSE))
    monkeypatch.setattr("adr_opt.judge.refined.flight.approach_of", lambda _: approach_of(ELLIPSE))
    found = list(check_missed(wider, plan))
    assert {each.leg for each in found} == set(range(1, len(plan.legs) + 1))
    assert "missed it comes within 2" in found[0].message
    assert found[0].rule == "keep-out"
    own = refined.replace(instance=refined.instance.replace(sha256=wider.sha256))
    rules = {each.rule for each in check_refined(wider, plan, own)}
    assert rules == {"keep-out"}
    assert SPARE_M < 10.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"inspection_revolutions": 60}, "out of step by then; give fewer"),
        ({"max_drift_s": 1e6}, "costs of drift legs do not include"),
        ({"keep_out_m": 760.0}, "must be at most 75"),
    ],
)
def test_ellipses_that_would_not_be_safe_are_refused(changes: dict[str, float], said: str) -> None:
    """In one sentence that names the field."""
    instance = mission(0)
    with pytest.raises(InputError, match=said):
        instance.replace(transfer=instance.transfer.replace(**changes))


def test_an_ellipse_about_an_eccentric_orbit_is_refused() -> None:
    """Beyond the eccentricities that it was flown for."""
    instance = mission(0)
    first, *others = instance.targets
    assert first.orbit is not None
    rounder = first.replace(orbit=first.orbit.replace(eccentricity=0.03))
    with pytest.raises(InputError, match=r"'debris-001' has eccentricity 0.03, more than"):
        instance.replace(targets=(rounder, *others))


def test_safety_ellipses_are_made_by_options(cli: Cli, tmp_path: Path) -> None:
    """`generate` and `import` write them, and say which option does not go with months."""
    assert cli("generate", "tiny", "--approach", "safety-ellipse", "--out", "a.json").status == 0
    made = adr_opt.load(tmp_path / "a.json")
    assert (made.transfer, made.name) == (ELLIPSE, "tiny-000-fitted")
    assert made.targets == adr_opt.generate("tiny", 0).targets
    (tmp_path / "all.json").write_text(as_json(field(8)), encoding="utf-8")
    call = ("import", "all.json", "--approach", "safety-ellipse", "--out", "b.json")
    assert cli(*call).status == 0
    assert adr_opt.load(tmp_path / "b.json").transfer.approach == "safety-ellipse"
    refused(cli(*call, "--duration-days", "90"), "--approach (approach", "do not include it yet")
