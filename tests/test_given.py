"""Costs from elsewhere (MODEL section 9): given in Python or as a file, planned, checked, told.

That plans and proofs are right is for test_all_rules and test_campaigns, which draw given
connections among others.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import browser
import numba
import numpy as np
import pytest
from conftest import Cli, refused
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st
from random_rules import given_mission

import adr_opt
from adr_opt.bodies import Station, Target
from adr_opt.chasers import AtStation, Chaser, Tank
from adr_opt.given import COLUMNS, of_rows
from adr_opt.instance import Instance
from adr_opt.kernels.given_connections import sifted
from adr_opt.plan import Plan
from adr_opt.settings import GivenFile, KeepOutZone, MissionSettings, TransferSettings

HOUR_S = 3600.0
NAMES = ("depot", "mill", "quay", "farm")


def roads(**changes: Any) -> Instance:
    """A depot and three places without orbits, whose connections are still to be given."""
    stated: dict[str, Any] = {
        "name": "roads",
        "epoch": "2026-05-04T06:00:00Z",
        "stations": [Station(name="depot")],
        "targets": [Target(name=name) for name in NAMES[1:]],
        "chasers": [
            Chaser(
                name="van", start=AtStation(station="depot"), end=AtStation(station="depot"),
                tank=Tank(delta_v_m_s=30.0),
            )
        ],
        "mission": MissionSettings(
            duration_s=6 * HOUR_S, service_s=600.0, refuel_revolutions=0.0
        ),
        "transfer": TransferSettings(given=GivenFile(file="roads.parquet")),
    }  # fmt: skip
    return Instance(**(stated | changes))


DEPARTURES = np.arange(0.0, 6 * HOUR_S, HOUR_S / 2)


def matrices() -> tuple[np.ndarray, np.ndarray]:
    """Half an hour between neighbours, longer in between; dearer the later one leaves."""
    away = np.abs(np.arange(4)[:, None] - np.arange(4)[None, :]) * 1500.0
    away[3, 1] = np.inf  # no way back from the farm to the mill
    dear = 1.0 + np.arange(DEPARTURES.size)[:, None, None] / 10.0
    return np.broadcast_to(away, (DEPARTURES.size, 4, 4)), dear * np.minimum(away, 1e9) / 500.0


def as_rows() -> dict[str, list[Any]]:
    """The same, one by one."""
    duration, cost = matrices()
    rows = [
        (NAMES[i], NAMES[j], at, at + duration[d, i, j], cost[d, i, j])
        for d, at in enumerate(DEPARTURES) for i in range(4) for j in range(4)
        if i != j and np.isfinite(duration[d, i, j])
    ]  # fmt: skip
    return {name: [row[at] for row in rows] for at, name in enumerate(COLUMNS)}


def road(origin: int, destinations: np.ndarray, departure: float) -> tuple[np.ndarray, np.ndarray]:
    duration, cost = matrices()
    at = int(departure // (HOUR_S / 2))
    return duration[at, origin, destinations], cost[at, origin, destinations]


@numba.njit
def compiled_road(origin, destinations, departure):
    takes, cost = np.empty(destinations.size), np.empty(destinations.size)
    for place, j in enumerate(destinations):
        takes[place] = abs(origin - j) * 1500.0
        if origin == 3 and j == 1:
            takes[place] = np.inf
        cost[place] = (1.0 + departure / 1800.0 / 10.0) * (abs(origin - j) * 1500.0) / 500.0
    return takes, cost


def solved() -> tuple[Instance, Plan]:
    """The roads with their connections, and the best plan."""
    instance = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *matrices()).instance
    result = adr_opt.solve(instance, "exact", time_limit=30.0)
    assert result.status == "optimal"
    return instance, result.plan


def test_rows_matrices_and_functions_give_the_same() -> None:
    """However connections are given, an instance is the same one, digest included."""
    table = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *matrices())
    shuffled = np.random.default_rng(0).permutation(len(as_rows()["origin"]))
    columns = {name: np.array(values)[shuffled] for name, values in as_rows().items()}
    numbered = columns | {
        name: np.array([NAMES.index(one) for one in columns[name]]) for name in COLUMNS[:2]
    }
    for other in (
        adr_opt.Timetable.from_connections(roads(), columns),
        adr_opt.Timetable.from_connections(roads(), numbered),
        adr_opt.Timetable.from_function(roads(), road, DEPARTURES),
        adr_opt.Timetable.from_function(roads(), compiled_road, DEPARTURES),
    ):
        assert other.instance == table.instance
        assert other.instance.sha256 == table.instance.sha256
    changed = columns | {"delta_v_m_s": columns["delta_v_m_s"] + 1e-9}
    other = adr_opt.Timetable.from_connections(roads(), changed)
    assert other.instance != table.instance


def test_the_digest_is_what_the_documentation_says() -> None:
    """Another program gets the digest of given connections by the description of it."""
    columns = as_rows()
    rows = sorted(
        zip(*(columns[name] for name in COLUMNS), strict=True),
        key=lambda row: (row[0], row[1], *row[2:]),
    )
    names = sorted(NAMES)
    digest = hashlib.sha256(json.dumps(names).encode() + b"\n")
    for at in range(5):
        values = [names.index(row[at]) if at < 2 else row[at] for row in rows]
        digest.update(np.array(values, dtype="<i4" if at < 2 else "<f8").tobytes())
    assert of_rows(columns, NAMES).sha256 == digest.hexdigest()


def test_who_is_ready_in_between_waits_for_the_next_departure() -> None:
    """A matrix is what leaves at its departure; nothing leaves in between or is made up."""
    table = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *matrices())
    found = table.connections("depot", "mill", after=1.0)
    assert found.departure[0] == HOUR_S / 2
    assert found.arrival[0] == HOUR_S / 2 + 1500.0
    assert found.delta_v[0] == pytest.approx(3.3)
    assert table.lookup("depot", "mill", 1.0) == (pytest.approx(3.3), HOUR_S / 2 + 1500.0)
    assert table.lookup("farm", "mill", 0.0) == (np.inf, np.inf)
    sampled = table.matrices([1.0], choose="earliest")
    assert sampled.duration[0, 0, 1] == HOUR_S / 2 - 1.0 + 1500.0


@settings(max_examples=200, deadline=None)
@drawn(
    st.lists(
        st.tuples(st.integers(0, 6), st.integers(1, 6), st.integers(0, 5)), max_size=30
    ),
    st.sampled_from([0.0, 1.0, 2.5]),
)  # fmt: skip
def test_what_is_left_out_is_dominated(rows: list[tuple[int, int, int]], resolution: float) -> None:
    """One is left out if, and only if, one that is kept is no later, no earlier and no dearer."""
    columns = np.array(sorted((at, at + takes, cost) for at, takes, cost in rows), dtype=float)
    columns = columns.reshape(-1, 3)
    columns.setflags(write=False)
    found = sifted(*np.ascontiguousarray(columns.T), 10.0, resolution)
    kept = list(zip(found.departure, found.arrival, found.delta_v, strict=True))
    assert kept == sorted(kept)
    assert {tuple(row) for row in columns} >= set(kept)
    for leaves, lands, cost in columns.tolist():
        others = [one for one in kept if one != (leaves, lands, cost)]
        dominated = any(a >= leaves and b <= lands and c <= cost + resolution for a, b, c in others)
        assert ((leaves, lands, cost) in kept) or dominated or lands > 10.0
    for one in kept:
        after = [other for other in kept if other[0] >= one[0] and other != one]
        assert not any(b <= one[1] and c <= one[2] + resolution for _, b, c in after)
    assert np.array_equal(np.argsort(found.arrival, kind="stable"),
                          np.argsort(found.crossing, kind="stable"))  # fmt: skip


def test_a_function_may_offer_choices() -> None:
    """Several connections at one departure are kept where one is quicker and another cheaper."""

    def quick_or_cheap(i: int, others: np.ndarray, at: float) -> tuple[np.ndarray, np.ndarray]:
        ones = np.ones(others.size)
        return np.array([600.0 * ones, 1200.0 * ones, 1800.0 * ones]), np.array(
            [9.0 * ones, 4.0 * ones, 4.5 * ones]
        )

    table = adr_opt.Timetable.from_function(roads(), quick_or_cheap, [0.0, 900.0])
    found = table.connections("depot", "farm")
    # The cheap one at 0 arrives no earlier than the quick one at 900, and is cheaper.
    assert found.departure.tolist() == [0.0, 0.0, 900.0, 900.0]
    assert found.delta_v.tolist() == [9.0, 4.0, 9.0, 4.0]
    given = table.instance.given
    assert given is not None
    assert 4.5 not in given.cost


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda rows: rows.pop("arrival_s"), "column arrival_s is missing"),
        (lambda rows: rows["origin"].pop(), "column destination has not one value"),
        (lambda rows: rows["origin"].__setitem__(3, "moon"), "'moon' is not a body"),
        (lambda rows: rows["departure_s"].__setitem__(2, np.nan), "departure_s = nan"),
        (lambda rows: rows["departure_s"].__setitem__(2, -5.0), "departure_s = -5.0"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(2, -5.0), "delta_v_m_s = -5.0"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(2, np.inf), "delta_v_m_s = inf"),
        (lambda rows: rows["arrival_s"].__setitem__(0, 0.0), "takes 0.0 s"),
        (lambda rows: rows["destination"].__setitem__(0, "depot"), "to where it begins"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(0, "dear"), "must be numbers"),
    ],
)
def test_rows_that_cannot_be_planned_on_are_refused(
    change: Callable[[dict[str, list[Any]]], object], said: str
) -> None:
    """Each mistake in rows is one sentence that names it."""
    rows = as_rows()
    change(rows)
    with pytest.raises(adr_opt.InputError, match=said) as error:
        adr_opt.Timetable.from_connections(roads(), rows)
    assert "\n" not in str(error.value)


def test_numbers_of_bodies_are_checked() -> None:
    """A body by a number that nobody has is refused."""
    rows = {name: [0.0] for name in COLUMNS} | {"origin": [0], "destination": [4]}
    with pytest.raises(adr_opt.InputError, match="destination = 4 is not the number of a body"):
        adr_opt.Timetable.from_connections(roads(), rows)


def test_matrices_that_cannot_be_planned_on_are_refused() -> None:
    """Departures out of order, another shape, NaN and negative durations are refused."""
    duration, cost = matrices()
    wrong = duration.copy()
    wrong[2, 0, 1] = -60.0
    nowhere = cost.copy()
    nowhere[1, 2, 3] = np.nan
    make = adr_opt.Timetable.from_matrices
    for given, said in (
        ((DEPARTURES[::-1], duration, cost), "departures\\[1\\] = 18000 is not after"),
        ((DEPARTURES[:-1], duration, cost), "duration has the shape"),
        ((DEPARTURES, duration, cost[:, :3]), "cost has the shape"),
        ((DEPARTURES, wrong, cost), "'depot' to 'mill': (takes|arrival)"),
        ((DEPARTURES, duration, nowhere), "cost\\[1, 2, 3\\] = nan"),
        ((DEPARTURES - 1.0, duration, cost), "finite times ≥ 0"),
    ):
        with pytest.raises(adr_opt.InputError, match=said):
            make(roads(), *given)


def test_functions_that_answer_otherwise_are_refused() -> None:
    """A function that gives too few numbers, NaN, or no pair is refused."""
    for f, said in (
        (lambda i, others, at: (others[1:], others[1:]), "one for each of the 3 destinations"),
        (lambda i, others, at: (others * np.nan, others), "gives nan"),
        (lambda i, others, at: None, "must give durations and costs"),
        (lambda i, others, at: (np.ones((1 + (at > 0), others.size)),) * 2, "as many rows"),
    ):
        with pytest.raises(adr_opt.InputError, match=said):
            adr_opt.Timetable.from_function(roads(), f, [0.0, 60.0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"transfer": TransferSettings()}, r"stations\[0\].orbit: missing"),
        (
            {"mission": MissionSettings(duration_s=1.0, refuel_revolutions=0.0)},
            "service_revolutions = 1.0: 'mill' has no orbit and so no period; give service_s",
        ),
        (
            {"mission": MissionSettings(duration_s=1.0, service_s=1.0)},
            "refuel_revolutions = 1.0: 'depot' has no orbit and so no period; write 0.0",
        ),
        (
            {
                "keep_out_zones": [
                    KeepOutZone(min_altitude_m=0.0, max_altitude_m=1.0, start_s=0.0, end_s=1.0)
                ]
            },
            "keep_out_zones: connections are given",
        ),
    ],
)
def test_instances_say_what_they_need_an_orbit_for(changes: dict[str, Any], said: str) -> None:
    """Without orbits there are no periods, no zones, and no connections of the model."""
    with pytest.raises(adr_opt.InputError, match=said):
        roads().replace(**changes)


def test_nothing_is_planned_on_what_was_not_read() -> None:
    """An instance that only names its connections says so where they are asked for."""
    with pytest.raises(adr_opt.InputError, match=r"are in 'roads.parquet', which was not read"):
        adr_opt.solve(roads())


def test_the_toy_is_planned_by_hand() -> None:
    """To the end of the road and back at the least cost; legs are given and burn nothing."""
    instance, plan = solved()
    assert adr_opt.check(instance, plan) == ()
    assert plan.objective == 3.0
    assert {leg.kind for leg in plan.legs} == {"given"}
    assert all(leg.burns == () for leg in plan.legs)
    assert plan.destinations[-1] == "depot"
    assert plan.legs[0].departure_s == 0.0
    # Each half hour makes everything dearer by a tenth, so nobody waits: 25 minutes of road and
    # 10 of service miss every other departure.
    assert [leg.departure_s / HOUR_S for leg in plan.legs] == [0.0, 1.0, 2.0, 3.0]
    assert plan.cost == pytest.approx(3.0 + 3.0 * 1.2 + 3.0 * 1.4 + 9.0 * 1.6)
    assert plan.legs[-1].end_s == 3 * HOUR_S + 4500.0


def test_a_margin_and_a_start_are_kept_to() -> None:
    """With a margin less is spent; a plan may be begun from."""
    instance, plan = solved()
    kept = adr_opt.solve(instance, "exact", time_limit=30.0, margin=0.5)
    assert kept.objective == 0.0 or kept.plan.cost <= 15.0
    again = adr_opt.solve(instance, "local-search", start=plan, time_limit=2.0, iterations=3)
    assert again.objective == plan.objective


def changed(plan: Plan, leg: int, **changes: Any) -> Plan:
    route = plan.routes[0]
    legs = list(route.legs)
    legs[leg] = legs[leg].replace(**changes)
    return plan.replace(routes=(route.replace(legs=tuple(legs)),))


@pytest.mark.parametrize(
    ("leg", "changes", "rule"),
    [
        (1, {"departure_s": 3700.0}, "departure"),
        (1, {"arrival_s": 5000.0}, "arrival"),
        (1, {"delta_v_m_s": 3.0}, "cost"),
        (1, {"delta_v_m_s": 3.6 - 0.9e-4}, None),
        (1, {"kind": "short"}, "given"),
        (1, {"phasing_revolutions": 1}, "given"),
        (1, {"ready_s": 0.0}, "ready"),
        (2, {"end_s": 1.0}, "service"),
    ],
)
def test_check_finds_legs_that_nobody_gave(
    leg: int, changes: dict[str, Any], rule: str | None
) -> None:
    """A leg that is none of the connections is a violation of the rule that it breaks."""
    instance, plan = solved()
    found = adr_opt.check(instance, changed(plan, leg, **changes))
    at_leg = [violation.rule for violation in found if violation.leg == leg + 1]
    assert at_leg == ([] if rule is None else at_leg[:1] and [rule, *at_leg[1:]])
    assert bool(at_leg) == (rule is not None)


def test_check_looks_among_what_planners_leave_out() -> None:
    """A dominated connection may be flown, one before the chaser is ready may not."""
    _, plan = solved()
    rows = as_rows()
    for name, value in zip(COLUMNS, ("depot", "mill", 0.0, 1700.0, 4.0), strict=True):
        rows[name].append(value)
    for name, value in zip(COLUMNS, ("mill", "quay", 2000.0, 5100.0, 3.6), strict=True):
        rows[name].append(value)
    more = adr_opt.Timetable.from_connections(roads(), rows).instance
    reference = plan.instance.replace(sha256=more.sha256)
    first = plan.routes[0].legs[0]
    worse = changed(plan, 0, arrival_s=1700.0, end_s=first.end_s + 200.0, delta_v_m_s=4.0)
    told = {violation.rule for violation in adr_opt.check(more, worse.replace(instance=reference))}
    assert told == {"ready", "delta-v-left", "cost"} - ({"ready"} if False else set())
    early = changed(plan, 1, departure_s=2000.0).replace(instance=reference)
    assert "departure" in {violation.rule for violation in adr_opt.check(more, early)}


def test_a_given_leg_is_none_of_the_model() -> None:
    """On an instance of the model a leg that says it is given is refused, not flown."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    found = adr_opt.check(instance, changed(plan, 0, kind="given", burns=()))
    assert [violation.rule for violation in found] == ["given"]


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@pytest.mark.parametrize("spacing_s", [0.0, 7000.0])
def test_the_model_given_back_is_the_same_problem(dynamics: str, spacing_s: float) -> None:
    """An instance's own connections as given ones: the same plans, bounds and proofs."""
    instance = adr_opt.generate("tiny", 3)
    instance = instance.replace(
        dynamics=dynamics, transfer=instance.transfer.replace(departure_spacing_s=spacing_s)
    ).with_time_value(75.0)
    mission = adr_opt.Mission(instance)
    parts: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    for i, origin in enumerate(mission.names):
        for j, destination in enumerate(mission.names):
            found = mission.connecting.of_pair(i, j, mission.connecting.planning_resolution_m_s)
            for name, values in zip(
                COLUMNS,
                ([origin] * found.departure.size, [destination] * found.departure.size,
                 found.departure, found.arrival, found.delta_v),
                strict=True,
            ):  # fmt: skip
                parts[name].extend(values)
    back = instance.with_given(of_rows(parts, instance.names)).with_time_value(75.0)
    for method in ("greedy-guarded", "beam", "exact"):
        ours = adr_opt.solve(instance, method, time_limit=60.0, iterations=3)
        theirs = adr_opt.solve(back, method, time_limit=60.0, iterations=3)
        assert theirs.objective == ours.objective, method
        assert theirs.upper_bound == ours.upper_bound, method
        assert theirs.status == ours.status, method
        assert adr_opt.check(back, theirs.plan) == ()
        if spacing_s or dynamics == "j2" or method == "exact":
            assert theirs.plan.cost == pytest.approx(ours.plan.cost, abs=1e-6), method
        if spacing_s or dynamics == "j2":
            assert theirs.sequence == ours.sequence, method
            flown = [(leg.arrival_s, leg.delta_v_m_s) for leg in ours.plan.legs]
            again = [(leg.arrival_s, leg.delta_v_m_s) for leg in theirs.plan.legs]
            assert np.allclose(again, flown, rtol=0.0, atol=1e-3)
    bounds = [adr_opt.bound(one, "lagrangian", iterations=5, time_limit=60.0)
              for one in (instance, back)]  # fmt: skip
    assert bounds[0].upper_bound == bounds[1].upper_bound


