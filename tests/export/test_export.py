"""The matrix files, read back by the programs they are meant for."""

from __future__ import annotations

import json
import math
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.export.tables import write, write_matrix
from adr_opt.export.tables.weights import LARGEST, whole_weights
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance

DEPARTURES = [0.0, 3600.0, 50000.0]
SUFFIXES = [".npz", ".nc", ".tsp", ".vrp", ".oplib"]


@pytest.fixture(scope="module")
def mission() -> Mission:
    """Make a tiny mission in which some pairs have no transfer at some departures."""
    instance = adr_opt.generate("tiny", 0)
    narrow = instance.transfer.replace(
        min_altitude_m=690e3, max_altitude_m=810e3, max_phasing_revolutions=2
    )
    found = Mission(instance.replace(transfer=narrow))
    delta_v = found.timetable.matrices(DEPARTURES).delta_v
    for cube in delta_v:
        off_diagonal = cube[~np.eye(len(cube), dtype=bool)]
        assert np.isinf(off_diagonal).any()
        assert np.isfinite(off_diagonal).any()
    return found


def renamed(mission: Mission, name: str) -> Instance:
    return mission.instance.replace(name=name)


def test_npz_holds_the_matrices_exactly(mission: Mission, tmp_path: Path) -> None:
    """NumPy reads back every number, the names and the instance, without pickles."""
    path = tmp_path / "costs.npz"
    written = write_matrix(mission, path, DEPARTURES)
    expected = mission.timetable.matrices(DEPARTURES)
    with np.load(path, allow_pickle=False) as read:
        assert set(read.files) == {
            "departures_s",
            "names",
            "delta_v_m_s",
            "duration_s",
            "service_s",
            "instance",
            "sha256",
            "transfers",
        }
        np.testing.assert_array_equal(read["departures_s"], DEPARTURES)
        np.testing.assert_array_equal(read["delta_v_m_s"], expected.delta_v)
        np.testing.assert_array_equal(read["duration_s"], expected.duration)
        np.testing.assert_array_equal(read["service_s"], mission.rules.service)
        assert tuple(read["names"]) == mission.names
        assert str(read["instance"]) == mission.instance.name
        assert str(read["sha256"]) == mission.instance.sha256
    np.testing.assert_array_equal(written.delta_v, expected.delta_v)


def test_netcdf_has_rows_of_windows(mission: Mission, tmp_path: Path) -> None:
    """Each window is a row with its target, its times and how much of a service it holds."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5py")
    first, second, *others = mission.instance.targets
    first = first.replace(windows_s=[(0.0, 5e3), (9e3, None)], capture_s=100.0)
    second = second.replace(window_s=(7.0, 1e5))
    path = tmp_path / "costs.nc"
    made = mission.instance.replace(targets=(first, second, *others))
    write_matrix(Mission(made), path, DEPARTURES)
    with xarray.open_dataset(path, engine="h5netcdf") as read:
        assert read.window_target.values.tolist() == [first.name, first.name, second.name]
        assert read.window_opens.values.tolist() == [0.0, 9e3, 7.0]
        assert read.window_closes.values.tolist() == [5e3, np.inf, 1e5]
        np.testing.assert_array_equal(read.window_capture.values, [100.0, 100.0, np.nan])


def test_netcdf_holds_the_matrices_exactly(mission: Mission, tmp_path: Path) -> None:
    """Through xarray every number comes back, +inf included, with names and units."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5py")
    path = tmp_path / "costs.nc"
    write_matrix(mission, path, DEPARTURES)
    expected = mission.timetable.matrices(DEPARTURES)
    with xarray.open_dataset(path, engine="h5netcdf") as read:
        assert read.delta_v.dims == ("departure", "origin", "destination")
        np.testing.assert_array_equal(read.delta_v.values, expected.delta_v)
        np.testing.assert_array_equal(read.duration.values, expected.duration)
        np.testing.assert_array_equal(read.departure.values, DEPARTURES)
        assert read.delta_v.dtype == read.duration.dtype == read.departure.dtype == np.float64
        assert tuple(read.origin.values) == tuple(read.destination.values) == mission.names
        assert read.delta_v.attrs["units"] == "m s-1"
        assert read.duration.attrs["units"] == read.departure.attrs["units"] == "s"
        assert all(variable.attrs["long_name"] for variable in read.variables.values())
        i, j = np.argwhere(
            np.isfinite(expected.delta_v[1]) & ~np.eye(len(mission.names), dtype=bool)
        )[0]
        labelled = read.delta_v.sel(
            departure=3600.0, origin=mission.names[i], destination=mission.names[j]
        )
        assert float(labelled) == mission.timetable.lookup(int(i), int(j), 3600.0)[0]


