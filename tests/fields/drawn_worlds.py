"""Uncertainty models drawn at random, and a policy that decides at random."""

from __future__ import annotations

import numpy as np

import adr_opt
from adr_opt.analysis.rehearse.flight import Halt, Situation, rehearsed
from adr_opt.analysis.rehearse.flying_chasers import refused
from adr_opt.analysis.rehearse.intended import intended
from adr_opt.analysis.rehearse.mission_facts import Hop, MissionFacts
from adr_opt.analysis.rehearse.policies import policy_of
from adr_opt.plan.leg_kinds import leg_kinds
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import ServiceUncertainty, Uncertainty
from adr_opt.problem.world import DrawnWorld

LATE = ServiceUncertainty.model_validate(
    {"factor": {"lognormal_sigma": 0.6}, "added": {"chance": 0.3, "mean_s": 4000.0}}
)
"""Times of services of which many are much longer than planned."""

RANDOM_POLICIES = 40

ROWS = 3
"""Number of connections of a pair among which is chosen."""


def drawn_uncertainty(instance: Instance, seed: int) -> Uncertainty:
    """A model in which each kind of event is there or not."""
    rng = np.random.default_rng([77, seed])
    content: dict[str, object] = {}
    if rng.random() < 0.6:
        factor = {"lognormal_sigma": float(rng.choice([0.05, 0.4])), "least": 0.4, "most": 3.0}
        content["legs"] = {"delta_v_factor": factor}
    if rng.random() < 0.6:
        content["service_s"] = {
            "factor": {"lognormal_sigma": 0.5},
            "added": {"chance": 0.3, "mean_s": 0.1 * instance.mission.duration_s},
        }
    if rng.random() < 0.7:
        given = instance.transfer.given is not None
        tries = 1 if given else int(rng.integers(1, 4))
        content["capture"] = {"success": float(rng.choice([0.5, 0.8])), "tries": tries}
    if rng.random() < 0.4:
        content["gone"] = 0.2
    if rng.random() < 0.5:
        content["launches"] = {"slip_s": {"mean_s": 0.1 * instance.mission.duration_s}}
    if rng.random() < 0.4:
        content["tanks"] = {"least": 0.7}
    own = instance.targets[0].name
    targets: dict[str, dict[str, object]] = {}
    if rng.random() < 0.3:
        targets[own] = {"success": 0.3, "gone": 0.1}
    if rng.random() < 0.4:
        kinds = {
            kind.name: {"lognormal_sigma": float(rng.choice([0.1, 0.5])), "least": 0.3}
            for kind in leg_kinds()
            if rng.random() < 0.5
        }
        content["legs"] = {**content.get("legs", {}), "kinds": kinds}  # type: ignore[dict-item]
    if rng.random() < 0.4:
        other = targets.setdefault(instance.targets[-1].name, {})
        other["delta_v_factor"] = {"lognormal_sigma": 0.4, "most": 4.0}
        other["service_s"] = {} if rng.random() < 0.5 else {"factor": {"lognormal_sigma": 0.3}}
    if targets:
        content["targets"] = targets
    return Uncertainty(**content)


class AtRandom:
    """A policy that flies anywhere at random, at once or a little later, and gives up at random."""

    def __init__(self, ground: MissionFacts, rng: np.random.Generator) -> None:
        self._ground, self._rng = ground, rng

    def next_leg(self, now: Situation) -> Hop | Halt:
        """Some leg that may begin."""
        ground, craft, rng = self._ground, now.craft, self._rng
        start = ground.chasers[craft.chaser].start
        hops = []
        for j in range(len(ground.names)):
            is_target = j >= ground.first_target and j not in now.closed
            if j == craft.body or not (is_target or j < ground.stations):
                continue
            rows = ground.rows(craft.body, j, towed=craft.towed)
            first = int(np.searchsorted(rows.departure, craft.free_s - 1e-6))
            if ground.chasers[craft.chaser].is_launched and craft.body == start:
                first = 0
            for row in range(first, min(first + ROWS, rows.departure.size)):
                hop = Hop(
                    j,
                    float(rows.departure[row]),
                    float(rows.arrival[row]),
                    float(rows.delta_v[row]),
                    int(rows.family[row]),
                    int(rows.revolutions[row]),
                )
                if not refused(ground, craft, hop):
                    hops.append(hop)
        if not hops or rng.random() < 0.02:
            return Halt("finished")
        return hops[int(rng.integers(len(hops)))]

    def tries_again(self, now: Situation, target: int, tries: int) -> bool:
        """Now and then."""
        return bool(self._rng.random() < 0.7)


def all_flown(ground: MissionFacts, world: DrawnWorld, seed: int):  # type: ignore[no-untyped-def]
    """Rehearsals of one world by policies that decide at random, and by those that come along."""
    most = [0 if each.loads is None else each.loads.full.size - 1 for each in ground.chasers]
    for number in range(RANDOM_POLICIES):
        rng = np.random.default_rng([seed, number])
        kits = tuple(int(rng.integers(0, each + 1)) for each in most)
        yield rehearsed(ground, world, AtRandom(ground, rng), kits)
    plan = adr_opt.solve(ground.instance, time_limit=5.0).plan
    if plan is not None:
        planned = intended(ground, plan)
        for name in ("follow", "skip", "replan", "learned"):
            yield rehearsed(
                ground, world, policy_of(name)(ground, planned, world.uncertainty, 0), planned.kits
            )
