"""The learned policy in rehearsals: what it sees, and that missions are flown by it."""

from __future__ import annotations

import launched
import numpy as np
import pytest
import towed_fields
from drawn_worlds import drawn_uncertainty
from random_rules import random_campaign, random_mission

import adr_opt
from adr_opt.analysis.rehearse.flight import Halt, Situation, rehearsed
from adr_opt.analysis.rehearse.flying_chasers import DRY, FINISHED, LATE, beginning, refused
from adr_opt.analysis.rehearse.intended import Intended
from adr_opt.analysis.rehearse.learned import Learned
from adr_opt.analysis.rehearse.mission_facts import Hop, MissionFacts
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.analysis.rehearse.service_delays import largest_delays_s, mean_delays_s
from adr_opt.analysis.rehearse.visible_legs import KEPT, VisibleLegs
from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.kernels.episodes.choices import CHOICE_FIELDS, MISSION_FIELDS
from adr_opt.learning.episodes import (
    Board,
    FieldPool,
    UncertainPool,
    begin_in_worlds,
    new_episodes,
    new_worlds,
    start,
)
from adr_opt.learning.policy import Policy, shapes
from adr_opt.mission.mission import Mission
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld

CERTAIN = Uncertainty()


def drawn_policy(seed: int) -> Policy:
    rng = np.random.default_rng(seed)
    drawn = {
        name: (0.3 * rng.standard_normal(shape)).astype(np.float32)
        for name, shape in shapes(16, 1).items()
    }
    return Policy(drawn, {"seed": seed})


def without_plan(ground: MissionFacts) -> Intended:
    most = [0 if each.loads is None else each.loads.full.size - 1 for each in ground.chasers]
    return Intended(None, ((),) * len(ground.chasers), tuple(most))


@pytest.mark.parametrize(
    "model", [CERTAIN, Uncertainty(gone=0.1, legs={"delta_v_factor": {"lognormal_sigma": 0.2}})]
)
def test_rehearsals_and_episodes_see_the_same_numbers(model: Uncertainty) -> None:
    """Rows made of connections on demand are those made of timetables, in all worlds."""
    instance = adr_opt.generate("nominal", 7, targets=22)
    mission, facts = Mission(instance), MissionFacts(instance)
    pool, episodes = FieldPool.of(mission), new_episodes(1, 23)
    start(pool, episodes, 0, 0, instance.chaser.tank.delta_v_m_s, instance.mission.duration_s)
    uncertain = UncertainPool(pool, [model])
    uncertain.install(0)
    worlds, first = new_worlds(uncertain, 1), np.zeros(1, dtype=np.int32)
    begin_in_worlds(pool, episodes, worlds, first, (first, first))
    board, visible = Board("choices", 1, 22), VisibleLegs(facts, model)
    for step in range(12):
        board.observe(pool.arrays, episodes, 0, 1, worlds)
        craft = beginning(facts, 0, 0, float(episodes.time[0]), 1.0)
        craft.body, craft.left = int(episodes.body[0]), float(episodes.left[0])
        craft.since, craft.serviced = int(episodes.since[0]), int(episodes.serviced[0])
        closed = set(np.flatnonzero(episodes.visited[0]).tolist())
        seen = visible.seen(craft, closed, [], None)
        assert seen.bodies.size == 23 - len(closed)
        rows = board.choices.moves[0, [kernels.action_of(j, 22) for j in seen.bodies.tolist()]]
        for column, name in enumerate(CHOICE_FIELDS):
            assert seen.moves[0, :, column] == pytest.approx(rows[:, column], abs=2e-5), name
        for column, name in enumerate(MISSION_FIELDS):
            wanted = board.choices.mission[0, column]
            assert seen.mission[0, column] == pytest.approx(wanted, abs=2e-5), name
        rows = board.choices.moves[0]
        cost = np.where(board.mask[0], rows[:, CHOICE_FIELDS.index("legal")] * rows[:, 7], np.inf)
        action = np.array([22 if step == 8 and board.mask[0, 22] else cost.argmin()])
        kernels.act(pool.arrays, episodes, 0, 1, action, np.zeros(1, dtype=np.float32))


@pytest.mark.parametrize("zones", [0, 3])
def test_legs_on_demand_are_those_of_lists(zones: int) -> None:
    """What is seen from a body is what a chaser takes that is ready there."""
    instance = adr_opt.generate("tiny", 3, targets=8, zones=zones)
    ground = MissionFacts(instance)
    visible = VisibleLegs(ground, CERTAIN)
    seen = 0
    for body, free_s in ((0, 0.0), (3, 20_000.0), (5, 61_234.5)):
        craft = beginning(ground, 0, 0, free_s, 1.0)
        craft.body, craft.since = body, 1
        choices = visible.seen(craft, {2}, [], None)
        assert 2 not in choices.bodies
        assert body not in choices.bodies[1:]
        for at, j in enumerate(choices.bodies.tolist()):
            hop = None if j == body else ground.best(body, j, free_s, towed=False)
            if hop is None or refused(ground, craft, hop) == "duration":
                assert not choices.legal[at]
                continue
            assert (choices.delta_v[at], choices.arrival[at]) == pytest.approx(
                (hop.delta_v, hop.arrival), rel=1e-9
            )
            own = visible.hop(craft, j, choices.arrival[at], choices.delta_v[at])
            assert own == pytest.approx(hop, rel=1e-12)
            assert choices.legal[at] == (not refused(ground, craft, hop))
            seen += 1
    assert seen > 15


