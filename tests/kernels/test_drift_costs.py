"""Drift legs in closed form: against the judge's searches, and what is listed of a grid."""

from __future__ import annotations

import math

import numpy as np
import pytest
from random_rules import weeks_mission
from rows import HIGHEST_M, LOWEST_M, FloatArray, drawn_body, oblate_rule, row

from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.judge.check.drift import drift_cost
from adr_opt.kernels.legs import drift, drift_arcs, drift_free, drift_grid, drift_pair
from adr_opt.kernels.legs.departure_events import Times
from adr_opt.kernels.legs.short_transfers import Shorts
from adr_opt.kernels.orbits import columns, ephemeris

CASES = 1500
NO_ZONES = np.empty((0, 4))
RULE = oblate_rule(limits=(LOWEST_M, HIGHEST_M))
of_both = pytest.mark.parametrize(
    "rule", [RULE, RULE._replace(free=True)], ids=["sequence", "free"]
)
"""By the burns of the sequence, and by free burns."""

ACCURATE_M_S = 1e-3
"""Optima are found so exactly [m/s]."""

DEAREST_M_S = 3000.0
"""Dearer legs are not compared: searches may end in another valley of theirs."""


def drawn(rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Two bodies: of any inclination, equatorial, polar, retrograde, near each other or not."""
    inclination = float(rng.choice([rng.uniform(0.1, 3.0), 0.5 * math.pi, 1.24, 1.5, 1.71]))
    apart = float(rng.choice([0.0, 1e-9, rng.normal() * 0.002, rng.normal() * 0.01]))
    raan = rng.uniform(-10.0, 10.0)
    return (
        drawn_body(rng, inclination, raan),
        drawn_body(rng, inclination + apart, raan + rng.normal() * float(rng.choice([0.01, 0.3]))),
    )


def judged(
    first: FloatArray, second: FloatArray, departure: float, arrival: float, rule=RULE
) -> tuple[float, float]:
    """What the judge finds: ΔV, and how much of it eccentricity adds [m/s]."""
    left = np.append(first, first[columns.RAAN_RATE])
    return drift_cost(left, second, rule, departure, arrival)


@of_both
@pytest.mark.parametrize("cases", [CASES // 5, pytest.param(CASES, marks=pytest.mark.slow)])
def test_the_judge_finds_the_same_optimum(cases, rule):
    """Newton steps and nested golden sections agree, from hours to years."""
    rng = np.random.default_rng(0)
    compared = 0
    for _ in range(cases):
        first, second = drawn(rng)
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10 ** rng.uniform(-0.7, 2.8) * DAY_S
        pair = drift_pair.prepare(first, second, rule, 0.0)
        found = drift.delta_v(pair, departure, departure + span)
        expected, shape = judged(first, second, departure, departure + span, rule)
        if min(found, expected) > DEAREST_M_S:
            continue
        case = (first, second, departure, span)
        assert found == pytest.approx(expected, abs=1e-3), case
        added = drift.shape_share(pair, departure, departure + span)
        assert added == pytest.approx(shape, abs=1e-3), case
        compared += 1
    assert compared > 0.4 * cases


@pytest.mark.slow
@of_both
def test_the_judge_agrees_about_tips(rule):
    """Where a burn changes next to nothing its size has a tip, about which searches agree, too."""
    rng = np.random.default_rng(5)
    for _ in range(CASES):
        inclination, raan = 1.24, rng.uniform(0.0, 6.0)
        first, second = (
            row(
                EARTH_RADIUS_M + rng.uniform(780e3, 800e3),
                inclination + rng.normal(0.0, 0.003),
                raan + rng.normal(0.0, 0.03),
                rng.uniform(0.0, 7.0),
                oblateness=OBLATENESS_M2,
                eccentricity=float(rng.choice([0.0, rng.uniform(0.0, 0.001)])),
                perigee=rng.uniform(0.0, 6.0),
            )
            for _ in range(2)
        )
        arrival = 10 ** rng.uniform(0.0, 1.0) * DAY_S
        pair = drift_pair.prepare(first, second, rule, 0.0)
        found = float(drift.delta_v(pair, 0.0, arrival))
        left = np.append(first, ephemeris.coasting_node_rate_at(first, 0.0))
        wanted, _ = drift_cost(left, second, rule, 0.0, arrival)
        if wanted < DEAREST_M_S:
            assert found == pytest.approx(wanted, abs=ACCURATE_M_S), (first, second, arrival)


def test_steps_do_not_go_to_and_fro_about_a_tip():
    """A leg whose first burn changes hardly more than the node costs what searches find."""
    instance = weeks_mission(74)
    rule = instance.transfer_rule()
    ends = [instance.names.index(name) for name in ("station", "debris-001")]
    first, second = (np.array(instance.body_orbits[at].row(OBLATENESS_M2)) for at in ends)
    departure, arrival = 14.0 * DAY_S, 18.0 * DAY_S
    split = drift.best_split(drift_pair.prepare(first, second, rule, 0.0), departure, arrival)
    assert abs(split.climb) < 1.0
    left = np.append(first, ephemeris.coasting_node_rate_at(first, 0.0))
    wanted, _ = drift_cost(left, second, rule, departure, arrival)
    assert split.delta_v == pytest.approx(wanted, abs=ACCURATE_M_S)


def test_the_optimum_at_a_tip_is_found_from_afar():
    """Half a year between neighbours, where all of the change is best made at one end."""
    departure, span = 49.742 * DAY_S, 198.409 * DAY_S
    first = row(7512531.512, 1.24, -2.505357150, 4.820490584, oblateness=OBLATENESS_M2)
    second = row(7524616.243, 1.24, -2.517625281, 5.747949683, oblateness=OBLATENESS_M2)
    found = drift.delta_v(drift_pair.prepare(first, second, RULE, 0.0), departure, departure + span)
    expected, _ = judged(first, second, departure, departure + span)
    assert found == pytest.approx(expected, abs=ACCURATE_M_S)
    assert found < 6.0


def test_the_target_is_met_after_whole_laps():
    """The drift orbit that a split leads to makes a whole number of laps, to a metre."""
    rng = np.random.default_rng(1)
    for _ in range(CASES):
        first, second = drawn(rng)
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10 ** rng.uniform(-0.3, 2.8) * DAY_S
        pair = drift_pair.prepare(first, second, RULE, 0.0)
        split = drift.best_split(pair, departure, departure + span)
        if not math.isfinite(split.delta_v):
            continue
        radius = drift_pair.radius_of(pair, split.climb)
        assert LOWEST_M - 1e-3 <= radius <= HIGHEST_M + 1e-3
        arcs = drift_arcs.coast(pair, span, radius)
        laps = (arcs.phase - drift_pair.task(pair, departure, departure + span).ahead) / math.tau
        missed_m = (laps - round(laps)) * math.tau / arcs.phase_slope
        assert abs(missed_m) < 1.0, (first, second, departure, span)


@of_both
def test_free_phase_costs_no_more_than_whole_laps(rule):
    """The optimum of free phase is a floor, but for the slack that tables of legs allow it."""
    rng = np.random.default_rng(2)
    for _ in range(CASES):
        first, second = drawn(rng)
        departure, span = rng.uniform(0.0, 700.0) * DAY_S, 10 ** rng.uniform(-0.7, 2.8) * DAY_S
        pair = drift_pair.prepare(first, second, rule, 0.0)
        leg = drift_pair.task(pair, departure, departure + span)
        rest = drift_free.rest_of(pair, leg)
        free = drift_free.free_phase(pair, leg, rest, *drift_free.first_guess(pair, leg))
        free = drift_free.matched(pair, leg, rest, free)
        found = drift.split(pair, leg, free).delta_v
        if found < DEAREST_M_S:
            assert free.least - drift_grid.SLACK_M_S <= found, (first, second, departure, span)


@of_both
def test_nothing_costs_less_than_radius_and_inclination(rule):
    """However long it drifts, radius and inclination have to be changed, and the shape matched."""
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        first, second = drawn(rng)
        span, arrival = 10 ** rng.uniform(-1.0, 3.0) * DAY_S, rng.uniform(0.0, 1e8)
        pair = drift_pair.prepare(first, second, rule, 0.0)
        leg = drift_pair.task(pair, arrival - span, arrival)
        # Burns that change the size change the shape as well.
        together = max if rule.free else math.hypot
        least = math.hypot(together(abs(pair.climb), 2.0 * leg.shape), pair.linear.tilt)
        assert drift.delta_v(pair, arrival - span, arrival) >= least - 1e-9


def grid_of(pair: drift_pair.DriftPair, step: float, longest: float, duration: float) -> FloatArray:
    """All transfers of a grid, one after another: departure, arrival, ΔV."""
    times = math.floor(duration / step) + 1
    return np.array(
        [
            (a * step, b * step, drift.delta_v(pair, a * step, b * step))
            for a in range(times)
            for b in range(a + 1, min(a + math.floor(longest / step), times - 1) + 1)
        ]
    )


def dominators(listed: FloatArray, row: FloatArray, by: float) -> np.ndarray:
    """Those of a list that depart no earlier, arrive no later and cost no more than an excess."""
    departure, arrival, cost = listed.T
    found: np.ndarray = (departure >= row[0]) & (arrival <= row[1]) & (cost <= row[2] + by)
    return found


@pytest.mark.slow
@of_both
def test_what_is_listed_is_what_nothing_else_dominates(rule):
    """Of a grid and of short transfers those are kept that save more than the resolution.

    No kept one dominates another; each that is left out, and is not too dear, is dominated by one
    that is kept, a short one through a long one at most.
    """
    rng = np.random.default_rng(6)
    kept_short = left_short = kept_long = 0
    for _ in range(150):
        first, second = drawn(rng)
        second[columns.RAAN] = first[columns.RAAN] + rng.normal() * 0.1
        pair = drift_pair.prepare(first, second, rule, 0.0)
        step, duration = rng.uniform(0.5, 4.0) * DAY_S, rng.uniform(20.0, 90.0) * DAY_S
        longest, resolution = rng.uniform(0.2, 1.2) * duration, float(rng.choice([0.0, 0.1, 5.0]))
        every = grid_of(pair, step, longest, duration)
        finite = every[np.isfinite(every[:, 2]), 2]
        most = min(DEAREST_M_S, float(np.quantile(finite, rng.uniform(0.3, 1.0))))
        shorts = short_ones(rng, duration, 0.5 * most, most)
        kept = np.empty(len(shorts), np.bool_)
        begins, ends, costs = drift_grid.of_pair(
            first[None],
            second,
            rule,
            Times(0.0, step, longest, most),
            duration,
            resolution,
            Shorts(*shorts.T.copy(), np.zeros(len(shorts), np.int8)),
            kept,
        )
        assert np.all(np.diff(begins * 100000 + ends) > 0)
        long = np.column_stack([begins * step, ends * step, costs])
        listed = np.concatenate([long, shorts[kept]])
        for row_ in listed:
            # Itself, and whatever is as good.
            better = dominators(listed, row_, resolution) & np.any(listed != row_, axis=1)
            assert not better.any(), (first, second, row_, listed[better])
        for row_ in np.concatenate([every, shorts[~kept]]):
            if row_[2] < most - 1e-9:
                assert dominators(listed, row_, 2.0 * resolution + ACCURATE_M_S).any(), (
                    first,
                    row_,
                )
        kept_short += int(kept.sum())
        left_short += int((~kept).sum())
        kept_long += len(long)
    assert min(kept_short, kept_long) > 1000
    assert left_short > 30


def short_ones(rng, duration: float, least: float, most: float) -> FloatArray:
    """Transfers none of which dominates another, in order of departure; some are long too."""
    departures = np.sort(rng.uniform(0.0, 0.9 * duration, 12))
    found: list[FloatArray] = []
    for departure in departures[::-1]:
        arrival = departure + float(rng.choice([0.3, 9.0])) * DAY_S
        made = np.array([departure, arrival, rng.uniform(least, most)])
        if not found or not dominators(np.array(found), made, 5.0).any():
            found.append(made)
    return np.array(found[::-1])


def test_zones_that_are_closed_anywhere_near_forbid_a_drift():
    """What is listed beside a zone is what no zone touches that is closed meanwhile."""
    rng = np.random.default_rng(7)
    forbidden = allowed = 0
    duration = 40.0 * DAY_S
    times, none = Times(0.0, DAY_S, duration, 1e9), Shorts(*np.empty((3, 0)), np.empty(0, np.int8))
    for _ in range(60):
        first, second = drawn(rng)
        pair = drift_pair.prepare(first, second, RULE, 0.0)
        low = EARTH_RADIUS_M + rng.uniform(300e3, 1900e3)
        opens = rng.uniform(0.0, 40.0) * DAY_S
        zones = np.array([[low, low + 20e3, opens, opens + rng.uniform(0.0, 10.0) * DAY_S]])
        begins, ends, _ = drift_grid.of_pair(
            first[None],
            second,
            RULE._replace(zones=zones),
            times,
            duration,
            0.0,
            none,
            np.empty(0, np.bool_),
        )
        for begin, end in zip(begins * DAY_S, ends * DAY_S, strict=True):
            touches = zones[0, 2] <= end and begin <= zones[0, 3]
            climb = drift.best_split(pair, begin, end).climb
            radius = drift_pair.radius_of(pair, climb)
            radii = (pair.linear.radius_i, pair.linear.radius_j, radius)
            crosses = min(radii) <= zones[0, 1] and max(radii) >= zones[0, 0]
            assert not (touches and crosses), (first, second, zones, begin, end)
            allowed += 1
        free, _, _ = drift_grid.of_pair(
            first[None], second, RULE, times, duration, 0.0, none, np.empty(0, np.bool_)
        )
        forbidden += free.size > begins.size
    assert allowed > 1000
    assert forbidden > 10