@pytest.mark.parametrize("seed", range(6))
def test_files_give_back_what_was_saved(tmp_path: Path, seed: int) -> None:
    """An instance and its connections, saved and loaded, are the same, and so are their plans."""
    pytest.importorskip("pyarrow")
    instance = given_mission(seed)
    instance.save(tmp_path / "my.json")
    again = adr_opt.load(tmp_path / "my.json")
    assert again == instance
    assert again.sha256 == instance.sha256
    assert (tmp_path / "my.json").read_text() == instance.to_json()
    for column in ("origin", "destination", "departure", "arrival", "cost"):
        assert np.array_equal(getattr(again.given, column), getattr(instance.given, column))
    ours, theirs = (adr_opt.solve(one, "greedy-guarded") for one in (instance, again))
    assert ours.sequence == theirs.sequence


def test_what_matrix_writes_can_be_given_back(cli: Cli, tmp_path: Path) -> None:
    """Connections as `.parquet` and matrices as `.nc`, as `matrix` writes them, are read."""
    for package in ("pyarrow", "h5netcdf"):
        pytest.importorskip(package)
    drawn = adr_opt.generate("tiny", 0).with_limits(duration_s=40000.0)
    Path("tiny.json").write_text(drawn.to_json())
    assert cli("matrix", "tiny.json", "--out", "all.parquet", "--quiet").status == 0
    assert cli("matrix", "tiny.json", "--every", 5000, "--out", "some.nc", "--quiet").status == 0
    for file in ("all.parquet", "some.nc"):
        content = json.loads(drawn.to_json())
        content["transfer"]["given"] = {"file": file}
        Path("given.json").write_text(json.dumps(content))
        instance = adr_opt.load("given.json")
        assert instance.transfer.given.sha256 == instance.given.sha256
        assert cli("solve", "given.json", "--time-limit", 5, "--out", "plan.json").status == 0
        assert cli("check", "given.json", "plan.json").status == 0
    sampled = adr_opt.Mission(drawn).timetable.matrices([0.0, 5000.0])
    there = np.isfinite(sampled.delta_v[0]) & ~np.eye(len(drawn.names), dtype=bool)
    i, j = np.argwhere(there)[0]
    leaves, lands, cost = instance.given.of_pair(drawn.names[i], drawn.names[j])
    assert leaves[0] == 0.0
    assert lands[0] == sampled.duration[0, i, j]
    assert cost[0] == sampled.delta_v[0, i, j]
    # What was given can be exported in turn.
    assert cli("matrix", "given.json", "--out", "again.parquet", "--quiet").status == 0
    assert cli("matrix", "given.json", "--at", 0, "--out", "again.nc", "--quiet").status == 0