def test_legs_from_disposal_orbits_are_those_of_lists() -> None:
    """A chaser that has towed an object away leaves from the disposal orbit, any other from it."""
    ground = MissionFacts(towed_fields.field())
    visible = VisibleLegs(ground, CERTAIN)
    body = min(ground.tow_s)
    found = []
    for towed in (False, True):
        craft = beginning(ground, 0, 1, 30_000.0, 1.0)
        craft.body, craft.since, craft.towed = body, 1, towed
        choices = visible.seen(craft, set(), [], None)
        for at in np.flatnonzero(np.isfinite(choices.delta_v)):
            j = int(choices.bodies[at])
            hop = ground.best(body, j, craft.free_s, towed=towed)
            own = visible.hop(craft, j, choices.arrival[at], choices.delta_v[at])
            assert own == pytest.approx(hop, rel=1e-12)
            found.append(own)
    assert len(found) > 4
    assert len(set(found)) == len(found)


def test_delays_of_services_are_those_of_targets_one_by_one() -> None:
    """What is said of all targets and what is said of each gives the same delays, to the bit."""
    instance = adr_opt.generate("tiny", 3, targets=5)
    mission = instance.mission.replace(service_s=None, service_revolutions=2.0)
    ground = MissionFacts(instance.replace(mission=mission))
    service = {"factor": {"lognormal_sigma": 0.4}, "added": {"chance": 0.3, "mean_s": 9000.0}}
    for_all = {"service_s": service, "capture": {"success": 0.7, "tries": 3}, "gone": 0.1}
    everywhere = Uncertainty(**for_all)
    each = {"service_s": service, "success": 0.7, "tries": 3, "gone": 0.1}
    apart = Uncertainty(targets={target.name: each for target in instance.targets})
    some = Uncertainty(targets={instance.targets[2].name: each}, **for_all)
    for delays in (mean_delays_s, lambda *asked: largest_delays_s(*asked, 0.9)):
        known = delays(ground, everywhere)
        assert (known[ground.first_target :] > 0.0).all()
        assert len(set(known[ground.first_target :].tolist())) > 1  # periods differ
        assert (known[: ground.first_target] == 0.0).all()
        for other in (apart, some):
            assert (delays(ground, other) == known).all()


def test_few_of_many_targets_are_looked_at() -> None:
    """Of a large field the cheapest of the nearest, required and planned next ones, are seen."""
    instance = adr_opt.generate("nominal", 3, targets=150)
    far = instance.targets[-1].replace(required=True)
    instance = instance.replace(targets=(*instance.targets[:-1], far))
    ground = MissionFacts(instance)
    craft = beginning(ground, 0, 0, 0.0, 1.0)
    choices = VisibleLegs(ground, CERTAIN).seen(craft, set(), [140], None)
    assert choices.bodies.size == KEPT
    assert {140, 150} <= set(choices.bodies.tolist())


class Watched(Learned):
    """The learned policy, whose legs are looked at before they are flown."""

    flown = 0

    def next_leg(self, now: Situation) -> Hop | Halt:
        """A leg that may begin, to a body that is open."""
        found = super().next_leg(now)
        if isinstance(found, Hop) and now.craft.made:
            assert not refused(self._facts, now.craft, found)
        if isinstance(found, Hop):
            assert found.destination not in now.closed
            assert found.destination != now.craft.body
            Watched.flown += 1
        return found


def tiny(seed: int) -> Instance:
    return adr_opt.generate("tiny", seed, targets=8)


@pytest.mark.parametrize("draw", [random_mission, random_campaign, tiny])
def test_every_leg_may_begin(draw) -> None:  # type: ignore[no-untyped-def]
    """Whatever the weights, rules and worlds, no leg is chosen that a chaser may not fly.

    And no chaser of the policy ends by a leg that is refused, nor halts while a target is in reach.
    """
    Watched.flown, stopped = 0, 0
    for seed in range(24):
        instance = draw(seed)
        uncertainty = drawn_uncertainty(instance, seed)
        ground = MissionFacts(instance)
        planned = without_plan(ground)
        policy = Watched(ground, planned, uncertainty, 0, drawn_policy(seed))
        done = rehearsed(ground, DrawnWorld(instance, uncertainty, seed), policy, planned.kits)
        closed = {made.hop.destination for craft in done.chasers for made in craft.made}
        for craft in done.chasers:
            assert craft.ended in (FINISHED, LATE, DRY)
            if craft.ended == FINISHED and craft.made:
                stopped += 1
                for j in sorted(set(ground.prizes) - closed):
                    hop = ground.best(craft.body, j, craft.free_s, towed=craft.towed)
                    assert hop is None or refused(ground, craft, hop)
    assert Watched.flown > 10
    assert stopped > 0


@pytest.mark.parametrize("kind", ["launched", "towed", "drifting"])
def test_campaigns_with_kits_tows_and_drifts_are_flown_without_a_plan(kind: str) -> None:
    """Where connections are listed, and loads change the tank, targets are serviced as well."""
    instance: Instance = {
        "launched": lambda: launched.campaign("two-body"),
        "towed": towed_fields.field,
        "drifting": lambda: launched.campaign("j2"),
    }[kind]()
    ground = MissionFacts(instance)
    planned = without_plan(ground)
    policy = Watched(ground, planned, CERTAIN, 0)
    done = rehearsed(ground, DrawnWorld(instance, CERTAIN, 0), policy, planned.kits)
    assert done.serviced


def test_ppo_is_another_name_of_it() -> None:
    """`--policy ppo` is the learned policy."""
    assert policy_of("ppo") is policy_of("learned") is Learned
