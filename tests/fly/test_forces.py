"""Flights with all forces, in the integrator of a library."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import towed_fields
import two_chasers
from conftest import Cli, refused
from drifting_plans import drifting_instance, drifting_plan
from electric_fields import electric
from plans import moved_to, solved
from scipy.integrate import solve_ivp
from seeds import over_seeds

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, J2, MU_M3_S2
from adr_opt.fly.flight.refined import planned_legs
from adr_opt.fly.forces import ForcedFlight, Forces, fly_forced
from adr_opt.fly.forces.flown import Stretch, correction_m_s, fly_leg, last_lap, plan_field
from adr_opt.fly.forces.library import Array, Moving, World, direction
from adr_opt.fly.trajectory.axes import rotation
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance

brahe = pytest.importorskip("brahe")
pytest.importorskip("astropy")

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
TEME = Frame(name="TEME", axes_epoch=EPOCH)
GCRF = Frame(name="GCRF")
EARTH_TURNS_RAD_S = 7.2921159e-5


@cache
def refined(seed: int = 0, dynamics: str = "j2") -> tuple[Instance, RefinedPlan]:
    """A tiny mission and its plan, refined."""
    instance = adr_opt.generate("tiny", seed).replace(dynamics=dynamics)
    return instance, adr_opt.refine(instance, solved(instance))


@cache
def flown(seed: int = 0, **settings: float) -> ForcedFlight:
    """Such a plan with all forces."""
    return fly_forced(*refined(seed), Forces(**settings))


def circle(radius_m: float, inclination_deg: float, angle_deg: float = 30.0) -> Array:
    """A state on a circle whose node is at 40°."""
    i, node, u = (math.radians(angle) for angle in (inclination_deg, 40.0, angle_deg))
    towards = np.array([math.cos(node), math.sin(node), 0.0])
    aside = np.array([-math.sin(node) * math.cos(i), math.cos(node) * math.cos(i), math.sin(i)])
    speed = math.sqrt(MU_M3_S2 / radius_m)
    place = radius_m * (math.cos(u) * towards + math.sin(u) * aside)
    return np.concatenate([place, speed * (math.cos(u) * aside - math.sin(u) * towards)])


def coasted(world: World, settings: Forces, area_mass: float, state: Array, time_s: float) -> Array:
    """A state after a coast with all forces."""
    forces = world.all_forces(settings, area_mass)
    return world.coast([Moving(state, forces)], 0.0, time_s)[0]


def worst_without_forces(instance: Instance, plan: RefinedPlan) -> float:
    """Largest distance from a planned stand-off with all forces off [m]."""
    world, field = plan_field(instance, plan.gravity)
    legs = [
        fly_leg(world, field, leg, instance.transfer.standoff_m)
        for leg in planned_legs(instance, plan)
    ]
    return max(math.inf if (off := leg.planned_body) is None else off.distance_m for leg in legs)


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
@over_seeds(range(4), gate=1)
def test_without_the_forces_both_integrators_agree(seed: int, dynamics: str) -> None:
    """In the field of its plan every leg is at its stand-off within a metre, by the library."""
    assert worst_without_forces(*refined(seed, dynamics)) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize("gravity", ["j3", "j4"])
def test_without_the_forces_higher_harmonics_agree(gravity: str) -> None:
    """So it is with J3 and J4."""
    instance, _ = refined()
    plan = adr_opt.refine(instance, solved(instance), gravity=gravity)
    assert worst_without_forces(instance, plan) < 1.0


@pytest.mark.slow
def test_without_the_forces_weeks_agree() -> None:
    """A leg that drifts for weeks agrees within the square of its weeks, in metres."""
    instance = drifting_instance()
    plan = adr_opt.refine(instance, drifting_plan())
    assert worst_without_forces(instance, plan) < weeks_of(plan) ** 2


@pytest.mark.slow
@pytest.mark.parametrize("campaign", [two_chasers.campaign, towed_fields.field])
def test_campaigns_and_tows_are_flown(campaign: Callable[[str], Instance]) -> None:
    """Legs of several chasers, and those that begin where a tow ends, agree without the forces."""
    instance = campaign("j2")
    plan = adr_opt.refine(instance, solved(instance))
    assert plan.legs
    assert worst_without_forces(instance, plan) < max(1.0, weeks_of(plan) ** 2)
    flight = fly_forced(instance, plan)
    assert len(flight.tanks) >= len(flight.chasers)


def weeks_of(plan: RefinedPlan) -> float:
    """Duration of the longest leg in weeks."""
    return max(leg.standoff_s - leg.states[0].time_s for leg in plan.legs) / (7.0 * DAY_S)


@pytest.mark.parametrize("year", [2000, 2015, 2026])
def test_axes_are_those_of_another_library(year: int) -> None:
    """TEME and EME2000 lie in GCRF where astropy has them, within 0.1 m in low orbit."""
    time = datetime(year, 3, 5, 7, 8, 9, tzinfo=UTC)
    for frame in (Frame(name="TEME", axes_epoch=time), Frame(name="EME2000")):
        world, other = World(time, frame), rotation(frame, GCRF)
        assert other is not None
        for axis in np.eye(3):
            # A moment of motion in GCRF and in the frame differ by the rotation alone.
            state = np.concatenate([7e6 * axis, np.roll(7.5e3 * axis, 1)])
            turned = np.concatenate([other @ state[:3], other @ state[3:]])
            inside = coasted(world, Forces(), 0.0, state, 60.0)
            outside = coasted(World(time, GCRF), Forces(), 0.0, turned, 60.0)
            assert math.dist(other @ inside[:3], outside[:3]) < 0.1


def test_nodes_drift_at_the_secular_rate() -> None:
    """With all forces a node drifts over a day as J2 says to first order, within 1.5 per cent."""
    radius, inclination = EARTH_RADIUS_M + 780e3, 60.0
    start = circle(radius, inclination)
    end = coasted(World(EPOCH, TEME), Forces(), 0.0, start, DAY_S)
    nodes = [math.atan2(h[0], -h[1]) for h in (np.cross(s[:3], s[3:]) for s in (start, end))]
    motion = math.sqrt(MU_M3_S2 / radius**3)
    rate = -1.5 * motion * J2 * (EARTH_RADIUS_M / radius) ** 2 * math.cos(math.radians(inclination))
    assert nodes[1] - nodes[0] == pytest.approx(rate * DAY_S, rel=0.015)


@pytest.mark.parametrize("activity", ["low", "mean", "high"])
def test_drag_lowers_a_circle_as_king_hele_says(activity: str) -> None:
    """A circle loses height at the rate that theory gives for the densities along it.

    D. King-Hele, Satellite Orbits in an Atmosphere (1987): da/dt = −ρ F (Cd A/m) √(μ a) on a
    circle, with F = (1 − (r w/v) cos i)² for an atmosphere that turns with the Earth.
    """
    radius, inclination, area_mass = EARTH_RADIUS_M + 450e3, 51.6, 0.02
    settings = Forces(reflection=0.0, activity=activity)
    world = World(EPOCH, TEME)
    states = [(area, circle(radius, inclination)) for area in (0.0, area_mass)]
    span, parts = 6.0 * 3600.0, 180
    free, slowed = (coasted(world, settings, *one, span) for one in states)
    # Both see the same field, so the difference of energies is what drag took.
    lost = axis_of(slowed) - axis_of(free)
    densities = []
    state, forces = states[0][1], world.all_forces(settings, 0.0)
    to_gcrf = rotation(TEME, GCRF)
    for part in range(parts):
        at = world._start + part * span / parts
        place = brahe.position_eci_to_ecef(at, to_gcrf @ state[:3])
        densities.append(brahe.density_nrlmsise00(at, place))
        state = world.coast(
            [Moving(state, forces)], part * span / parts, (part + 1) * span / parts
        )[0]
    speed = math.sqrt(MU_M3_S2 / radius)
    turning = radius * EARTH_TURNS_RAD_S / speed * math.cos(math.radians(inclination))
    share = (1.0 - turning) ** 2
    rate = -np.mean(densities) * share * settings.drag * area_mass * math.sqrt(MU_M3_S2 * radius)
    assert lost == pytest.approx(rate * span, rel=0.025)


def axis_of(state: Array) -> float:
    """Semi-major axis of a state [m]."""
    radius = float(np.linalg.norm(state[:3]))
    return 1.0 / (2.0 / radius - float(state[3:] @ state[3:]) / MU_M3_S2)


US_1976 = {400e3: 2.803e-12, 600e3: 1.137e-13, 800e3: 1.136e-14, 1000e3: 3.561e-15}
"""U.S. Standard Atmosphere, 1976, of mean activity [kg/m³]."""


def test_mean_densities_are_those_of_the_standard_atmosphere() -> None:
    """At mean activity densities average to those of the U.S. Standard Atmosphere within two."""
    world = World(EPOCH, TEME)
    world.all_forces(Forces(), 0.01)
    for height, known in US_1976.items():
        found = [
            brahe.density_nrlmsise00_geod(world._start, np.array([longitude, latitude, height]))
            for longitude in range(0, 360, 45)
            for latitude in (-45.0, 0.0, 45.0)
        ]
        assert known / 2.0 < np.mean(found) < 2.0 * known


def places_of(name: str, hours: Array) -> Array:
    """Places of Sun or Moon by astropy, in the frame of the tests, shape (3, times) [m]."""
    from astropy import units
    from astropy.coordinates import get_body
    from astropy.time import Time
    from astropy.utils import iers

    with iers.earth_orientation_table.set(iers.IERS_B.open()):
        times = Time(EPOCH.replace(tzinfo=None), scale="utc") + hours * units.hour
        found = get_body(name, times).cartesian.xyz.to_value(units.m)
    turned = rotation(TEME, GCRF)
    assert turned is not None
    return turned.T @ found


def test_sun_and_moon_pull_where_another_library_has_them() -> None:
    """Far out, a day of the pull of Sun and Moon is that of their places by astropy.

    Within a per cent of what they do: the places of brahe are of low precision.
    """
    state = circle(1e8, 40.0)
    hours = np.linspace(0.0, 24.0, 25)
    bodies = [(1.32712440018e20, places_of("sun", hours)), (4.9028001e12, places_of("moon", hours))]

    def rates(time_s: float, state: Array, pulled: bool) -> Array:
        place = state[:3]
        pull = -MU_M3_S2 * place / np.linalg.norm(place) ** 3
        for mu, places in bodies if pulled else ():
            there = np.array([np.interp(time_s, 3600.0 * hours, row) for row in places])
            away = there - place
            pull = pull + mu * (
                away / np.linalg.norm(away) ** 3 - there / np.linalg.norm(there) ** 3
            )
        return np.concatenate([state[3:], pull])

    with_them, without = (
        solve_ivp(rates, (0.0, DAY_S), state, "DOP853", rtol=1e-12, atol=1e-6, args=(pulled,)).y[
            :3, -1
        ]
        for pulled in (True, False)
    )
    found = coasted(World(EPOCH, TEME), Forces(), 0.0, state, DAY_S)[:3]
    effect = math.dist(with_them, without)
    assert effect > 1e4
    assert math.dist(found, with_them) < 0.01 * effect


def test_light_pushes_away_from_the_sun() -> None:
    """Radiation moves an absorbing object from the Sun as 4.56 µN/m² at its mean distance do."""
    state, hours = circle(1e8, 40.0, 200.0), np.array([0.0])
    sun = places_of("sun", hours)[:, 0]
    world, settings, span = World(EPOCH, TEME), Forces(drag=0.0, reflection=1.0), 3600.0
    lit, dark = (coasted(world, settings, area, state, span)[:3] for area in (1.0, 0.0))
    away = state[:3] - sun
    distance = np.linalg.norm(away)
    push = 4.56e-6 * (149597870700.0 / distance) ** 2 * away / distance
    assert lit - dark == pytest.approx(0.5 * push * span**2, rel=0.02, abs=0.2)


@over_seeds(range(4), gate=1)
def test_corrections_remove_what_forces_do(seed: int) -> None:
    """Legs are off by metres to tens of kilometres; corrections are found, and tanks give them."""
    _, plan = refined(seed)
    flight = flown(seed)
    assert [leg.leg for leg in flight.legs] == [leg.leg for leg in plan.legs]
    for leg in flight.legs:
        for off in (leg.planned_body, leg.flown_body):
            assert off is not None
            assert 1.0 < off.distance_m < 1e5
            assert off.correction_m_s is not None
            assert 0.0 < off.correction_m_s < 20.0
    assert flight.correction_m_s is not None
    taken = sum(tank.flown_delta_v_m_s or 0.0 for tank in flight.tanks)
    assert taken == pytest.approx(plan.flown_delta_v_m_s + flight.correction_m_s, abs=1e-6)
    assert flight.holds == all(tank.holds for tank in flight.tanks)


def test_a_delay_costs_two_small_burns() -> None:
    """To arrive late by some length takes two burns along the track, of a sixth of it a lap each.

    After a revolution, a burn of Δv has moved the chaser by 3 T Δv.
    """
    instance, _ = refined()
    world, field = plan_field(instance, "two-body")
    start = circle(EARTH_RADIUS_M + 700e3, 86.0)
    lap = math.tau * math.sqrt((EARTH_RADIUS_M + 700e3) ** 3 / MU_M3_S2)

    def fly(impulses: Array) -> Array:
        state, now = start, 0.0
        for time, impulse in zip(last.times, impulses, strict=True):
            state = world.coast([Moving(state, field.chaser)], now, float(time))[0].copy()
            state[3:] += impulse
            now = float(time)
        return state

    reached = world.coast([Moving(start, field.chaser)], 0.0, lap)[0]
    last = last_lap(Stretch(0.0, lap, start, reached), {})
    for length in (100.0, 10e3, -50e3):
        delay = length / math.hypot(*start[3:])
        goal = world.coast([Moving(start, field.chaser)], 0.0, lap - delay)[0]
        cost = correction_m_s(last, goal, fly)
        assert cost == pytest.approx(2.0 * abs(length) / (3.0 * lap), rel=0.03)


@pytest.mark.slow
def test_more_drag_leads_farther_off() -> None:
    """A chaser alone with much drag is the farther from its plan, the more the Sun is active."""
    offs = [
        flown(0, area_mass_m2_kg=5.0, target_area_mass_m2_kg=0.0, reflection=0.0, activity=activity)
        for activity in ("low", "mean", "high")
    ]
    assert offs[0].worst_body_off_m < offs[1].worst_body_off_m < offs[2].worst_body_off_m


def test_equal_settings_give_equal_flights() -> None:
    """The same flight again has the same figures, whatever was flown between."""
    again = fly_forced(*refined(0), Forces())
    assert again == flown(0)


def test_a_tank_that_corrections_break_is_named(tmp_path: Path, cli: Cli) -> None:
    """A tank that burns leave nothing in has none for corrections: exit status 1."""
    instance, plan = refined()
    tight = instance.with_limits(delta_v_m_s=plan.flown_delta_v_m_s + 0.01)
    moved = moved_to(tight, plan)
    tight.save(tmp_path / "tight.json")
    moved.save(tmp_path / "refined.json")
    files = [str(tmp_path / "tight.json"), str(tmp_path / "refined.json")]
    assert cli("fly", *files, "--json").status == 0
    outcome = cli("fly", *files, "--forces", "full", "--json")
    assert outcome.status == 1
    told = json.loads(outcome.out)
    assert not told["holds"]
    assert told["tanks"][0]["over_m_s"] == pytest.approx(told["correction_m_s"] - 0.01, abs=1e-6)
    assert "is over by" in cli("fly", *files, "--forces", "full").out


def test_the_command_line_tells_all_of_it(tmp_path: Path, cli: Cli) -> None:
    """``--json`` has the settings and both arrivals of each leg; ``--out`` writes one note."""
    instance, plan = refined()
    instance.save(tmp_path / "my.json")
    plan.save(tmp_path / "refined.json")
    files = [str(tmp_path / "my.json"), str(tmp_path / "refined.json"), "--forces", "full"]
    outcome = cli("fly", *files, "--area-mass", "0.02", "--activity", "high", "--json")
    told = json.loads(outcome.out)
    assert told["forces"] == {
        "area_mass_m2_kg": 0.02,
        "target_area_mass_m2_kg": 0.02,
        "drag": 2.2,
        "reflection": 1.3,
        "activity": "high",
        "f107": 250.0,
        "ap": 45.0,
        "gravity_degree": 20,
    }
    assert len(told["legs"]) == len(plan.legs)
    assert told["legs"][0]["planned_body"]["distance_m"] > 0.0
    noted = tmp_path / "noted.json"
    for _ in range(2):
        assert cli("fly", *files, "--out", str(noted)).status == outcome.status
        files[1] = str(noted)
    notes = RefinedPlan.load(noted).notes
    assert sum(note.startswith("flown with all forces") for note in notes) == 1


@pytest.mark.slow
def test_low_thrust_agrees_without_the_forces() -> None:
    """Arcs of low thrust lead to their stand-offs within the square of their weeks, in metres."""
    instance = electric(0, targets=6)
    plan = adr_opt.refine(instance, solved(instance))
    assert plan.has_thrust
    assert worst_without_forces(instance, plan) < weeks_of(plan) ** 2


def test_thrust_points_where_its_law_says() -> None:
    """Parts outward, ahead and across are those of the law of steering, at any latitude."""
    rng = np.random.default_rng(0)
    for _ in range(100):
        inclination, angle = rng.uniform(5.0, 175.0), rng.uniform(0.0, 360.0)
        a, b, c, d, e = steering = tuple(rng.normal(size=5).tolist())
        state = circle(7e6, inclination, angle)
        found = direction(state, np.array([0.0, 0.0, 1.0]), steering)
        outward, ahead = state[:3] / 7e6, state[3:] / np.linalg.norm(state[3:])
        cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        law = np.array(
            [a * sine - b * cosine, c + 2.0 * (a * cosine + b * sine), d * cosine + e * sine]
        )
        parts = [found @ outward, found @ ahead, found @ np.cross(outward, ahead)]
        assert parts == pytest.approx(law / np.linalg.norm(law), abs=1e-12)


def test_a_leg_that_falls_is_lost(tmp_path: Path, cli: Cli) -> None:
    """A leg that leads into the Earth is told as lost, the others are flown, exit status 1."""
    instance, plan = refined()
    first = plan.legs[0]
    burn = first.burns[0]
    state = next(one for one in first.states if one.time_s == burn.time_s)
    back = tuple(-0.2 * part for part in state.velocity_m_s)
    stopped = burn.replace(delta_v_m_s=back)
    spent = first.flown_delta_v_m_s - burn.size_m_s + stopped.size_m_s
    leg = first.replace(burns=(stopped, *first.burns[1:]), flown_delta_v_m_s=spent)
    instance.save(tmp_path / "my.json")
    plan.replace(legs=(leg, *plan.legs[1:])).save(tmp_path / "refined.json")
    files = [str(tmp_path / "my.json"), str(tmp_path / "refined.json"), "--forces", "full"]
    refused(cli("fly", *files), "not legal: leg 1")
    files.append("--unjudged")
    outcome = cli("fly", *files, "--json")
    assert outcome.status == 1
    told = json.loads(outcome.out)
    assert told["legs"][0]["lost"] == "the orbit leads into the Earth"
    assert told["legs"][0]["planned_body"] is None
    assert told["legs"][1]["planned_body"]["correction_m_s"] > 0.0
    assert told["correction_m_s"] is None
    assert "leg 1 is lost: the orbit leads into the Earth" in cli("fly", *files).out
