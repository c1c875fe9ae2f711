"""The planner `ortools` with several chasers: windows of one or two of them in one model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from brute_force import brute_force_campaign
from calling import call
from random_rules import carrying, random_campaign

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from adr_opt.mission.result import Result
from solvers.beams.beams import with_time_value
from solvers.beams.greedy_order import guarded_sequence
from solvers.planners.ortools_windows import ortools, unrolling
from solvers.planners.ortools_windows.fleet import Fleet
from solvers.planners.ortools_windows.joined import joined
from solvers.planners.ortools_windows.model import best_paths
from solvers.planners.ortools_windows.prices import edge_worths
from solvers.planners.ortools_windows.window_network import SlackWorth, UnrollLimits, Window
from solvers.routes.one_chaser import one_after_another

LIMITS = UnrollLimits(20_000, 10, 0.02, 1.0)
WORTH = SlackWorth(1e-6, 1e-4)
FLOOR = -1e3
"""Below all worths."""


class Found(NamedTuple):
    """Best paths through windows."""

    paths: tuple[tuple[int, ...], ...]
    worth: float
    bound: float


@pytest.fixture(scope="module")
def campaign() -> Problem:
    """Two chasers that have to leave targets out."""
    drawn = adr_opt.generate("campaign", 2, targets=24, chasers=2, stations=2)
    return Problem(drawn.with_limits(duration_s=4 * 86400.0))


def plan(campaign: Problem, windows: int = 8, **how: object) -> Result:
    """A result that passes the check."""
    result = call(ortools, campaign, **{"stop": MaxIterations(windows), **how})
    assert adr_opt.check(campaign.instance, result.plan) == ()
    return result


def test_launches_are_planned_and_kits_refused() -> None:
    """Chasers that start anywhere pass `check`, none better than enumeration; kits are refused.

    The sentence names methods that know them.
    """
    refused = launched = 0
    for seed in range(40):
        instance = carrying(random_campaign(seed), seed)
        campaign = Problem(instance)
        if any(mission.rules.loads is not None for mission in campaign.missions):
            said = (
                r"'ortools' does not follow (kits|tanks not full by mass).*"
                r"auto, exact, greedy, greedy-guarded, or leave it out$"
            )
            with pytest.raises(InputError, match=said):
                adr_opt.solve(campaign, "ortools", iterations=1)
            refused += 1
            continue
        prizes, _ = brute_force_campaign(campaign)
        result = adr_opt.solve(campaign, "ortools", iterations=6)
        if result.plan is not None:
            assert adr_opt.check(instance, result.plan) == (), seed
            assert result.objective <= prizes + 1e-9, seed
            started = {leg.origin for leg in result.plan.legs}
            launched += any(c.is_launched and c.name in started for c in instance.chasers)
    assert refused > 5
    assert launched > 0


def fleet_of(campaign: Problem, routes: object = None) -> Fleet:
    """The guarded greedy plan, or another one, as windows see it."""
    layers = tuple(with_time_value(mission) for mission in campaign.missions)
    if routes is None:
        routes = one_after_another(campaign, guarded_sequence)
    return Fleet.flying(campaign, layers, [np.array(route, dtype=np.int64) for route in routes])


def test_gains_on_guarded_greedy(campaign: Problem) -> None:
    """Windows service more targets than the greedy plan that they begin with."""
    greedy = adr_opt.solve(campaign, "greedy-guarded")
    result = plan(campaign, windows=16)
    assert result.objective >= greedy.objective + 1.0
    assert result.counters["windows"] == 16


def test_same_seed_same_plan(campaign: Problem) -> None:
    """Seed, windows and jobs fix routes and counters; another seed searches elsewhere."""
    one, two, other = (plan(campaign, windows=5, seed=seed) for seed in (3, 3, 4))
    assert (one.routes, one.counters) == (two.routes, two.counters)
    assert (other.routes, other.counters) != (one.routes, one.counters)
    threads = [plan(campaign, windows=5, jobs=2) for _ in range(2)]
    assert (threads[0].routes, threads[0].counters) == (threads[1].routes, threads[1].counters)


@pytest.mark.parametrize("seed", range(3))
def test_a_campaign_of_one_is_the_mission(seed: int) -> None:
    """One chaser planned as a campaign flies what it flies as a mission, window by window."""
    instance = adr_opt.generate("reduced-fuel", seed, targets=16).with_limits(
        duration_s=3 * 86400.0
    )
    alone, several = (plan(problem(instance), windows=5) for problem in (Mission, Problem))
    assert several.routes == (alone.sequence,)
    assert several.counters == alone.counters


def test_begins_from_a_start_plan(campaign: Problem) -> None:
    """A start plan is never left worse, and an illegal one is refused."""
    good = plan(campaign, windows=12)
    again = plan(campaign, windows=1, start=good.routes)
    assert again.objective >= good.objective
    assert plan(campaign, windows=6, start=((), ())).objective > 0.0
    first = campaign.instance.first_target
    with pytest.raises(InputError, match="start plan"):
        plan(campaign, start=((first, first), ()))


def test_a_fleet_offers_what_others_leave(campaign: Problem) -> None:
    """A chaser may fly its own targets, unvisited ones, and those of chasers replanned with it."""
    fleet = fleet_of(campaign)
    own, other = (set(order.moves[order.moves >= 2].tolist()) for order in fleet.orders)
    open_to = {
        anew: set(np.flatnonzero(fleet.offered(0, anew=anew).rules.prize > 0.0).tolist())
        for anew in ((), (1,))
    }
    everything = set(range(campaign.instance.first_target, len(campaign.names)))
    assert own
    assert other
    assert open_to[()] == everything - other
    assert open_to[1,] == everything
    assert fleet.objective == len(own | other) == len(own) + len(other)


def whole_windows(fleet: Fleet) -> list[Window]:
    """Everything that each chaser flies, planned anew together."""
    windows = []
    for order, layer in zip(fleet.orders, fleet.layers, strict=True):
        rules, pace = layer.rules, order.pace(WORTH)
        values = np.concatenate(([0.0], np.cumsum(rules.prize[order.moves])))
        values = values - WORTH.per_m_s * pace.costs - WORTH.per_s * (pace.times - pace.times[0])
        windows.append(
            Window(
                int(rules.start),
                float(rules.ready),
                float(rules.budget),
                np.flatnonzero(rules.prize > 0.0),
                np.empty(0, np.int64),
                float(rules.duration),
                2 if rules.stations else 0,
                int(rules.limits.targets),
                pace.times,
                values,
            )
        )
    return windows


def best_of(campaign: Problem, layers: Sequence[Mission], windows: Sequence[Window]) -> Found:
    """The best paths through some windows, what they are worth, and what prices say."""
    nets = [
        unrolling.grow(layer.rules, WORTH, window, LIMITS)
        for layer, window in zip(layers, windows, strict=True)
    ]
    parts = zip([layer.rules for layer in layers], windows, nets, strict=True)
    together = joined(list(parts))
    bound, worths = edge_worths(together, WORTH, FLOOR, 60)
    how = {"unit": 1.0, "seed": 0, "effort": 20.0, "remaining_s": math.inf}
    answer = best_paths(together, WORTH, np.arange(worths.size), FLOOR, **how)
    assert answer.closed
    assert answer.paths is not None
    worth = worth_of(layers, answer.paths)
    # Who keeps only what prices do not exclude loses nothing.
    kept = np.flatnonzero(worths >= worth - 1e-6)
    again = best_paths(together, WORTH, kept, FLOOR, **how)
    assert again.paths is not None
    assert worth_of(layers, again.paths) == pytest.approx(worth, abs=1e-4)
    return Found(answer.paths, worth, bound)


def worth_of(layers: Sequence[Mission], paths: Sequence[tuple[int, ...]]) -> float:
    """What paths are worth, each flown by the rules."""
    worth = 0.0
    for layer, path in zip(layers, paths, strict=True):
        rules, ends = layer.rules, np.empty((2, len(path)))
        made, delta_v, state = rule_kernels.replay(
            rules,
            np.array(path, dtype=np.int64),
            rule_kernels.beginning(rules),
            np.zeros(rules.service.size, dtype=np.bool_),
            *ends,
        )
        assert made == len(path)
        worth += float(rules.prize[list(path)].sum())
        worth -= WORTH.per_m_s * delta_v + WORTH.per_s * state.resources.time
    return worth


def test_two_windows_are_one_model() -> None:
    """The best paths of two chasers share no target, can be flown, and keep below the bound.

    They are worth at least what one after the other is, and here and there more: the first leaves
    the second what that does better.
    """
    several = better = 0
    for seed in range(40):
        campaign = Problem(random_campaign(seed))
        fleet = fleet_of(campaign)
        if campaign.required or fleet.objective <= 0.0:
            continue
        layers, windows = fleet.layers[:2], whole_windows(fleet)[:2]
        found = best_of(campaign, layers, windows)
        first = campaign.instance.first_target
        targets = [j for path in found.paths for j in path if j >= first]
        assert len(set(targets)) == len(targets)
        assert found.worth <= found.bound + 1e-6
        alone = best_of(campaign, layers[:1], windows[:1])
        rest = np.setdiff1d(windows[1].open_targets, alone.paths[0])
        then = best_of(campaign, layers[1:], [windows[1]._replace(open_targets=rest)])
        assert found.worth >= alone.worth + then.worth - 1e-4
        several += all(found.paths)
        better += found.worth > alone.worth + then.worth + 0.1
    assert several > 5
    assert better > 0


def test_one_window_joined_is_itself(campaign: Problem) -> None:
    """The network of one window is what it was, with its tanks and targets beside it."""
    fleet = fleet_of(campaign)
    layer, window = fleet.layers[0], whole_windows(fleet)[0]
    net = unrolling.grow(layer.rules, WORTH, window, LIMITS)
    together = joined([(layer.rules, window, net)])
    for mine, other in zip(net, together.net, strict=True):
        assert np.array_equal(mine, other)
    assert together.tanks.tolist() == [layer.rules.budget] * 3
    assert (together.net.onward == -1).all()
