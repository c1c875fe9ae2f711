"""The timetable: exact at every time, not only at its events."""

from __future__ import annotations

import itertools
import math

import every_sequence
import numpy as np
import pytest
from hand_made import PERIOD_S, hand_made
from one_window import one_window
from random_rules import all_filled, random_mission
from seeds import over_kinds

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M, SLACK_M_S, SLACK_S
from adr_opt.kernels.legs import co_elliptic, sequences
from adr_opt.kernels.orbits import columns, ephemeris
from adr_opt.kernels.tables import timetable as kernels
from adr_opt.legs import timetable
from adr_opt.problem.settings import KeepOutZone


@pytest.fixture(scope="module")
def table() -> adr_opt.Timetable:
    return adr_opt.Timetable(adr_opt.generate("tiny", 3, zones=3))


@over_kinds("seeds", drawn=(range(40), 10))
def test_entries_are_the_best_of_all_that_leave_then_or_later(seeds):
    """Each entry is the least ΔV + w · (time until service) of all (k, m) of this and later events.

    Those that zones block are not among them, nor those whose service would end too late, nor
    those that leave before a chaser is there.
    """
    waits = finite = early = 0
    for seed in seeds:
        # Where what was spent before the start is charged, connections are listed.
        instance = all_filled(random_mission(seed))
        rng = np.random.default_rng(seed)
        time_value = float(rng.choice([0.0, 20.0, 110.0, 1000.0]))
        made = adr_opt.Timetable(instance, time_value_m_s_per_h=time_value)
        limits = made.limits
        for i, j in itertools.permutations(range(len(made.names)), 2):
            events = every_sequence.of_pair(instance, i, j, -SLACK_S, limits.duration)
            assert kernels.events(made.table, i, j) == len(events)
            best, flown = math.inf, (math.inf, math.inf)
            for event in range(len(events) - 1, -1, -1):
                own = math.inf
                too_early = kernels.departure_at(made.table, i, j, event) < limits.ready - SLACK_S
                early += too_early
                for sequence in () if too_early else events[event]:
                    begin = max(sequence.arrival, limits.windows.opening[j])
                    if begin > limits.windows.closing[j]:
                        continue
                    own = min(own, sequence.delta_v + time_value / 3600.0 * begin)
                    if own < best:
                        best, flown = own, (sequence.delta_v, sequence.arrival)
                delta_v, arrival = kernels.entry_at(made.table, i, j, event)
                if math.isinf(best):
                    assert (delta_v, arrival) == (math.inf, math.inf)
                    continue
                finite += 1
                waits += own > best
                stated = delta_v + time_value / 3600.0 * max(arrival, limits.windows.opening[j])
                assert stated == pytest.approx(best, abs=1e-5), (i, j, event)
                # Where two are as good, either may be held; both lie on the same line of cost.
                if abs(arrival - flown[1]) < 1.0:
                    assert delta_v == pytest.approx(flown[0], abs=1e-5), (i, j, event)
                assert max(arrival, limits.windows.opening[j]) <= limits.windows.closing[j]
    assert finite > 1000
    assert waits > 50
    assert early > 20


def test_all_events_of_the_mission_are_there(table):
    """Events start within half a period, end at the deadline, and none is left out between."""
    duration = table.instance.mission.duration_s
    for i in range(len(table.names)):
        for j in range(len(table.names)):
            if i == j:
                continue
            count = kernels.events(table.table, i, j)
            spacing = float(table.table.spacing[i])
            assert 0.0 <= kernels.departure_at(table.table, i, j, 0) < spacing
            assert kernels.departure_at(table.table, i, j, count - 1) <= duration
            assert kernels.departure_at(table.table, i, j, count) > duration


def test_lookup_takes_the_next_event(table):
    """A lookup gives the first event at or after its time, and one that is just missed by rounding.

    Up to the slack of the model, and not beyond it.
    """
    rng = np.random.default_rng(0)
    duration = table.instance.mission.duration_s
    for _ in range(3000):
        i, j = rng.choice(len(table.names), 2, replace=False)
        count = kernels.events(table.table, i, j)
        times = np.array([kernels.departure_at(table.table, i, j, m) for m in range(count)])
        m = int(rng.integers(count))
        late = times[m] + np.array([0.0, 1e-10, 0.9 * SLACK_S, 1.1 * SLACK_S])
        for time in (rng.uniform(0, duration), *late):
            expected = int(np.searchsorted(times, time - SLACK_S, side="left"))
            assert kernels.next_event(table.table, i, j, time) == expected
            found = table.lookup(int(i), int(j), time)
            if expected == count:
                assert found == (math.inf, math.inf)
            else:
                assert found == kernels.entry_at(table.table, i, j, expected)


