"""When services may begin, and its inverse, against a plain statement."""

from __future__ import annotations

import math

import numpy as np
import pytest
from seeds import over_seeds

from adr_opt.kernels.core.windows import (
    Windows,
    latest_arrival,
    service_begin,
    service_end,
    service_ends,
    windows_of,
)


def drawn(rng: np.random.Generator, bodies: int = 4) -> tuple[list[np.ndarray], Windows]:
    """Intervals of bodies, some without any, and the windows that are made of them."""
    lists = []
    for _ in range(bodies):
        intervals = np.sort(rng.uniform(0.0, 100.0, 2 * int(rng.integers(1, 7)))).reshape(-1, 2)
        shorter = intervals - np.array([0.0, rng.choice([0.0, 5.0, 30.0])])
        lists.append(shorter)
    body = np.repeat(np.arange(bodies), [len(each) for each in lists])
    opens, latest = np.concatenate(lists).T
    return lists, windows_of(body, opens.copy(), latest.copy())


def plain(intervals: np.ndarray, arrival: float) -> float:
    """The least begin from an arrival on that lies in an interval."""
    begins = [max(arrival, a) for a, b in intervals.tolist() if max(arrival, a) <= b]
    return min(begins, default=math.inf)


@over_seeds(range(200), gate=20)
def test_services_begin_at_the_first_time_that_an_interval_holds(seed: int) -> None:
    """From every arrival, one by one and in arrays, and nowhere in what has no interval."""
    rng = np.random.default_rng(seed)
    lists, windows = drawn(rng)
    arrivals = rng.uniform(-10.0, 110.0, 50)
    for body, intervals in enumerate(lists):
        wanted = [plain(intervals, arrival) for arrival in arrivals.tolist()]
        assert [service_begin(windows, body, arrival) for arrival in arrivals] == wanted
        assert service_ends(windows, body, arrivals).tolist() == wanted
    other = rng.permutation(len(lists))
    part, last = windows.of(other), 60.0
    for place, body in enumerate(other.tolist()):
        ends = service_ends(part.until(last), place, arrivals)
        within = [plain(lists[body], arrival) for arrival in arrivals.tolist()]
        assert ends.tolist() == [begin if begin <= last else math.inf for begin in within]


@over_seeds(range(400), gate=40)
def test_who_arrives_later_is_not_done_sooner(seed: int) -> None:
    """The end of a stay never falls as arrival rises, in 20,000 draws."""
    rng = np.random.default_rng(seed)
    _, windows = drawn(rng, bodies=5)
    for body in range(5):
        first = np.sort(rng.uniform(0.0, 100.0, 10))
        later = first + rng.choice([1e-9, 1e-3, 1.0, 20.0], 10)
        service = float(rng.uniform(0.0, 10.0))
        for early, late in zip(first.tolist(), later.tolist(), strict=True):
            ends = [service_end(windows, body, time, service) for time in (early, late)]
            assert ends[0] <= ends[1]


@over_seeds(range(200), gate=20)
def test_the_latest_arrival_is_in_time_and_no_later_one_is(seed: int) -> None:
    """It begins by the time asked, and whoever arrives a little later does not."""
    rng = np.random.default_rng(seed)
    lists, windows = drawn(rng)
    for body, intervals in enumerate(lists):
        for begin in rng.uniform(0.0, 110.0, 20).tolist():
            arrival = latest_arrival(windows, body, begin)
            if arrival == -math.inf:
                assert plain(intervals, 0.0) > begin
                continue
            assert plain(intervals, arrival) <= begin
            assert plain(intervals, arrival + 1e-6) > begin


def test_windows_of_one_body_are_replaced_alone() -> None:
    """Another interval, or a later end, of one body changes no other one's."""
    windows = drawn(np.random.default_rng(3))[1]
    made, longer = windows.only(1, 5.0, 7.0), windows.later(1, 200.0)
    assert service_begin(made, 1, 6.0) == 6.0
    assert service_begin(made, 1, 8.0) == math.inf
    assert service_begin(longer, 1, 150.0) == 150.0
    for body in (0, 2, 3):
        for time in np.linspace(0.0, 100.0, 9).tolist():
            began = service_begin(windows, body, time)
            assert service_begin(made, body, time) == began
            assert service_begin(longer, body, time) == began
    assert made.opening[1] == pytest.approx(5.0)
    assert made.closing[1] == pytest.approx(7.0)
