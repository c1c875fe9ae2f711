"""The learned planner: policy files, decoding, and PyTorch against ONNX Runtime."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from calling import call

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.stop import MaxIterations, MaxRuntime, Stop
from adr_opt.mission.mission import Mission

pytest.importorskip("onnxruntime")
onnx = pytest.importorskip("onnx")
torch = pytest.importorskip("torch")

import solvers.policies  # noqa: E402
from adr_opt.kernels.episodes import episodes as kernels  # noqa: E402
from adr_opt.learning.environment import Fields  # noqa: E402
from adr_opt.learning.environment.vector import MissionVecEnv  # noqa: E402
from adr_opt.learning.episodes.board import MISSION, MOVES, move_fields  # noqa: E402
from adr_opt.mission.certified import certify  # noqa: E402
from solvers.planners.ppo import ppo  # noqa: E402
from solvers.policies import SHIPPED, Policy, load_policy  # noqa: E402
from solvers.policies.decoding import Field, finish  # noqa: E402
from solvers.policies.promises import follow_chains, promises  # noqa: E402
from solvers.training import configs  # noqa: E402
from solvers.training.export import write_onnx  # noqa: E402
from solvers.training.policies import SetNetwork  # noqa: E402

STATES = 1000


class _Wrapped:
    """What the exporter takes from a policy of Stable-Baselines3."""

    def __init__(self, network: SetNetwork) -> None:
        self.network = network


def _network(observation: str = "lookahead") -> SetNetwork:
    torch.manual_seed(3)
    network = SetNetwork(len(move_fields(observation)))
    # The head starts near zero; scores that differ are what is compared.
    torch.nn.init.normal_(network.score.weight, std=0.3)
    return network


@pytest.fixture(scope="module")
def policy_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy of random weights."""
    path = tmp_path_factory.mktemp("policy") / "random.onnx"
    write_onnx(
        _Wrapped(_network()), path, name="set", observation="lookahead", targets=None, facts={}
    )
    return path


