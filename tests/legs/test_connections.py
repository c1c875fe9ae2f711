"""Connections: all transfers of a pair that may be worth waiting for, and no others."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from rows import changed

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, TURN_RAD
from adr_opt.common.errors import InputError
from adr_opt.kernels.legs import co_elliptic, connections
from adr_opt.kernels.legs import zones as keep_out
from adr_opt.legs.timetable import Timetable

DAY_S = 86400.0


def every_sequence(origin, destination, extra, rule, duration):
    """All sequences (k, m) of all departure events as rows (departure, arrival, ΔV, k)."""
    pair = co_elliptic.prepare(origin, destination, extra, rule, 0.0)
    approach = rule.approach_revolutions * TURN_RAD / pair.rate_j
    first, half_turns = co_elliptic.first_departure(pair)
    found = []
    number = 0
    while (departure := first + number * math.pi / pair.rate_i) <= duration:
        lead = co_elliptic.target_lead(pair, departure, half_turns + number)
        phase = 3.0 * math.pi - lead + rule.standoff / pair.radius_j
        longest = pair.longest + rule.max_phasing_revolutions * pair.longest_lap
        s = math.ceil((pair.shortest * pair.rate_j - phase) / TURN_RAD)
        while (time := (phase + TURN_RAD * s) / pair.rate_j) <= longest:
            s += 1
            arrival = departure + time + approach
            for k in range(rule.max_phasing_revolutions + 1):
                low = pair.shortest + k * pair.shortest_lap
                high = pair.longest + k * pair.longest_lap
                if not low <= time <= high or arrival > duration:
                    continue
                r = co_elliptic.phasing_radius(pair, rule, k, time)
                if not keep_out.is_blocked(pair, rule, k, r, departure):
                    cost = co_elliptic.leg_delta_v(pair, rule, k, r, departure, time, pair.turn)
                    found.append((departure, arrival, cost, k))
        number += 1
    return np.array(found).reshape(-1, 4)


def sifted(rows, resolution):
    """What is left when each is compared with all that were kept, best first."""
    order = np.lexsort((rows[:, 2], np.round(rows[:, 1], 3), -rows[:, 0]))
    kept: list[np.ndarray] = []
    for row in rows[order]:
        better = (
            other[0] >= row[0] and other[1] <= row[1] + 1e-6 and other[2] <= row[2] + resolution
            for other in kept
        )
        if not any(better):
            kept.append(row)
    return np.array(sorted(kept, key=lambda row: (row[0], row[1]))).reshape(-1, 4)


def random_cases(count):
    """Pairs of random fields with random settings, zones and other planes."""
    rng = np.random.default_rng(0)
    fields = [adr_opt.generate("tiny", seed, zones=zones) for seed in range(4) for zones in (0, 3)]
    for number in range(count):
        instance = fields[number % len(fields)]
        orbits = instance.orbits()
        i, j = rng.choice(len(orbits), 2, replace=False)
        origin, destination = orbits[i], orbits[j]
        if rng.random() < 0.3:
            destination = changed(destination, radius=rng.uniform(-2e5, 8e5))
        if rng.random() < 0.3:
            destination = changed(destination, raan=rng.uniform(-1.0, 1.0))
        rule = instance.transfer_rule()._replace(
            first_leg_fraction=float(rng.choice([0.0, 0.5, 0.75, 1.0])),
            standoff=float(rng.choice([0.0, 1e3, 5e4])),
            max_phasing_revolutions=int(rng.choice([0, 1, 5, 12])),
            min_radius=EARTH_RADIUS_M + float(rng.choice([200e3, 500e3])),
            max_radius=EARTH_RADIUS_M + float(rng.choice([900e3, 2000e3, 9000e3])),
        )
        yield origin, destination, rule, float(rng.choice([0.0, 0.1, 5.0]))


def test_connections_are_what_is_left_of_all_sequences():
    """The quick sifting keeps exactly those that comparing every sequence with every other does."""
    kept = 0
    for origin, destination, rule, resolution in random_cases(120):
        expected = sifted(every_sequence(origin, destination, 3.0, rule, 0.7 * DAY_S), resolution)
        found = np.column_stack(
            connections.of_pair(origin, destination, 3.0, rule, 0.7 * DAY_S, resolution)[:4]
        )
        case = (origin, destination, rule, resolution)
        assert found.shape == expected.shape, case
        np.testing.assert_allclose(found, expected, atol=1e-6, err_msg=str(case))
        kept += len(found)
    assert kept > 1500


def test_those_of_a_crossing_arrive_together():
    """Connections of a pair have one crossing if and only if they arrive at one time."""
    for origin, destination, rule, resolution in random_cases(30):
        found = connections.of_pair(origin, destination, 3.0, rule, 0.7 * DAY_S, resolution)
        half_turn = math.pi / co_elliptic.prepare(origin, destination, 3.0, rule, 0.0).rate_j
        if found.departure.size:
            after = (found.arrival - found.arrival[0]) / half_turn
            crossings = found.crossing - found.crossing[0]
            np.testing.assert_allclose(after, crossings, rtol=0.0, atol=1e-6)
            assert found.crossing.min() >= 1


@pytest.mark.parametrize("zones", [0, 3])
def test_a_longer_mission_has_the_same_connections_before_the_end_of_a_shorter_one(zones):
    """What arrives later dominates nothing that arrives before, whatever number of events."""
    instance = adr_opt.generate("nominal", 1, targets=5, zones=zones)
    orbits, rule = instance.orbits(), instance.transfer_rule()
    for i, j in itertools.permutations(range(len(orbits)), 2):
        short, long = (
            connections.of_pair(orbits[i], orbits[j], 0.0, rule, days * DAY_S, 0.0)
            for days in (6.0, 30.0)
        )
        before = long.arrival <= 6.0 * DAY_S
        events = np.unique(long.departure).size
        assert events > 2 * connections.BLOCK
        assert short.departure.size > 100
        for name in ("departure", "arrival", "delta_v", "revolutions"):
            np.testing.assert_array_equal(getattr(long, name)[before], getattr(short, name))


@pytest.mark.parametrize("since_s", [-1.0, 0.2 * DAY_S, 0.69 * DAY_S, 2.0 * DAY_S])
def test_connections_from_some_time_on_are_those_of_all_that_leave_later(since_s):
    """Who asks for what leaves from a time on gets all of it unchanged, and little besides."""
    spared = 0
    for origin, destination, rule, resolution in random_cases(60):
        pair = origin, destination, 3.0, rule, 0.7 * DAY_S, resolution
        whole, late = connections.of_pair(*pair), connections.of_pair(*pair, since_s)
        for name in whole._fields:
            expected = getattr(whole, name)[whole.departure >= since_s]
            found = getattr(late, name)[late.departure >= since_s]
            np.testing.assert_array_equal(found, expected, err_msg=name)
        half_turn = math.pi / co_elliptic.prepare(origin, destination, 3.0, rule, 0.0).rate_i
        assert (late.departure >= since_s - 3.0 * half_turn).all()
        spared += whole.departure.size - late.departure.size
    assert (spared > 0) == (since_s > 0.0)


@pytest.fixture(scope="module")
def timetable() -> Timetable:
    return Timetable(adr_opt.generate("tiny", 2, zones=2))


def test_waiting_never_does_worse_than_the_next_event(timetable):
    """At any ready time some connection arrives no later and costs no more than what plans fly."""
    rng = np.random.default_rng(1)
    bodies = len(timetable.names)
    flown = 0
    for time in rng.uniform(0.0, DAY_S, 60):
        i, j = rng.choice(bodies, 2, replace=False)
        delta_v, arrival = timetable.lookup(i, j, time)
        if arrival > timetable.instance.mission.duration_s:
            continue
        found = timetable.connections(i, j, time, resolution_m_s=0.0)
        assert (found.departure >= time).all()
        assert ((found.arrival <= arrival + 1e-6) & (found.delta_v <= delta_v + 1e-6)).any()
        flown += 1
    assert flown > 30


def test_a_later_start_leaves_the_later_connections(timetable):
    """Connections after a time are those of the whole mission that depart then or later."""
    whole = timetable.connections("station", timetable.names[1])
    later = timetable.connections("station", timetable.names[1], after=float(whole.departure[5]))
    first = int(np.searchsorted(whole.departure, whole.departure[5]))
    np.testing.assert_array_equal(later.delta_v, whole.delta_v[first:])
    assert timetable.connections(1, 1).departure.size == 0


@pytest.mark.parametrize(
    ("choose", "key"),
    [
        ("earliest", lambda dv, duration: (duration, dv)),
        ("cheapest", lambda dv, duration: (dv, duration)),
        (75.0, lambda dv, duration: (dv + 75.0 * duration / 3600.0, duration)),
        ("20", lambda dv, duration: (dv + 20.0 * duration / 3600.0, duration)),
    ],
)
def test_matrices_hold_the_chosen_connection(timetable, choose, key):
    """Each cell is the least of all connections from the ready time on, by the choice made."""
    times = [0.0, 5000.0, 60000.0, 1.4 * DAY_S]
    matrices = timetable.matrices(times, choose)
    bodies = len(timetable.names)
    for t, time in enumerate(times):
        for i in range(bodies):
            for j in range(bodies):
                cell = (matrices.delta_v[t, i, j], matrices.duration[t, i, j])
                if i == j:
                    assert cell == (0.0, 0.0)
                    continue
                found = timetable.connections(i, j, time)
                pairs = zip(found.delta_v, found.arrival - time, strict=True)
                least = min((key(*pair) for pair in pairs), default=(math.inf, math.inf))
                assert key(*cell) == pytest.approx(least)
    assert np.isinf(matrices.delta_v[3]).any()


@pytest.mark.parametrize("choose", ["quickest", -1.0, math.nan, "1e400"])
def test_other_choices_are_refused(timetable, choose):
    """A choice that there is not is refused in one sentence."""
    with pytest.raises(InputError, match="choose = "):
        timetable.matrices([0.0], choose)


@pytest.mark.parametrize(("after", "resolution"), [(-1.0, 0.1), (math.inf, 0.1), (0.0, -0.1)])
def test_times_and_resolutions_that_make_no_sense_are_refused(timetable, after, resolution):
    """A negative or infinite number is refused."""
    with pytest.raises(InputError, match="must be a finite number"):
        timetable.connections(0, 1, after, resolution_m_s=resolution)


FIELDS = {
    "two-body": lambda: adr_opt.generate("tiny", 0, targets=4),
    "drifting": lambda: adr_opt.generate("sso", 0, targets=3).with_limits(duration_s=20 * DAY_S),
    "launched": lambda: adr_opt.generate("removal", 0, targets=3, chasers=2),
    "nothing": lambda: adr_opt.generate("tiny", 0, targets=0),
}


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize(("after", "resolution"), [(0.0, None), (30_000.0, 0.0), (5_000.0, 25.0)])
def test_all_connections_are_those_of_the_pairs(field, after, resolution):
    """The arrays of the whole field hold, pair by pair, what each pair has by itself."""
    table = Timetable(FIELDS[field]())
    found = table.all_connections(after, resolution_m_s=resolution)
    assert found.names == table.names
    at = 0
    for i, j in itertools.permutations(range(len(table.names)), 2):
        pair = table.connections(i, j, after, resolution_m_s=resolution)
        rows = slice(at, at := at + pair.departure.size)
        assert (found.origin[rows] == i).all()
        assert (found.destination[rows] == j).all()
        for name in ("departure", "arrival", "delta_v", "revolutions"):
            np.testing.assert_array_equal(getattr(found, name)[rows], getattr(pair, name))
    assert at == len(found) == found.origin.size == found.destination.size
    kinds = [column.dtype.str[1:] for column in found.columns().values()]
    assert kinds == ["i4", "i4", "f8", "f8", "f8", "i1"]


def test_all_connections_make_the_same_timetable_again():
    """Their columns are what `from_connections` takes: the same field, its costs given."""
    instance = adr_opt.generate("tiny", 0, targets=4)
    table = Timetable(instance)
    found = table.all_connections()
    columns = found.columns()
    given = Timetable.from_connections(
        instance, {k: v for k, v in columns.items() if k[:3] != "rev"}
    )
    for i, j in itertools.permutations(range(5), 2):
        ours, theirs = table.connections(i, j), given.connections(i, j)
        np.testing.assert_array_equal(ours.departure, theirs.departure)
        np.testing.assert_array_equal(ours.delta_v, theirs.delta_v)
    assert repr(found).startswith(f"<AllConnections: {len(found)}, of 20 pairs, ")


@pytest.mark.parametrize(("after", "resolution"), [(-1.0, None), (math.nan, None), (0.0, -0.1)])
def test_all_connections_refuse_what_makes_no_sense(after, resolution):
    """A time or a resolution that is negative or no number is refused before anything is done."""
    with pytest.raises(InputError, match="must be a finite number ≥ 0"):
        Timetable(adr_opt.generate("tiny", 0, targets=2)).all_connections(
            after, resolution_m_s=resolution
        )
