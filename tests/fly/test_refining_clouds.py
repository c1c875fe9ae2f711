"""Real clouds: what is planned is what the plan's own burns take when they are flown."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from plans import solved

import adr_opt
from adr_opt.fly.flight import fly_refined

DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", Path(__file__).parents[2] / "../shared/data"))
CLOUDS = (
    DATA / "tle" / "celestrak_2025-02_iridium-33-debris.txt",
    DATA / "omm" / "celestrak_2025-04_iridium-33-debris.csv",
)


@pytest.mark.external
@pytest.mark.parametrize("cloud", CLOUDS, ids=lambda path: path.stem)
def test_own_burns_take_what_was_planned(cli: Cli, cloud: Path) -> None:
    """Planned is within 5 % of flown in total and 15 % for a leg; 10 m and 1 cm/s are kept."""
    if not cloud.is_file():
        pytest.skip(f"no file {cloud} (ADR_OPT_EXTERNAL_DATA)")
    made = cli(
        "import",
        cloud,
        "--max-targets",
        "30",
        "--duration-days",
        "4",
        "--burns",
        "sequence",
        "--out",
        "my.json",
    )
    assert made.status == 0
    instance = adr_opt.load("my.json")
    plan = solved(instance)
    assert len(plan.legs) > 5
    refined = adr_opt.refine(instance, plan, freedom="planned")
    assert refined.status == "complete"
    planned = np.array([leg.planned_delta_v_m_s for leg in refined.legs])
    flown = np.array([leg.flown_delta_v_m_s for leg in refined.legs])
    assert planned.sum() == pytest.approx(flown.sum(), rel=0.05)
    assert np.abs(planned / flown - 1.0).mean() < 0.15
    flight = fly_refined(instance, refined)
    assert flight.worst_miss_m < 10.0
    assert flight.worst_miss_m_s < 0.01