def test_what_lies_on_a_limit_is_not_left_to_rounding():
    """A sequence exactly at the highest altitude is flown, and one at the edge of a zone is not.

    At every event, whatever the last digits of its time are.
    """
    instance = hand_made()
    level = instance.transfer.replace(
        standoff_m=0.0, max_altitude_m=700e3, max_phasing_revolutions=0
    )
    table = adr_opt.Timetable(instance.replace(transfer=level)).table
    for i, j in itertools.permutations(range(5), 2):
        for event in range(kernels.events(table, i, j)):
            departure = kernels.departure_at(table, i, j, event)
            _, arrival = kernels.entry_at(table, i, j, event)
            # The flight and the service together take three periods.
            if departure + 3.0 * PERIOD_S > instance.mission.duration_s:
                assert arrival == math.inf
            else:
                assert arrival == pytest.approx(departure + 2.0 * PERIOD_S, abs=1e-3)

    behind = instance.targets[0].orbit.replace(true_anomaly_deg=340.0)
    instance = instance.replace(targets=(instance.targets[0].replace(orbit=behind),))
    elements, rule = instance.orbits(), instance.transfer_rule()
    pair = co_elliptic.prepare(elements[0], elements[1], 0.0, rule, 0.0)
    first, half_turns = co_elliptic.first_departure(pair)
    lead = co_elliptic.target_lead(pair, first, half_turns)
    chosen = sequences.best_sequence(pair, rule, first, lead, one_window(), 0, first)
    radius = chosen.phasing_radius
    edge = KeepOutZone(
        min_altitude_m=radius - EARTH_RADIUS_M,
        max_altitude_m=radius - EARTH_RADIUS_M + 1e3,
        start_s=0.0,
        end_s=instance.mission.duration_s,
    )
    table = adr_opt.Timetable(instance.replace(keep_out_zones=(edge,))).table
    open_table = adr_opt.Timetable(instance).table
    legs = slice(0, 20)
    assert radius > elements[0, 0] + 10e3
    assert np.ptp(open_table.entries[0, legs, 1, 0]) < 1e-6
    assert np.ptp(table.entries[0, legs, 1, 0]) < 1e-6
    assert abs(table.entries[0, 0, 1, 0] - open_table.entries[0, 0, 1, 0]) > 1.0


def test_the_clock_of_a_year_is_that_of_the_angles():
    """After a year departures and arrivals are still those of the angles, to 1/50 of the slack."""
    instance = adr_opt.generate("tiny", 3, targets=2)
    made = adr_opt.Timetable(instance.with_limits(duration_s=365.0 * 86400.0))
    table, limits = made.table, made.limits
    elements, rule = instance.orbits(), instance.transfer_rule()
    for i, j in itertools.permutations(range(3), 2):
        pair = co_elliptic.prepare(elements[i], elements[j], 0.0, rule, 0.0)
        approach = rule.approach_revolutions * ephemeris.period(elements[j, columns.RADIUS])
        best, expected = math.inf, (math.inf, math.inf)
        for m in range(kernels.events(table, i, j) - 1, -1, -1):
            departure = kernels.departure_at(table, i, j, m)
            past = (pair.phase_i + pair.rate_i * departure) / math.pi
            exact = departure + (round(past) - past) * math.pi / pair.rate_i
            assert abs(departure - exact) < SLACK_S / 50.0
            lead = (pair.phase_j + pair.rate_j * exact - math.pi * round(past)) % (2.0 * math.pi)
            after = exact + approach
            flown = sequences.best_sequence(pair, rule, exact, lead, limits.windows, j, after)
            arrival = exact + flown.flight_time + approach
            if flown.delta_v + rule.time_value * arrival < best:
                best = flown.delta_v + rule.time_value * arrival
                expected = flown.delta_v, arrival
            delta_v, stated = kernels.entry_at(table, i, j, m)
            if math.isinf(best):
                assert stated == math.inf
                continue
            assert abs(stated - expected[1]) < SLACK_S / 50.0
            assert abs(delta_v - expected[0]) < SLACK_M_S / 50.0


