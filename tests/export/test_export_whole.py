"""The whole timetable as Parquet and as a model, read back without this project."""

from __future__ import annotations

import itertools
import json
import re
import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from brute_force import brute_force
from conftest import Cli
from hand_made import OPTIMAL_PLAN, OPTIMUM, hand_made

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.export.tables import arrays, write, write_timetable
from adr_opt.export.tables.write import ONE_DEPARTURE, SAMPLED, whole_suffixes
from adr_opt.mission.mission import Mission
from solvers.planners.mip import files

MODELS = pytest.mark.parametrize("suffix", [".lp", ".mps"])


LONG = (2, 7, 10)
"""Seeds of odd missions whose models take seconds to solve."""


def odd_mission(seed: int) -> Mission:
    """Make a tiny mission with zones, unequal and non-integer prizes, or a small tank by turns."""
    rng = np.random.default_rng(seed)
    instance = adr_opt.generate("tiny", seed, targets=3 + seed % 4, zones=3 * (seed % 3 == 0))
    prizes = rng.integers(0, 6, 9) * 2.0 if seed % 2 else np.round(rng.uniform(0.1, 3.0, 9), 3)
    targets = tuple(
        target.replace(prize=float(prize))
        for target, prize in zip(instance.targets, prizes, strict=False)
    )
    tank = float(rng.uniform(300.0, 1500.0))
    return Mission(instance.replace(targets=targets).with_limits(delta_v_m_s=tank), threads=1)


def crowded_mission(seed: int, targets: int, delta_v_m_s: float, days: float) -> Mission:
    """Make a mission in which several ways lead to the same leg, so that the rows of ΔV decide."""
    instance = adr_opt.generate("nominal", seed, targets=targets)
    limited = instance.with_limits(delta_v_m_s=delta_v_m_s, duration_s=days * DAY_S)
    return Mission(limited, threads=1)


def small_missions() -> list[Mission]:
    """Make missions whose models are solved at once."""
    return [
        Mission(hand_made(), threads=1),
        *(odd_mission(seed) for seed in range(5) if seed not in LONG),
        *(crowded_mission(seed, 5, 600.0, 1.2) for seed in (10, 12)),
    ]


def large_missions() -> list[Mission]:
    """Make missions whose models take seconds."""
    return [
        *(odd_mission(seed) for seed in {*LONG, *range(5, 12)}),
        *(crowded_mission(seed, 5, 600.0, 1.2) for seed in (18, 27)),
        crowded_mission(9, 7, 800.0, 2.0),
    ]


def solved(path: Path) -> tuple[float, tuple[int, ...]]:
    """Optimum of a model file by HiGHS, which knows nothing but the file, and its order."""
    highspy = pytest.importorskip("highspy")
    highs = highspy.Highs()
    highs.setOptionValue("output_flag", False)
    highs.setOptionValue("mip_rel_gap", 0.0)
    assert highs.readModel(str(path)) == highspy.HighsStatus.kOk
    highs.run()
    assert highs.getModelStatus() == highspy.HighsModelStatus.kOptimal
    columns = zip(highs.getLp().col_names_, highs.getSolution().col_value, strict=True)
    return highs.getObjectiveValue(), files.order_of(dict(columns))


@MODELS
@pytest.mark.parametrize(
    "make", [small_missions, pytest.param(large_missions, marks=pytest.mark.slow)]
)
def test_the_optimum_of_the_file_is_the_optimum_of_the_mission(
    suffix: str, make: Callable[[], list[Mission]], tmp_path: Path
) -> None:
    """HiGHS, from the file alone, finds what brute force finds, and the names give the plan."""
    pytest.importorskip("pyomo")
    for mission in make():
        optimum, _, _ = brute_force(mission)
        path = tmp_path / f"model{suffix}"
        write_timetable(mission, path)
        value, order = solved(path)
        assert value == pytest.approx(optimum, abs=1e-6)
        timing = mission.time(order)
        assert timing.made == len(order)
        assert timing.objective == pytest.approx(optimum, abs=1e-6)
        assert mission.instance.sha256 in path.read_text(encoding="ascii")
    assert list(tmp_path.iterdir()) == [path]


