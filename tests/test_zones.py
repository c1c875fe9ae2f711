"""Keep-out zones: no leg crosses an open one, and nothing but a crossing forbids a leg."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest
from altitude_profile import Burns, coasts, crosses, on_circle, profile
from brute_force import brute_force
from hand_made import OPTIMAL_PLAN, PERIOD_S, hand_made

import adr_opt
from adr_opt.errors import MissingExtra
from adr_opt.generator import by_name
from adr_opt.instance import Instance
from adr_opt.kernels import burns as burn_kernels
from adr_opt.kernels.burns import PHASES
from adr_opt.mission import Mission
from adr_opt.orbit import Orbit
from adr_opt.plan import InstanceReference, Leg
from adr_opt.planner import BOUNDS, PLANNERS, names
from adr_opt.settings import KeepOutZone

MARGIN_M, MARGIN_S = 1.0, 0.01
"""Rounding, far below what a zone measures."""

ITERATIONS = 3
LIMIT_S = 10.0


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
def test_no_leg_crosses_an_open_zone(method: str) -> None:
    """The altitude profiles of hundreds of planned legs of each planner keep out of open zones."""
    count = 0
    for seed in range(10):
        instance = mission(seed, 6).instance
        for leg in legs(seed, 6, method):
            assert not crossing(instance, leg, instance.keep_out_zones, -1), (seed, leg)
            count += 1
    assert count > 150


def test_zones_bite() -> None:
    """The same fields planned without zones do cross some: the zones change what is flown."""
    crossed = 0
    for seed in range(10):
        zones = mission(seed, 6).instance.keep_out_zones
        for leg in legs(seed, 0, "greedy-guarded"):
            crossed += crossing(mission(seed, 0).instance, leg, zones, -1)
    assert crossed > 10


def entries(plain: Mission, zoned: Mission, number: int) -> Iterator[tuple[bool, bool, Leg, Leg]]:
    """Entries of the timetable at random, with and without zones: differs, exists, both legs."""
    rng = np.random.default_rng(3)
    first, second = plain.timetable.table, zoned.timetable.table
    elements, extra, rule = plain.transfer_inputs
    _, _, zoned_rule = zoned.transfer_inputs
    size = len(plain.names)
    for _ in range(number):
        i, j = rng.choice(size, 2, replace=False)
        event = int(rng.integers(0, first.total[i, j]))
        made = []
        for rules in (rule, zoned_rule):
            revolutions, times, vectors, phases = burn_kernels.burns_of_event(
                elements[i], elements[j], extra[i, j], rules, event
            )
            made.append((revolutions, times, vectors, phases))
        exists = bool(np.isfinite(second.entries[i, event, j, 0]))
        differs = not np.array_equal(first.entries[i, event, j], second.entries[i, event, j])
        yield (
            differs,
            exists,
            *(
                Leg(
                    origin=plain.names[i],
                    destination=plain.names[j],
                    ready_s=0.0,
                    departure_s=float(times[0]),
                    arrival_s=float(times[-1]),
                    end_s=float(times[-1]),
                    delta_v_m_s=float(np.linalg.norm(vectors, axis=1).sum()),
                    delta_v_left_m_s=0.0,
                    phasing_revolutions=int(revolutions),
                    burns=[
                        {
                            "time_s": float(t),
                            "delta_v_m_s": tuple(map(float, v)),
                            "phase": PHASES[p],
                        }
                        for t, v, p in zip(times, vectors, phases, strict=True)
                    ],
                )
                if revolutions >= 0
                else None
                for revolutions, times, vectors, phases in made
            ),
        )


def test_a_sequence_is_dropped_exactly_if_it_crosses() -> None:
    """Over hundreds of entries, the timetable differs from the one without zones just there."""
    plain, zoned = mission(2, 0), mission(2, 12)
    zones = zoned.instance.keep_out_zones
    changed = detours = nothing = 0
    for differs, exists, without, within in entries(plain, zoned, 800):
        if without is None:
            assert not exists
            continue
        if differs:
            assert crossing(plain.instance, without, zones, 1), without
            changed += 1
            nothing += not exists
        else:
            assert not crossing(plain.instance, without, zones, -1), without
        if exists:
            assert within is not None
            assert not crossing(zoned.instance, within, zones, -1), within
            detours += differs
    assert changed > 50
    assert detours > 10
    assert nothing > 10


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
        # Twice: the model flies something else there, and the burns lead through a zone.
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
    ("start", "end", "made"),
    [(-1.0, 1e-6, 0), (1.9, 2.5, 0), (2.1, 3.6, 1), (5.4, 5.45, 1), (8.9, 9.0, 2)],
)
def test_departure_and_arrival_are_not_exempt(start: float, end: float, made: int) -> None:
    """A leg may neither leave nor reach an orbit that is closed then.

    There is no waiting for it to open: the transfer at that departure event does not exist.
    """
    mission = closed(start, end)
    assert mission.time(OPTIMAL_PLAN).made == made


def test_a_chaser_shut_in_for_good_stays() -> None:
    """Where no body can be left or reached, the plan is empty and every target has no transfer."""
    shut = closed(-1.0, 1e6)
    for method in ("greedy", "greedy-guarded", "beam"):
        plan = adr_opt.solve(shut, method).plan
        assert plan is not None
        assert plan.legs == ()
        assert {entry.reason for entry in plan.unvisited} == {"no-transfer"}
        assert adr_opt.check(shut.instance, plan) == ()


TINY = [(seed, zones) for seed in (20, 21, 22) for zones in (3, 8)]


@cache
def tiny(seed: int, zones: int) -> Mission:
    return Mission(adr_opt.generate("tiny", seed, zones=zones), threads=1)


@cache
def optimum(seed: int, zones: int) -> float:
    return brute_force(tiny(seed, zones))[0]


def test_zones_change_optima() -> None:
    """The zoned tiny instances below are no idle test: zones cost visits in most of them."""
    worse = [optimum(seed, zones) < optimum(seed, 0) for seed, zones in TINY]
    assert sum(worse) > len(TINY) // 2
    assert max(optimum(*which) for which in TINY) > 1.0


@pytest.mark.parametrize("method", names(PLANNERS))
def test_planners_meet_zones(method: str) -> None:
    """Every planner's plan on zoned instances is legal and no better than brute force."""
    for which in TINY:
        try:
            result = adr_opt.solve(tiny(*which), method, iterations=ITERATIONS, time_limit=LIMIT_S)
        except MissingExtra as missing:
            pytest.skip(str(missing))
        assert result.plan is not None
        assert adr_opt.check(tiny(*which).instance, result.plan) == ()
        assert result.objective <= optimum(*which) + 1e-9
        assert result.upper_bound >= optimum(*which) - 1e-6
        if result.status == "optimal":
            assert result.objective == pytest.approx(optimum(*which))


@pytest.mark.parametrize("method", names(BOUNDS))
def test_bounds_meet_zones(method: str) -> None:
    """Every bound on zoned instances is at least what brute force finds."""
    for which in TINY:
        try:
            result = adr_opt.bound(tiny(*which), method, iterations=ITERATIONS, time_limit=LIMIT_S)
        except MissingExtra as missing:
            pytest.skip(str(missing))
        assert math.isfinite(result.upper_bound)
        assert result.upper_bound >= optimum(*which) - 1e-6
