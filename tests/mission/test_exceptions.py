"""Limits on exceptions among given connections, against enumeration."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest
from seeds import over_seeds

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.problem import Problem
from adr_opt.problem.given import of_rows

HOUR_S = 3600.0


class Row(NamedTuple):
    """A row of the table."""

    origin: str
    destination: str
    departure_s: float
    arrival_s: float
    delta_v_m_s: float
    exception: bool


def drawn(
    seed: int, *, cost: str = "duration", tank: float = 1e6, required: bool = True
) -> tuple[adr_opt.Instance, list[Row]]:
    """A field of a few targets over connections of which some are exceptions."""
    rng = np.random.default_rng(seed)
    names = [f"t{number}" for number in range(int(rng.integers(2, 5)))]
    start = "anywhere" if rng.random() < 0.4 else {"station": "base"}
    stations = [] if start == "anywhere" else [{"name": "base"}]
    bodies = [*names, *(["base"] if stations else [])]
    rows = []
    for origin, destination in itertools.permutations(bodies, 2):
        if destination == "base":
            continue
        for _ in range(int(rng.integers(1, 5))):
            exception = bool(rng.random() < 0.5)
            departure = HOUR_S * float(rng.integers(0, 12))
            arrival = departure + HOUR_S * float(rng.integers(1, 3 if exception else 7))
            rows.append(
                Row(origin, destination, departure, arrival, float(rng.integers(1, 9)), exception)
            )
    targets = [
        {
            "name": name, "prize": float(rng.integers(1, 4)), "required": required,
            "window_s": [0.0, None if rng.random() < 0.7 else 24 * HOUR_S],
        }
        for name in names
    ]  # fmt: skip
    instance = adr_opt.Instance.model_validate(
        {
            "name": f"drawn-{seed}", "epoch": "2026-05-04T00:00:00Z",
            "stations": stations,
            "targets": targets,
            "chasers": [
                {
                    "name": "one", "start": start, "tank": {"delta_v_m_s": tank},
                    "max_exceptions": int(rng.integers(0, 3)),
                }
            ],
            "mission": {
                "duration_s": 30 * HOUR_S, "service_s": 0.5 * HOUR_S, "refuel_revolutions": 0.0,
            },
            "transfer": {"given": {"file": "rows.parquet"}},
            "objective": {"cost": cost},
        }
    )  # fmt: skip
    columns = {name: [getattr(row, name) for row in rows] for name in Row._fields}
    return instance.with_given(of_rows(columns, instance.names)), rows


def ways(instance: adr_opt.Instance, rows: list[Row]) -> dict[tuple[str, ...], list[float]]:
    """Least (cost) of every order that can be flown, and of its objective, by going through all."""
    chaser, mission = instance.chaser, instance.mission
    most = math.inf if chaser.max_exceptions is None else chaser.max_exceptions
    windows = {target.name: target.window_s for target in instance.targets}
    best: dict[tuple[str, ...], list[float]] = {(): [0.0, 0.0]}

    def go(order: tuple[str, ...], here: str, free: float, spent: float, used: int) -> None:
        found = best.setdefault(order, [math.inf, math.inf])
        if order:
            found[0], found[1] = min(found[0], free), min(found[1], spent)
        for row in rows:
            fits = row.departure_s >= free and spent + row.delta_v_m_s <= chaser.tank.delta_v_m_s
            if row.origin == here and row.destination not in order and fits:
                visit(order, row, spent + row.delta_v_m_s, used + row.exception)

    def visit(order: tuple[str, ...], row: Row, spent: float, used: int) -> None:
        opens, closes = windows[row.destination]
        end = max(row.arrival_s, opens) + mission.service_s
        if used <= most and end <= min(mission.duration_s, closes or math.inf):
            go((*order, row.destination), row.destination, end, spent, used)

    if chaser.is_launched:
        for name in windows:
            visit((), Row("", name, 0.0, 0.0, 0.0, False), 0.0, 0)
    else:
        go((), "base", 0.0, 0.0, 0)
    return best


@over_seeds(range(200), gate=11)
def test_orders_are_scheduled_as_by_enumeration(seed: int) -> None:
    """The schedule of every order has the least cost of all ways to fly it, or none exists."""
    for place, cost in enumerate(("duration", "delta-v")):
        instance, rows = drawn(seed, cost=cost, tank=12.0 if seed % 2 else 1e6)
        problem = Problem(instance)
        known = ways(instance, rows)
        names = [target.name for target in instance.targets]
        for length in range(1, len(names) + 1):
            for order in itertools.permutations(names, length):
                found = problem.missions[0].time(order)
                if order in known:
                    assert found.made == length
                    assert found.cost == pytest.approx(known[order][place])
                else:
                    assert found.made < length


@over_seeds(range(200), gate=11)
def test_the_least_end_is_that_of_enumeration(seed: int) -> None:
    """Where all targets are required, the plan ends as early as any, or there is none."""
    instance, rows = drawn(seed)
    known = ways(instance, rows)
    ends = [cost[0] for order, cost in known.items() if len(order) == len(instance.targets)]
    result = adr_opt.solve(instance, time_limit=math.inf, iterations=3)
    if not ends:
        assert result.status == "infeasible" or result.plan is None
        return
    assert adr_opt.check(instance, result.plan) == ()
    assert result.plan.cost == pytest.approx(min(ends))


@over_seeds(range(100), gate=7)
def test_plans_and_bounds_hold_enumeration_between_them(seed: int) -> None:
    """The best prize lies between that of the plan and the bound, with any tank and cost."""
    cost = ("duration", "delta-v")[seed % 2]
    instance, rows = drawn(seed, cost=cost, tank=10.0, required=False)
    prizes = {target.name: target.prize for target in instance.targets}
    best = max(sum(prizes[name] for name in order) for order in ways(instance, rows))
    for method in ("exact", "lagrangian"):
        assert adr_opt.bound(instance, method, time_limit=60.0, iterations=3).upper_bound >= best
    result = adr_opt.solve(instance, time_limit=60.0, iterations=3)
    assert adr_opt.check(instance, result.plan) == ()
    assert result.objective <= best <= result.upper_bound
    if result.status == "optimal":
        assert result.objective == best


def test_check_counts_exceptions() -> None:
    """A plan that uses more exceptions than allowed is illegal, and only then."""
    for seed in range(40):
        instance, _ = drawn(seed)
        free = instance.replace(chasers=[instance.chaser.replace(max_exceptions=None)])
        plan = adr_opt.solve(free, time_limit=math.inf, iterations=1).plan
        if plan is None:
            continue
        given = instance.given
        assert given is not None
        used = sum(
            bool(given.exception[np.flatnonzero(
                (given.departure == leg.departure_s) & (given.arrival == leg.arrival_s)
                & (given.origin == given.names.index(leg.origin))
                & (given.destination == given.names.index(leg.destination))
            )].all()) for leg in plan.legs if leg.kind == "given"
        )  # fmt: skip
        if used == 0:
            continue
        for most in (used - 1, used):
            limited = instance.replace(chasers=[instance.chaser.replace(max_exceptions=most)])
            said = plan.replace(instance=plan.instance.replace(sha256=limited.sha256))
            rules = {violation.rule for violation in adr_opt.check(limited, said)}
            assert rules == ({"exceptions"} if most < used else set())
        return
    pytest.fail("no drawn plan uses an exception")


def test_what_is_not_set_is_not_there() -> None:
    """Neither files nor digests mention the rule where it is not used."""
    instance, rows = drawn(0)
    free = instance.replace(chasers=[instance.chaser.replace(max_exceptions=None)])
    assert "max_exceptions" not in free.model_dump_json()
    columns = {name: [getattr(row, name) for row in rows] for name in Row._fields}
    without = of_rows({**columns, "exception": [0] * len(rows)}, instance.names)
    columns.pop("exception")
    assert without.sha256 == of_rows(columns, instance.names).sha256
    assert without.exception is None


def test_wrong_rules_are_refused_in_a_sentence() -> None:
    """The limit needs given connections, and the column holds 0 and 1."""
    instance = adr_opt.generate("tiny", seed=0, targets=3)
    with pytest.raises(InputError, match="only given connections have exceptions"):
        instance.replace(chasers=[instance.chaser.replace(max_exceptions=1)])
    given, rows = drawn(0)
    columns = {name: [getattr(row, name) for row in rows] for name in Row._fields}
    with pytest.raises(InputError, match=r"row 0: exception = 2\.0; must be 0 or 1"):
        of_rows({**columns, "exception": [2] * len(rows)}, given.names)
    with pytest.raises(InputError, match="one value for each row"):
        of_rows({**columns, "exception": [1]}, given.names)
    with pytest.raises(InputError, match="does not support max_exceptions"):
        adr_opt.solve(given, "exact")
    with pytest.raises(InputError, match="max_exceptions"):
        adr_opt.solve(given, "beam")


def test_exceptions_are_written_and_read(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """An instance with exceptions comes back from its files."""
    pytest.importorskip("pyarrow")
    instance, _ = drawn(3)
    path = tmp_path / "drawn.json"
    instance.save(path)
    back = adr_opt.load(path)
    assert back.sha256 == instance.sha256
    assert back.given is not None
    assert back.given.sha256 == instance.given.sha256
