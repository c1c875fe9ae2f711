"""Disposal: orbits, lifetimes, re-entries and casualties of all that a plan leaves."""

from __future__ import annotations

import json
import math
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from towed_fields import TANK, field

import adr_opt
from adr_opt.analysis.disposal import Debris, casualty_area_m2, fates
from adr_opt.analysis.disposal.casualties import MILLIONS, density_below
from adr_opt.analysis.disposal.reentry import ENTRY_M, lowering, reentry, to_apogee
from adr_opt.common.constants import EARTH_RADIUS_M, J2, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.plan.kit_sizes import disposal_m_s, with_sized_kits
from adr_opt.plan.lifetimes import lifetimes_years
from adr_opt.plan.plan import Plan
from adr_opt.plan.tows import removals_of
from adr_opt.problem.disposal import DisposalCircle, DisposalPerigee
from adr_opt.problem.frame import Frame
from adr_opt.problem.instance import Instance


def disposing(perigee_m: float | None = 50e3, **chaser: object) -> tuple[Instance, Plan]:
    """A field whose objects are all towed, and its plan."""
    free = field("j2", 1).with_limits(duration_s=4 * 86400.0)
    disposal = {"circle_m": 450e3} if perigee_m is None else {"perigee_m": perigee_m}
    epoch = datetime.fromisoformat("2026-01-03T06:00:00+00:00")
    instance = free.replace(
        epoch=epoch,
        frame=Frame(name="TEME", axes_epoch=epoch),
        mission=free.mission.replace(disposal=disposal),
        chasers=(free.chaser.replace(**chaser),),
    )
    plan = adr_opt.solve(instance, "greedy").plan
    assert plan is not None
    return instance, plan


def test_casualties_are_those_of_a_published_case() -> None:
    """Of the Upper Atmosphere Research Satellite NASA told 22 m², and 1 in 3,200 in 2011."""
    area = casualty_area_m2(5668.0, Debris())
    assert area == pytest.approx(22.38, rel=0.03)
    grown = 6.99e9 / (1e6 * sum(MILLIONS))  # people in 2011
    assert 1e-6 * area * density_below(57.0) * grown == pytest.approx(1.0 / 3200.0, rel=0.05)


def test_a_reentry_is_where_an_independent_flight_leads() -> None:
    """Integrated under J2 elsewhere it enters as soon, above a place that astropy finds, too."""
    coordinates = pytest.importorskip("astropy.coordinates")
    time = pytest.importorskip("astropy.time")
    iers = pytest.importorskip("astropy.utils.iers")
    units = pytest.importorskip("astropy.units")
    instance, _ = disposing()
    radius, tilt = EARTH_RADIUS_M + 780e3, math.radians(98.6)
    speed = math.sqrt(MU_M3_S2 / radius)
    state = np.array([radius, 0, 0, 0, speed * math.cos(tilt), speed * math.sin(tilt)])
    wait_s, before = to_apogee(state)
    burn = lowering(before, EARTH_RADIUS_M + 40e3)
    made = reentry(instance, 3000.0 + wait_s, before, burn)
    assert made is not None

    def rates(_: float, now: np.ndarray) -> np.ndarray:
        r = np.linalg.norm(now[:3])
        bulge = 1.5 * J2 * (EARTH_RADIUS_M / r) ** 2
        zonal = bulge * (1.0 - 5.0 * (now[2] / r) ** 2 + np.array([0.0, 0.0, 2.0]))
        return np.r_[now[3:], -MU_M3_S2 / r**3 * now[:3] * (1.0 + zonal)]

    since = made.entry_s - made.burn_s
    start = before + np.r_[0.0, 0.0, 0.0, burn]
    flown = solve_ivp(rates, (0.0, since), start, rtol=1e-10, atol=1e-6).y[:3, -1]
    with iers.conf.set_temp("auto_download", False):
        when = time.Time(instance.epoch + timedelta(seconds=made.entry_s))
        teme = coordinates.TEME(coordinates.CartesianRepresentation(flown * units.m), obstime=when)
        earth = teme.transform_to(coordinates.ITRS(obstime=when)).earth_location
    assert earth.height.to_value("m") == pytest.approx(ENTRY_M, abs=500.0)
    assert earth.lat.deg == pytest.approx(made.entry[0], abs=0.05)
    off = (earth.lon.deg - made.entry[1] + 180.0) % 360.0 - 180.0
    assert abs(off) < 0.05
    assert made.track[0][0] == made.burn_s
    assert made.earliest is not None
    assert made.latest is not None
    along = [np.array(place) for place in (made.earliest, made.entry, made.latest)]
    assert (along[1] - along[0]) @ (along[2] - along[1]) > 0.0
    at = len(made.track) // 2
    north, east = np.radians(np.subtract(made.right[at], made.left[at]))
    wide = math.hypot(north, east * math.cos(math.radians(made.track[at][1])))
    assert wide * EARTH_RADIUS_M == pytest.approx(200e3, rel=0.02)