def test_netcdf_states_constants_and_settings(mission: Mission, tmp_path: Path) -> None:
    """A reader of the file alone knows the constants, every setting, the epoch and the instance."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5py")
    instance = adr_opt.generate("tiny", 0, zones=2)
    path = tmp_path / "costs.nc"
    write_matrix(instance, path, [0.0])
    with xarray.open_dataset(path, engine="h5netcdf") as read:
        stated = read.attrs
    assert stated["mu_m3_s2"] == MU_M3_S2
    assert stated["earth_radius_m"] == EARTH_RADIUS_M
    assert stated["instance"] == instance.name
    assert stated["sha256"] == instance.sha256
    assert stated["epoch"] == "2026-01-01T00:00:00Z"
    told = instance.model_dump(mode="json")
    for part in ("transfer", "mission"):
        for key, value in told[part].items():
            assert stated[f"{part}_{key}"] == value
    assert json.loads(stated["keep_out_zones_json"]) == told["keep_out_zones"]


def test_netcdf_without_its_packages(
    mission: Mission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A missing package of the extra is named before anything is computed or written."""
    for package in ("xarray", "h5netcdf", "h5py"):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, package, None)
            with pytest.raises(adr_opt.MissingExtra, match=rf"{package}.*\[io\]"):
                write_matrix(mission, tmp_path / "costs.nc", [0.0])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("quantity", ["delta_v", "duration"])
def test_tsp_is_read_by_vrplib(mission: Mission, tmp_path: Path, quantity: str) -> None:
    """An independent reader of TSPLIB finds every weight within half a unit of the truth."""
    vrplib = pytest.importorskip("vrplib")
    path = tmp_path / "costs.tsp"
    write_matrix(mission, path, 3600.0, quantity=quantity)
    problem = vrplib.read_instance(path)
    exact = getattr(mission.timetable.matrices([3600.0]), quantity)[0]
    assert problem["type"] == "ATSP"
    assert problem["name"] == mission.instance.name
    assert problem["dimension"] == len(mission.names)
    read = problem["edge_weight"]
    weights = whole_weights(mission.timetable.matrices([3600.0]), quantity, None)
    np.testing.assert_array_equal(read, weights.values)
    finite = np.isfinite(exact)
    # rounding to the nearest integer, plus what the multiplication itself rounds
    worst = np.abs(read[finite] / weights.scale - exact[finite]).max()
    assert worst <= 0.5 / weights.scale * (1.0 + 1e-9)
    assert (read[~finite] == weights.no_transfer).all()
    assert f"{quantity} in " in problem["comment"]
    assert f" times {weights.scale:g}, " in problem["comment"]
    assert f"{weights.no_transfer} = no transfer" in problem["comment"]
    assert mission.instance.sha256 in problem["comment"]
    assert "ready at 3600.0 s" in problem["comment"]


def test_a_tour_prefers_any_transfer_to_none(mission: Mission) -> None:
    """The weight for "no transfer" exceeds every tour of real transfers, and fits 31 bits."""
    matrices = mission.timetable.matrices([0.0])
    for quantity in ("delta_v", "duration"):
        weights = whole_weights(matrices, quantity, None)
        real = weights.values[np.isfinite(matrices.delta_v[0])]
        assert weights.no_transfer > len(mission.names) * real.max()
        assert weights.no_transfer <= LARGEST
    assert whole_weights(matrices, "delta_v", None, limit=1e6).no_transfer > 1e6 * 1000.0


def test_scale_is_the_finest_that_fits(mission: Mission) -> None:
    """Large weights lower the scale by powers of ten; a scale that is asked for is kept."""
    matrices = mission.timetable.matrices([0.0])
    assert whole_weights(matrices, "delta_v", None).scale == 1000.0
    assert whole_weights(matrices, "delta_v", None, limit=1e7).scale == 100.0
    assert whole_weights(matrices, "delta_v", 7.5).scale == 7.5
    with pytest.raises(adr_opt.InputError, match="31 bits"):
        whole_weights(matrices, "delta_v", 1e9)


