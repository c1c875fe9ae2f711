"""Robust plans keep what they promise, and bounds on them hold for every plan that does."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from statistics import NormalDist
from typing import Any

import launched
import numpy as np
import pytest
import towed_fields

import adr_opt
from adr_opt import analysis
from adr_opt.analysis.rehearse.intended import intended
from adr_opt.analysis.rehearse.mission_facts import MissionFacts
from adr_opt.analysis.rehearse.tries import TryWorths
from adr_opt.analysis.robust.careful_problem import between, careful_problem, equal, shared
from adr_opt.analysis.robust.promise import StayTime, promise_of, slip_chance, slip_quantile
from adr_opt.analysis.robust.robust import robust
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.kernels.core.windows import service_begin
from adr_opt.legs.corrections import Moments, RiskCharge
from adr_opt.plan.leg_kinds import leg_kinds
from adr_opt.plan.plan import Plan
from adr_opt.problem.chasers import Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Delay, LognormalFactor, TankUncertainty, Uncertainty
from adr_opt.problem.world import DrawnWorld

CONFIDENCE = 0.9


def test_moments_of_factors_are_those_of_draws() -> None:
    """Mean and standard deviation of a bounded lognormal factor are those of many draws."""
    rng = np.random.default_rng(1)
    for _ in range(20):
        model = LognormalFactor(
            lognormal_sigma=float(rng.uniform(0.0, 1.0)),
            least=float(rng.uniform(0.3, 1.0)),
            most=float(rng.uniform(1.0, 3.0)),
        )
        places = (np.arange(4000) + 0.5) / 4000
        drawn = np.array([model.at(float(place)) for place in places])
        mean, sigma = model.moments
        assert mean == pytest.approx(drawn.mean(), rel=2e-4)
        assert sigma == pytest.approx(drawn.std(), rel=2e-3, abs=1e-6)
    usable = TankUncertainty(least=0.8, most=0.9)
    assert usable.moments == pytest.approx((0.85, 0.1 / math.sqrt(12.0)))


@pytest.mark.parametrize("draws", [400, pytest.param(3000, marks=pytest.mark.slow)])
def test_charges_never_exceed_a_tank_that_keeps_its_legs(draws: int) -> None:
    """Legs that keep mean + z · sqrt(variance) ≤ tank are charged no more than it, equal ones it.

    What is planned is had back from what is charged.
    """
    rng = np.random.default_rng(2)
    for _ in range(draws):
        count, full = int(rng.integers(1, 15)), float(rng.uniform(500.0, 5000.0))
        score = float(rng.uniform(0.0, 3.5))
        usable = Moments(float(rng.uniform(0.8, 1.0)), float(rng.uniform(0.0, 0.05)))
        alike = rng.random() < 0.3
        one = 1 if alike else count
        mean = np.resize(np.exp(rng.uniform(-0.1, 0.1, one)), count)
        sigma = np.resize(rng.uniform(0.0, 0.3, one), count)
        planned = np.resize(rng.exponential(1.0, one) ** rng.uniform(0.3, 2.0), count)
        spread = score * usable.sigma * full
        if usable.mean * full <= spread:
            continue

        def need(scale: float) -> float:
            reserve = score**2 * ((sigma * planned * scale) ** 2).sum() + spread**2  # noqa: B023
            return float((mean * planned * scale).sum() + math.sqrt(reserve))  # noqa: B023

        low, high = 0.0, full
        while need(high) < usable.mean * full:
            high *= 2.0
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if need(middle) <= usable.mean * full else (low, middle)
        factors = {
            (str(leg), "short"): Moments(float(mean[leg]), float(sigma[leg]))
            for leg in range(count)
        }
        charge = RiskCharge(score, full, usable, factors)
        charged = [
            float(charge.charged(str(leg), "short", low * planned[leg])) for leg in range(count)
        ]
        assert sum(charged) <= full * (1.0 + 1e-9)
        if alike:
            assert sum(charged) == pytest.approx(full, rel=1e-9)
        for leg in range(count):
            back = float(charge.planned(str(leg), "short", charged[leg]))
            assert back == pytest.approx(low * planned[leg], rel=1e-9, abs=1e-9)


def test_stays_are_as_long_as_in_worlds() -> None:
    """The chance of a stay is its share among worlds, and its quantile has that chance."""
    instance = adr_opt.generate("tiny", seed=0)
    uncertainty = Uncertainty(
        service_s={"factor": {"lognormal_sigma": 0.4}, "added": {"chance": 0.3, "mean_s": 3000.0}},
        capture={"success": 0.7, "tries": 3},
        gone=0.1,
    )
    name, planned_s = instance.targets[0].name, 5000.0
    stay = StayTime(uncertainty, name, planned_s)
    found = []
    for seed in range(4000):
        world = DrawnWorld(instance, uncertainty, seed)
        tries = world.first_success(name) or uncertainty.tries_of(name)
        there = not world.is_gone(name)
        found.append(there * tries * world.service_s(name, planned_s))
    for time_s in (0.0, 3000.0, 6000.0, 12000.0, 25000.0):
        share = float(np.mean(np.array(found) <= time_s))
        assert stay.chance(time_s) == pytest.approx(share, abs=0.03)
    for level in (0.6, 0.9, 0.99):
        assert stay.chance(stay.quantile(level)) == pytest.approx(level, abs=1e-3)
    assert StayTime(Uncertainty(), name, planned_s).quantile(0.99) == planned_s
    slip = Delay(chance=0.4, mean_s=1000.0, most_s=2000.0)
    assert slip_quantile(slip, 0.5) == 0.0
    for level in (0.7, 0.9):
        assert slip_chance(slip, slip_quantile(slip, level)) == pytest.approx(level)


def test_shares_of_risk_keep_the_whole() -> None:
    """Levels of parts multiplied give the confidence; between two of them they rise."""
    instance = adr_opt.generate("tiny", seed=0)
    plan = adr_opt.solve(instance, method="beam").plan
    assert plan is not None
    facts = MissionFacts(instance)
    uncertainty = Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.1}},
        service_s={"factor": {"lognormal_sigma": 0.1}},
    )
    promise = promise_of(facts, intended(facts, plan), uncertainty)
    levels = shared(CONFIDENCE, promise)
    parts = levels.tank ** len(promise.tanks) * levels.stay ** len(promise.stays)
    assert promise.tanks
    assert promise.stays
    assert parts == pytest.approx(CONFIDENCE)
    halfway = between(equal(CONFIDENCE), levels, 0.5)
    assert CONFIDENCE < halfway.stay < levels.stay


def _drawn(rng: np.random.Generator) -> tuple[Instance, Uncertainty]:
    """A small mission with tanks that are short, and its uncertainty."""
    instance = adr_opt.generate("tiny", seed=int(rng.integers(1000)))
    targets = instance.targets[: int(rng.integers(3, 5))]
    if rng.random() < 0.5:
        targets = tuple(target.replace(prize=float(rng.integers(1, 4))) for target in targets)
    chaser = instance.chasers[0]
    assert isinstance(chaser.tank, Tank)
    tank = Tank(delta_v_m_s=chaser.tank.delta_v_m_s * float(rng.uniform(0.1, 0.5)))
    given: dict[str, Any] = {
        "legs": {"delta_v_factor": {"lognormal_sigma": float(rng.uniform(0.02, 0.3))}}
    }
    if rng.random() < 0.5:
        given["service_s"] = {"factor": {"lognormal_sigma": float(rng.uniform(0.1, 0.5))}}
    if rng.random() < 0.3:
        given["tanks"] = {"least": 0.9, "most": 1.0}
    if rng.random() < 0.4:
        given["capture"] = {"success": float(rng.uniform(0.5, 1.0)), "tries": 2}
    chaser = chaser.replace(tank=tank)
    drawn = instance.replace(targets=targets, chasers=(chaser,))
    return drawn, Uncertainty.model_validate(given)


class _Way:
    """A way through the mission: when it is free, what its tank took, and chances so far."""

    def __init__(self, free: float, mean: float, square: float, chance: float) -> None:
        self.free, self.mean, self.square, self.chance = free, mean, square, chance

    def beats(self, other: _Way) -> bool:
        return (
            self.free <= other.free
            and self.mean <= other.mean
            and self.square <= other.square
            and self.chance >= other.chance
        )


def _stay(facts: MissionFacts, uncertainty: Uncertainty, target: int) -> StayTime:
    """Distribution of the time at a target."""
    planned_s = float(facts.chasers[0].limits.service[target])
    return StayTime(uncertainty, facts.names[target], planned_s)


def _best(facts: MissionFacts, uncertainty: Uncertainty, worths: dict[int, float]) -> float:
    """The most that any plan of one chaser with a tank in ΔV collects that keeps its promise."""
    what = facts.chasers[0]
    assert what.loads is None
    share, share_sigma = (1.0, 0.0) if uncertainty.tanks is None else uncertainty.tanks.moments
    full = what.budget
    allotted = {
        j: StayTime(uncertainty, facts.names[j], float(what.limits.service[j])).quantile(CONFIDENCE)
        for j in worths
    }

    def chance(way: _Way) -> float:
        sigma = math.sqrt(way.square + (share_sigma * full) ** 2)
        spare = share * full - what.spent - way.mean
        return float(spare >= 0.0) if sigma == 0.0 else NormalDist().cdf(spare / sigma)

    def flown(way: _Way, i: int, j: int) -> Iterator[_Way]:
        rows = facts.rows(i, j, towed=False)
        for row in np.flatnonzero(rows.departure >= way.free - 1e-6):
            kind = leg_kinds()[rows.family[row]].name
            name = None if j < facts.stations else facts.names[j]
            model = uncertainty.factor_of(kind, name)
            mean, sigma = (1.0, 0.0) if model is None else model.moments
            cost = float(rows.delta_v[row])
            begin = float(service_begin(what.limits.windows, j, rows.arrival[row]))
            stay = allotted.get(j, float(what.limits.service[j]))
            if begin + stay > what.limits.duration:
                continue
            then = _Way(
                begin + stay, way.mean + mean * cost, way.square + (sigma * cost) ** 2, way.chance
            )
            if way.chance * chance(then) < CONFIDENCE:
                continue
            if j < facts.stations:
                then = _Way(then.free, 0.0, 0.0, way.chance * chance(then))
            yield then

    def kept(ways: Iterator[_Way]) -> list[_Way]:
        found: list[_Way] = []
        for way in ways:
            if not any(each.beats(way) for each in found):
                found = [each for each in found if not way.beats(each)] + [way]
        return found

    def ends(route: list[int]) -> bool:
        here, ways = what.start, [_Way(what.limits.ready, 0.0, 0.0, 1.0)]
        for j in route:
            ways, here = kept(then for way in ways for then in flown(way, here, j)), j
        return bool(ways)

    best = 0.0
    for count in range(1, len(worths) + 1):
        for order in itertools.permutations(worths, count):
            if sum(worths[j] for j in order) <= best:
                continue
            for stops in itertools.product((None, *range(facts.stations)), repeat=count - 1):
                route = [order[0]]
                for stop, j in zip(stops, order[1:], strict=True):
                    route += [j] if stop is None else [stop, j]
                if ends(route):
                    best = sum(worths[j] for j in order)
                    break
    return best


@pytest.mark.parametrize(
    ("seed", "count", "most_missed"), [(3, 2, 1), pytest.param(4, 60, 12, marks=pytest.mark.slow)]
)
def test_bounds_hold_for_every_plan_that_keeps_its_promise(
    seed: int, count: int, most_missed: int
) -> None:
    """No plan found by exhaustive search collects more than the bound, and robust plans are some.

    Most of them are the best there are; those that are not have tanks that hold less often when
    they are rehearsed than by the normal distribution.
    """
    rng, missed = np.random.default_rng(seed), 0
    for _ in range(count):
        instance, uncertainty = _drawn(rng)
        facts = MissionFacts(instance)
        worths = _worths(facts, uncertainty)
        made = robust(instance, uncertainty, CONFIDENCE, method="exact", time_limit=20.0)
        best = _best(facts, uncertainty, worths)
        assert made.upper_bound >= best - 1e-6
        assert made.worth <= best + 1e-6 or made.plan is None
        if made.plan is not None:
            assert not adr_opt.check(instance, made.plan)
            promise = promise_of(facts, intended(facts, made.plan), uncertainty)
            assert promise.keeps(CONFIDENCE)
        missed += max(made.worth, 0.0) < best - 1e-6
    assert missed <= most_missed


def _worths(facts: MissionFacts, uncertainty: Uncertainty) -> dict[int, float]:
    """What going to each target is worth on average, as robust plans count it."""
    worths = TryWorths(facts.instance, uncertainty)
    return {body: worths.most(body) for body in range(facts.first_target, len(facts.names))}


@pytest.mark.parametrize("name", ["launched", "towed"])
def test_tanks_by_mass_hold_as_promised(name: str) -> None:
    """Where kits and tows change masses, tanks hold at least as often as is promised of them.

    A chaser stops before a leg that it cannot pay as planned, even if the leg turns out cheap.
    """
    instance = launched.campaign("two-body") if name == "launched" else towed_fields.field()
    plan = adr_opt.solve(instance, time_limit=3.0).plan
    facts = MissionFacts(instance)
    for sigma in (0.1, 0.4):
        uncertainty = Uncertainty(legs={"delta_v_factor": {"lognormal_sigma": sigma}})
        promise = promise_of(facts, intended(facts, plan), uncertainty)
        made = analysis.rehearse(instance, plan, uncertainty, samples=1000)
        kept = np.mean([each.as_planned for each in made.outcomes])
        assert promise.tanks
        assert kept >= promise.tanks_chance - 0.03


def test_plans_are_kept_as_often_as_asked() -> None:
    """A plan made with a confidence is kept in that share of rehearsals, a plain one is not."""
    instance = adr_opt.generate("reduced-fuel", seed=1, targets=15)
    uncertainty = Uncertainty(
        legs={"delta_v_factor": {"lognormal_sigma": 0.1}},
        service_s={"factor": {"lognormal_sigma": 0.1}},
    )
    made = analysis.robust(instance, uncertainty, 0.95, method="beam", time_limit=60.0)
    assert made.plan is not None
    assert not adr_opt.check(instance, made.plan)
    plain = adr_opt.solve(instance, method="beam").plan
    assert plain is not None

    def kept(plan: Plan) -> float:
        found = analysis.rehearse(instance, plan, uncertainty, samples=400, seed=7)
        return float(found.to_dict()["as_planned"]["share"])

    assert kept(made.plan) >= 0.915
    assert kept(plain) < 0.6


def test_a_tank_that_surely_runs_dry_is_promised_by_nobody() -> None:
    """A tank of which only a part can be used, less than its legs take, has no chance."""
    instance = adr_opt.generate("reduced-fuel", seed=1, targets=25)
    plan = adr_opt.solve(instance, method="greedy").plan
    facts = MissionFacts(instance)
    uncertainty = Uncertainty(tanks={"least": 0.2, "most": 0.2})
    promise = promise_of(facts, intended(facts, plan), uncertainty)
    assert promise.tanks_chance == 0.0
    assert not promise.keeps(0.5)


def test_worths_are_means_where_all_targets_have_one_chance() -> None:
    """Worth and bound count chances of captures also where they are the same everywhere."""
    instance = adr_opt.generate("tiny", seed=1)
    sure = robust(instance, Uncertainty(), 0.9, method="exact")
    half = robust(instance, Uncertainty(capture={"success": 0.5}), 0.9, method="exact")
    assert half.worth == pytest.approx(0.5 * sure.worth)
    assert half.upper_bound == pytest.approx(0.5 * sure.upper_bound)
    gone = Uncertainty(targets={instance.targets[0].name: {"gone": 1.0}})
    made = robust(instance, gone, 0.9, method="exact")
    assert made.worth == made.upper_bound <= len(instance.targets) - 1


def test_no_bound_is_stated_where_tanks_by_mass_are_used_in_part() -> None:
    """What a kit takes off the mass is no share of what is left, so that charges prove nothing."""
    instance = launched.campaign("two-body")
    made = robust(
        instance, Uncertainty(tanks={"least": 0.9}), 0.9, method="greedy-guarded", time_limit=5.0
    )
    assert made.upper_bound == math.inf
    assert not any("no plan" in note for note in made.notes)


def test_levels_stay_below_certainty() -> None:
    """However cautious, no level is 1, which no tank and no stay could keep."""
    highest = between(equal(0.95), equal(0.9999), 30.0)
    assert max(highest) < 1.0


@pytest.mark.parametrize("confidence", [0.3, 1.0, math.nan])
def test_other_confidences_are_refused(confidence: float) -> None:
    """A confidence is at least a half and below 1."""
    with pytest.raises(InputError, match="confidence"):
        robust(adr_opt.generate("tiny", seed=0), Uncertainty(), confidence)


SLIPS = Uncertainty(
    legs={"delta_v_factor": {"lognormal_sigma": 0.05}},
    service_s={"factor": {"lognormal_sigma": 0.2}},
    capture={"success": 0.9, "tries": 2},
    launches={"slip_s": {"chance": 0.3, "mean_s": DAY_S, "most_s": 5.0 * DAY_S}},
)


def _late(instance: Instance, **changes: Any) -> Instance:
    """The same with its launches in the opposite order, and another mission."""
    mission = instance.mission.replace(**changes)
    return instance.replace(chasers=instance.chasers[::-1], mission=mission)


def _briefly(instance: Instance, until_s: float) -> Instance:
    """The same with a last chaser that is there for a short time only."""
    *others, last = instance.chasers
    since_s = last.available_s[0]
    return instance.replace(
        chasers=(*others, last.replace(available_s=(since_s, since_s + until_s)))
    )


@pytest.mark.parametrize(
    "change",
    [
        lambda instance: instance,
        _late,
        lambda instance: instance.replace(
            mission=instance.mission.replace(launch_separation_s=DAY_S)
        ),
        lambda instance: _late(instance, launch_separation_s=0.0),
        lambda instance: _briefly(instance, 3600.0),
    ],
    ids=["in order", "turned", "apart", "order", "briefly"],
)
def test_launches_that_slip_are_planned_for(change) -> None:
    """A plan launches when slips are over with the confidence, and is kept that often."""
    instance = change(launched.campaign("two-body"))
    made = robust(instance, SLIPS, CONFIDENCE, "greedy-guarded", time_limit=60.0)
    assert made.plan is not None
    assert adr_opt.check(instance, made.plan) == ()
    assert made.worth <= made.upper_bound + 1e-6
    slip = SLIPS.slip_of("")
    least_s = slip_quantile(slip, CONFIDENCE)
    assert least_s > 0.5 * DAY_S
    since = {c.name: s for c, (s, _) in zip(instance.chasers, instance.available_s, strict=True)}
    flown = [route for route in made.plan.routes if route.legs]
    assert flown
    for route in flown:
        assert route.legs[0].departure_s >= since[route.chaser] + least_s
    found = analysis.rehearse(instance, made.plan, SLIPS, samples=400, seed=7)
    assert found.to_dict()["as_planned"]["share"] >= CONFIDENCE - 0.04


def test_the_slip_of_a_launch_delays_no_other() -> None:
    """What is proven holds for a plan whose only launch cannot slip, though one before it may."""
    instance = launched.campaign("two-body")
    instance = instance.replace(mission=instance.mission.replace(launch_separation_s=0.0))
    first, second = instance.chasers
    slips = Uncertainty(launches={"chasers": {first.name: {"chance": 1.0, "mean_s": 60.0 * DAY_S}}})
    problem = careful_problem(MissionFacts(instance), slips, equal(CONFIDENCE))
    assert problem.instance.available_s[1] == second.available_s
    assert problem.instance.available_s[0][0] > instance.mission.duration_s


def test_a_launch_may_be_stated_later() -> None:
    """Chosen departures may begin with a launch at any time from its first, and none before."""
    instance = launched.campaign("two-body")
    chaser, target = instance.chasers[1], instance.targets[0].name
    since_s = chaser.available_s[0]
    plan = adr_opt.plan_of(instance, {chaser.name: [(target, since_s + 3600.0)]})
    (leg,) = plan.legs
    assert (leg.departure_s, leg.arrival_s) == (since_s + 3600.0, since_s + 3600.0)
    assert adr_opt.check(instance, plan) == ()
    with pytest.raises(InputError, match="but may not before"):
        adr_opt.plan_of(instance, {chaser.name: [(target, since_s - 3600.0)]})
