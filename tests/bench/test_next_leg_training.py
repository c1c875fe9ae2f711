"""The training of the choice of the next leg, and the comparison of what came of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import adr_opt
from adr_opt.learning.next_leg.features import LEG_FEATURES, MISSION_FEATURES
from adr_opt.learning.next_leg.scorer import load_scorer, shipped
from adr_opt.problem.uncertainty import Uncertainty

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture(autouse=True)
def _bench(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH))


def run(script: str, *words: object) -> str:
    command = [sys.executable, str(BENCH / script), *map(str, words)]
    path = os.pathsep.join([str(BENCH.parent), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_the_network_in_training_scores_as_the_one_that_flies() -> None:
    """PyTorch and NumPy give the same scores of the same legs, whatever is padded."""
    torch = pytest.importorskip("torch")
    from next_leg.network import NextLegNetwork

    rng = np.random.default_rng(5)
    network = NextLegNetwork.of(shipped().layers)
    legs = rng.normal(size=(3, 9, LEG_FEATURES)).astype(np.float32)
    mission = rng.normal(size=(3, MISSION_FEATURES)).astype(np.float32)
    counts = np.array([9, 4, 1])
    there = np.arange(9)[None, :] < counts[:, None]
    with torch.no_grad():
        scores = network(*map(torch.from_numpy, (legs, mission, there))).numpy()
    for row, count in enumerate(counts):
        wanted = shipped().scores(legs[row], mission[row], there[row])
        assert scores[row, :count] == pytest.approx(wanted[:count], rel=1e-4, abs=1e-4)
        assert (scores[row, count:] < -1e8).all()
    for mine, other in zip(network.layers(), shipped().layers, strict=True):
        assert np.array_equal(mine, other)


def test_chances_of_drawn_choices_are_those_of_their_scores() -> None:
    """A drawn flight tells its choices, with the logarithms of their chances by the softmax."""
    pytest.importorskip("torch")
    from next_leg.flights import collected, kept
    from next_leg.policy_gradient import SHARPNESS, Drawing

    mission = kept(adr_opt.generate("tiny", 3, targets=8), Uncertainty())
    policy = Drawing(mission, shipped(), np.random.default_rng(0))
    collected(mission, policy, 0)
    assert len(policy.steps) > 3
    for step in policy.steps:
        seen = step.seen
        legal = np.ones(seen.count, dtype=np.bool_)
        scores = SHARPNESS * shipped().scores(seen.legs[: seen.count], seen.mission, legal)
        allowed = step.allowed[: seen.count]
        assert allowed[step.chosen]
        chances = np.exp(scores - scores[allowed].max()) * allowed
        wanted = np.log(chances[step.chosen] / chances.sum())
        assert step.log_chance == pytest.approx(float(wanted), abs=1e-3)


def test_what_a_judge_finds_can_be_collected() -> None:
    """The best move is worth a proven optimum at the start, and no move is worth more."""
    pytest.importorskip("torch")
    from next_leg.judging import Judge

    from adr_opt.analysis.rehearse.flying_chasers import beginning
    from adr_opt.analysis.rehearse.mission_facts import MissionFacts

    instance = adr_opt.generate("reduced-fuel", 3, targets=8)
    ground = MissionFacts(instance)
    judge = Judge(ground, Uncertainty(), 0)
    assert judge.is_proven
    optimum = adr_opt.solve(instance, "exact").objective
    craft = beginning(ground, 0, 0, 0.0, 1.0)
    worths = judge.worths(craft, set(), np.arange(1, 9))
    assert np.nanmax(worths) == pytest.approx(optimum, abs=0.51)
    assert np.nanmax(worths) <= optimum + 1e-9
    assert worths[judge.best[0] - 1] == pytest.approx(optimum, abs=0.51)


def test_what_others_do_does_not_count_for_a_chaser() -> None:
    """A chaser with two targets at most goes on to two, also if others have serviced three."""
    from next_leg.asked import beam_from

    from adr_opt.kernels.rules.resources import Resources
    from adr_opt.kernels.rules.rules import State
    from adr_opt.mission.mission import Mission

    drawn = adr_opt.generate("tiny", 3, targets=8)
    mission = Mission(drawn.replace(chasers=(drawn.chaser.replace(max_targets=2),)))
    done = np.zeros(len(drawn.names), dtype=np.bool_)
    done[-3:] = True
    budget = drawn.chaser.tank.delta_v_m_s
    for serviced, wanted in ((0, 2), (1, 1), (2, 0)):
        has = Resources(0.0, budget, np.int64(0), np.int64(serviced), np.int64(0))
        there = done.copy()
        there[1 : 1 + serviced] = True
        sequence, prize = beam_from(mission, State(np.int64(0), has), there, 4)
        targets = [j for j in sequence.tolist() if j >= drawn.first_target]
        assert len(targets) == wanted == prize
        assert not there[targets].any()


def test_claims_are_corrected_by_holm() -> None:
    """Of three chances the least counts threefold, and none less than a smaller one."""
    from next_leg.claims import holm

    assert holm([0.04, 0.001, 0.03]) == pytest.approx([0.06, 0.003, 0.06])
    assert holm([0.9, 0.8]) == [1.0, 1.0]


@pytest.mark.slow
def test_a_training_writes_weights_of_its_variant(tmp_path: Path) -> None:
    """A short training judges its steps, and writes the best weights with how they were made."""
    words = ("--rounds", 30, 30, "--epochs", 2, "--held", 1, "--improvements", 1, "--missions", 2)
    for variant in ("reduced-time", "domain-randomised"):
        out = tmp_path / f"{variant}.npz"
        told = run("train_next_leg.py", "--variant", variant, *words, "--out", out)
        assert told.count("\n") == 5
        assert ", best" in told
        facts = load_scorer(out).facts
        assert facts["variant"] == variant
        assert facts["decisions"] >= 30


@pytest.mark.slow
@pytest.mark.parametrize("what", ["known", "uncertain"])
def test_the_frontier_is_told(what: str) -> None:
    """Every method has a row, and what is held is said for both times."""
    told = run("frontier.py", what, "--targets", 20, "--fields", 3, "--widths", 1)
    for method in ("learned", "guarded greedy", "beam of 1"):
        assert f"| {method} | 3 |" in told
    assert "| learned | time per decision |" in told
    assert "| learned | total time |" in told