@pytest.mark.parametrize("quantity", ["delta_v", "duration"])
def test_vrp_is_read_by_vrplib(mission: Mission, tmp_path: Path, quantity: str) -> None:
    """The reference reader of VRPLIB finds the matrix, the depot and the prizes."""
    vrplib = pytest.importorskip("vrplib")
    path = tmp_path / "costs.vrp"
    write_matrix(mission, path, [0.0], quantity=quantity)
    read = vrplib.read_instance(path)
    instance = mission.instance
    duration_s = instance.mission.duration_s
    limit = instance.chaser.tank.delta_v_m_s if quantity == "delta_v" else duration_s
    weights = whole_weights(mission.timetable.matrices([0.0]), quantity, None, limit)
    np.testing.assert_array_equal(read["edge_weight"], weights.values)
    assert read["dimension"] == len(mission.names)
    assert read["depot"].tolist() == [0]
    assert read["prize"][0] == 0
    assert (read["prize"][1:] > 0).all()
    key = "vehicles_max_distance" if quantity == "delta_v" else "vehicles_max_duration"
    assert read[key] == math.floor(limit * weights.scale)
    if quantity == "duration":
        slack = np.array(read["service_time"]) / weights.scale - mission.rules.service
        assert read["service_time"][0] == 0
        assert (slack[1:] >= 0.0).all()
        assert (slack[1:] <= 1.0 / weights.scale).all()
    else:
        assert "service_time" not in read
    assert f"{weights.no_transfer} = no transfer" in read["comment"]


@pytest.mark.parametrize("quantity", ["delta_v", "duration"])
def test_vrp_is_solved_by_pyvrp(mission: Mission, tmp_path: Path, quantity: str) -> None:
    """PyVRP finds routes that keep to the limits and use real transfers only."""
    pyvrp = pytest.importorskip("pyvrp")
    path = tmp_path / "costs.vrp"
    matrices = write_matrix(mission, path, [0.0], quantity=quantity)
    data = pyvrp.read(path)
    result = pyvrp.solve(data, stop=pyvrp.stop.MaxIterations(300), seed=1, display=False)
    assert result.is_feasible()
    assert result.best.num_clients() >= 1
    assert len(result.best.routes()) <= (1 if quantity == "duration" else len(mission.names))
    for route in result.best.routes():
        visits = [visit.idx + 1 for visit in route.schedule() if visit.is_client()]
        assert len(visits) == route.num_clients()
        stops = [0, *visits, 0]
        costs = [matrices.delta_v[0][i, j] for i, j in pairwise(stops)]
        times = [matrices.duration[0][i, j] for i, j in pairwise(stops)]
        assert np.isfinite(costs).all()
        if quantity == "delta_v":
            assert sum(costs) <= mission.instance.chaser.tank.delta_v_m_s + 1e-3 * len(costs)
        else:
            service = mission.rules.service[visits].sum()
            assert sum(times) + service <= mission.instance.mission.duration_s + 1e-2 * len(times)


def test_pyvrp_collects_every_prize_that_the_limits_allow(tmp_path: Path) -> None:
    """A prize outweighs all distances, but a prize of zero is no duty."""
    pyvrp = pytest.importorskip("pyvrp")
    instance = adr_opt.generate("tiny", 2)
    instance = instance.replace(
        targets=tuple(
            target.replace(prize=prize)
            for target, prize in zip(
                instance.targets, [0.0, 0.01, 2.5] + [1.0] * len(instance.targets), strict=False
            )
        )
    ).with_limits(delta_v_m_s=50000.0)
    path = tmp_path / "costs.vrp"
    write_matrix(instance, path, [0.0])
    data = pyvrp.read(path)
    result = pyvrp.solve(data, stop=pyvrp.stop.MaxIterations(300), seed=1, display=False)
    assert result.is_feasible()
    assert result.best.num_clients() == len(instance.targets) - 1
    prizes = [client.prize for client in data.clients()]
    assert prizes[0] == 1
    assert prizes[2] == pytest.approx(250 * prizes[1], rel=1e-6)
    assert not any(client.required for client in data.clients())