def test_what_is_released_has_its_orbit_and_its_lifetime() -> None:
    """Apsides are those of tows, lifetimes those of the model, and low activity lasts longest."""
    instance, plan = disposing(None)
    found = {fate.name: fate for fate in fates(instance, plan)}
    years = lifetimes_years(instance, None)
    towed = [leg.destination for leg in plan.legs if leg.tow is not None]
    assert set(found) == {*towed, instance.chaser.name}
    for name in towed:
        body, fate = instance.names.index(name), found[name]
        shell = removals_of(instance, None)[body].released_m
        assert (fate.perigee_m, fate.apogee_m) == pytest.approx(np.array(shell) - EARTH_RADIUS_M)
        assert fate.lifetimes_years["mean"] == pytest.approx(years[body])
        spread = [fate.lifetimes_years[each] for each in ("high", "mean", "low")]
        assert spread == sorted(spread)
        assert not fate.controlled
    total = sum(found[name].propellant_kg for name in towed)
    aboard = sum(leg.removal_m_s > 0.0 for leg in plan.legs)
    assert total > 0.0
    assert aboard == len(towed)
    short = min(years.values())
    strict = fates(instance, plan, years=0.9 * short)
    assert [fate.name for fate in strict if fate.how == "tow" and fate.meets] == []


def test_aimed_objects_reenter_and_heavy_ones_must() -> None:
    """A perigee of 50 km is a controlled re-entry after the plan's own burn; 300 km is none."""
    instance, plan = disposing()
    towed = [fate for fate in fates(instance, plan) if fate.how == "tow"]
    assert len(towed) > 2
    for fate in towed:
        leg = next(leg for leg in plan.legs if leg.destination == fate.name)
        assert fate.reentry is not None
        assert fate.reentry.burn_s == pytest.approx(leg.tow.burns[0].time_s)
        assert fate.reentry.burn_m_s == pytest.approx(leg.tow.burns[0].size_m_s)
        assert 1500.0 < fate.reentry.entry_s - fate.reentry.burn_s < 3600.0
    high, plan = disposing(300e3)
    loose = [fate for fate in fates(high, plan) if fate.how == "tow"]
    assert all(fate.meets and not fate.controlled for fate in loose)
    tight = [fate for fate in fates(high, plan, most_uncontrolled_kg=249.0) if fate.how == "tow"]
    assert not any(fate.meets for fate in tight)
    anywhere = Debris(survives=0.9)
    struck = [fate for fate in fates(high, plan, debris=anywhere) if fate.how == "tow"]
    assert all((fate.casualties > 1e-4) == (not fate.meets) for fate in struck)


