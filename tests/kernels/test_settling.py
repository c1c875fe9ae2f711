"""Sequences between drifting planes settled many at a time, against one by one."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from drift_cases import Pair, drawn, pair_of, pairs
from rows import oblate_rule

from adr_opt.common.constants import DAY_S
from adr_opt.kernels.legs import co_elliptic, departure_events, fixed_points, phasing, precession


def one_by_one(pair, law, half_turns, number, met):
    """ΔV, revolutions, departure and stand-off of the cheapest sequence of a row of an event."""
    best = math.inf, -1, 0.0, 0.0
    for k in range(law.max_phasing_revolutions + 1):
        departure, stand_off = number[0], met
        for _ in range(2):  # it ends where a step is short; the next one is by far shorter
            way = precession.fixed_point(
                pair, law, half_turns, k, departure, stand_off, number[2], number[3]
            )
            departure, stand_off = way.departure, way.stand_off
        if departure >= 0.0 and abs(stand_off - met) < math.pi / pair.rate_j:
            best = min(best, (way.delta_v, k, departure, stand_off))
    return best


def ellipses(number: int) -> Iterator[Pair]:
    """Pairs at one altitude, between which the eccentricities are what costs most."""
    rng = np.random.default_rng(12)
    for _ in range(number):
        yield pair_of(
            *(
                drawn(
                    rng, 71.0 + rng.normal(0.0, 0.2), rng.normal(0.0, 0.2), True, (700e3, 705e3)
                ).replace(eccentricity=0.02)
                for _ in range(2)
            )
        )


@pytest.mark.parametrize("drawn_pairs", [pairs(11, 20, 0.5), pairs(11, 20, 3.0), ellipses(12)])
def test_many_at_a_time_are_those_one_by_one(drawn_pairs):
    """Of each row of each event the same sequence is the cheapest, at the same times and ΔV.

    But where two cost the same, or where it is said to be unsure: one in five between near planes.
    """
    law = oblate_rule(k_max=5)
    unsure = none = compared = 0
    for pair in drawn_pairs:
        made = co_elliptic.prepare(pair.i, pair.j, 0.0, law, 0.0)
        half_turns, numbers = departure_events.events_of(made, 0.0, 2.0 * DAY_S, 0.0)
        half_turns, numbers = half_turns[::-3][::-1], np.ascontiguousarray(numbers[::-3][::-1])
        lap, first = 2.0 * math.pi / made.rate_j, made.shortest - fixed_points.BAND_S
        bases = np.array(
            [
                precession.meeting(made, law, h, number[3], number[0] + first + 0.5 * lap)
                - number[0]
                for h, number in zip(half_turns, numbers, strict=True)
            ]
        )
        rows = 8
        grid = fixed_points.grid_of(phasing.curves_of(made, law), rows)
        fixed_points.lay_out(made, grid, numbers, bases, rows)
        for e, number in enumerate(numbers):
            found = grid.found[:, grid.place[e] :: fixed_points.BLOCK]
            for row in range(rows):
                met = number[0] + bases[e] + row * lap
                cost, k, left, late = found[row]
                expected = one_by_one(made, law, half_turns[e], number, met)
                if cost == -math.inf:
                    unsure += 1
                elif expected[0] == math.inf:
                    assert cost == math.inf, (pair, number, row)
                    none += 1
                else:
                    assert cost == pytest.approx(expected[0], abs=1e-8), (pair, number, row)
                    if k == expected[1]:
                        assert number[0] + left == pytest.approx(expected[2], abs=1e-7)
                        assert met + late == pytest.approx(expected[3], abs=1e-7)
                        compared += 1
    assert compared > 1000
    assert none > 10
    assert unsure < 0.2 * compared
