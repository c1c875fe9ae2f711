"""The families whose nodes drift: what is drawn, how transfers are laid out, and what is told."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M
from adr_opt.plan.plane_drift import node_rates
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.transfer_sizes import transfers_for
from adr_opt.sources.generator import FAMILIES, belt, clouds, rocket_bodies

INSTANCES = Path(__file__).parents[2] / "instances"
DRIFTING = {"rocket-bodies": (rocket_bodies, ""), "sso": (belt, "SSO_")}
"""Modules of families, and what the names of their limits begin with."""

LIMITS = ("ALTITUDE_KM", "INCLINATION_DEG", "ECCENTRICITY", "RAAN_DEG")


def apart_deg_a_year(name: str) -> np.ndarray:
    """How fast the nodes of two targets drift apart, of all pairs of some fields."""
    found = []
    for seed in range(5):
        rates = node_rates(adr_opt.generate(name, seed))[1:]
        pairs = np.triu_indices(rates.size, 1)
        found.append(np.abs(rates[pairs[0]] - rates[pairs[1]]))
    return np.degrees(np.concatenate(found)) * 365.25 * DAY_S


def stated(name: str) -> str:
    """The page of a family, in one line."""
    return " ".join((INSTANCES / name / "README.md").read_text(encoding="utf-8").split())


def test_all_families_that_drift_are_looked_at() -> None:
    """The families of the generator whose nodes drift are those of this file."""
    looked_at = {*DRIFTING, "removal", "electric", "fragment-cloud"}
    assert looked_at == {family.name for family in FAMILIES.values() if family.drifts}


def test_removal_has_two_kinds_of_targets() -> None:
    """Each target of the family is within the limits of one of the kinds, and weighs as it does."""
    kinds = (
        (rocket_bodies.ALTITUDE_KM, rocket_bodies.INCLINATION_DEG, rocket_bodies.HEAVY_KG),
        (
            rocket_bodies.LIGHTER_ALTITUDE_KM,
            rocket_bodies.LIGHTER_INCLINATION_DEG,
            rocket_bodies.LIGHT_KG,
        ),
    )
    counts = [0, 0]
    for seed in range(10):
        made = adr_opt.generate("removal", seed)
        for target in made.targets:
            altitude_km = (target.orbit.semi_major_axis_m - EARTH_RADIUS_M) / 1e3
            of_kind = [
                low[0] <= altitude_km <= low[1]
                and tilt[0] <= target.orbit.inclination_deg <= tilt[1]
                and target.mass_kg == mass
                for low, tilt, mass in kinds
            ]
            assert sum(of_kind) == 1
            counts[of_kind.index(True)] += 1
        assert [chaser.available_s[0] for chaser in made.chasers] == [
            number * rocket_bodies.APART_S for number in range(4)
        ]
    assert min(counts) > 200


def test_pieces_of_a_cloud_are_within_the_limits() -> None:
    """All pieces cross the height of the event, near its inclination, in planes all round."""
    orbits = [target.orbit for target in adr_opt.generate("fragment-cloud", 0).targets]
    sizes_km = np.array([orbit.semi_major_axis_m for orbit in orbits]) / 1e3
    swings_km = sizes_km * np.array([orbit.eccentricity for orbit in orbits])
    perigees_km = sizes_km - swings_km - EARTH_RADIUS_M / 1e3
    apogees_km = sizes_km + swings_km - EARTH_RADIUS_M / 1e3
    tilts_deg = np.array([orbit.inclination_deg for orbit in orbits])
    nodes_deg = np.array([orbit.raan_deg for orbit in orbits])
    for values, low, high in (
        (perigees_km, clouds.LOWEST_KM, clouds.EVENT_KM),
        (apogees_km, clouds.EVENT_KM, clouds.HIGHEST_KM),
        (tilts_deg - clouds.FRAGMENTS_INCLINATION_DEG, -clouds.SPREAD_DEG, clouds.SPREAD_DEG),
        (nodes_deg, 0.0, 360.0),
    ):
        assert low - 1e-3 <= values.min() < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < values.max() <= high + 1e-3
    # The lesser of two uniform numbers lies below a half three times of four.
    halfway_km = 0.5 * (clouds.EVENT_KM + clouds.HIGHEST_KM)
    assert np.mean(apogees_km < halfway_km) == pytest.approx(0.75, abs=0.05)


@pytest.mark.parametrize("name", DRIFTING)
def test_targets_are_within_the_limits(name: str) -> None:
    """Altitude, inclination and eccentricity fill their limits, and so do the angles."""
    drawn: list[Orbit] = []
    module, beginning = DRIFTING[name]
    limits = {end: getattr(module, beginning + end) for end in LIMITS}
    for seed in range(10):
        drawn += [target.orbit for target in adr_opt.generate(name, seed).targets]
    for values, (low, high) in (
        ([(o.semi_major_axis_m - EARTH_RADIUS_M) / 1e3 for o in drawn], limits["ALTITUDE_KM"]),
        ([o.inclination_deg for o in drawn], limits["INCLINATION_DEG"]),
        ([o.eccentricity for o in drawn], limits["ECCENTRICITY"]),
        ([o.raan_deg for o in drawn], limits["RAAN_DEG"]),
        ([o.argument_of_perigee_deg for o in drawn], (0.0, 360.0)),
        ([o.true_anomaly_deg for o in drawn], (0.0, 360.0)),
    ):
        shares = (np.array(values) - low) / (high - low)
        assert shares.min() >= -1e-9
        assert shares.max() <= 1.0 + 1e-9
        assert np.histogram(shares, 4, (0.0, 1.0))[0] / shares.size == pytest.approx(
            np.full(4, 0.25), abs=0.1
        )


def test_nobody_refuels_among_rocket_bodies() -> None:
    """There is no station, and the chaser starts in a circle of its own with the same limits."""
    for seed in range(5):
        made = adr_opt.generate("rocket-bodies", seed)
        assert made.stations == ()
        orbit = made.start_bodies["chaser"]
        assert orbit.eccentricity == 0.0
        assert 830e3 <= orbit.semi_major_axis_m - EARTH_RADIUS_M <= 850e3
        assert 70.9 <= orbit.inclination_deg <= 71.1
        fewer = adr_opt.generate("rocket-bodies", seed, targets=7)
        assert fewer.start_bodies == made.start_bodies
        orbits = [target.orbit for target in made.targets]
        assert [target.orbit for target in fewer.targets] == orbits[:7]


@pytest.mark.parametrize("name", DRIFTING)
def test_what_drifts_is_laid_out_by_the_length_of_the_mission(name: str) -> None:
    """Dynamics, service and transfers are those of the page, and drifts may last the mission."""
    made = adr_opt.generate(name, 0)
    assert made.dynamics == "j2"
    assert made.mission.service_s == DAY_S
    assert made.transfer == transfers_for(made.mission.duration_s)
    assert made.transfer.max_drift_s == made.mission.duration_s
    said = stated(name)
    assert f"in steps of {made.transfer.drift_step_s / DAY_S:g} days" in said
    spacing = made.transfer.departure_spacing_s / DAY_S
    assert f"at least {'a day' if spacing == 1.0 else f'{spacing:g} days'} apart" in said
    assert f"ΔV to {made.transfer.delta_v_resolution_m_s:g} m/s" in said


def test_the_pages_state_the_drift() -> None:
    """What the pages say about rates of nodes is what the fields have."""
    bodies, debris = apart_deg_a_year("rocket-bodies"), apart_deg_a_year("sso")
    said = stated("rocket-bodies")
    assert round(np.median(bodies)) == 3
    assert "by 3° a year in the median, and by 15° at most" in said
    assert 10.0 < bodies.max() <= 15.0
    assert np.median(debris) == pytest.approx(35.0, abs=1.0)
    assert "here by 35° a year" in stated("sso")
    rate = np.degrees(np.mean(node_rates(adr_opt.generate("rocket-bodies", 0)))) * DAY_S
    match = re.search(r"nodes regress by ([\d.]+)° a day", said)
    assert match is not None
    assert float(match[1]) == round(-rate, 1)
    # A circle that is 100 km lower or higher: 7/2 of the rate for each part of the radius.
    assert round(3.5 * 100.0 / (6378.137 + 840.0) * -rate * 100.0, -1) == 10
    turn = np.sqrt(3.986004418e14 / (EARTH_RADIUS_M + 840e3)) * np.sin(np.radians(71.0))
    assert f"costs {np.radians(turn):.0f} m/s" in said