def test_files_that_are_missing_or_others_are_refused(cli: Cli, tmp_path: Path) -> None:
    """A file that is not there, is another one's, or no such file is one sentence, exit code 2."""
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    there = Path("roads.parquet").read_bytes()
    for verb in (
        ("solve", "my.json"),
        ("check", "my.json", "plan.json"),
        ("bound", "my.json", "--method", "lagrangian"),
    ):
        Path("roads.parquet").unlink(missing_ok=True)
        refused(cli(*verb), "roads.parquet: no such file")
        Path("roads.parquet").write_bytes(b"PAR1 nothing of the kind")
        refused(cli(*verb), "roads.parquet: not a Parquet file")
    dearer = as_rows()
    dearer["delta_v_m_s"][0] += 1.0
    adr_opt.Timetable.from_connections(roads(), dearer).instance.save("other.json")
    refused(cli("solve", "my.json"), "roads.parquet: not the connections that my.json names")
    parquet.write_table(pa.table({"origin": ["depot"]}), "roads.parquet")
    refused(cli("solve", "my.json"), "roads.parquet: column destination is missing")
    parquet.write_table(pa.table(as_rows() | {"origin": ["moon"] * 132}), "roads.parquet")
    refused(cli("solve", "my.json"), "roads.parquet: column origin: 'moon' is not a body")
    rows = as_rows() | {"delta_v_m_s": [None, *as_rows()["delta_v_m_s"][1:]]}
    parquet.write_table(pa.table(rows), "roads.parquet")
    refused(cli("solve", "my.json"), "column delta_v_m_s has rows without a value")
    for content in (there, None):
        if content is None:
            # From another program, with a column more and texts as they are.
            parquet.write_table(pa.table(as_rows() | {"lane": [1] * 132}), "roads.parquet")
        else:
            Path("roads.parquet").write_bytes(content)
        assert cli("check", "my.json", "plan.json").status == 0
    text = Path("my.json").read_text()
    for name in ("../roads.parquet", "roads.csv", "sub/roads.parquet"):
        Path("odd.json").write_text(text.replace("roads.parquet", name))
        refused(cli("solve", "odd.json"), "transfer.given.file")
    Path("no.json").write_text(text.replace("roads.parquet", "roads.nc"))
    Path("roads.nc").write_bytes(b"nothing")
    pytest.importorskip("h5netcdf")
    refused(cli("solve", "no.json"), "roads.nc: not a NetCDF 4 file")