def test_prizes_of_too_many_orders_are_refused(mission: Mission, tmp_path: Path) -> None:
    """Prizes that the integers of the format cannot hold are an error, not an overflow."""
    first, *others = mission.instance.targets
    instance = mission.instance.replace(targets=(first.replace(prize=1e-12), *others))
    with pytest.raises(adr_opt.InputError, match="prizes from 1e-12 to 1"):
        write_matrix(instance, tmp_path / "costs.vrp", [0.0])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "name", ["MY TYPE", "GEOFF", "a: b", "line\nEOF\nDIMENSION : 3", "Müll 5%", "é"]
)
def test_odd_names_do_not_break_the_text_formats(
    mission: Mission, tmp_path: Path, name: str
) -> None:
    """A name with blanks, keywords or line breaks leaves the files readable."""
    vrplib = pytest.importorskip("vrplib")
    instance = renamed(mission, name)
    for suffix in (".tsp", ".vrp", ".oplib"):
        write_matrix(instance, tmp_path / f"costs{suffix}", [0.0])
    for suffix in (".tsp", ".vrp", ".oplib"):
        read = vrplib.read_instance(tmp_path / f"costs{suffix}")
        assert read["edge_weight"].shape == (len(instance.names),) * 2
        assert instance.sha256 in read["comment"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_no_transfer_at_all_can_be_written(mission: Mission, tmp_path: Path, suffix: str) -> None:
    """After the last departure event every file says "no transfer" and nothing breaks."""
    path = tmp_path / f"costs{suffix}"
    written = write_matrix(mission, path, [mission.instance.mission.duration_s + 1.0])
    off_diagonal = ~np.eye(len(mission.names), dtype=bool)
    assert np.isinf(written.duration[0][off_diagonal]).all()
    assert path.stat().st_size > 0


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_same_file_from_instance_and_mission(mission: Mission, tmp_path: Path, suffix: str) -> None:
    """An instance gives what its mission gives; upper-case suffixes count, and names stay."""
    a, b = tmp_path / f"A{suffix}", tmp_path / f"B{suffix.upper()}"
    write_matrix(mission, a, [0.0])
    write_matrix(mission.instance, b, [0.0])
    assert sorted(path.name for path in tmp_path.iterdir()) == [a.name, b.name]
    if suffix in (".tsp", ".vrp", ".oplib"):
        assert a.read_bytes() == b.read_bytes()


@pytest.mark.parametrize(
    ("name", "departures", "options", "said"),
    [
        ("costs.csv", [0.0], {}, r"'\.csv' is unknown; use one of \.npz, \.nc, \.tsp"),
        ("costs", [0.0], {}, "suffix '' is unknown"),
        ("costs.npz", [], {}, "departures: there are none"),
        ("costs.npz", [-1.0], {}, "departures must be"),
        ("costs.nc", [math.nan], {}, "departures must be"),
        ("costs.npz", [[0.0, 1.0]], {}, "departures must be"),
        ("costs.tsp", DEPARTURES, {}, r"a \.tsp file holds one departure, but 3 are given"),
        ("costs.vrp", DEPARTURES, {}, r"a \.vrp file holds one departure, but 3 are given"),
        ("costs.oplib", DEPARTURES, {}, r"a \.oplib file holds one departure, but 3 are given"),
        ("costs.parquet", [0.0], {}, "holds every connection; leave out the ready times"),
        ("costs.tsp", [0.0], {"quantity": "price"}, "quantity = 'price': use one of"),
        ("costs.tsp", [0.0], {"scale": 0.0}, "scale = 0.0: must be a positive number"),
        ("costs.vrp", [0.0], {"scale": 1e12}, "31 bits"),
        ("nowhere/costs.npz", [0.0], {}, "does not exist; create it"),
    ],
)
def test_wrong_calls_are_refused_and_write_nothing(
    mission: Mission, tmp_path: Path, name: str, departures: list[float], options: dict, said: str
) -> None:
    """What cannot be written is said in one sentence, and no file is left behind."""
    with pytest.raises(adr_opt.InputError, match=said):
        write_matrix(mission, tmp_path / name, departures, **options)
    assert not list(tmp_path.iterdir())


def test_a_vrp_needs_a_target(tmp_path: Path) -> None:
    """Without targets there is nothing to route."""
    with pytest.raises(adr_opt.InputError, match="has no target"):
        write_matrix(adr_opt.generate("tiny", 0, targets=0), tmp_path / "costs.vrp", [0.0])


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_failure_leaves_the_old_file(
    mission: Mission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    """Files are written whole or not at all: a failure on the way changes nothing."""
    path = tmp_path / f"costs{suffix}"
    path.write_text("old")
    function = f"write_{suffix[1:].replace('nc', 'netcdf')}"
    honest = getattr(write, function)

    def fails(temporary: Path, *arguments: object) -> None:
        honest(temporary, *arguments)
        raise RuntimeError("the machine stops here")

    monkeypatch.setattr(write, function, fails)
    with pytest.raises(RuntimeError, match="stops here"):
        write_matrix(mission, path, [0.0])
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
