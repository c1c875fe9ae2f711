"""Rows of the network where transfers of both kinds leave together, and proofs on them."""

from __future__ import annotations

import numpy as np
import pytest
from brute_force import brute_force

import adr_opt
from adr_opt.common.stop import TimeIsOver
from adr_opt.legs.corrections import Corrections
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance
from solvers.networks.network import build

DAY_S = 86400.0

TOGETHER = {0: 45.45, 4: 22.05, 5: 54.9, 9: 42.3, 24: 73.8}
"""Seeds, and true anomalies of the station for which short and long transfers leave at once [deg].

A node has been crossed some seconds before the epoch: short transfers are put off to it, and it is
on the grid of long ones.
"""

CORRECTIONS = (
    Corrections(),
    Corrections(factors={"drift": 4.0}),
    Corrections(factors={"short": 3.0}),
)


def drifting(seed: int, anomaly_deg: float, days: float, tank_m_s: float) -> Instance:
    """Three targets and few departures, short and long."""
    field = adr_opt.generate("tiny", seed, targets=3)
    transfer = {"drift_step_s": 43200.0, "max_drift_s": 432000.0, "departure_spacing_s": 20000.0}
    station = field.stations[0]
    orbit = station.orbit.replace(true_anomaly_deg=anomaly_deg)
    return field.replace(
        stations=(station.replace(orbit=orbit),),
        dynamics="j2",
        transfer=field.transfer.model_copy(update=transfer),
    ).with_limits(duration_s=days * DAY_S, delta_v_m_s=tank_m_s)


@pytest.mark.parametrize("corrections", CORRECTIONS, ids=str)
@pytest.mark.parametrize("seed", TOGETHER)
def test_the_later_legs_of_a_row_land_the_less_they_cost(
    seed: int, corrections: Corrections
) -> None:
    """Whatever leaves together and is corrected, labels may look for legs by bisection."""
    mission = Mission(drifting(seed, TOGETHER[seed], 5.0, 1500.0), threads=1).corrected(corrections)
    mixed = 0
    for j in range(1, len(mission.names)):
        found = mission.connecting.found(0, j)
        mixed += np.unique(found.revolutions[found.departure == 0.0] < 0).size == 2
    assert mixed > 0
    network = build(mission, jobs=1)
    for row in range(network.departure.size):
        legs = slice(network.first[row], network.first[row + 1])
        assert np.all(np.diff(network.landing[legs]) >= 0)
        assert np.all(np.diff(network.delta_v[legs]) < 0.0)


@pytest.mark.parametrize("corrections", CORRECTIONS, ids=str)
@pytest.mark.parametrize(("days", "tank_m_s"), [(1.4, 622.0), (2.5, 400.0)])
@pytest.mark.parametrize("seed", TOGETHER)
def test_proofs_over_transfers_of_both_kinds_equal_brute_force(
    seed: int, days: float, tank_m_s: float, corrections: Corrections
) -> None:
    """What is proven where short and long transfers leave together is what brute force finds."""
    instance = drifting(seed, TOGETHER[seed], days, tank_m_s)
    mission = Mission(instance, threads=1).corrected(corrections)
    best, _, _ = brute_force(mission)
    result = adr_opt.solve(mission, "exact", time_limit=60.0, jobs=1)
    assert result.objective == pytest.approx(best)
    assert result.upper_bound == pytest.approx(best, abs=1e-5)


def test_a_network_is_given_up_when_its_time_is_over() -> None:
    """It asks before each body, and begins none once the time is over."""
    asked: list[bool] = []

    def over() -> bool:
        asked.append(len(asked) >= 3)
        return asked[-1]

    with pytest.raises(TimeIsOver):
        build(Mission(adr_opt.generate("nominal", 0)), jobs=1, over=over)
    assert asked[:4] == [False, False, False, True]
