"""Missions of weeks with drift legs, proven and verified, against plain enumeration."""

from __future__ import annotations

import math

import pytest
from brute_force import brute_force
from random_rules import freely, weeks_mission

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.mission import Mission


@pytest.mark.slow
@pytest.mark.parametrize("is_free", [False, True])
@pytest.mark.parametrize("seeds", [range(50), range(50, 100)])
def test_proofs_of_weeks_end_at_the_optimum(seeds: range, is_free: bool) -> None:
    """`exact` proves the best plan of enumeration, `check` and `verify` agree, and legs drift."""
    drifting = 0
    for seed in seeds:
        instance = weeks_mission(seed)
        mission = Mission(freely(instance, seed) if is_free else instance)
        prizes, _, _ = brute_force(mission)
        result = adr_opt.solve(mission, "exact", time_limit=60.0)
        if not math.isfinite(prizes):
            assert result.status == "infeasible", seed
            continue
        assert result.status == "optimal", seed
        assert result.plan is not None
        assert result.objective == pytest.approx(prizes, abs=1e-9), seed
        assert adr_opt.check(mission.instance, result.plan) == (), seed
        certificate = certificate_of(mission.instance, result)
        verdict = adr_opt.verify(mission.instance, result.plan, certificate)
        assert verdict.verified, (seed, verdict.reasons)
        drifting += sum(
            leg.kind == "drift" and leg.arrival_s - leg.departure_s < 5.0 * DAY_S
            for leg in result.plan.legs
        )
    assert drifting > len(seeds) / 3