def test_given_costs_have_no_trajectory(cli: Cli, tmp_path: Path) -> None:
    """What would fly a plan refuses it in a sentence, before anything is written."""
    pytest.importorskip("pyarrow")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    for verb in (
        ("fly", "my.json", "plan.json"),
        ("refine", "my.json", "plan.json", "--out", "x.json"),
        ("solve", "my.json", "--refine", "--out", "x.json"),
        ("export", "my.json", "plan.json", "--out", "x.oem"),
    ):
        refused(cli(*verb), "its plans have no trajectory")
        assert not Path("x.json").exists()
    free = instance.replace(chasers=[instance.chaser.replace(end="anywhere")])
    with pytest.raises(adr_opt.InputError, match="has bodies without an orbit"):
        adr_opt.solve(free, "ppo")


def test_the_page_shows_what_there_is(cli: Cli, tmp_path: Path) -> None:
    """A report has timeline, costs and budget, and neither orbits, altitude nor planes."""
    pytest.importorskip("pyarrow")
    pytest.importorskip("plotly")
    instance, plan = solved()
    instance.save("my.json")
    plan.save("plan.json")
    outcome = cli("report", "my.json", "plan.json", "--out", "my.html")
    assert outcome.status == 0, outcome.err
    text = Path("my.html").read_text()
    found = text.partition('id="mission">')[2].partition("</script>")[0]
    figures = json.loads(found)["figures"]
    assert set(figures) == {"budget", "costs", "gantt"}
    assert [trace["name"] for trace in figures["costs"]["data"]] == ["planned"]
    assert "transfer" in {trace["name"] for trace in figures["gantt"]["data"]}
    assert len(figures["budget"]["data"][0]["x"]) == 1 + len(plan.legs) + 1
    for absent in ('id="orbits"', 'id="altitude"', 'id="planes"', "co-elliptic"):
        assert absent not in text.partition("<script>")[0]
    assert "connections given in roads.parquet" in text
    with_orbits = adr_opt.generate("tiny", 0)
    back = with_orbits.with_given(of_rows({name: [] for name in COLUMNS}, with_orbits.names))
    nothing = adr_opt.solve(back, "greedy-guarded").plan
    from adr_opt.report import page

    assert 'id="planes"' in page(back, nothing)