def test_a_chaser_pays_for_its_own_disposal() -> None:
    """It lowers its perigee as far as the rule asks, and aims if it is heavy and has enough."""
    instance, plan = disposing(650e3, tank=TANK | {"propellant_kg": 900.0})
    chaser = fates(instance, plan)[-1]
    assert chaser.how == "chaser"
    assert chaser.meets
    assert chaser.left_m_s > chaser.delta_v_m_s > 0.0
    assert chaser.lifetimes_years["mean"] == pytest.approx(25.0, rel=0.01)
    aimed = fates(instance, plan, most_uncontrolled_kg=100.0)[-1]
    assert aimed.controlled
    assert aimed.delta_v_m_s > chaser.delta_v_m_s
    assert aimed.propellant_kg == pytest.approx(
        plan.legs[-1].mass_kg * -math.expm1(-aimed.delta_v_m_s / (9.80665 * TANK["isp_s"]))
    )
    for propellant_kg in (600.0, 700.0):
        tank = TANK | {"propellant_kg": propellant_kg}
        fate = fates(*disposing(650e3, tank=tank), most_uncontrolled_kg=100.0)[-1]
        assert fate.meets == fate.controlled
        kept = disposing(650e3, tank=tank, end_of_life_m_s=230.0)
        assert fates(*kept, most_uncontrolled_kg=100.0)[-1].meets


def test_a_kit_is_held_to_what_it_has_to_have() -> None:
    """ΔV and propellant are those of its burn at the apogee; a kit that is lighter is told."""
    drawn = field("j2").with_limits(duration_s=2 * 86400.0)
    for disposal, kit_kg in (({"perigee_m": 50e3}, 5.0), ({"perigee_m": 50e3}, 60.0), (None, 60.0)):
        targets = [
            target.replace(removal="kit", disposal=disposal, mass_kg=200.0)
            for target in drawn.targets
        ]
        chaser = drawn.chaser.replace(kits=6, kit_mass_kg=kit_kg)
        instance = drawn.replace(targets=tuple(targets), chasers=(chaser,))
        plan = adr_opt.solve(instance, "greedy").plan
        assert plan is not None
        kits = [fate for fate in fates(instance, plan, kit_isp_s=220.0) if fate.how == "kit"]
        assert len(kits) == (len(plan.destinations) if disposal else 0)
        for fate in kits:
            target = next(each for each in targets if each.name == fate.name)
            axis, low = target.orbit.semi_major_axis_m, EARTH_RADIUS_M + 50e3
            radius = axis * (1.0 + target.orbit.eccentricity)
            speeds = [
                math.sqrt(MU_M3_S2 * (2.0 / radius - 1.0 / a)) for a in (axis, 0.5 * (radius + low))
            ]
            assert fate.delta_v_m_s == pytest.approx(speeds[0] - speeds[1], rel=0.01)
            burnt = (200.0 + kit_kg) * -math.expm1(-fate.delta_v_m_s / (220.0 * 9.80665))
            assert fate.propellant_kg == pytest.approx(burnt)
            assert fate.controlled
            assert fate.meets == (kit_kg > burnt)


def test_burns_of_kits_end_on_the_orbit_of_disposal() -> None:
    """From ellipses, by energy and momentum, to below, between and above their apsides."""
    rng, target = np.random.default_rng(0), field().targets[0]

    def opposite_m(at_m: float, speed_m_s: float) -> float:
        axis_m = 1.0 / (2.0 / at_m - speed_m_s**2 / MU_M3_S2)
        return 2.0 * axis_m - at_m

    for _ in range(1000):
        low_m, eccentricity = EARTH_RADIUS_M + rng.uniform(300e3, 1200e3), rng.uniform(0.0, 0.2)
        axis_m, to_m = low_m / (1.0 - eccentricity), rng.uniform(50e3, 2000e3)
        high_m = 2.0 * axis_m - low_m
        orbit = target.orbit.replace(semi_major_axis_m=axis_m, eccentricity=eccentricity)
        before = math.sqrt(MU_M3_S2 * (2.0 / high_m - 1.0 / axis_m))
        lowered = target.replace(orbit=orbit, disposal=DisposalPerigee(perigee_m=min(to_m, 250e3)))
        after = before - disposal_m_s(lowered)
        assert opposite_m(high_m, after) == pytest.approx(EARTH_RADIUS_M + min(to_m, 250e3))
        circle_m = EARTH_RADIUS_M + max(to_m, 300e3)
        circled = target.replace(orbit=orbit, disposal=DisposalCircle(circle_m=max(to_m, 300e3)))
        leaves = brentq(
            lambda v, at=high_m, to=circle_m: opposite_m(at, v) - to, 0.5 * before, 1.2 * before
        )
        arrives = leaves * high_m / circle_m
        taken = abs(before - leaves) + abs(arrives - math.sqrt(MU_M3_S2 / circle_m))
        assert disposal_m_s(circled) == pytest.approx(taken, abs=1e-6)


