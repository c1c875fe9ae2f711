"""Subset-row cuts, and proofs with them, against enumeration."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations
from typing import ClassVar

import numpy as np
import pytest
from against_enumeration import compared
from paying_routes import random_cuts, routes_of, toll_of
from random_rules import (
    carrying,
    drifting_mission,
    given_field,
    given_mission,
    mixed_campaign,
    random_campaign,
    towing,
)
from roomy_fields import roomy, roomy_and_laden, roomy_launched, tight
from seeds import over_kinds
from verify_fields import FEW, most_collected, towing_and_laden

import adr_opt
from adr_opt.judge.verify import verify
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.evidence import Evidence
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem
from solvers.columns import proof
from solvers.columns.subset_rows import VIOLATED, SubsetRows, violated_rows
from solvers.labels.label_search import LabelSearch
from solvers.walks.walks import WalkBound

every_mission = over_kinds(
    "draw, seeds",
    **{
        draw.__name__: (draw, range(60), 3)
        for draw in (
            roomy,
            roomy_launched,
            roomy_and_laden,
            drifting_mission,
            given_mission,
            towing_and_laden,
        )
    },
)


def small(mission: Mission) -> bool:
    """Whether its routes can be gone through one by one."""
    return len(mission.names) - len(mission.instance.targets) < 4


@every_mission
def test_the_best_walk_is_the_best_route_less_its_tolls(draw, seeds):
    """Whatever is paid and remembered of cuts, labels find what enumeration finds."""
    paying = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        rng = np.random.default_rng([21, seed])
        if not small(mission):
            continue
        cuts = random_cuts(rng, mission)
        multipliers = rng.uniform(0.0, 0.7, len(mission.names)) * mission.planning_prizes
        gains = mission.planning_prizes - multipliers
        first = mission.instance.first_target
        found = {
            route: math.fsum(gains[j] for j in route if j >= first) - toll_of(route, cuts)
            for route in routes_of(mission)
        }
        best = max(found.values(), default=-math.inf)
        search = LabelSearch(WalkBound(mission, 20.0))
        search.neighbourhood[:] = -1
        search.cut(cuts)
        search.use(multipliers)
        scale = max(float(mission.planning_prizes.max()), 1e-9)
        least = search.total - 3.0 * scale
        finished, value, plan, _ = search.search(least, 10**6, lambda: False)
        assert finished, seed
        if best < -3.0 * scale:
            continue
        assert value - search.total == pytest.approx(best, abs=1e-6 * scale), seed
        moves = () if plan is None else tuple(plan.tolist())
        assert found[moves] == pytest.approx(best, abs=1e-6 * scale), seed
        paying += any(toll_of(route, cuts) > 0.0 for route in found)
    assert paying > len(seeds) / 10 or draw is towing_and_laden


@every_mission
def test_every_set_of_targets_is_listed_less_its_tolls(draw, seeds):
    """Where all sets are told apart, each pays for the cuts of which it services two rows."""
    listed = 0
    for seed in seeds:
        mission = Mission(draw(seed))
        rng = np.random.default_rng([22, seed])
        if not small(mission):
            continue
        cuts = random_cuts(rng, mission, 70)
        multipliers = rng.uniform(0.0, 0.7, len(mission.names)) * mission.planning_prizes
        first = mission.instance.first_target
        worths = {
            targets: math.fsum(mission.planning_prizes[j] - multipliers[j] for j in targets)
            - math.fsum(cut.multiplier for cut in cuts if len(targets & set(cut.rows)) > 1)
            for targets in (
                frozenset(j for j in route if j >= first) for route in routes_of(mission)
            )
        }
        scale = float(mission.planning_prizes.max())
        least = float(rng.choice([-1.0, 0.0, 0.4])) * scale
        search = LabelSearch(WalkBound(mission, 20.0), all_sets=True)
        search.cut(cuts, forgetful=False)
        search.use(multipliers)
        finished, _, _, _ = search.search(search.total + least, 10**6, lambda: False)
        assert finished, seed
        found = {frozenset(j for j in route if j >= first) for route in search.plans(10**6)}
        some = {targets for targets in worths if targets}
        off = 1e-6 * scale
        assert found >= {each for each in some if worths[each] > least + off}, seed
        assert found - {frozenset()} <= {each for each in some if worths[each] > least - 1e-3}, seed
        listed += len(found)
    assert listed > 0.5 * len(seeds)


def test_violated_cuts_are_those_of_enumeration():
    """The cuts that a mixture violates most are found, and none that it does not violate."""
    most = 0
    for seed in range(60):
        rng = np.random.default_rng([23, seed])
        routes = [
            frozenset(rng.choice(9, int(rng.integers(1, 6)), replace=False)) for _ in range(8)
        ]
        shares = rng.uniform(0.0, 0.9, 8) * rng.integers(0, 2, 8)
        excess = {
            rows: sum(s for s, r in zip(shares, routes, strict=True) if len(r & set(rows)) > 1) - 1
            for rows in combinations(range(9), 3)
        }
        found = violated_rows(routes, shares, 9)
        assert all(excess[rows] > VIOLATED - 1e-9 for rows in found), seed
        worst = max(excess.values())
        assert bool(found) == (worst > VIOLATED), seed
        if found:
            assert excess[found[0]] == pytest.approx(worst, abs=1e-5), seed
            most += 1
    assert most > 20


def test_memory_grows_until_routes_pay():
    """What a cut remembers is enough for a route to pay once, and no more than needed for that."""
    for seed in range(100):
        rng = np.random.default_rng([24, seed])
        route = tuple(rng.permutation(10)[: int(rng.integers(2, 9))].tolist())
        cuts = SubsetRows()
        cuts.add([tuple(sorted(rng.choice(10, 3, replace=False).tolist()))], [])
        times = min(1, len(set(route) & set(cuts.rows[0])) // 2)
        grown = cuts.remember(route, np.ones(1))
        assert toll_of(route, cuts.priced(np.ones(1))) == times, seed
        assert cuts.remember(route, np.ones(1)) == 0, seed
        assert (grown == 0) or times == 1, seed


class CutAtRandom(proof.ColumnProof):
    """Column generation with cuts from the start, paid for whatever the master says.

    Attributes
    ----------
    shown : list of Evidence
        Of all bounds.
    """

    shown: ClassVar[list[Evidence]] = []

    def begin(self) -> None:
        """No descent, which would leave nothing to prove, but cuts."""
        first, bodies = self._problem.instance.first_target, len(self._problem.names)
        rows = list(combinations(range(first, bodies), 3))
        drawn = self._rng.permutation(len(rows))[:6]
        self._master.cut(self._cuts.add([rows[at] for at in drawn], []))

    def _near(self, duals):
        near = super()._near(duals)
        more = self._largest * self._rng.uniform(0.0, 0.3, near.cuts.size)
        return near._replace(cuts=near.cuts + more)

    def _evidence(self, multipliers):
        self.shown.append(super()._evidence(multipliers))
        return self.shown[-1]


@over_kinds(
    "draw, seeds",
    two_body=(tight, range(200), 3),
    j2=(drifting_mission, range(20), 1),
    given=(given_field, range(30), 3),
)
@pytest.mark.parametrize("make", [random_campaign, mixed_campaign])
def test_proofs_with_cuts_hold(make, draw, seeds, monkeypatch):
    """With any cuts and multipliers, what is proven is what enumeration finds, and verified.

    Without floors, which would leave nothing to prove of some of them.
    """
    monkeypatch.setattr("solvers.planners.many_routes.ColumnProof", CutAtRandom)
    monkeypatch.setattr(
        "solvers.planners.many_routes.floor_evidence", lambda problem: (math.inf, None)
    )
    planned = cut = 0
    for seed in seeds:
        instance = make(seed, draw)
        if seed % 2:
            instance = carrying(instance, seed)
        if seed % 5 == 0 and instance.given is None:
            instance = towing(instance, seed)
        CutAtRandom.shown.clear()
        result = adr_opt.solve(instance, "exact", time_limit=30.0, iterations=6)
        planned += compared(Problem(instance), result, seed)
        most = most_collected(instance)
        for evidence in CutAtRandom.shown[:3]:
            # The certificate is that of what follows from the evidence.
            shown = replace(result, evidence=evidence, status="feasible", upper_bound=0.0)
            certificate = certificate_of(instance, shown)
            assert adr_opt.Certificate.from_json(certificate.to_json()) == certificate
            verdict = verify(instance, None, certificate, connections=FEW)
            assert verdict.verified, (seed, verdict.reasons)
            assert verdict.upper_bound >= most - 1e-9, seed
            cut += bool(certificate.cuts)
    assert planned > 0.4 * len(seeds)
    assert cut > 0.05 * len(seeds)
