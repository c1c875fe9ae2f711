"""The exact method: equal to brute force, and a valid bound wherever it is cut short."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any

import pytest
from brute_force import brute_force
from calling import call
from exact_variants import variant
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made
from seeds import over_seeds

import adr_opt
from adr_opt.common.stop import MaxIterations, MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.run.methods import BOUNDS, PLANNERS, get
from solvers.planners.exact import exact

TINY = sorted((Path(__file__).parents[2] / "instances" / "tiny").glob("*.json"))


def prove(mission: Mission, stop: Any = None, **options: Any) -> Result:
    """Run the exact method, to its end unless told otherwise."""
    return call(exact, mission, stop=stop or MaxRuntime(60.0), **{"jobs": 1, **options})


@pytest.mark.parametrize("path", TINY, ids=lambda path: path.stem)
def test_equals_brute_force_on_the_tiny_family(path: Path) -> None:
    """Every committed tiny instance is proven, with the objective that brute force finds."""
    mission = Mission(adr_opt.load(path), threads=1)
    result = prove(mission)
    assert result.status == "optimal"
    assert result.objective == brute_force(mission)[0]
    assert result.upper_bound == pytest.approx(result.objective)


@over_seeds(range(30), gate=6)
def test_equals_brute_force_on_variants(seed: int) -> None:
    """So are variants with zones, unequal prizes, short tanks and short missions."""
    mission = Mission(variant(seed), threads=1)
    result = prove(mission)
    assert result.status == "optimal"
    assert result.objective == pytest.approx(brute_force(mission)[0])
    assert result.upper_bound == pytest.approx(result.objective, abs=1e-5)
    assert result.plan is not None
    assert adr_opt.check(mission.instance, result.plan) == ()


@over_seeds(range(10), gate=3)
def test_cut_short_the_bound_is_valid(seed: int) -> None:
    """After any number of iterations the bound holds, and more of them never loosen it."""
    mission = Mission(variant(seed), threads=1)
    best, _, _ = brute_force(mission)
    found = [prove(mission, MaxIterations(limit)).upper_bound for limit in (1, 2, 4, 8)]
    assert min(found) >= best - 1e-6
    assert found == sorted(found, reverse=True)
    assert math.isfinite(found[0])


def test_finds_the_worked_out_optimum() -> None:
    """On the hand-made instance it finds the only optimal plan, and says that it is optimal."""
    result = prove(Mission(hand_made(), threads=1))
    assert result.objective == OPTIMUM
    assert result.sequence == OPTIMAL_PLAN
    assert result.status == "optimal"


def test_slot_and_cores_do_not_matter_in_the_end() -> None:
    """Another slot of ΔV or another number of cores leads to the same objective and bound."""
    mission = Mission(variant(3), threads=1)
    objectives = {
        (result.objective, round(result.upper_bound, 5))
        for result in (
            prove(mission),
            prove(mission, jobs=2),
            prove(mission, delta_v_slot_m_s=3.0),
            prove(mission, delta_v_slot_m_s=400.0),
        )
    }
    assert len(objectives) == 1


def test_too_few_labels_end_with_a_valid_bound() -> None:
    """With hardly any labels it still ends by itself, with a plan and a bound that hold."""
    mission = Mission(adr_opt.generate("tiny", 6, targets=8), threads=1)
    result = prove(mission, most_labels=5)
    assert result.upper_bound >= brute_force(mission)[0]
    assert result.plan is not None


@pytest.mark.parametrize("method", ["auto", "exact", "lagrangian"])
def test_a_proof_that_breaks_ends_its_threads(method: str) -> None:
    """Whatever goes wrong in the middle of a proof, no thread of it lives on."""
    mission = Mission(adr_opt.generate("reduced-time", 1, targets=20), threads=1)
    group = BOUNDS if method == "lagrangian" else PLANNERS
    before = threading.active_count()
    while_proving = []

    def breaks(incumbent: float, bound: float) -> None:
        if bound < mission.total_worth:
            while_proving.append(threading.active_count())
            raise RuntimeError("nobody is listening")

    with pytest.raises(RuntimeError, match="nobody is listening"):
        call(get(method, group), mission, stop=MaxIterations(10), progress=breaks, jobs=2)
    assert max(while_proving) > before
    assert threading.active_count() == before