@MODELS
def test_the_worked_out_plan_is_the_solution(suffix: str, tmp_path: Path) -> None:
    """The only optimal plan of the hand-made instance, with its refuelling, is read back."""
    pytest.importorskip("pyomo")
    write_timetable(hand_made(), tmp_path / f"model{suffix}")
    assert solved(tmp_path / f"model{suffix}") == (pytest.approx(OPTIMUM), OPTIMAL_PLAN)


def test_a_model_without_a_budget_is_caught(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the rows that keep the ΔV used within the budget, the file promises too much."""
    pytest.importorskip("pyomo")
    from solvers.planners.mip.constraints import MipConstraints

    monkeypatch.setattr(MipConstraints, "_delta_v_fits", lambda self: None)
    for mission in (crowded_mission(seed, 5, 600.0, 1.2) for seed in (10, 12, 18, 27)):
        write_timetable(mission, tmp_path / "model.lp")
        assert solved(tmp_path / "model.lp")[0] > brute_force(mission)[0] + 0.5


@pytest.mark.slow
def test_another_reader_and_solver_agree(tmp_path: Path) -> None:
    """SCIP, by way of OR-Tools, reads the .mps file, maximises, and finds the same optimum."""
    pytest.importorskip("pyomo")
    from ortools.linear_solver.python import model_builder

    for mission in small_missions()[:5]:
        write_timetable(mission, tmp_path / "model.mps")
        model, solver = model_builder.Model(), model_builder.Solver("scip")
        assert model.import_from_mps_file(str(tmp_path / "model.mps"))
        assert solver.solve(model) == model_builder.SolveStatus.OPTIMAL
        assert solver.objective_value == pytest.approx(brute_force(mission)[0], abs=1e-6)


@MODELS
def test_worthless_targets_and_odd_names_can_be_written(suffix: str, tmp_path: Path) -> None:
    """Without any prize the optimum is 0, and a name of any letters leaves the file readable."""
    pytest.importorskip("pyomo")
    instance = adr_opt.generate("tiny", 1)
    targets = tuple(target.replace(prize=0.0) for target in instance.targets)
    odd = instance.replace(targets=targets, name="Müll\nEND */ \\* 5%")
    write_timetable(odd, tmp_path / f"model{suffix}")
    assert solved(tmp_path / f"model{suffix}")[0] == 0.0


@MODELS
def test_models_that_cannot_be_written(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Too many moves, none at all, or no Pyomo: one sentence each, and no file."""
    pytest.importorskip("pyomo")
    path = tmp_path / f"model{suffix}"
    path.write_text("old")
    instance = adr_opt.generate("tiny", 0)
    nowhere = instance.with_limits(delta_v_m_s=0.0)
    with pytest.raises(adr_opt.InputError, match="has no legal move"):
        write_timetable(nowhere, path)
    with monkeypatch.context() as patch:
        patch.setattr(files, "MOST_MOVES", 10)
        with pytest.raises(adr_opt.InputError, match=r"has \d+ moves, more than the 10 that fit"):
            write_timetable(instance, path)
    monkeypatch.setattr(files, "find_spec", lambda name: None)
    with pytest.raises(adr_opt.MissingExtra, match=r"pyomo.*\[mip\]"):
        write_timetable(instance, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_format_shows_up_by_being_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A third party's model format is written by its callable; a broken one says so."""
    installed = tmp_path / "installed"
    metadata = installed / "other-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(
        f"[{write.MODELS}]\nnl = other_format:write\ngms = other_format:nothing\n"
    )
    (installed / "other_format.py").write_text(
        "def write(mission, path):\n    path.write_text(' '.join(mission.names))\n"
    )
    monkeypatch.syspath_prepend(str(installed))
    instance = adr_opt.generate("tiny", 0)
    write_timetable(instance, tmp_path / "model.NL")
    assert (tmp_path / "model.NL").read_text() == " ".join(instance.names)
    with pytest.raises(adr_opt.InputError, match=r"'\.gms' is declared, but cannot be imported"):
        write_timetable(instance, tmp_path / "model.gms")
    assert not (tmp_path / "model.gms").exists()


@pytest.fixture(scope="module")
def mission() -> Mission:
    """Make a tiny mission with zones in which some departures have no transfer."""
    instance = adr_opt.generate("tiny", 0, zones=2)
    narrow = instance.transfer.replace(max_altitude_m=810e3, max_phasing_revolutions=2)
    return Mission(instance.replace(transfer=narrow))


def test_parquet_holds_every_connection(mission: Mission, tmp_path: Path) -> None:
    """The rows are the connections of all pairs, no more and no less.

    They are in order of origin, destination and departure.
    """
    pq = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "timetable.parquet"
    write_timetable(mission, path)
    assert pq.ParquetFile(path).num_row_groups == len(mission.names)
    columns = ("departure_s", "arrival_s", "delta_v_m_s", "phasing_revolutions")
    expected = []
    for origin, destination in itertools.permutations(mission.names, 2):
        found = mission.timetable.connections(origin, destination)
        numbers = (found.departure, found.arrival, found.delta_v, found.revolutions)
        for row in zip(*(each.tolist() for each in numbers), strict=True):
            expected.append(
                {
                    "origin": origin,
                    "destination": destination,
                    **dict(zip(columns, row, strict=True)),
                }
            )
    assert pq.read_table(path).to_pylist() == expected
    assert len(expected) > 100
    assert {row["phasing_revolutions"] for row in expected} <= {0, 1, 2}
    assert all(row["departure_s"] < row["arrival_s"] for row in expected)


def test_the_best_mission_is_known_from_the_parquet_file(tmp_path: Path) -> None:
    """With the file alone an order of bodies is flown at the ΔV that the planner found, nearly.

    Up to the resolution that connections are told apart to.
    """
    pq = pytest.importorskip("pyarrow.parquet")
    instance = adr_opt.generate("tiny", 4)
    path = tmp_path / "timetable.parquet"
    write_timetable(instance, path)
    read = pq.read_table(path)
    stated = read.schema.metadata
    service = {body["name"]: body["service_s"] for body in json.loads(stated[b"bodies_json"])}
    plan = adr_opt.solve(instance, method="beam").plan
    assert plan is not None
    assert len(plan.legs) >= 3
    rows: dict[tuple[str, str], list[dict[str, Any]]] = defaultdict(list)
    for row in read.to_pylist():
        rows[row["origin"], row["destination"]].append(row)
    # Ways to have come so far: when free, ΔV spent; stations fill the tank.
    ways = [(0.0, 0.0, 0.0)]
    body = stated[b"station"].decode()
    for leg in plan.legs:
        after = []
        for free, tank, spent in ways:
            for row in rows[body, leg.destination]:
                end = row["arrival_s"] + service[leg.destination]
                used = tank + row["delta_v_m_s"]
                if (
                    row["departure_s"] >= free
                    and end <= instance.mission.duration_s
                    and used <= instance.chaser.tank.delta_v_m_s
                ):
                    refuels = leg.destination in instance.station_names
                    after.append((end, 0.0 if refuels else used, spent + row["delta_v_m_s"]))
        ways = []
        for way in sorted(after):
            if not any(other[1] <= way[1] and other[2] <= way[2] for other in ways):
                ways.append(way)
        body = leg.destination
    best = min(spent + instance.time_m_s_per_s * free for free, _, spent in ways)
    assert plan.cost - 1e-9 <= best <= plan.cost + 0.1 * len(plan.legs)


def test_parquet_states_units_and_settings(mission: Mission, tmp_path: Path) -> None:
    """Every number has a unit, every column a meaning, and the file names its instance."""
    pq = pytest.importorskip("pyarrow.parquet")
    write_timetable(mission, tmp_path / "timetable.parquet")
    schema = pq.read_schema(tmp_path / "timetable.parquet")
    units = {field.name: (field.metadata or {}).get(b"units") for field in schema}
    assert units == {
        "origin": None,
        "destination": None,
        "departure_s": b"s",
        "delta_v_m_s": b"m s-1",
        "arrival_s": b"s",
        "phasing_revolutions": b"1",
    }
    assert all(field.metadata[b"long_name"] for field in schema)
    stated = {key.decode(): value.decode() for key, value in schema.metadata.items()}
    assert stated["sha256"] == mission.instance.sha256
    assert stated["epoch"] == "2026-01-01T00:00:00Z"
    assert float(stated["mission_delta_v_m_s"]) == mission.instance.chaser.tank.delta_v_m_s
    assert [body["name"] for body in json.loads(stated["bodies_json"])] == list(mission.names)
    told = mission.instance.model_dump(mode="json")
    assert json.loads(stated["keep_out_zones_json"]) == told["keep_out_zones"]


def test_parquet_without_targets_and_without_its_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No target is no row; no pyarrow is a sentence that names the extra, and no file."""
    pq = pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "timetable.parquet"
    write_timetable(adr_opt.generate("tiny", 0, targets=0), path)
    assert pq.read_table(path).num_rows == 0
    path.unlink()
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(adr_opt.MissingExtra, match=r"pyarrow.*\[io\]"):
        write_timetable(adr_opt.generate("tiny", 0), path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", [".lp", ".mps", ".oplib"])
def test_models_of_missions_with_kits_are_refused(suffix: str, cli: Cli, tmp_path: Path) -> None:
    """A file that would state a mission without its kits is not written, which is said."""
    drawn = adr_opt.generate("tiny", 0)
    targets = (drawn.targets[0].replace(removal="kit"), *drawn.targets[1:])
    chaser = drawn.chaser.replace(kits=0)
    instance = tmp_path / "kits.json"
    instance.write_text(drawn.replace(targets=targets, chasers=(chaser,)).to_json())
    ready = ["--at", "0"] if suffix == ".oplib" else []
    refused = cli("matrix", instance, *ready, "--out", f"kits{suffix}")
    assert refused.status == 2
    assert "does not follow kits" in refused.err
    assert [path.name for path in tmp_path.iterdir()] == ["kits.json"]


def test_formats_with_and_without_ready_times(cli: Cli, tiny_file: Path) -> None:
    """`matrix` wants ready times for matrices and none for the whole timetable, and says so."""
    pytest.importorskip("pyarrow.parquet")
    outcome = cli("matrix", tiny_file, "--out", "t.parquet", "--json")
    assert outcome.status == 0
    assert json.loads(outcome.out)["bodies"][0] == "station"
    assert "every connection" in outcome.err
    assert cli("matrix", tiny_file, "--at", "0", "--out", "c.oplib").status == 0
    for arguments, named in (
        (["--at", "0", "--out", "t.parquet"], "leave out --every and --at"),
        (["--every", "3600", "--out", "t.lp"], "a .lp file holds every connection"),
        (["--out", "c.oplib"], "either with --every S or with --at S"),
        (["--out", "c.csv"], "suffix '.csv' is unknown"),
        (["--at", "0", "--at", "1", "--out", "c.oplib"], "holds one departure, but 2"),
    ):
        refused = cli("matrix", tiny_file, *arguments)
        assert refused.status == 2
        assert named in refused.err
    with pytest.raises(adr_opt.InputError, match="holds matrices at ready times"):
        write_timetable(adr_opt.load(tiny_file), "c.npz")


def test_the_page_on_matrices_lists_every_format_and_the_limit() -> None:
    """docs/matrices.md has a row for every suffix and states the most moves of a model."""
    page = (Path(__file__).parents[2] / "docs" / "matrices.md").read_text(encoding="utf-8")
    rows = set(re.findall(r"^\| `(\.[a-z]+)` \|", page, re.MULTILINE))
    assert rows == {*SAMPLED, *ONE_DEPARTURE, *whole_suffixes()}
    assert f"{files.MOST_MOVES:,}".replace(",", " ") in page
    assert all(f"`{column}`" in page for column in arrays.COLUMNS)
