"""The learned choice of the next leg: what it sees, how it scores, and that it is flown by."""

from __future__ import annotations

import io
import zipfile
from importlib import import_module
from pathlib import Path
from typing import Any

import launched
import next_leg_seen
import numpy as np
import numpy.typing as npt
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
from adr_opt.analysis.rehearse.visible_legs import RANKS, VisibleLegs
from adr_opt.common.errors import InputError
from adr_opt.learning.next_leg import features as seen_module
from adr_opt.learning.next_leg import onward as onward_module
from adr_opt.learning.next_leg.features import LEG_FEATURES, MISSION_FEATURES
from adr_opt.learning.next_leg.onward import OnwardLegs
from adr_opt.learning.next_leg.scorer import LegScorer, ScorerLayers, load_scorer, shapes, shipped
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.problem.world import DrawnWorld

CERTAIN = Uncertainty()
FloatArray = npt.NDArray[np.float64]

# Modules by name: the package has a function of the name `rehearse`.
learned_module = import_module("adr_opt.analysis.rehearse.learned")
sight_module = import_module("adr_opt.analysis.rehearse.visible_legs")


def drawn_scorer(seed: int) -> LegScorer:
    rng = np.random.default_rng(seed)
    drawn = {
        name: (0.3 * rng.standard_normal(shape)).astype(np.float32)
        for name, shape in shapes(16).items()
    }
    return LegScorer(ScorerLayers(**drawn), {"seed": seed})


def without_plan(ground: MissionFacts) -> Intended:
    most = [0 if each.loads is None else each.loads.full.size - 1 for each in ground.chasers]
    return Intended(None, ((),) * len(ground.chasers), tuple(most))


def test_scores_do_not_depend_on_the_order_of_legs() -> None:
    """Legs in another order have the same scores, and those that are not legal have none."""
    rng = np.random.default_rng(0)
    scorer = drawn_scorer(1)
    legs, mission = rng.normal(size=(9, LEG_FEATURES)), rng.normal(size=MISSION_FEATURES)
    legal = rng.random(9) < 0.7
    scores = scorer.scores(legs, mission, legal)
    order = rng.permutation(9)
    assert scorer.scores(legs[order], mission, legal[order]) == pytest.approx(
        scores[order], rel=1e-4
    )
    assert (np.isneginf(scores) == ~legal).all()
    assert len(set(scores[legal].tolist())) == legal.sum()
    # What the others are counts, but not what is not legal.
    other = legs.copy()
    other[~legal] += 1.0
    assert (scorer.scores(other, mission, legal) == scores).all()
    assert np.isneginf(scorer.scores(legs, mission, np.zeros(9, dtype=np.bool_))).all()


def test_the_weights_that_come_along_are_small_and_say_how_they_were_made() -> None:
    """The file is below 200 kB, and has its seed and the number of its decisions."""
    path = Path(adr_opt.__file__).parent / "learning" / "next_leg" / "weights" / "next-leg.npz"
    assert path.stat().st_size < 200_000
    assert {"seed", "rounds", "decisions"} <= set(shipped().facts)


def test_weights_are_read_as_they_were_written(tmp_path: Path) -> None:
    """A file gives the same scores again; anything else is refused in a sentence."""
    scorer = drawn_scorer(2)
    scorer.save(tmp_path / "own.npz")
    again = load_scorer(tmp_path / "own.npz")
    assert again.facts == {"seed": 2}
    for one, other in zip(again.layers, scorer.layers, strict=True):
        assert (one == other).all()
    wrong = scorer.layers._replace(out=np.zeros(3, dtype=np.float32))
    LegScorer(wrong, {}).save(tmp_path / "wrong.npz")
    bad = scorer.layers._replace(out=np.full(16, np.nan, dtype=np.float32))
    LegScorer(bad, {}).save(tmp_path / "bad.npz")
    (tmp_path / "text.npz").write_text("no weights", encoding="utf-8")
    np.savez(tmp_path / "other.npz", facts=np.zeros(3))
    # Of a few bytes, but their heading states a terabyte.
    content = io.BytesIO()
    numbers = np.lib.format.header_data_from_array_1_0(np.zeros(4)) | {"shape": (2**37,)}
    np.lib.format.write_array_header_1_0(content, numbers)
    with zipfile.ZipFile(tmp_path / "large.npz", "w") as archive:
        archive.writestr("leg.npy", content.getvalue())
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("leg.npy", bytes(10**7))
    names = "wrong", "bad", "text", "other", "none", "large", "bomb"
    for name in (f"{name}.npz" for name in names):
        with pytest.raises(InputError, match="not a file of weights"):
            load_scorer(tmp_path / name)


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
        choices = visible.choices(craft, {2}, [], set(), [], None)
        assert 2 not in choices.bodies
        assert body not in choices.bodies
        for at, j in enumerate(choices.bodies.tolist()):
            hop = ground.best(body, j, free_s, towed=False)
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
        choices = visible.choices(craft, set(), [], set(), [], None)
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


@pytest.mark.parametrize("draw", ["tiny", "dense", "campaign", "towed", "rules"])
def test_what_is_seen_is_what_numpy_works_out(draw: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiled numbers of legs, of legs after them and of missions are those of a twin."""
    instance = {
        "tiny": lambda: tiny(1),
        "dense": lambda: adr_opt.generate("nominal", 4, targets=90),
        "campaign": lambda: launched.campaign("two-body"),
        "towed": towed_fields.field,
        "rules": lambda: random_mission(3),
    }[draw]()
    compared = []

    def features(*given: Any) -> tuple[FloatArray, FloatArray]:
        found, wanted = seen_module.features(*given), next_leg_seen.seen(*given)
        for mine, other in zip(found, wanted, strict=True):
            assert mine == pytest.approx(other, rel=1e-9, abs=1e-9)
        compared.append(given[1].bodies.size)
        return found

    def onward(*given: Any) -> OnwardLegs:
        found, wanted = onward_module.onward(*given), next_leg_seen.onward_legs(*given)
        for mine, other in zip(found, wanted, strict=True):
            assert mine == pytest.approx(other, rel=1e-9, abs=1e-9)
        return found

    monkeypatch.setattr(learned_module, "features", features)
    monkeypatch.setattr(sight_module, "onward", onward)
    uncertainty = drawn_uncertainty(instance, 1)
    ground = MissionFacts(instance)
    planned = without_plan(ground)
    policy = Learned(ground, planned, uncertainty)
    rehearsed(ground, DrawnWorld(instance, uncertainty, 0), policy, planned.kits)
    assert sum(compared) > 3


def test_few_of_many_targets_are_looked_at() -> None:
    """Of a large field only the nearest, and what is required or planned next, are candidates."""
    instance = adr_opt.generate("nominal", 3, targets=150)
    far = instance.targets[-1].replace(required=True)
    instance = instance.replace(targets=(*instance.targets[:-1], far))
    ground = MissionFacts(instance)
    craft = beginning(ground, 0, 0, 0.0, 1.0)
    choices = VisibleLegs(ground, CERTAIN).choices(craft, set(), [140], set(), [], None)
    assert RANKS < choices.bodies.size <= RANKS + 3
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
        policy = Watched(ground, planned, uncertainty, 0, drawn_scorer(seed))
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
