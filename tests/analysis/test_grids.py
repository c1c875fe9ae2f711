"""Other grids of drift legs, and what `solve` says of them."""

from __future__ import annotations

import pytest
from conftest import Cli
from drifting_plans import orbit

import adr_opt
from adr_opt.analysis.grids import grid_advice, on_grid
from adr_opt.common.constants import DAY_S
from adr_opt.mission.problem import Problem
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance


def field(step_d: float, tank_m_s: float = 600.0) -> Instance:
    """Six objects at two altitudes over forty days, too many for the tank, on a grid of a step."""
    drawn = adr_opt.generate("rocket-bodies", 0, targets=6)
    places = [orbit(760 + 90 * (n % 2), 71.0, 1.5 * n, true_anomaly_deg=50.0 * n) for n in range(7)]
    return drawn.replace(
        targets=tuple(
            target.replace(orbit=place)
            for target, place in zip(drawn.targets, places[1:], strict=True)
        ),
        chasers=(
            drawn.chaser.replace(
                start={"orbit": places[0].model_dump()}, tank={"delta_v_m_s": tank_m_s}
            ),
        ),
        mission=drawn.mission.replace(duration_s=40.0 * DAY_S),
        transfer=drawn.transfer.replace(
            drift_step_s=step_d * DAY_S,
            max_drift_s=40.0 * DAY_S,
            delta_v_resolution_m_s=0.1,
            departure_spacing_s=2.0 * DAY_S,
        ),
    )


def planned(step_d: float) -> tuple[Problem, Plan]:
    """The mission on a grid, and its plan by a beam, of which nothing is proven."""
    mission = Problem(field(step_d))
    plan = adr_opt.solve(mission, "beam", time_limit=60.0).plan
    assert plan is not None
    assert any(leg.kind == "drift" for leg in plan.legs)
    return mission, plan


def test_the_same_grid_costs_the_same() -> None:
    """The orders of a plan cost on its own grid what the plan says."""
    mission, plan = planned(4.0)
    trial = on_grid(mission, plan, 4.0 * DAY_S)
    assert trial.delta_v_m_s == pytest.approx(plan.delta_v_m_s, abs=0.05)


def test_finer_grids_that_divide_cost_no_more() -> None:
    """Half of the step has all departures of the step: the orders cost no more."""
    mission, plan = planned(4.0)
    costs = [on_grid(mission, plan, step * DAY_S).delta_v_m_s for step in (4.0, 2.0, 1.0)]
    assert costs[1] <= costs[0] + 0.1 * len(plan.legs)
    assert costs[2] <= costs[1] + 0.1 * len(plan.legs)


def test_advice_is_what_the_other_grid_gives() -> None:
    """A finer grid pays where orders cost 5 % less, a coarser one where they cost as much."""
    said = set()
    for step_d in (0.25, 8.0):
        mission, plan = planned(step_d)
        finer, coarser = (on_grid(mission, plan, share * step_d * DAY_S) for share in (0.5, 2.0))
        advice = grid_advice(mission, plan)
        if finer.delta_v_m_s <= 0.95 * plan.delta_v_m_s:
            assert advice is not None
            assert f"drift_step_s = {finer.step_s:g}" in advice
            said.add("finer")
        elif coarser.delta_v_m_s <= 1.03 * plan.delta_v_m_s:
            assert advice is not None
            assert f"drift_step_s = {coarser.step_s:g}" in advice
            said.add("coarser")
        else:
            assert advice is None
    assert said == {"finer", "coarser"}


def test_solve_tells_the_advice(cli: Cli) -> None:
    """`solve` says on standard error that a finer grid pays, where one does."""
    field(8.0).save("i.json")
    said = cli("solve", "i.json", "--method", "beam", "--out", "p.json")
    assert said.status == 0
    assert "note: a finer grid pays: with drift_step_s = 345600 (4 days)" in said.err
    assert "finer grid" not in cli("solve", "i.json", "--method", "beam", "--quiet").err
