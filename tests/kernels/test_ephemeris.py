"""Elements of bodies at a time: accessors of kernels, those of arrays, and rows that are made."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rows import oblate_rule

from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.kernels.legs import co_elliptic, drift_pair
from adr_opt.kernels.orbits import columns, elements, ephemeris
from adr_opt.kernels.orbits.body_rows import as_left, with_orbit
from adr_opt.kernels.orbits.ephemeris import body_row

BOTH = {
    elements.radii: ephemeris.radius_at,
    elements.inclinations: ephemeris.inclination_at,
    elements.nodes: ephemeris.node_at,
    elements.node_rates: ephemeris.node_rate_at,
    elements.latitudes: ephemeris.latitude_at,
    elements.latitude_rates: ephemeris.latitude_rate_at,
    elements.eccentricities: ephemeris.eccentricity_at,
    elements.perigees: ephemeris.perigee_at,
}
"""What each array of elements has of every body."""


def drawn(rng: np.random.Generator, bodies: int) -> np.ndarray:
    """Bodies on orbits of low eccentricity under J2."""
    return np.array(
        [
            body_row(
                rng.uniform(6.8e6, 7.8e6),
                rng.uniform(0.1, 3.0),
                *rng.uniform(0.0, 6.2, 2),
                eccentricity=rng.uniform(0.0, 0.02),
                perigee=rng.uniform(0.0, 6.2),
                oblateness_m2=OBLATENESS_M2,
            )
            for _ in range(bodies)
        ]
    )


@pytest.mark.parametrize("array", BOTH, ids=lambda array: array.__name__)
def test_arrays_of_elements_hold_what_kernels_take(array) -> None:
    """Of all bodies at a time, and of one at many times, to the last digit."""
    rng = np.random.default_rng(1)
    bodies, times = drawn(rng, 20), rng.uniform(-1.0, 400.0, 20) * DAY_S
    for time in times:
        assert array(bodies, time).tolist() == [BOTH[array](body, time) for body in bodies]
    for body in bodies:
        of_one = np.broadcast_to(array(body, times), times.shape)
        assert of_one.tolist() == [BOTH[array](body, time) for time in times]


def test_rates_are_the_slopes_of_the_elements() -> None:
    """Each rate is how fast its element moves, and a tangent touches the motion at its time."""
    rng = np.random.default_rng(2)
    for body in drawn(rng, 20):
        time = float(rng.uniform(0.0, 400.0)) * DAY_S
        for at, rate_at, tangent in (
            (ephemeris.node_at, ephemeris.node_rate_at, ephemeris.node_tangent),
            (ephemeris.latitude_at, ephemeris.latitude_rate_at, ephemeris.latitude_tangent),
            (ephemeris.perigee_at, ephemeris.perigee_rate_at, ephemeris.perigee_tangent),
        ):
            slope = (at(body, time + 500.0) - at(body, time - 500.0)) / 1000.0
            assert rate_at(body, time) == pytest.approx(slope, rel=1e-6)
            start, rate = tangent(body, time)
            assert start + rate * time == pytest.approx(at(body, time), rel=1e-12)
            assert rate == rate_at(body, time)


@pytest.mark.parametrize(
    "prepare",
    [
        lambda i, j, time: co_elliptic.prepare(i, j, 0.0, oblate_rule(), time),
        lambda i, j, time: drift_pair.prepare(i, j, oblate_rule(), time),
    ],
)
def test_pairs_of_even_motion_do_not_depend_on_the_time_of_their_elements(prepare) -> None:
    """Where rates are constant, what a pair holds is the same about whichever time it is made."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        i, j = drawn(rng, 2)
        at_epoch, later = (flat(prepare(i, j, time)) for time in (0.0, 100.0 * DAY_S))
        moved = {"alpha_i", "alpha_j", "theta", "phase_i", "phase_j", "turn"}
        assert at_epoch.keys() == later.keys()
        for name in at_epoch.keys() - moved:
            assert later[name] == pytest.approx(at_epoch[name], rel=1e-9, abs=1e-9), name


def flat(pair) -> dict[str, float]:
    """The numbers of a pair by name, with those of a pair within it."""
    found = pair._asdict()
    return found | flat(found.pop("linear")) if "linear" in found else found


def test_rows_on_another_orbit_keep_everything_else() -> None:
    """A row that is changed has what is stated, and all else of the body, which stays as it was."""
    row = as_left(drawn(np.random.default_rng(4), 1))[0]
    before = row.copy()
    lower = with_orbit(row, radius_m=6.9e6, node=1.0, eccentricity=0.0, coasting_node_rate=2e-7)
    assert np.array_equal(row, before)
    assert ephemeris.radius_at(lower, 0.0) == 6.9e6
    assert ephemeris.node_at(lower, 0.0) == 1.0
    assert ephemeris.eccentricity_at(lower, 0.0) == 0.0
    assert ephemeris.coasting_node_rate_at(lower, 0.0) == 2e-7
    assert ephemeris.coasting_node_rate_at(row, 0.0) == ephemeris.node_rate_at(row, 0.0)
    assert np.flatnonzero(lower != before).tolist() == [
        columns.RADIUS,
        columns.RAAN,
        columns.ECCENTRICITY,
        columns.COASTING_RAAN_RATE,
    ]


def test_states_lie_on_the_circle_of_the_elements() -> None:
    """A body is at its radius and latitude in its plane, and planes drift under J2 alone."""
    body = drawn(np.random.default_rng(5), 1)[0]
    time = 30.0 * DAY_S
    position, velocity = ephemeris.state_at(body, time)
    assert math.hypot(*position) == pytest.approx(ephemeris.radius_at(body, time))
    ascending, ahead, normal = ephemeris.frame(
        ephemeris.inclination_at(body, time), ephemeris.node_at(body, time)
    )
    latitude = math.atan2(position @ ahead, position @ ascending)
    apart = latitude - ephemeris.latitude_at(body, time)
    assert math.remainder(apart, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert [position @ normal, velocity @ normal] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert [ephemeris.planes_drift(each) for each in (0.0, OBLATENESS_M2)] == [False, True]
