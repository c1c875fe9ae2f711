"""The transfer of the kernels against one worked out with the reference library boinor."""

from __future__ import annotations

import math

import numpy as np
import pytest
from one_window import one_window

import adr_opt
from adr_opt.kernels.legs import co_elliptic, sequences
from adr_opt.legs.timetable import Timetable
from adr_opt.problem.instance import Instance

reference_leg = pytest.importorskip("reference_leg").reference_leg

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:.*faster on contiguous arrays")]


def next_leg(
    instance: Instance, origin: str, destination: str, ready_s: float
) -> tuple[float, float]:
    """ΔV [m/s] and arrival [s] of the sequence chosen at the next departure event, by kernels."""
    i, j = instance.names.index(origin), instance.names.index(destination)
    bodies, rule = instance.orbits(), instance.transfer_rule()
    extra = float(instance.eccentricity_delta_v()[i, j])
    pair = co_elliptic.prepare(bodies[i], bodies[j], extra, rule, 0.0)
    first, half_turns = co_elliptic.first_departure(pair)
    event = max(0, math.ceil((ready_s - first) * pair.rate_i / math.pi))
    departure = first + event * math.pi / pair.rate_i
    lead = co_elliptic.target_lead(pair, departure, half_turns + event)
    flown = sequences.best_sequence(pair, rule, departure, lead, one_window(), 0, departure)
    approach = rule.approach_revolutions * 2.0 * math.pi / pair.rate_j
    return float(flown.delta_v), float(departure + flown.flight_time + approach)


def assert_agree(instance: Instance, origin: str, destination: str, ready_s: float) -> None:
    delta_v, arrival = next_leg(instance, origin, destination, ready_s)
    leg = (instance.name, origin, destination, ready_s)
    found = reference_leg(instance, origin, destination, ready_s)
    assert found[0] == pytest.approx(delta_v, rel=1e-6), leg
    assert found[1] == pytest.approx(arrival, abs=1e-3), leg


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(24))
def test_legs_of_the_reference_scenario(seed: int) -> None:
    """ΔV agrees to 1e-6 and the arrival to a millisecond, whichever pair and time."""
    rng, instance = np.random.default_rng(seed), adr_opt.generate("tiny", seed)
    origin, destination = rng.choice(instance.names, 2, replace=False)
    assert_agree(instance, str(origin), str(destination), rng.uniform(0.0, 1e5))


@pytest.mark.parametrize(
    "orbit",
    [
        {"inclination_deg": 83.0, "raan_deg": 170.0},
        {"inclination_deg": 0.0, "raan_deg": 40.0},
        {"inclination_deg": 180.0},
        {"inclination_deg": 96.0, "raan_deg": 0.0},
        {"inclination_deg": 96.0, "raan_deg": 0.0, "semi_major_axis_m": 7078137.0},
        {"semi_major_axis_m": 7078137.0},
        {"semi_major_axis_m": 7800000.0, "true_anomaly_deg": -700.0},
    ],
    ids=["crossing", "equatorial", "retrograde", "coplanar", "same-orbit", "equal-radii", "high"],
)
@pytest.mark.slow
def test_special_geometries(orbit: dict[str, float]) -> None:
    """Planes and radii that are special in some way give what the reference gives, both ways."""
    instance = adr_opt.generate("tiny", 3, targets=1)
    (target,) = instance.targets
    instance = instance.replace(
        targets=(target.replace(orbit=target.orbit.replace(**orbit)),),
        transfer=instance.transfer.replace(max_phasing_revolutions=4),
    )
    assert_agree(instance, "station", target.name, 20000.0)
    assert_agree(instance, target.name, "station", 40000.0)


@pytest.mark.slow
def test_what_an_hour_is_worth() -> None:
    """Who does not value time gets the cheapest sequence from both."""
    instance = adr_opt.generate("tiny", 6).with_time_value(0.0)
    assert_agree(instance, "station", "debris-002", 30000.0)


@pytest.mark.parametrize(
    "settings",
    [
        {"max_phasing_revolutions": 0},
        {"first_leg_fraction": 0.0, "max_phasing_revolutions": 3},
        {"first_leg_fraction": 1.0, "max_phasing_revolutions": 3},
        {"standoff_m": 5000.0, "max_phasing_revolutions": 3},
        {"approach": "safety-ellipse"},
        {"inspection_revolutions": 2, "approach": "safety-ellipse", "keep_out_m": 90.0},
        {"min_altitude_m": 650e3, "max_altitude_m": 900e3},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_other_settings(settings: dict[str, float]) -> None:
    """Every setting of the transfer means the same to both."""
    instance = adr_opt.generate("tiny", 6)
    instance = instance.replace(transfer=instance.transfer.replace(**settings))
    assert_agree(instance, "station", "debris-002", 30000.0)


def test_no_transfer() -> None:
    """Where no radius within the limits meets the target, both say so."""
    instance = adr_opt.generate("tiny", 0)
    instance = instance.replace(
        transfer=instance.transfer.replace(
            min_altitude_m=700e3, max_altitude_m=700.1e3, max_phasing_revolutions=0
        )
    )
    assert math.isinf(Timetable(instance).lookup("debris-001", "debris-002", 0.0)[0])
    assert reference_leg(instance, "debris-001", "debris-002", 0.0) == (math.inf, math.inf)


def test_what_it_does_not_know_is_refused() -> None:
    """Keep-out zones are not ignored in silence."""
    instance = adr_opt.generate("tiny", 0, zones=1)
    with pytest.raises(adr_opt.InputError, match="keep-out zones"):
        reference_leg(instance, "station", "debris-001", 0.0)
