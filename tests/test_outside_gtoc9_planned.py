"""Campaigns of made-up debris by the rules of GTOC9: planned, bounded and flown."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from from_outside import BENCH
from outside.gtoc9 import cells
from outside.gtoc9.campaign import read_campaign
from outside.gtoc9.debris import read_debris
from outside.gtoc9.estimate import LIMITS_M
from outside.gtoc9.flights import report_flight
from outside.gtoc9.flying import CLOSE_M, CLOSE_M_S, MOST_IMPULSES, flown_leg, read_ephemeris
from outside.gtoc9.least import proven
from outside.gtoc9.ours import planned, write_campaign
from scipy.integrate import solve_ivp

from adr_opt.errors import InputError
from adr_opt.kernels import drift
from adr_opt.kernels.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2, OBLATENESS_M2

assert BENCH.is_dir()


def made_up(path, count, spread_deg=6.0, epoch=22000.0, seed=4):
    """A file of debris whose planes are near at an epoch, in the form of the contest's."""
    random = np.random.default_rng(seed)
    lines = []
    for number in range(count):
        plane = math.radians(100.0 + random.uniform(-spread_deg, spread_deg))
        elements = [
            epoch + random.uniform(0.0, 1.0), 7.1e6 + random.uniform(-5e4, 5e4),
            random.uniform(0.0, 0.01),
            math.radians(98.0 + spread_deg * random.uniform(-0.1, 0.1)), plane,
            random.uniform(0.0, math.tau), random.uniform(0.0, math.tau),
        ]  # fmt: skip
        lines.append(" ".join(repr(value) for value in (float(number), *elements)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def field(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("gtoc9") / "debris_data.txt", 7)


@pytest.fixture(scope="module")
def close(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("near") / "debris_data.txt", 4, 0.5, 23599.0)


def test_no_leg_of_a_cell_is_cheaper_than_its_bound(field):
    """Legs that arrive anywhere in a cell, after any time of flight, cost at least its bound."""
    rows = read_debris(field)
    random = np.random.default_rng(1)
    near = 0
    for _ in range(400):
        i, j = random.choice(len(rows), 2, replace=False)
        pair = drift.prepare(rows[i], rows[j], *LIMITS_M, OBLATENESS_M2)
        width, longest = random.uniform(0.2, 5.0) * DAY_S, random.uniform(0.2, 25.0) * DAY_S
        begin = random.uniform(23467.0, 26400.0) * DAY_S
        bound = cells.least_cost(pair, begin, begin + width, longest)
        cheapest = min(
            drift.delta_v(pair, arrival - span, arrival)
            for arrival in np.linspace(begin, begin + width, 7)
            for span in np.linspace(longest / 9, longest, 9)
        )
        assert bound <= cheapest
        near += bound > 0.9 * cheapest
    # A bound that is always nothing would hold as well.
    assert near > 200


def test_a_plan_is_legal_and_above_the_bound(field, tmp_path):
    """A campaign planned from nothing keeps all rules, and J is no less than the bound."""
    rows = read_debris(field)
    found = planned(rows, seed=1, chains=1, step_d=0.5, iterations=1000)
    assert found.judged.violations == ()
    below = proven(rows, time_limit_s=0.5)
    assert 30.0 < below.value <= found.judged.total_meur
    write_campaign(tmp_path / "ours.json", found.missions, rows)
    again = read_campaign(tmp_path / "ours.json")
    assert [stop.debris for mission in again for stop in mission.stops] == [
        stop.debris for mission in found.missions for stop in mission.stops
    ]


def pull(_, state):
    """The contest's equations of motion."""
    x, y, z = state[:3]
    r = math.sqrt(x * x + y * y + z * z)
    share, strength = 1.5 * J2 * (EARTH_RADIUS_M / r) ** 2, -MU_M3_S2 / r**3
    across, polar = 1.0 - 5.0 * (z / r) ** 2, 3.0 - 5.0 * (z / r) ** 2
    return [
        *state[3:],
        strength * x * (1.0 + share * across),
        strength * y * (1.0 + share * across),
        strength * z * (1.0 + share * polar),
    ]


@pytest.mark.parametrize("days", [1.0, 4.0])
def test_a_flown_leg_arrives_in_another_propagation(close, days):
    """Impulses of a leg lead from one debris to the other also where SciPy integrates them."""
    debris = read_ephemeris(close)
    departure, arrival = 23600.0, 23600.0 + days
    leg = flown_leg(debris[0], debris[1], departure, arrival)
    assert leg.impulses <= MOST_IMPULSES
    assert leg.delta_v_m_s == pytest.approx(np.linalg.norm(leg.impulses_m_s, axis=1).sum())
    state, now = debris[0].state(departure * DAY_S), departure * DAY_S
    for time, impulse in zip(
        [*leg.times_s, arrival * DAY_S], [*leg.impulses_m_s, np.zeros(3)], strict=True
    ):
        if time > now:
            flown = solve_ivp(pull, (0.0, time - now), state, "DOP853", rtol=1e-12, atol=1e-6)
            state, now = flown.y[:, -1], time
        state[3:] += impulse
    off = state - debris[1].state(arrival * DAY_S)
    assert np.linalg.norm(off[:3]) < CLOSE_M
    assert np.linalg.norm(off[3:]) < CLOSE_M_S


def test_a_mission_is_flown_and_reported(close, tmp_path):
    """A mission of a file is flown leg by leg, and one that is not in it is refused."""
    mission = {"debris": [2, 3], "stay_d": [5.0, 5.0], "transfer_d": [3.0], "dv_m_s": [0.0]}
    path = tmp_path / "campaign.json"
    path.write_text(json.dumps({"start_mjd2000": [23600.0], "missions": [mission]}))
    text = report_flight(close, path, 0, read_debris(close))
    assert "1 of 1 legs flown" in text
    with pytest.raises(InputError, match="missions 0 to 0"):
        report_flight(close, path, 1, read_debris(close))
