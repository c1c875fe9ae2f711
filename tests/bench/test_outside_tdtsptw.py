"""The time-dependent travelling salesperson with windows: reading, scoring, known ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from from_outside import DATA, external
from outside.tdtsptw import reading
from outside.tdtsptw.ours import breakpoints, drawn, instance_of, plan
from outside.tdtsptw.scoring import arrival, score

FOLDER = DATA / "tdtsptw"

pytestmark = external("tdtsptw")


def test_all_instances_are_read():
    """There are 130, of 15 to 40 customers, a hundred with a known least end."""
    files, best = reading.instance_files(FOLDER), reading.read_best(FOLDER / reading.BEST)
    sizes = [len(reading.read_roads(path).customers) for path in files]
    assert {size: sizes.count(size) for size in sizes} == {15: 25, 20: 25, 30: 25, 40: 55}
    assert {path.stem for path in files} == set(best)
    assert sum(math.isnan(end) for end in best.values()) == 30


def test_as_many_known_as_open_ones_are_drawn():
    """Drawn instances are among the largest, half of them open, and the same every time."""
    files, best = reading.instance_files(FOLDER), reading.read_best(FOLDER / reading.BEST)
    found = drawn(files, best, 5)
    assert found == drawn(files, best, 5)
    assert len({path.stem for path in found}) == 10
    assert {path.stem.split("_")[0] for path in found} == {"40"}
    assert sum(math.isnan(best[path.stem]) for path in found) == 5


def test_functions_are_what_is_driven():
    """Between breakpoints, too, functions arrive when the way has been driven zone by zone."""
    roads = reading.read_roads(FOLDER / "15_70_B_100_C6.json")
    rng = np.random.default_rng(0)
    for _ in range(50):
        i, j = rng.choice(np.argwhere(roads.cluster >= 0))
        speeds = roads.speeds[roads.cluster[i, j]]
        points = breakpoints(roads.edges, speeds, float(roads.distance[i, j]))
        for leaves in rng.random(20) * points[-1, 0]:
            lands = np.interp(leaves, points[:, 0], points[:, 1])
            assert lands == pytest.approx(arrival(roads, i, j, float(leaves)), abs=1e-9)


@pytest.mark.parametrize("name", ["15_70_A_25_B6", "15_70_B_100_C6", "20_98_B_50_B10"])
def test_known_ends_are_reached_and_proven(name):
    """The least end is the published one, proven, and the same by the scorer."""
    roads = reading.read_roads(FOLDER / f"{name}.json")
    ours = plan(roads, 1000.0, jobs=1)
    judged = score(roads, ours.tour)
    assert judged.violations == ()
    assert judged.end == pytest.approx(ours.end, abs=1e-6)
    assert ours.end == pytest.approx(reading.read_best(FOLDER / reading.BEST)[name], abs=0.0051)
    assert ours.end <= ours.bound * (1.0 + 1e-6)


def test_missing_ways_are_closed():
    """Ways that the graph does not have are no functions, and no tour uses them."""
    roads = reading.read_roads(FOLDER / "15_70_A_25_B6.json")
    instance = instance_of(roads)
    assert instance.given.functions.of_pair("begin", "end") is None
    assert len(instance.given.functions.pairs) == 240
    assert "no customer" not in str(score(roads, roads.customers))
    assert score(roads, roads.customers[1:]).violations