@pytest.mark.parametrize("disposal", [{"perigee_m": 50e3}, {"circle_m": 560e3}])
def test_sized_kits_hold_what_their_disposal_takes(disposal: dict[str, float]) -> None:
    """They hold the largest need, and `dispose` finds that of each on its true orbit."""
    drawn, _ = disposing()
    targets = tuple(
        target.replace(removal="kit", disposal=None, mass_kg=100.0 + 20.0 * at)
        for at, target in enumerate(drawn.targets)
    )
    chaser = drawn.chaser.replace(kits=6, kit_mass_kg=12.0)
    mission = drawn.mission.replace(disposal=None)
    dry = drawn.replace(targets=targets, chasers=(chaser,), mission=mission)
    to = DisposalPerigee(**disposal) if "perigee_m" in disposal else DisposalCircle(**disposal)
    sized = with_sized_kits(dry, 220.0, to)
    plan = adr_opt.solve(sized, "greedy").plan
    assert plan is not None
    kits = [fate for fate in fates(sized, plan, kit_isp_s=220.0) if fate.how == "kit"]
    assert len(kits) == len(plan.destinations)
    exhaust_m_s, whole_kg = 220.0 * 9.80665, sized.chaser.kit_mass_kg
    needs = [
        (each.mass_kg + 12.0) * math.expm1(disposal_m_s(each) / exhaust_m_s)
        for each in sized.targets
    ]
    assert whole_kg == pytest.approx(12.0 + max(needs))
    for fate in kits:
        target = next(each for each in sized.targets if each.name == fate.name)
        share = -math.expm1(-disposal_m_s(target) / exhaust_m_s)
        assert fate.propellant_kg == pytest.approx((target.mass_kg + whole_kg) * share, rel=0.02)
        assert fate.propellant_kg < 1.02 * (whole_kg - 12.0)
    unknown = dry.replace(targets=(targets[0].replace(mass_kg=None), *targets[1:]))
    with pytest.raises(InputError, match="its mass_kg is unknown"):
        with_sized_kits(unknown, 220.0, to)
    with pytest.raises(InputError, match="give its disposal"):
        with_sized_kits(dry, 220.0)


def test_the_verb_writes_a_report(cli: Cli) -> None:
    """JSON and page have all fates; the exit status says whether the rules are met."""
    instance, plan = disposing()
    instance.save("a.json")
    plan.save("p.json")
    outcome = cli("dispose", "a.json", "p.json", "--out", "d.json", "--page", "d.html", "--json")
    assert outcome.status == 0, outcome
    said = json.loads(outcome.out)
    assert said == json.loads(Path("d.json").read_text(encoding="utf-8"))
    names = [each["name"] for each in said["fates"]]
    assert names == [fate.name for fate in fates(instance, plan)]
    page = Path("d.html").read_text(encoding="utf-8")
    assert all(name in page for name in names)
    assert "<script" not in page
    strict = cli("dispose", "a.json", "p.json", "--survives", "0.9", "--fails", "1")
    assert strict.status == 1
    assert "casualty expectation" in strict.err
    refused = cli("dispose", "a.json", "p.json", "--years", "0")
    assert refused.status == 2
    with pytest.raises(InputError, match="kit_isp_s"):
        fates(instance, plan, kit_isp_s=-1.0)


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"piece_kg": 0.0}, "piece_kg = 0: must be a positive number"),
        ({"piece_m2": -1.0}, "piece_m2 = -1: must be a positive number"),
        ({"survives": 2.0}, "survives = 2: must be a share from 0 to 1"),
        ({"fails": math.nan}, "fails = nan: must be a share from 0 to 1"),
    ],
)
def test_what_cannot_be_assumed_is_refused(stated: dict[str, float], said: str) -> None:
    """Shares lie between 0 and 1, and pieces are something."""
    with pytest.raises(InputError, match=said):
        Debris(**stated)
