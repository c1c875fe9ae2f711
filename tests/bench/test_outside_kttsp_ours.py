"""Our tours of ESA's travelling salesperson, and what is proven of them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from from_outside import DATA, external
from outside.kttsp import (
    arrivals,
    boxes,
    cells,
    costs,
    drawing,
    kepler,
    known,
    ours,
    proof,
    sampling,
    spans,
    write_instance,
)
from outside.kttsp.reading import Problem, read_problem, read_tour
from outside.kttsp.scoring import score

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError

FOLDER = DATA / "kttsp"

pytestmark = external("kttsp")

PAIRS = [(8, 39, 100.0), (33, 14, 100.0), (16, 27, 100.0), (7, 8, 600.0), (27, 14, 600.0)]
"""Neighbours high up, two in one plane, low ones, a jump, and from low to high."""


@pytest.fixture(scope="module")
def problem():
    return read_problem(FOLDER / "small.kttsp")


def some(problem, places):
    """The instance of some targets."""
    values = vars(problem) | {"name": "some", "elements": problem.elements[list(places)]}
    return Problem(**values)


def legs(problem, i, j, limit, count, seed):
    """Legs within a limit at random times: departures and arrivals [s]."""
    rng = np.random.default_rng(seed)
    departures, flights = rng.uniform(0.0, 20.0, (count, 1)), rng.uniform(0.01, 6.0, (count, 50))
    found = []
    for departure, flight in zip(departures, flights, strict=True):
        leaves, lands, _ = costs.connections(problem, i, j, departure, np.sort(flight), limit)
        found += list(zip(leaves, lands, strict=True))
    return found


@pytest.mark.parametrize(("i", "j", "limit"), PAIRS)
def test_no_box_of_a_leg_is_ruled_out(problem, i, j, limit):
    """A box around a leg within the limit counts as possible, however wide it is."""
    one, other = problem.elements[i], problem.elements[j]
    normals = spans.normal_of(one), spans.normal_of(other)
    between = math.acos(min(float(normals[0] @ normals[1]), 1.0))
    rng = np.random.default_rng(1)
    rows = np.empty((1, 10)), np.empty((1, 10))
    met = 0
    for leaves, lands in legs(problem, i, j, limit, 60, 2):
        wide, long = 10.0 ** rng.uniform(0.0, 3.5, 2)
        for elements, time, half, row in zip(
            (one, other), (leaves, lands), (wide, long), rows, strict=True
        ):
            spans.spans(elements, np.array([time + rng.uniform(-1.0, 1.0) * half]), half, row)
        flight = lands - leaves
        low, high = max(flight - 2.0 * (wide + long), 86.4), flight + 2.0 * (wide + long)
        assert boxes.possible(rows[0][0], rows[1][0], *normals, between, low, high, limit)
        met += 1
    assert met > 50


def crossings(elements, normal, until_s):
    """Times at which a target crosses a plane through the centre [s]."""
    times = np.arange(0.0, until_s, 60.0)
    heights = kepler.states_of(elements, times)[0] @ normal
    found = []
    for k in np.flatnonzero(heights[:-1] * heights[1:] < 0.0):
        low, high = times[k], times[k + 1]
        for _ in range(40):
            middle = 0.5 * (low + high)
            height = float(kepler.states_of(elements, np.array([middle]))[0][0] @ normal)
            low, high = (middle, high) if height * heights[k] > 0.0 else (low, middle)
        found.append(low)
    return np.array(found)


@pytest.mark.parametrize(("i", "j"), [(20, 11), (16, 24), (4, 6), (14, 32), (27, 14)])
def test_arcs_in_line_with_the_centre_are_told_by_their_cost(problem, i, j):
    """Boxes about both nodes hold arcs in any plane, and mostly none of nine tenths of the cost."""
    one, other = problem.elements[i], problem.elements[j]
    normals = spans.normal_of(one), spans.normal_of(other)
    between = math.acos(float(normals[0] @ normals[1]))
    # Who is in the other one's plane is on the line in which both planes meet.
    leaves = crossings(one, normals[1], 5.0 * DAY_S)
    lands = crossings(other, normals[0], 8.0 * DAY_S)
    rng = np.random.default_rng(5)
    rows = np.empty((1, 10)), np.empty((1, 10))
    met = ruled_out = 0
    for leave, land in itertools.product(leaves, lands):
        if not 0.05 * DAY_S < land - leave < 3.0 * DAY_S:
            continue
        half = 10.0 ** rng.uniform(-1.0, 1.5)
        shifts = half * rng.uniform(-1.0, 1.0, (40, 2))
        least = min(
            costs.delta_v_m_s(
                problem, i, j, (leave + late) / DAY_S, (land - leave + later - late) / DAY_S
            )
            for late, later in shifts
        )
        for elements, time, row in zip((one, other), (leave, land), rows, strict=True):
            spans.spans(elements, np.array([time]), half, row)
        seconds = land - leave - 2.0 * half, land - leave + 2.0 * half
        box = rows[0][0], rows[1][0], *normals, between, *seconds
        assert boxes.possible(*box, least * (1.0 + 1e-9))
        met += 1
        ruled_out += not boxes.possible(*box, 0.9 * least)
    assert met >= 10
    assert ruled_out > 0.9 * met


def test_no_arc_is_slower_than_the_slowest():
    """Whatever angles planes have, an arc within the limit is no slower than a box says."""
    rng = np.random.default_rng(9)
    near = 0
    for _ in range(4000):
        (v, w), limit = rng.uniform(300.0, 2000.0, 2), rng.choice([100.0, 600.0])
        angles = rng.uniform(0.0, 0.6, 2)
        across = v * math.sin(angles[0]) + w * math.sin(angles[1])
        if across > limit:
            continue
        # A box knows the least of each angle, and of their sum, from which the budget follows.
        first, second = angles * rng.uniform(size=2)
        both = max(angles.sum() * rng.uniform(0.8, 1.0), first + second)
        sums = [
            v * math.sin(first) + w * math.sin(second),
            v * math.sin(first) + w * math.sin(both - first),
            v * math.sin(both - second) + w * math.sin(second),
        ]
        own, budget = (math.sqrt(limit**2 - x**2) for x in (sums[0], min(sums[1:])))
        found = boxes._slowest(v, math.cos(first), w * math.sin(second), own, budget, limit)
        slowest = max(v * math.cos(angles[0]) - math.sqrt(limit**2 - across**2), 0.0)
        assert found <= slowest + 1e-9
        near += found > 0.95 * slowest > 0.0
    assert near > 100


@pytest.mark.parametrize(("i", "j", "limit"), PAIRS)
def test_boxes_are_ruled_out_where_legs_are_dear(problem, i, j, limit):
    """Of small boxes around legs that cost half as much again most are ruled out."""
    one, other = problem.elements[i], problem.elements[j]
    normals = spans.normal_of(one), spans.normal_of(other)
    between = math.acos(min(float(normals[0] @ normals[1]), 1.0))
    rng = np.random.default_rng(3)
    rows = np.empty((1, 10)), np.empty((1, 10))
    ruled_out = tried = 0
    for leaves, flight in zip(rng.uniform(0, 20, 400), rng.uniform(0.2, 5, 400), strict=True):
        if not costs.delta_v_m_s(problem, i, j, leaves, flight) > 1.5 * limit:
            continue
        spans.spans(one, np.array([leaves * DAY_S]), 20.0, rows[0])
        spans.spans(other, np.array([(leaves + flight) * DAY_S]), 20.0, rows[1])
        seconds = flight * DAY_S - 40.0, flight * DAY_S + 40.0
        tried += 1
        ruled_out += not boxes.possible(rows[0][0], rows[1][0], *normals, between, *seconds, limit)
    assert tried > 50
    assert ruled_out > 0.9 * tried


@pytest.mark.parametrize(("i", "j", "limit"), PAIRS)
def test_nobody_arrives_before_it_is_proven(problem, i, j, limit):
    """No leg within the limit arrives before what cells prove for its departure."""
    one, other = problem.elements[i], problem.elements[j]
    normals = spans.normal_of(one), spans.normal_of(other)
    between = math.acos(min(float(normals[0] @ normals[1]), 1.0))
    step, count = 864.0, 2000
    before = np.zeros(0)
    for depth in (0, 2):
        out = np.arange(count) * step + 86.4
        cells.first_arrivals(
            one, other, *normals, between, step, 5, depth, 86.4, 10 * DAY_S, limit, 0, count,
            np.full(count, np.inf), out,
        )  # fmt: skip
        assert (np.diff(out) >= 0.0).all()
        for leaves, lands in legs(problem, i, j, limit, 200, 4):
            assert out[int(leaves / step)] <= lands
        # Smaller parts prove more.
        assert not before.size or (out >= before).all()
        before = out


@pytest.mark.parametrize(("i", "j", "limit"), PAIRS)
def test_within_says_what_costs_say(problem, i, j, limit):
    """An arc within a limit is found exactly where the cheapest one is within it."""
    rng = np.random.default_rng(7)
    one, other = problem.elements[i], problem.elements[j]
    met = 0
    for leaves, flight in zip(rng.uniform(0, 50, 500), rng.uniform(0.1, 8, 500), strict=True):
        times = np.array([leaves * DAY_S]), np.array([(leaves + flight) * DAY_S])
        r_1, v_1 = kepler.states_of(one, times[0])
        r_2, v_2 = kepler.states_of(other, times[1])
        cost = costs.delta_v_m_s(problem, i, j, leaves, flight)
        if abs(cost - limit) < 1e-6:
            continue
        seconds = times[1][0] - times[0][0]
        found = arrivals.within(r_1[0], v_1[0], r_2[0], v_2[0], seconds, limit)
        assert found == (cost <= limit)
        met += found
    assert met


def test_a_leg_ruled_out_by_momentum_is_dear(problem):
    """No leg costs less than the change of angular momentum does."""
    rng = np.random.default_rng(11)
    for _ in range(200):
        i, j = rng.choice(problem.targets, 2, replace=False)
        least = spans.least_cost_m_s(problem.elements[i], problem.elements[j])
        cost = costs.delta_v_m_s(problem, i, j, rng.uniform(0, 50), rng.uniform(0.1, 5))
        assert cost >= least


def test_a_leg_that_the_contest_accepts_is_none(problem):
    """What its solver takes for a leg of 52 m/s costs five times as much by the cheapest arc."""
    assert costs.delta_v_m_s(problem, 45, 28, 94.085641, 1.144852) > 250.0


def test_sampled_rows_are_legs_in_time(problem):
    """Rows cost what they say, within their limit; of a pair later ones arrive later."""
    few = some(problem, (34, 23, 46, 18))
    grid = sampling.Grid(3.0, (0.05, 0.1), (0.05, 0.1), (2.0, 1.0), (3, 3))
    rows = sampling.sampled(few, grid)
    assert set(rows.exception.tolist()) == {False, True}
    for row in range(0, rows.departure.size, 7):
        flight = (rows.arrival[row] - rows.departure[row]) / DAY_S
        pair = int(rows.origin[row]), int(rows.destination[row])
        cost = costs.delta_v_m_s(few, *pair, rows.departure[row] / DAY_S, flight)
        assert cost == pytest.approx(rows.delta_v[row], abs=1e-6)
        assert cost <= sampling.limit_m_s(few, int(rows.exception[row]))
    pair = (rows.exception * 4 + rows.origin) * 4 + rows.destination
    same = np.diff(pair) == 0
    assert (np.diff(rows.departure)[same] > 0.0).all()
    assert (np.diff(rows.arrival)[same] > 0.0).all()
    near = sampling.sampled(few, grid, visits_d=np.ones(4), within_d=0.25)
    assert 0 < near.departure.size < rows.departure.size
    assert (np.abs(near.departure / DAY_S - 1.0) <= 0.25).all()


def test_an_instance_is_written_planned_and_scored(problem, tmp_path, capsys):
    """A field is sampled into an instance that solve plans; its tour breaks no rule."""
    few = some(problem, (34, 23, 46, 18))
    out, plan, tour, file = (
        tmp_path / name for name in ("moon.json", "plan.json", "tour.json", "few.kttsp")
    )
    lines = [" ".join(map(repr, row)) for row in few.elements.tolist()]
    file.write_text("\n".join(["p kttsp 0.0 0.001 200.0 100.0 600.0 2", *lines]), encoding="utf-8")
    field = ["--field", str(file)]
    grid = "--end 30 --step 0.05 0.05 --arrival 0.05 0.05 --flight 6 2 --nearest 4 4"
    assert write_instance.main([str(out), *field, *grid.split()]) == 0
    assert "4 targets" in capsys.readouterr().out
    result = adr_opt.solve(adr_opt.load(out), time_limit=60.0)
    assert result.plan is not None
    assert result.plan.cost_status == "optimal"
    result.plan.save(plan)
    assert write_instance.main([*field, "--score", str(plan), "--tour", str(tour)]) == 0
    said = capsys.readouterr().out
    assert said.count("0 rules broken") == 2
    assert score(few, read_tour(tour, 4)).duration_d <= result.plan.cost / DAY_S + 1e-6
    assert drawing.drawn(60, 3).targets == 60
    for wrong in ([str(out)], [str(tmp_path / "moon.txt"), *field], ["--draw", "1"]):
        assert write_instance.main(wrong) == 2
        assert capsys.readouterr().err.count("\n") == 1


def by_all_orders(problem):
    """The best of all orders and exceptions, every leg flown as early as it can be."""
    best = math.inf
    for order in itertools.permutations(range(problem.targets)):
        ends = {0: 0.0}
        for i, j in itertools.pairwise(order):
            then: dict[int, float] = {}
            for used, ready in ends.items():
                for kind in range(2):
                    if used + kind > problem.exceptions:
                        continue
                    _, end = arrivals.earliest_from(
                        problem.elements[i], problem.elements[j], ready * DAY_S, 0.02 * DAY_S,
                        86.4, (ready + 10.0) * DAY_S, ours.limit_m_s(problem, kind),
                    )  # fmt: skip
                    then[used + kind] = min(then.get(used + kind, math.inf), end / DAY_S)
            ends = then
        best = min(best, *ends.values())
    return best


def test_bound_and_plan_hold_the_best_of_all_orders(problem):
    """On three targets the best of all orders lies between the bound and the plan, closely."""
    few = Problem(**(vars(some(problem, (34, 23, 46))) | {"exceptions": 1}))
    made = ours.plan(few, end_d=20.0)
    assert score(few, made.tour).violations == ()
    assert score(few, made.tour).duration_d == made.duration_d
    proven = proof.bound(few, made.duration_d)
    best = by_all_orders(few)
    assert proven.duration_d <= best + 1e-6
    assert best - 1e-2 <= made.duration_d
    assert made.duration_d - proven.duration_d < 0.1


def test_a_proof_goes_on_from_its_cells(problem, tmp_path):
    """From cells that were kept the same bound follows as at once; other files are refused."""
    few = Problem(**(vars(some(problem, (34, 23, 46))) | {"exceptions": 1}))
    made = ours.plan(few, end_d=20.0)
    whole = proof.bound(few, made.duration_d)
    path = tmp_path / "cells"
    steps = [proof.bound(few, made.duration_d, path=path, time_limit_s=0.0) for _ in range(2)]
    assert steps[1].rounds > steps[0].rounds
    assert proof.bound(few, made.duration_d, path=path).duration_d >= whole.duration_d - 0.1
    assert [one.name for one in tmp_path.iterdir()] == ["cells"]
    with pytest.raises(InputError, match="cells of another proof"):
        proof.bound(few, made.duration_d + 1.0, path=path)
    moved = Problem(**(vars(few) | {"elements": few.elements * (1.0 + 1e-9)}))
    with pytest.raises(InputError, match="cells of another proof"):
        proof.bound(moved, made.duration_d, path=path)
    assert proof.bound(few, made.duration_d - 1.0, path=path).duration_d < made.duration_d
    path.write_text("nothing", encoding="utf-8")
    with pytest.raises(InputError, match="no cells of a proof"):
        proof.bound(few, made.duration_d, path=path)


def test_our_best_tour_is_legal(problem, tmp_path):
    """The tour that is kept breaks no rule and is shorter than the best published one."""
    tour = known.best_known(problem)
    assert tour is not None
    known.write_tour(tmp_path / "tour.json", problem, tour)
    again = read_tour(tmp_path / "tour.json", problem.targets)
    assert score(problem, again) == score(problem, tour)
    found = score(problem, tour)
    assert found.violations == ()
    assert found.duration_d < known.PUBLISHED_D