@pytest.mark.skipif(browser.EXECUTABLE is None, reason="needs Chromium")
def test_the_page_works_without_orbits(tmp_path: Path) -> None:
    """All charts that there are get drawn, and nothing is complained about."""
    pytest.importorskip("plotly")
    from adr_opt.report import write_report

    write_report(*solved(), tmp_path / "my.html")
    with browser.Browser(tmp_path / "profile") as tab:
        tab.open(tmp_path / "my.html")
        tab.wait_for("document.documentElement?.dataset.complete")
        assert tab.evaluate("document.querySelectorAll('.chart.js-plotly-plot').length") == 3
        assert [text for level, text in tab.complaints if level == "error"] == []


def test_a_very_short_leg_does_not_hold_up_proofs() -> None:
    """Two bodies side by side, a hundredth of a second apart, in a mission of months."""
    days = 86400.0
    instance = roads(mission=MissionSettings(
        duration_s=100 * days, service_s=0.0, refuel_revolutions=0.0
    ))  # fmt: skip
    duration, cost = matrices()
    duration = np.where(np.isfinite(duration), 20 * days, np.inf)
    duration[:, 1, 2] = duration[:, 2, 1] = 0.01
    table = adr_opt.Timetable.from_matrices(instance, DEPARTURES * 400, duration, cost)
    began = time.process_time()
    result = adr_opt.solve(table.instance, "exact", time_limit=60.0)
    assert result.status == "optimal"
    assert result.objective == 3.0
    assert adr_opt.check(table.instance, result.plan) == ()
    assert time.process_time() - began < 30.0


