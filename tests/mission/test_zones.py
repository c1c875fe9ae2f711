"""Keep-out zones: no leg crosses an open one, and nothing but a crossing forbids a leg."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest
from altitude_profile import Burns, coasts, crosses, on_circle, profile
from every_sequence import Flown, of_pair
from hand_made import OPTIMAL_PLAN, PERIOD_S, hand_made
from seeds import over_kinds

import adr_opt
from adr_opt.kernels.legs import burns as burn_kernels
from adr_opt.kernels.legs.burns import PHASES
from adr_opt.legs.connection_finder import ConnectionFinder
from adr_opt.mission.mission import Mission
from adr_opt.plan.plan import InstanceReference, Leg
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import KeepOutZone, Objective
from adr_opt.sources.generator import by_name

MARGIN_M, MARGIN_S = 1.0, 0.01
"""Rounding, far below what a zone measures."""


@cache
def mission(seed: int, zones: int) -> Mission:
    return Mission(adr_opt.generate("nominal", seed, zones=zones))


@cache
def orbits(name: str) -> dict[str, Orbit]:
    instance = by_name(name)
    return dict(zip(instance.names, instance.body_orbits, strict=True))


def flown(leg: Leg) -> Burns:
    return [(burn.time_s, burn.delta_v_m_s, burn.phase) for burn in leg.burns]


def crossing(instance: Instance, leg: Leg, zones: tuple[KeepOutZone, ...], sign: int) -> bool:
    """Whether a leg crosses one of the zones, made larger (sign 1) or smaller (−1) by a margin."""
    of = orbits(instance.name)
    origin, destination = of[leg.origin], of[leg.destination]
    return crosses(origin, destination, flown(leg), zones, sign * MARGIN_M, sign * MARGIN_S)


def legs(seed: int, zones: int, method: str) -> tuple[Leg, ...]:
    plan = adr_opt.solve(mission(seed, zones), method, seed=0).plan
    assert plan is not None
    return plan.legs


def test_the_profile_is_that_of_the_leg() -> None:
    """The altitude profile starts at the origin and its burns lead to the stand-off."""
    instance = mission(0, 6).instance
    of = orbits(instance.name)
    for leg in legs(0, 6, "greedy-guarded"):
        origin, destination = of[leg.origin], of[leg.destination]
        times, altitudes = profile(origin, destination, flown(leg))
        assert times[0] == leg.departure_s
        assert times[-1] == pytest.approx(leg.arrival_s, abs=1e-6)
        assert np.all(np.diff(times) >= 0.0)
        assert altitudes[0] == pytest.approx(origin.semi_major_axis_m - 6378137.0, abs=1e-3)
        assert altitudes[-3:] == pytest.approx(destination.semi_major_axis_m - 6378137.0, abs=0.1)
        # The jumps between two samples are those of half ellipses, not of a mistaken state.
        assert np.abs(np.diff(altitudes)).max() < 5e3
        *_, last = coasts(origin, flown(leg))
        standoff, _ = last.state(last.end_s)
        target, _ = on_circle(destination, last.end_s)
        assert np.linalg.norm(standoff - target) == pytest.approx(1000.0, abs=0.1)


@pytest.mark.parametrize("method", ["greedy-guarded", "beam"])
@over_kinds("seeds", fields=(range(10), 3))
def test_no_leg_crosses_an_open_zone(method: str, seeds: range) -> None:
    """The altitude profiles of hundreds of planned legs of each planner keep out of open zones."""
    count = 0
    for seed in seeds:
        instance = mission(seed, 6).instance
        for leg in legs(seed, 6, method):
            assert not crossing(instance, leg, instance.keep_out_zones, -1), (seed, leg)
            count += 1
    assert count > 15 * len(seeds)


@over_kinds("seeds", fields=(range(10), 3))
def test_zones_bite(seeds: range) -> None:
    """The same fields planned without zones do cross some: the zones change what is flown."""
    crossed = 0
    for seed in seeds:
        zones = mission(seed, 6).instance.keep_out_zones
        for leg in legs(seed, 0, "greedy-guarded"):
            crossed += crossing(mission(seed, 0).instance, leg, zones, -1)
    assert crossed > len(seeds)


def burns_of(instance: Instance, i: int, j: int, sequence: Flown) -> Burns:
    elements, extra = instance.orbits(), instance.eccentricity_delta_v()
    times, vectors, phases = burn_kernels.burns_between(
        elements[i],
        elements[j],
        extra[i, j],
        instance.transfer_rule(),
        sequence.departure,
        sequence.arrival,
        sequence.revolutions,
    )
    return [
        (float(time), (float(vector[0]), float(vector[1]), float(vector[2])), PHASES[phase])
        for time, vector, phase in zip(times, vectors, phases, strict=True)
    ]


def random_pairs(instance: Instance, number: int) -> Iterator[tuple[int, int, float]]:
    """Two bodies and a time, at random."""
    rng = np.random.default_rng(3)
    for _ in range(number):
        i, j = rng.choice(len(instance.names), 2, replace=False)
        yield int(i), int(j), float(rng.uniform(0.0, instance.mission.duration_s))


@pytest.mark.slow
def test_a_sequence_is_dropped_exactly_if_it_crosses() -> None:
    """Of thousands of sequences, those are left out whose altitude profile enters an open zone."""
    plain, zoned = mission(2, 0).instance, mission(2, 12).instance
    of = orbits(plain.name)
    dropped = left = 0
    for i, j, since in random_pairs(plain, 60):
        until = since + 6000.0
        kept = {
            (sequence.departure, sequence.arrival, sequence.revolutions)
            for event in of_pair(zoned, i, j, since, until)
            for sequence in event
        }
        origin, destination = of[plain.names[i]], of[plain.names[j]]
        for sequence in itertools.chain(*of_pair(plain, i, j, since, until)):
            burns = burns_of(plain, i, j, sequence)
            there = (sequence.departure, sequence.arrival, sequence.revolutions) in kept
            sign = -1 if there else 1
            crossed = crosses(
                origin, destination, burns, zoned.keep_out_zones, sign * MARGIN_M, sign * MARGIN_S
            )
            assert crossed != there, (i, j, sequence)
            dropped, left = dropped + crossed, left + there
    assert dropped > 200
    assert left > 200


def test_no_connection_crosses() -> None:
    """None of the connections that schedules choose from leads through an open zone."""
    instance = mission(2, 12).instance
    of = orbits(instance.name)
    timetable = ConnectionFinder(instance)
    count = 0
    for i, j, _ in random_pairs(instance, 10):
        origin, destination = of[instance.names[i]], of[instance.names[j]]
        found = timetable.of_pair(i, j, 0.0)
        rows = zip(found.departure, found.arrival, found.delta_v, found.revolutions, strict=True)
        for departure, arrival, delta_v, revolutions in itertools.islice(rows, 0, None, 10):
            sequence = Flown(departure, arrival, delta_v, int(revolutions), math.nan)
            burns = burns_of(instance, i, j, sequence)
            assert not crosses(
                origin, destination, burns, instance.keep_out_zones, -MARGIN_M, -MARGIN_S
            )
            spent = sum(math.hypot(*vector) for _, vector, _ in burns)
            assert spent == pytest.approx(delta_v, abs=1e-6)
            count += 1
    assert count > 300


def test_check_finds_the_legs_that_cross() -> None:
    """A plan made without zones is refused at exactly the legs whose profile crosses one."""
    found = 0
    for seed in range(4):
        zoned = mission(seed, 6).instance
        plan = adr_opt.solve(mission(seed, 0), "greedy-guarded").plan
        assert plan is not None
        claimed = plan.replace(
            instance=InstanceReference(name=zoned.name, sha256=zoned.sha256)
        )  # what a planner that forgot the zones would hand in
        violations = adr_opt.check(zoned, claimed)
        wrong = {violation.leg for violation in violations}
        # All else is in order: a leg is a flyable one, whatever zones there are.
        assert {violation.leg for violation in violations if violation.rule == "zone"} == wrong
        for number, leg in enumerate(plan.legs, start=1):
            if number in wrong:
                assert crossing(zoned, leg, zoned.keep_out_zones, 1)
                found += 1
            else:
                assert not crossing(zoned, leg, zoned.keep_out_zones, -1)
    assert found > 3


def zone(start_s: float, end_s: float) -> KeepOutZone:
    """Closes the circle that all bodies of the hand-made instance fly on."""
    return KeepOutZone(min_altitude_m=690e3, max_altitude_m=710e3, start_s=start_s, end_s=end_s)


def closed(start: float, end: float) -> Mission:
    """The hand-made mission with its orbit closed from and until a number of periods."""
    return Mission(hand_made().replace(keep_out_zones=(zone(start * PERIOD_S, end * PERIOD_S),)))


def test_waiting_and_service_are_exempt() -> None:
    """An orbit may close while the chaser serves and waits on it; only legs have to be clear."""
    # Legs are flown in [0, 2], [3.5, 5.5], … periods, with up to a thousandth of detours.
    assert closed(2.1, 3.4).time(OPTIMAL_PLAN).made == 4
    assert closed(5.6, 6.9).time(OPTIMAL_PLAN).made == 4


@pytest.mark.parametrize(
    ("start", "end", "leg", "departs", "ends"),
    [
        (-1.0, 1e-6, 0, 0.5, 14.0),
        (1.9, 2.4, 0, 2.5, 16.0),
        (2.1, 3.6, 1, 4.0, 14.0),
        (5.4, 5.45, 1, 5.5, 15.5),
        (8.9, 8.95, 2, 9.0, 15.5),
    ],
)
def test_departure_and_arrival_are_not_exempt(
    start: float, end: float, leg: int, departs: float, ends: float
) -> None:
    """A leg may neither leave nor reach an orbit that is closed then: the chaser waits.

    It leaves at the first departure event at which the whole leg is clear.
    """
    instance = hand_made(periods=20.0).replace(
        keep_out_zones=(zone(start * PERIOD_S, end * PERIOD_S),),
        objective=Objective(cost="duration"),
    )
    schedule = Mission(instance).time(OPTIMAL_PLAN)
    assert schedule.departures[leg] / PERIOD_S == pytest.approx(departs, abs=1e-6)
    assert schedule.ends[-1] / PERIOD_S == pytest.approx(ends, abs=1e-3)
    assert schedule.lefts == pytest.approx([168.4, 300.0, 168.4, 36.8], abs=0.2)


def test_a_chaser_shut_in_for_good_stays() -> None:
    """Where no body can be left or reached, the plan is empty and every target has no transfer."""
    shut = closed(-1.0, 1e6)
    for method in ("greedy", "greedy-guarded", "beam"):
        plan = adr_opt.solve(shut, method).plan
        assert plan is not None
        assert plan.legs == ()
        assert {entry.reason for entry in plan.unvisited} == {"no-transfer"}
        assert adr_opt.check(shut.instance, plan) == ()
