"""The learned planner: policy files, scores in NumPy and PyTorch, decoding."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calling import call

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations, MaxRuntime, Stop
from adr_opt.learning.policy import FORMAT, SHIPPED, Policy, load_policy, shapes
from adr_opt.mission.mission import Mission
from solvers.planners.ppo import ppo

torch = pytest.importorskip("torch")

from adr_opt.learning.environment import Fields  # noqa: E402
from adr_opt.learning.environment.vector import MissionVecEnv  # noqa: E402
from adr_opt.learning.training.policy_network import SetNetwork  # noqa: E402

FILE = Path(adr_opt.__file__).parent / "learning" / "weights" / "policy.npz"


def network() -> SetNetwork:
    torch.manual_seed(3)
    made = SetNetwork(width=16)
    # The head starts near zero; scores that differ are what is compared.
    torch.nn.init.normal_(made.score.weight, std=0.3)
    return made


@pytest.fixture(scope="module")
def policy_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy of random weights."""
    path = tmp_path_factory.mktemp("policy") / "random.npz"
    Policy(network().arrays(), {}).save(path)
    return path


def states(count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Moves and missions of masked random play, of few and of many choices."""
    env = MissionVecEnv(8, Fields(targets=(4, 40)), slots=4)
    rng, seen, found = np.random.default_rng(0), env.reset(), []
    for _ in range(count // 8):
        found.append((seen["moves"].copy(), seen["mission"].copy()))
        mask = env.action_masks()
        seen = env.step((rng.random(mask.shape) * mask).argmax(axis=1))[0]
    env.close()
    return found


def test_numpy_and_torch_give_the_same_scores(policy_file: Path) -> None:
    """On states with few and many choices both agree in every score and every best move."""
    made, policy = network(), load_policy(policy_file)
    for moves, mission in states(240):
        with torch.no_grad():
            scores, _ = made(torch.as_tensor(moves), torch.as_tensor(mission))
        wanted = np.where(moves[..., 0] > 0.0, scores.numpy(), -1e8)
        got = policy.scores(moves, mission)
        np.testing.assert_allclose(got, wanted, atol=1e-4, rtol=0.0)
        assert (got.argmax(axis=1) == wanted.argmax(axis=1)).all()


def test_permuted_choices_have_permuted_scores(policy_file: Path) -> None:
    """The network does not know in which order the targets stand."""
    policy, rng = load_policy(policy_file), np.random.default_rng(1)
    for moves, mission in states(80):
        order = rng.permutation(moves.shape[1])
        scores = policy.scores(moves, mission)
        permuted = policy.scores(np.ascontiguousarray(moves[:, order]), mission)
        np.testing.assert_allclose(permuted, scores[:, order], atol=1e-4)


@pytest.mark.parametrize("decode", ["greedy", "sample", "beam"])
def test_decoded_plans_pass_check(decode: str, policy_file: Path) -> None:
    """Whatever the weights and the decoding, the plan is legal and counts what it says."""
    for seed in range(3):
        instance = adr_opt.generate("reduced-time", seed, targets=12, zones=3 * seed)
        result = adr_opt.solve(
            instance, method="ppo", policy=str(policy_file), decode=decode, samples=20, width=8
        )
        assert result.plan is not None
        assert adr_opt.check(instance, result.plan) == ()


class _Overdue:
    """Says enough from the second time on; its time was over before it began."""

    def __init__(self) -> None:
        self.asked = 0

    def __call__(self, incumbent: float, bound: float) -> bool:
        self.asked += 1
        return self.asked > 1

    def remaining_s(self) -> float:
        return -1.0


@pytest.mark.parametrize("stop", [_Overdue, lambda: MaxRuntime(0.2), lambda: MaxIterations(10**9)])
def test_samples_and_beams_are_no_worse_than_the_greedy_plan(stop: Callable[[], Stop]) -> None:
    """With any time both end, the plan is legal, and the greedy plan is among theirs."""
    mission = Mission(adr_opt.generate("reduced-time", 5, targets=20, zones=3))
    found = []
    for decode in ("greedy", "sample", "beam"):
        result = call(ppo, mission, stop=stop(), decode=decode, width=10, samples=30)
        assert result.plan is not None
        assert adr_opt.check(mission.instance, result.plan) == ()
        found.append(result.objective)
    assert found[0] <= min(found[1:])


def test_shipped_policy_is_better_than_the_guard() -> None:
    """The policy of the package services more targets than greedy-guarded on unseen fields."""
    learned, guarded = 0.0, 0.0
    for seed in (20_001, 20_002, 20_003):
        mission = Mission(adr_opt.generate("nominal", seed))
        learned += adr_opt.solve(mission, method="ppo").objective
        guarded += adr_opt.solve(mission, method="greedy-guarded").objective
    assert learned > guarded


def test_shipped_policy_takes_any_number_of_targets() -> None:
    """One policy plans for 1, 20 and 100 targets."""
    for targets in (1, 20, 100):
        instance = adr_opt.generate("reduced-time", 5, targets=targets)
        result = adr_opt.solve(instance, method="ppo")
        assert result.plan is not None
        assert adr_opt.check(instance, result.plan) == ()
        assert result.objective >= 1


def test_the_card_says_how_the_policy_came_about() -> None:
    """Commit, seed, steps, curve, and means of each family before and after the training."""
    card = load_policy().card
    assert FILE.stat().st_size < 400_000
    assert {"commit", "seed", "steps", "curve", "families", "versions"} <= card.keys()
    for family in ("nominal", "reduced-time", "reduced-fuel"):
        means = card["families"][family]
        assert means["trained"] > means["untrained"] + 2.0
    assert card["families"]["nominal"]["untrained"] <= 10.0


@pytest.mark.parametrize(
    ("method", "options"),
    [("ppo", {}), ("beam", {"policy": SHIPPED, "width": 5}), ("mcts", {"policy": SHIPPED})],
)
def test_a_plan_says_what_its_policy_was_trained_on(method: str, options: dict[str, Any]) -> None:
    """On a mission under J2 a policy of two-body fields plans legally, and the plan says so."""
    usual = adr_opt.generate("tiny", 4, targets=6)
    said = []
    for instance in (usual, usual.replace(dynamics="j2")):
        result = adr_opt.solve(instance, method, **options)
        assert result.plan is not None
        assert adr_opt.check(instance, result.plan) == ()
        said.append([note for note in result.plan.notes if "was trained on" in note])
    assert said[0] == []
    assert len(said[1]) == 1
    assert "dynamics 'two-body', and this mission has 'j2'" in said[1][0]


def test_a_policy_is_read_as_it_was_written(tmp_path: Path) -> None:
    """A file gives the same weights and card again."""
    made = Policy(network().arrays(), {"seed": 2, "name": "mine"})
    made.save(tmp_path / "own.npz")
    again = load_policy(tmp_path / "own.npz")
    assert again.card == made.card
    assert again.name == "mine"
    assert shapes(16, 2).keys() == again.arrays.keys()
    assert all((again.arrays[name] == of).all() for name, of in made.arrays.items())


def test_what_is_no_policy_is_refused_in_a_sentence(tmp_path: Path) -> None:
    """Other shapes, types and numbers, other formats, and files of another kind or size."""
    arrays = network().arrays()
    for change in (
        {"score.bias": np.zeros(3, np.float32)},
        {"score.bias": np.zeros(1)},
        {"score.bias": np.full(1, np.nan, np.float32)},
        {"more": np.zeros(1, np.float32)},
        {"encode.bias": np.zeros((), np.float32)},
    ):
        with pytest.raises(InputError, match="weights do not fit the policy's network"):
            Policy(arrays | change, {})
    for missing in ("encode.bias", "attend_1.bias"):
        with pytest.raises(InputError, match="weights do not fit"):
            Policy({name: of for name, of in arrays.items() if name != missing}, {})
    (tmp_path / "text.npz").write_text("no weights", encoding="utf-8")
    np.savez(tmp_path / "other.npz", card=np.zeros(3))
    # Of a few bytes, but their heading states a terabyte.
    content = io.BytesIO()
    numbers = np.lib.format.header_data_from_array_1_0(np.zeros(4)) | {"shape": (2**37,)}
    np.lib.format.write_array_header_1_0(content, numbers)
    for name, held in (("large", content.getvalue()), ("bomb", bytes(10**8))):
        with zipfile.ZipFile(tmp_path / f"{name}.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("token.weight.npy", held)
    for name in ("text", "other", "large", "bomb"):
        with pytest.raises(InputError, match="is not a file of a policy"):
            load_policy(tmp_path / f"{name}.npz")
    for name in ("set", "set-transfer", "none.npz"):
        with pytest.raises(InputError, match="no such file; give one that train wrote"):
            load_policy(name)
    older = Policy(arrays, {"format": "adr-opt-policy/1"})
    older.save(tmp_path / "older.npz")
    with pytest.raises(InputError, match="of another version"):
        load_policy(tmp_path / "older.npz")
    assert FORMAT == "adr-opt-policy/2"


def test_corrupted_policy_files(tmp_path: Path) -> None:
    """A file with some bytes changed, cut off or put in plans, or is refused in one sentence."""
    whole, rng = FILE.read_bytes(), np.random.default_rng(31)
    mission = Mission(adr_opt.generate("tiny", 0))
    path, planned = tmp_path / "corrupted.npz", 0
    for number in range(60):
        content = bytearray(whole)
        at = int(rng.integers([len(whole), 9000, 2000][number % 3]))
        at = len(whole) - 1 - at if number % 3 == 2 else at
        if number % 4 == 0:
            content[at] ^= 1 << int(rng.integers(8))
        elif number % 4 == 1:
            content[at : at + 8] = rng.bytes(8)
        elif number % 4 == 2:
            content[at:at] = rng.bytes(int(rng.integers(1, 50)))
        else:
            del content[at:]
        path.write_bytes(content)
        with suppress(InputError):
            call(ppo, mission, stop=MaxRuntime(10.0), policy=str(path))
            planned += 1
    assert planned < 60


@pytest.mark.parametrize("bias", [-1e20, 3e38])
def test_scores_without_measure_are_refused(bias: float, tmp_path: Path) -> None:
    """No illegal move is taken because legal ones score less than anything: that would not end."""
    arrays = network().arrays()
    arrays["score.bias"] = np.full(1, bias, np.float32)
    Policy(arrays, {}).save(tmp_path / "low.npz")
    with pytest.raises(InputError, match=r"beyond 1e\+08"):
        adr_opt.solve(adr_opt.generate("tiny", 0), method="ppo", policy=str(tmp_path / "low.npz"))
