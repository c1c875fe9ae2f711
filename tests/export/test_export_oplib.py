"""Orienteering files: as OPLib's own are, and read by programs that read those."""

from __future__ import annotations

import math
import os
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.export.tables import write_matrix
from adr_opt.export.tables.weights import scores
from adr_opt.mission.mission import Mission

EXTERNAL = Path(
    os.environ.get("ADR_OPT_EXTERNAL_DATA", Path(__file__).parents[3] / "shared" / "data")
)
QUANTITIES = pytest.mark.parametrize("quantity", ["delta_v", "duration"])


@pytest.fixture(scope="module")
def mission() -> Mission:
    """Make a tiny mission with unequal prizes and some pairs without a transfer."""
    instance = adr_opt.generate("tiny", 0)
    targets = tuple(
        target.replace(prize=float(number % 4)) for number, target in enumerate(instance.targets)
    )
    narrow = instance.transfer.replace(
        min_altitude_m=690e3, max_altitude_m=810e3, max_phasing_revolutions=2
    )
    return Mission(instance.replace(targets=targets, transfer=narrow))


def exact(mission: Mission, quantity: str) -> np.ndarray:
    """What the weights stand for, at departure 0."""
    values = getattr(mission.timetable.matrices([0.0]), quantity)[0].copy()
    if quantity == "duration":
        values[:, 1:] += mission.rules.service[1:]
        np.fill_diagonal(values, 0.0)
    return values


@QUANTITIES
def test_oplib_is_read_by_vrplib(mission: Mission, tmp_path: Path, quantity: str) -> None:
    """Weights, limit, scores and depot come back: service is in the durations, not at the end."""
    vrplib = pytest.importorskip("vrplib")
    path = tmp_path / "costs.oplib"
    write_matrix(mission, path, 0.0, quantity=quantity, scale=10.0)
    read = vrplib.read_instance(path)
    instance = mission.instance
    duration_s = instance.mission.duration_s
    limit = instance.chaser.tank.delta_v_m_s if quantity == "delta_v" else duration_s
    truth = exact(mission, quantity)
    finite = np.isfinite(truth)
    assert not finite.all()
    assert np.abs(read["edge_weight"] / 10.0 - truth)[finite].max() <= 0.05 * (1.0 + 1e-9)
    assert (read["edge_weight"][~finite] > read["cost_limit"]).all()
    assert read["type"] == "OP"
    assert read["dimension"] == len(mission.names)
    assert read["cost_limit"] == math.floor(10.0 * limit)
    assert read["depot"].tolist() == [0]
    assert read["node_score"].tolist() == mission.rules.prize.tolist()
    assert "1 = a prize of one" in read["comment"]


def test_the_best_cycle_of_the_file_is_the_best_fuel_load(tmp_path: Path) -> None:
    """By OPLib's rules the best cycle collects what one fuel load can at these costs."""
    vrplib = pytest.importorskip("vrplib")
    instance = adr_opt.generate("tiny", 3, targets=5)
    mission = Mission(instance.with_limits(delta_v_m_s=600.0))
    write_matrix(mission, tmp_path / "costs.oplib", 0.0)
    read = vrplib.read_instance(tmp_path / "costs.oplib")

    def best(costs: np.ndarray, limit: float) -> int:
        most = 0
        for visits in range(1, len(costs)):
            for order in permutations(range(1, len(costs)), visits):
                cycle = (0, *order)
                if sum(costs[a, b] for a, b in zip(cycle, (*order, 0), strict=True)) <= limit:
                    most = visits
        return most

    static = best(exact(mission, "delta_v"), 600.0)
    assert 0 < static < 5
    assert best(read["edge_weight"], read["cost_limit"]) == static


def test_scores_are_whole() -> None:
    """Whole prizes stay; others get three digits, fewer where 31 bits do not hold them."""
    assert scores([1.0, 0.0, 7.0]) == ([1, 0, 7], 1.0)
    assert scores([0.25, 1.0]) == ([250, 1000], 1000.0)
    assert scores([0.5, 1e9]) == ([0, 10**9], 1.0)
    with pytest.raises(adr_opt.InputError, match=r"prizes up to 10000000000\.0 do not fit"):
        scores([1e10])


def test_no_target_and_no_budget_can_be_written(tmp_path: Path) -> None:
    """An orienteering problem of the depot alone is still one."""
    vrplib = pytest.importorskip("vrplib")
    instance = adr_opt.generate("tiny", 0, targets=0)
    write_matrix(instance, tmp_path / "costs.oplib", 0.0)
    read = vrplib.read_instance(tmp_path / "costs.oplib")
    assert (read["dimension"], read["node_score"].tolist()) == (1, [0])


@pytest.mark.external
@pytest.mark.parametrize("name", ["att48-gen1-50", "eil51-gen2-50", "berlin52-gen1-50"])
def test_real_files_have_the_same_parts(mission: Mission, tmp_path: Path, name: str) -> None:
    """Ours has every keyword of OPLib's, in its order, and OPLib's solutions keep its limit.

    The limit is one on the cycle with the way back to the depot; the depot's score counts.
    """
    folder = EXTERNAL / "oplib"
    if not folder.is_dir():
        pytest.skip(f"{folder} is absent; set ADR_OPT_EXTERNAL_DATA")
    vrplib = pytest.importorskip("vrplib")
    real = vrplib.read_instance(folder / f"{name}.oplib", compute_edge_weights=False)
    write_matrix(mission, tmp_path / "costs.oplib", 0.0)
    ours = vrplib.read_instance(tmp_path / "costs.oplib")
    assert set(real) - set(ours) == {"node_coord"}
    assert set(ours) - set(real) == {"edge_weight", "edge_weight_format"}
    assert [type(real[key]) for key in ("dimension", "cost_limit", "type")] == [int, int, str]
    for key in ("node_score", "depot"):
        assert ours[key].dtype == real[key].dtype
        assert ours[key].ndim == real[key].ndim

    words = (folder / f"{name}.sol").read_text().split()
    stated = {
        key: int(words[words.index(key) + 2])
        for key in ("COST_LIMIT", "ROUTE_SCORE", "ROUTE_COST", "ROUTE_NODES")
    }
    begin = words.index("NODE_SEQUENCE_SECTION") + 1
    cycle = np.array(words[begin : words.index("-1")], dtype=int) - 1
    steps = real["node_coord"][cycle] - real["node_coord"][np.roll(cycle, -1)]
    if real["edge_weight_type"] == "ATT":  # TSPLIB 95: a tenth, then up to the next integer
        costs = np.ceil(np.sqrt((steps**2).sum(axis=1) / 10.0))
    else:
        costs = np.floor(np.hypot(*steps.T) + 0.5)
    assert stated["COST_LIMIT"] == real["cost_limit"]
    assert stated["ROUTE_NODES"] == cycle.size
    assert stated["ROUTE_COST"] == costs.sum() <= real["cost_limit"]
    assert stated["ROUTE_SCORE"] == real["node_score"][cycle].sum()
