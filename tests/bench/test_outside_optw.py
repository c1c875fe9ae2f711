"""Orienteering with time windows as others state it: their optima, their rules, their files."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from from_outside import DATA, external
from outside.optw import reading
from outside.optw.ours import plan
from outside.optw.scoring import score, travel_ms

FOLDER = DATA / "optw"
FIRST, STATIC = FOLDER / "20.1.1.TXT", FOLDER / "titt20.TXT"

pytestmark = external("optw")


@pytest.fixture(scope="module")
def published():
    return reading.read_optima(FOLDER / "optima.csv")


def test_all_instances_are_read(published):
    """There are 24, twelve of 20 places and twelve of 50, 21 with a proven optimum."""
    files = reading.instance_files(FOLDER)
    found = [reading.read_places(path) for path in files]
    assert sorted(places.count for places in found) == [20] * 12 + [50] * 12
    assert {places.name for places in found} == set(published)
    assert sum(known.is_proven for known in published.values()) == 21
    for places in found:
        assert places.score[0] == places.score[-1] == 0.0
        assert places.longest_ms == places.closes_ms[0] - places.opens_ms[0]


@pytest.mark.parametrize("size", [20, 50])
def test_travel_times_have_the_announced_shape(size):
    """Both matrices of a size have nought on the diagonal, and later never arrives earlier."""
    static = reading.read_static(FOLDER / f"titt{size}.TXT", size)
    varying = reading.read_varying(FOLDER / f"tt{size}.TXT", size)
    assert static.shape == (size, size, 1)
    assert varying.shape == (size, size, reading.SLOTS)
    for travel in (static, varying):
        assert (travel[range(size), range(size)] == 0.0).all()
        assert (np.diff(travel, axis=2) >= -reading.SLOT_MS).all()


@pytest.mark.parametrize("varying", [False, True])
def test_no_short_tour_beats_the_optimum(varying):
    """Over the first places of an instance, trying every tour finds what is proven."""
    places = reading.read_places(FIRST)
    travel = reading.travel_of(FIRST, places, varying=varying)
    some = [0, 1, 2, 3, 4, 5, 6, 19]
    columns = places.score, places.service_ms, places.opens_ms, places.closes_ms
    fewer = reading.Places("some", places.longest_ms, *(column[some] for column in columns))
    between = travel[np.ix_(some, some)]
    best = 0.0
    for count in range(7):
        for tour in itertools.permutations(range(1, 7), count):
            judged = score(fewer, between, tour)
            if not judged.violations:
                best = max(best, judged.score)
    ours = plan(fewer, between, 60.0)
    assert ours.score == ours.bound == best


def test_ways_are_linear_between_slots():
    """A way takes what is given at a slot, the mean half-way, and after the last slot the last."""
    varying = reading.read_varying(FOLDER / "tt20.TXT", 20)
    given = varying[3, 7]
    begin, slot = reading.FIRST_MS, reading.SLOT_MS
    assert travel_ms(varying, 3, 7, begin + 5 * slot) == given[5]
    assert travel_ms(varying, 3, 7, begin + 5.5 * slot) == pytest.approx((given[5] + given[6]) / 2)
    assert travel_ms(varying, 3, 7, begin + 55.5 * slot) == given[55]


@pytest.mark.parametrize(
    ("tour", "said"),
    [
        ([1, 1], "visited twice"),
        ([0], "not between"),
        ([19], "not between"),
        ([*range(1, 12)], "closed"),
    ],
)
def test_broken_rules_are_named(tour, said):
    """A tour that breaks a rule is told by a sentence about that rule."""
    places = reading.read_places(FIRST)
    judged = score(places, reading.travel_of(FIRST, places, varying=False), tour)
    assert any(said in sentence for sentence in judged.violations)


def test_too_long_a_tour_is_named():
    """A tour that ends in the window of the last place but takes too long is told."""
    places = reading.read_places(FIRST)
    travel = reading.travel_of(FIRST, places, varying=False)
    short = reading.Places("short", 1e6, *(vars(places)[name] for name in list(vars(places))[2:]))
    assert score(places, travel, []).violations == ()
    assert "longer than" in score(short, travel, []).violations[0]


@pytest.mark.parametrize("varying", [False, True])
@pytest.mark.parametrize(
    "name",
    ["20.1.1", *(pytest.param(name, marks=pytest.mark.slow) for name in ("20.2.1", "20.4.2"))],
)
def test_ours_are_proven_optima(published, name, varying):
    """Our tours of 20 places are proven, by the scorer too, and static ones what CPLEX proved."""
    path = FOLDER / f"{name}.TXT"
    places = reading.read_places(path)
    travel = reading.travel_of(path, places, varying=varying)
    ours = plan(places, travel, 60.0)
    assert score(places, travel, ours.tour).violations == ()
    assert ours.score == ours.bound
    assert varying or (published[name].is_proven and published[name].score == ours.score)


def test_out_of_time_leaves_a_bound_or_none():
    """Without time nothing is claimed: the bound is at least the optimum."""
    places = reading.read_places(FIRST)
    travel = reading.travel_of(FIRST, places, varying=False)
    ours = plan(places, travel, 0.01)
    best = reading.read_optima(FOLDER / "optima.csv")[places.name].score
    assert ours.score <= best <= ours.bound