def test_plots_of_time_are_drawn() -> None:
    """The plots that need no orbit show given legs; those that do say what is missing."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    from adr_opt import plot

    instance, plan = solved()
    _, ax = pyplot.subplots()
    plot.gantt(ax, instance, plan)
    plot.delta_v_left(ax, instance, plan)
    plot.leg_delta_v(ax, instance, plan)
    phases = {segment.phase for segment in plot.segments(instance, plan)}
    assert phases == {"wait", "transfer", "service"}
    for function in (plot.planes, plot.altitude):
        with pytest.raises(adr_opt.InputError, match=r"has no orbit|have no trajectory"):
            function(ax, instance, plan)
    pyplot.close("all")


@pytest.mark.parametrize(
    "method", ["auto", "beam", "cpsat", "exact", "greedy", "greedy-guarded", "local-search",
               "mcts", "mip", "ortools"],
)  # fmt: skip
def test_every_method_plans_the_toy(method: str) -> None:
    """All planners take given costs, and none exceeds what is proven."""
    if method == "mip":
        pytest.importorskip("highspy")
    instance, best = solved()
    result = adr_opt.solve(instance, method, time_limit=5.0, iterations=20)
    assert result.plan is None or adr_opt.check(instance, result.plan) == ()
    assert result.objective <= best.objective
    if method in ("auto", "cpsat", "exact", "mip"):
        assert result.objective == best.objective


def test_time_is_worth_what_the_tank_is() -> None:
    """Of given costs nobody knows the unit: an hour is worth a share of the tank, without a cap."""
    instance, _ = solved()
    share = 0.8 * 3.0 * 30.0 / 6.0
    assert instance.time_value_m_s_per_h == pytest.approx(share)
    rich = instance.replace(chasers=[instance.chaser.replace(tank=Tank(delta_v_m_s=3e6))])
    assert rich.time_value_m_s_per_h == pytest.approx(1e5 * share)


def test_a_part_of_the_bodies_keeps_its_connections() -> None:
    """A subset of the targets is planned on the connections between them."""
    instance, _ = solved()
    part = instance.part([0, 1, 2])
    assert part.names == ("depot", "mill", "quay")
    result = adr_opt.solve(part, "exact", time_limit=30.0)
    assert result.objective == 2.0
    assert adr_opt.check(part, result.plan) == ()
