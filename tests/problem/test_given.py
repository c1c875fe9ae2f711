"""Costs from elsewhere, given in Python: what is one, what is kept or refused.

See docs/model.md section 9.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import settings
from hypothesis import strategies as st
from toy_roads import (
    DEPARTURES,
    HOUR_S,
    NAMES,
    as_rows,
    compiled_road,
    matrices,
    road,
    roads,
    solved,
)

import adr_opt
from adr_opt.kernels.legs.given import sifted
from adr_opt.problem.given import COLUMNS, among, of_rows
from adr_opt.problem.instance import instance_of
from adr_opt.problem.settings import KeepOutZone, MissionSettings, TransferSettings


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
    st.lists(st.tuples(st.integers(0, 6), st.integers(1, 6), st.integers(0, 5)), max_size=30),
    st.sampled_from([0.0, 1.0, 2.5]),
)
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
    assert np.array_equal(
        np.argsort(found.arrival, kind="stable"), np.argsort(found.crossing, kind="stable")
    )


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
        (lambda rows: rows["origin"].pop(), "column destination must have one value"),
        (lambda rows: rows["origin"].__setitem__(3, "moon"), "'moon' is not a body"),
        (lambda rows: rows["departure_s"].__setitem__(2, np.nan), "departure_s = nan"),
        (lambda rows: rows["departure_s"].__setitem__(2, -5.0), "departure_s = -5.0"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(2, -5.0), "delta_v_m_s = -5.0"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(2, np.inf), "delta_v_m_s = inf"),
        (lambda rows: rows["arrival_s"].__setitem__(0, 0.0), "takes 0.0 s"),
        (lambda rows: rows["destination"].__setitem__(0, "depot"), "ends where it begins"),
        (lambda rows: rows["delta_v_m_s"].__setitem__(0, "dear"), "must be numbers"),
        (lambda rows: rows.update(exception=[0] * 132), "exceptions were removed in 1.1"),
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
    """A body number out of range is refused."""
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
        ((DEPARTURES, duration, nowhere), "cost\\[1, 2, 3\\] is missing and duration is not"),
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
            "keep_out_zones: the paths of given connections",
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


def test_a_part_of_the_bodies_keeps_its_connections() -> None:
    """A subset of the targets is planned on the connections between them."""
    instance, _ = solved()
    part = instance.part([0, 1, 2])
    assert part.names == ("depot", "mill", "quay")
    result = adr_opt.solve(part, "exact", time_limit=30.0)
    assert result.objective == 2.0
    assert adr_opt.check(part, result.plan) == ()


def test_bodies_of_given_connections_do_not_go_unseen() -> None:
    """A copy without a body that connections are given of is refused in a sentence."""
    instance, _ = solved()
    for changes, name in (
        ({"targets": instance.targets[:-1]}, "farm"),
        ({"targets": (), "stations": instance.stations}, "farm"),
    ):
        with pytest.raises(
            adr_opt.InputError, match=rf"^given connections: '{name}' is one of their bodies"
        ):
            instance.replace(**changes)
    others = instance.with_given(among(instance.given, NAMES[:-1]))
    assert others.replace(targets=instance.targets[:-1]).names == NAMES[:-1]
    renamed = instance.chaser.replace(name="lorry", start={"station": "depot"})
    assert instance.replace(chasers=(renamed,)).given is instance.given
    start = {"orbit": adr_opt.generate("tiny", 0).targets[0].orbit}
    own = roads(chasers=[instance.chaser.replace(start=start)])
    row = {name: values[:1] for name, values in as_rows().items()} | {"origin": ["van"]}
    there = adr_opt.Timetable.from_connections(own, row).instance
    with pytest.raises(adr_opt.InputError, match=r"'van' is one of their bodies"):
        there.replace(chasers=(own.chaser.replace(name="lorry"),))


def test_a_limit_of_exceptions_is_refused() -> None:
    """A file with the limit that 1.1 removed is refused in a sentence that says so."""
    content = roads().model_dump(mode="json")
    content["chasers"][0]["max_exceptions"] = None
    with pytest.raises(adr_opt.InputError, match=r"chasers\[0\].*removed in 1\.1; leave it out"):
        instance_of(content)