@pytest.fixture(scope="module")
def small_published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A policy of the published kind for five targets."""
    from dataclasses import replace

    from solvers.training.trainer import model_of

    config = replace(configs.config("published"), fields=Fields(targets=(5, 5)), missions=2)
    env = MissionVecEnv(2, config.fields, observation="published", slots=1)
    path = tmp_path_factory.mktemp("policy") / "published.onnx"
    model = model_of(config, env, 0, "cpu")
    write_onnx(model.policy, path, name="published", observation="published", targets=5, facts={})
    env.close()
    return path


def _states(observation: str, count: int) -> Iterator[tuple[object, np.ndarray]]:
    """Observations and masks of masked random play."""
    env = MissionVecEnv(8, Fields(targets=(4, 12)), observation=observation, slots=4)
    rng = np.random.default_rng(0)
    seen = env.reset()
    for _ in range(count // 8):
        mask = env.action_masks()
        yield seen, mask
        seen = env.step((rng.random(mask.shape) * mask).argmax(axis=1))[0]
    env.close()


@pytest.mark.slow
def test_torch_and_onnx_take_the_same_actions(policy_file: Path) -> None:
    """On 1,000 states PyTorch and ONNX Runtime agree in every score and every best move."""
    network, policy = _network(), Policy(policy_file)
    compared = 0
    for seen, mask in _states("lookahead", STATES):
        assert isinstance(seen, dict)
        with torch.no_grad():
            scores, value = network(torch.as_tensor(seen[MOVES]), torch.as_tensor(seen[MISSION]))
        expected = np.where(mask, scores.numpy(), -1e8)
        got, got_value = policy.judge(seen, mask)
        assert np.allclose(got, expected, atol=1e-4)
        assert np.allclose(got_value, value.numpy(), atol=1e-4)
        assert (got.argmax(axis=1) == expected.argmax(axis=1)).all()
        compared += len(mask)
    assert compared == STATES


def test_permuted_moves_have_permuted_scores(policy_file: Path) -> None:
    """The set network does not know in which order the targets stand."""
    policy = Policy(policy_file)
    rng = np.random.default_rng(1)
    for seen, mask in list(_states("lookahead", 80)):
        assert isinstance(seen, dict)
        order = rng.permutation(mask.shape[1])
        scores, value = policy.judge(seen, mask)
        other = {MISSION: seen[MISSION], MOVES: np.ascontiguousarray(seen[MOVES][:, order])}
        permuted, same = policy.judge(other, mask[:, order])
        assert np.allclose(permuted, scores[:, order], atol=1e-4)
        assert np.allclose(same, value, atol=1e-4)


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


@pytest.mark.parametrize("policy", ["set", "set-transfer"])
@pytest.mark.parametrize("stop", [_Overdue, lambda: MaxRuntime(0.2), lambda: MaxIterations(10**9)])
def test_beams_need_neither_chains_nor_time(policy: str, stop: Callable[[], Stop]) -> None:
    """With any policy and any time, beams end, and the plan is legal and no worse than greedy."""
    mission = Mission(adr_opt.generate("reduced-time", 5, targets=20, zones=3))
    greedy, beam = (
        call(ppo, mission, stop=stop(), policy=policy, decode=decode, width=10)
        for decode in ("greedy", "beam")
    )
    assert beam.plan is not None
    assert adr_opt.check(mission.instance, beam.plan) == ()
    assert beam.objective >= greedy.objective


def test_samples_and_beams_are_no_worse_than_the_greedy_plan(policy_file: Path) -> None:
    """Both keep the greedy plan among theirs, so they never service fewer targets."""
    mission = Mission(adr_opt.generate("nominal", 3, targets=25))
    found = {
        decode: adr_opt.solve(
            mission, method="ppo", policy=str(policy_file), decode=decode, samples=30, width=16
        ).objective
        for decode in ("greedy", "sample", "beam")
    }
    assert found["sample"] >= found["greedy"]
    assert found["beam"] >= found["greedy"]


def test_what_chains_promise_can_be_flown(policy_file: Path) -> None:
    """Following the chains from any state ends with at least the targets that they promise."""
    rng = np.random.default_rng(8)
    gains = 0
    for seed in range(12):
        instance = adr_opt.generate("reduced-fuel", seed, targets=15, zones=seed % 4)
        field = Field(Mission(instance, threads=1), load_policy(policy_file))
        episodes, made = field.begin(1), [[]]
        for _ in range(rng.integers(0, 6)):
            board = field.board(episodes)
            if not board.legal[0]:
                break
            action = rng.choice(np.flatnonzero(board.mask[0]), size=1)
            kernels.act(field.pool.arrays, episodes, 0, 1, action, np.zeros(1, np.float32))
            made[0].append(int(kernels.body_of(int(action[0]), field.targets)))
        seen = promises(field.board(episodes))
        assert seen is not None
        if not np.isfinite(seen).any():
            continue
        plans: list[np.ndarray] = []
        most = finish(field, episodes, made, follow_chains, plans.append)
        assert most == np.count_nonzero(plans[0])
        assert most >= round(float(seen.max()), 3)
        assert certify(field.mission, "chains", plans[0], seed=0, runtime_s=0.0).objective == most
        gains += most > seen.max() + 0.5
    assert gains > 0


@pytest.mark.parametrize("decode", ["greedy", "sample", "beam"])
def test_no_decoding_falls_behind_what_chains_promised(decode: str, policy_file: Path) -> None:
    """A policy of random weights still ends with what its observation promised at the start."""
    mission = Mission(adr_opt.generate("reduced-time", 5, targets=20))
    field = Field(mission, load_policy(policy_file))
    episodes = field.begin(1)
    seen = promises(field.board(episodes))
    assert seen is not None
    result = adr_opt.solve(
        mission, method="ppo", policy=str(policy_file), decode=decode, samples=4, width=4
    )
    assert result.objective >= round(float(seen.max()), 3)


def test_shipped_policy_is_better_than_the_guard() -> None:
    """The policy of the package services more targets than greedy-guarded on unseen fields."""
    learned, guarded = 0.0, 0.0
    for seed in (20_001, 20_002, 20_003):
        mission = Mission(adr_opt.generate("nominal", seed))
        learned += adr_opt.solve(mission, method="ppo").objective
        guarded += adr_opt.solve(mission, method="greedy-guarded").objective
    assert learned >= guarded + 3


def test_shipped_policy_takes_any_number_of_targets() -> None:
    """One policy plans for 1, 20 and 100 targets."""
    for targets in (1, 20, 100):
        instance = adr_opt.generate("reduced-time", 5, targets=targets)
        result = adr_opt.solve(instance, method="ppo")
        assert result.plan is not None
        assert adr_opt.check(instance, result.plan) == ()
        assert result.objective >= 1


def test_shipped_policy_says_what_it_is() -> None:
    """The file names its configuration, observation, training steps and versions."""
    policy = load_policy(SHIPPED)
    assert policy.name == "set"
    assert policy.targets is None
    assert policy.facts["steps"] > 0
    assert {"torch", "sb3-contrib"} <= set(policy.facts["versions"])


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


def test_published_policy_refuses_more_targets(small_published: Path) -> None:
    """A network of fixed size plans for fewer targets, and names the other policy for more."""
    few = adr_opt.generate("tiny", 0, targets=4)
    assert adr_opt.solve(few, method="ppo", policy=str(small_published)).objective >= 0
    with pytest.raises(InputError, match=r"made for 5 targets.*the package's own \('set'\)"):
        adr_opt.solve(
            adr_opt.generate("tiny", 0, targets=6), method="ppo", policy=str(small_published)
        )


def _with_metadata(source: Path, target: Path, **changes: str | None) -> Path:
    model = onnx.load(source)
    kept = {entry.key: entry.value for entry in model.metadata_props}
    del model.metadata_props[:]
    for key, value in {**kept, **changes}.items():
        if value is not None:
            entry = model.metadata_props.add()
            entry.key, entry.value = key, value
    onnx.save(model, target)
    return target


def test_files_that_only_look_like_a_policy(policy_file: Path, tmp_path: Path) -> None:
    """Metadata of a policy on a network of other shapes or types is refused in one sentence."""
    from onnx import TensorProto, helper

    known = {entry.key: entry.value for entry in onnx.load(policy_file).metadata_props}
    wide, whole = [None, None, len(move_fields("lookahead"))], [None, 16]
    for number, (kind, moves, mission) in enumerate(
        [
            (TensorProto.FLOAT, wide, whole),
            (TensorProto.DOUBLE, wide, whole),
            (TensorProto.FLOAT, [], []),
            (TensorProto.FLOAT, [1, 51, 51], [1, 16]),
        ]
    ):
        inputs = [
            helper.make_tensor_value_info(MOVES, kind, moves),
            helper.make_tensor_value_info(MISSION, kind, mission),
        ]
        outputs = [helper.make_tensor_value_info(name, kind, None) for name in "ab"]
        nodes = [
            helper.make_node("Identity", [entry.name], [name])
            for entry, name in zip(inputs, "ab", strict=True)
        ]
        graph = helper.make_graph(nodes, "no policy", inputs, outputs)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
        helper.set_model_props(model, known)
        path = tmp_path / f"{number}.onnx"
        onnx.save(model, path)
        with pytest.raises(InputError, match="does not take the observation 'lookahead'"):
            load_policy(path)


def test_damaged_and_foreign_policy_files(policy_file: Path, tmp_path: Path) -> None:
    """Every file that is no policy of this observation is refused in one sentence."""
    text = policy_file.read_bytes()
    files = {
        "truncated": text[: len(text) // 2],
        "empty": b"",
        "pickle": pickle.dumps({"weights": [1, 2, 3]}),
        "json": json.dumps({"format": "adr-opt-policy/1"}).encode(),
    }
    paths = []
    for name, content in files.items():
        path = tmp_path / f"{name}.onnx"
        path.write_bytes(content)
        paths.append(path)
    for number, changes in enumerate(
        (
            {"format": None},
            {"format": "adr-opt-policy/9"},
            {"observation": "telescope"},
            {"observation": "transfer"},
            {"fields": "something else"},
            {"targets": "many"},
            {"facts": "{"},
        )
    ):
        paths.append(_with_metadata(policy_file, tmp_path / f"m{number}.onnx", **changes))
    for path in [*paths, tmp_path / "missing.onnx", tmp_path]:
        with pytest.raises(InputError) as refused:
            load_policy(path)
        assert "\n" not in str(refused.value)


def _attacks(model: Any) -> Iterator[tuple[str, Any]]:
    """Models that would take time or memory without end, with what is said of them."""
    from onnx import TensorProto, helper, numpy_helper

    def made(change: Callable[[Any], object]) -> Any:
        other = onnx.ModelProto()
        other.CopyFrom(model)
        change(other)
        return other

    def adds(*nodes: Any) -> Callable[[Any], object]:
        return lambda other: other.graph.node.extend(nodes)

    def node(kind: str, inputs: list[str], **attributes: Any) -> Any:
        return helper.make_node(kind, inputs, ["/more"], **attributes)

    def claims(**fields: Any) -> Callable[[Any], object]:
        return lambda other: other.graph.initializer.append(TensorProto(name="more", **fields))

    body = helper.make_graph([], "body", [], [])
    thin = numpy_helper.from_array(np.zeros((5000, 1), np.float32), "thin")
    flat = numpy_helper.from_array(np.zeros((1, 5000), np.float32), "flat")

    def product(other: Any) -> None:
        other.graph.initializer.extend([thin, flat])
        adds(node("MatMul", ["thin", "flat"]))(other)

    def doubled(other: Any) -> None:
        for number in range(20):
            names = [f"/{number}" if number else "moves"] * 2
            other.graph.node.append(helper.make_node("Concat", names, [f"/{number + 1}"], axis=1))

    yield "'Loop'", made(adds(node("Loop", ["", ""], body=body)))
    yield "attribute", made(adds(node("Relu", ["moves"], body=body)))
    yield "'ConstantOfShape'", made(adds(node("ConstantOfShape", ["moves"])))
    yield "tensor", made(claims(dims=[10**6, 10**6], data_type=1))
    yield "tensor", made(claims(dims=[2**32, 2**32], data_type=1, raw_data=b""))
    yield "tensor", made(claims(dims=[0], data_type=1))
    yield "tensor", made(claims(dims=[2], data_type=8, string_data=[b"a", b"b"]))
    far = onnx.StringStringEntryProto(key="location", value="/etc/passwd")
    yield "tensor", made(claims(dims=[1], data_type=1, data_location=1, external_data=[far]))
    yield "'MatMul' of a size", made(product)
    yield "'Concat' of a size", made(doubled)
    yield "more than a network", made(lambda other: other.functions.add(name="f"))
    yield "operator set", made(lambda other: other.opset_import.add(domain="more", version=1))
    yield "operators", made(adds(*[node("Relu", ["moves"])] * 1000))
    yield "fit together", made(adds(node("MatMul", ["moves", "moves"])))
    yield "does not take", made(lambda other: other.graph.input.pop())


def test_networks_that_attack_are_refused(policy_file: Path, tmp_path: Path) -> None:
    """What could run for ever or take any memory is refused before it is run, in one sentence."""
    path = tmp_path / "attack.onnx"
    for said, model in _attacks(onnx.load(policy_file)):
        path.write_bytes(model.SerializeToString())
        with pytest.raises(InputError, match=said) as refused:
            load_policy(path)
        assert "\n" not in str(refused.value)


def test_metadata_that_claim_too_much_are_refused(
    policy_file: Path, small_published: Path, tmp_path: Path
) -> None:
    """No number or text of the metadata makes reading a policy slow, large or a traceback."""
    path = tmp_path / "claims.onnx"
    for changes in (
        {"targets": "10000000"},
        {"targets": "9" * 4000},
        {"targets": "6"},
        {"targets": "-1"},
        {"facts": "[" * 100_000},
        {"facts": "[]"},
        {"name": "n" * 100_000},
        {"observation": "o" * 100_000},
        {"format": "f" * 100_000},
    ):
        with pytest.raises(InputError) as refused:
            load_policy(_with_metadata(small_published, path, **changes))
        assert "\n" not in str(refused.value)
        assert len(str(refused.value)) < 500
    claimed = load_policy(_with_metadata(policy_file, path, targets="10000000"))
    claimed.check_size(100)


def test_corrupted_policy_files(tmp_path: Path) -> None:
    """A file with some bytes changed, cut off or put in plans, or is refused in one sentence."""
    whole = (Path(solvers.policies.__file__).parent / "weights" / "set.onnx").read_bytes()
    rng = np.random.default_rng(31)
    mission = Mission(adr_opt.generate("tiny", 0))
    path, planned = tmp_path / "corrupted.onnx", 0
    for number in range(120):
        content = bytearray(whole)
        ends = [len(whole), 9000, 2000]  # weights; operators; the last bytes are metadata
        at = int(rng.integers(ends[number % 3]))
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
    assert 0 < planned < 120


@pytest.mark.parametrize("name", configs.CONFIGS)
def test_policies_of_all_configurations_are_taken(name: str, tmp_path: Path) -> None:
    """What the exporter writes before and after a training is made of known operators only."""
    from solvers.training.trainer import model_of

    config = configs.config(name)
    env = MissionVecEnv(2, config.fields, observation=config.observation, slots=1)
    model = model_of(config, env, 0, "cpu")
    env.close()
    targets = None if config.policy == "set" else config.fields.most_targets
    for number in range(2):
        path = tmp_path / f"{number}.onnx"
        write_onnx(
            model.policy, path, name=name, observation=config.observation, targets=targets, facts={}
        )
        assert load_policy(path).targets == targets
        for tensor in model.policy.parameters():  # else equal ones are written once
            torch.nn.init.normal_(tensor, std=0.1)


def test_scores_without_measure_are_refused(policy_file: Path, tmp_path: Path) -> None:
    """No illegal move is taken because legal ones score less than anything: that would not end."""
    network = _network()
    torch.nn.init.constant_(network.score.bias, -1e20)
    path = tmp_path / "low.onnx"
    write_onnx(_Wrapped(network), path, name="set", observation="lookahead", targets=None, facts={})
    with pytest.raises(InputError, match=r"beyond 1e\+08"):
        adr_opt.solve(adr_opt.generate("tiny", 0), method="ppo", policy=str(path))


def test_weights_that_are_not_numbers_are_refused(tmp_path: Path) -> None:
    """A network that gives NaN is refused, instead of planning by it."""
    network = _network()
    torch.nn.init.constant_(network.score.bias, float("nan"))
    path = tmp_path / "nan.onnx"
    write_onnx(_Wrapped(network), path, name="set", observation="lookahead", targets=None, facts={})
    with pytest.raises(InputError, match="not finite"):
        adr_opt.solve(adr_opt.generate("tiny", 0), method="ppo", policy=str(path))


def test_command_line_says_what_is_wrong_with_a_policy(cli, tiny_file: Path) -> None:
    """A file that is no policy ends ``solve`` with exit code 2 and one sentence."""
    outcome = cli("solve", tiny_file, "--method", "ppo", "--policy", tiny_file)
    assert outcome.status == 2
    assert "not a complete ONNX file" in outcome.err
    assert "Traceback" not in outcome.err
    assert cli("solve", tiny_file, "--method", "ppo", "--decode", "guess").status == 2
    assert cli("solve", tiny_file, "--method", "greedy", "--decode", "beam").status == 2