def test_zones_are_waited_out(table):
    """Where a zone blocks all that leaves now, the entry is that of the next event that is open."""
    instance = table.instance
    blocked = 0
    for i, j in itertools.permutations(range(len(table.names)), 2):
        events = every_sequence.of_pair(instance, i, j, -SLACK_S, table.limits.duration)
        for event, own in enumerate(events[:-1]):
            if not own:
                later = kernels.entry_at(table.table, i, j, event + 1)
                assert kernels.entry_at(table.table, i, j, event) == later
                blocked += math.isfinite(later[0])
    assert blocked > 0


def test_matrices_are_lookups(table):
    """Sampled matrices have the stated shape and hold ΔV and arrival − ready, +inf together."""
    departures = [0.0, 5000.0, 86400.0, 1e9]
    sampled = table.matrices(departures)
    size = len(table.names)
    assert sampled.delta_v.shape == sampled.duration.shape == (4, size, size)
    assert sampled.names[0] == "station"
    for d, ready in enumerate(departures):
        for i in range(size):
            for j in range(size):
                if i == j:
                    assert sampled.delta_v[d, i, j] == sampled.duration[d, i, j] == 0.0
                    continue
                delta_v, arrival = table.lookup(i, j, ready)
                assert sampled.delta_v[d, i, j] == delta_v
                assert sampled.duration[d, i, j] == arrival - ready
    assert np.isinf(sampled.delta_v[3][~np.eye(size, dtype=bool)]).all()


def test_matrices_are_the_same_slice_by_slice(table, monkeypatch):
    """However many ready times are looked up in one go, the last and odd ones too."""
    times = np.linspace(0.0, 2e5, 7)
    whole = table.matrices(times)
    monkeypatch.setattr(timetable, "SLICE_SAMPLES", 3 * len(table.names) ** 2)
    assert table.matrices(times) == whole


@pytest.mark.parametrize("bad", [[-1.0], [math.nan], [math.inf]])
def test_matrices_refuse_bad_times(table, bad):
    """A negative or non-finite departure is refused."""
    with pytest.raises(adr_opt.InputError, match="departures"):
        table.matrices(bad)


def test_threads_do_not_matter():
    """One thread and several give the same bits."""
    instance = adr_opt.generate("tiny", 1)
    one, two = adr_opt.Timetable(instance, 1), adr_opt.Timetable(instance, 2)
    for a, b in zip(one.table, two.table, strict=True):
        assert np.array_equal(a, b)


def test_table_is_read_only(table):
    """Nobody can change a timetable."""
    with pytest.raises(ValueError, match="read-only"):
        table.table.entries[0, 0, 1, 0] = 0.0


def test_no_transfer_between_limits():
    """Where the phasing radius finds no room there is no transfer: both numbers are +inf."""
    instance = hand_made()
    tight = instance.transfer.replace(min_altitude_m=699e3, max_altitude_m=699.5e3)
    table = adr_opt.Timetable(instance.replace(transfer=tight))
    assert table.lookup("station", "north", 0.0) == (math.inf, math.inf)


def test_hand_made_costs():
    """Between equal circles that meet at the node, a leg costs the turn and the approach."""
    table = adr_opt.Timetable(hand_made())
    radius = table.instance.orbits()[0, 0]
    speed, rate = math.sqrt(ephemeris.MU_M3_S2 / radius), ephemeris.mean_motion(radius)
    period = ephemeris.period(radius)
    for name, degrees in (("north", 1.0), ("beyond", 2.0), ("south", 1.0)):
        delta_v, arrival = table.lookup("station", name, 0.0)
        turn = 2.0 * speed * math.sin(math.radians(degrees) / 2.0)
        assert delta_v == pytest.approx(turn + rate * 1000.0 / 2.0, abs=0.3)
        assert arrival == pytest.approx(2.0 * period, abs=1.0)
