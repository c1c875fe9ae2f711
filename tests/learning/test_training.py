"""Training: runs, resumes after a kill, learns, and gives files for planners."""

from __future__ import annotations

import csv
import json
import math
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from seeds import over_seeds

import adr_opt

for package in ("torch", "gymnasium", "sb3_contrib", "safetensors"):
    pytest.importorskip(package)

import torch  # noqa: E402
from safetensors.torch import load, save  # noqa: E402
from sb3_contrib import MaskablePPO  # noqa: E402
from stable_baselines3.common.vec_env import VecNormalize  # noqa: E402

from adr_opt.common.errors import InputError  # noqa: E402
from adr_opt.kernels.episodes.choices import IS_STATION, LEGAL  # noqa: E402
from adr_opt.learning import SetPolicy, evaluate, load_policy, write_policy  # noqa: E402
from adr_opt.learning.environment import fields  # noqa: E402
from adr_opt.learning.environment.vector import MissionVecEnv  # noqa: E402
from adr_opt.learning.evaluation import APART, UNCERTAIN, digest, splits  # noqa: E402
from adr_opt.learning.held_out import FAMILIES, HELD_FIELDS, HELD_SEED, HeldFields, chaser_by_chaser  # noqa: E402
from adr_opt.learning.training import configs, imitation, trainer  # noqa: E402
from adr_opt.learning.training.checkpoints import read_checkpoint, read_state, write_checkpoint  # noqa: E402
from adr_opt.learning.training.runs import TrainingRun, locked  # noqa: E402
from adr_opt.sources.library import load_library  # noqa: E402


def _call(folder: Path, *more: str) -> list[str]:
    return [
        sys.executable,
        "-m",
        "adr_opt",
        "train",
        "--out",
        str(folder),
        "--evaluate-every",
        "16384",
        "--checkpoint-every",
        "0",
        *more,
    ]


def _curve(folder: Path) -> list[dict[str, str]]:
    with (folder / "evaluations.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _steps(folder: Path) -> int:
    """Steps of the last checkpoint."""
    path = folder / "checkpoint.safetensors"
    return int(read_state(path)["steps"]) if path.exists() else 0


@pytest.mark.slow
def test_training_survives_a_kill(tmp_path: Path) -> None:
    """Killed at any moment, a training goes on from its last checkpoint with whole files."""
    folder = tmp_path / "run"
    training = subprocess.Popen(_call(folder, "--steps", "65536", "--quiet"))
    deadline = time.monotonic() + 300.0
    while time.monotonic() < deadline and not _steps(folder):
        time.sleep(0.2)
    training.send_signal(signal.SIGKILL)
    training.wait()
    assert 0 < _steps(folder) < 65536
    ended = subprocess.run(
        _call(folder, "--steps", "65536", "--json"), capture_output=True, text=True, check=True
    )
    assert json.loads(ended.stdout)["held"]["nominal"] > 0.0
    after = read_state(folder / "checkpoint.safetensors")
    assert after["steps"] >= 65536
    steps = [int(float(row["steps"])) for row in _curve(folder)]
    assert steps == sorted(set(steps))
    assert load_policy(folder / "best.npz").name == "policy"
    assert load_policy(folder / "last.npz").card["steps"] == steps[-1]
    again = subprocess.run(_call(folder, "--steps", "65536"), capture_output=True, text=True)
    assert again.returncode == 0
    assert read_state(folder / "checkpoint.safetensors") == after


@pytest.mark.slow
def test_a_minute_of_training_beats_random(tmp_path: Path) -> None:
    """After a minute the greedy policy services more than twice what an untrained one does."""
    folder = tmp_path / "run"
    training = subprocess.Popen(_call(folder, "--steps", "10000000", "--quiet"))
    time.sleep(90.0)  # the pool of fields takes about half a minute of these
    training.send_signal(signal.SIGINT)
    assert training.wait(timeout=120.0) == 130
    curve = _curve(folder)
    assert float(curve[0]["steps"]) == 0
    untrained = float(curve[0]["nominal"])
    assert max(float(row["nominal"]) for row in curve) > 2.0 * untrained
    result = adr_opt.solve(
        adr_opt.generate("nominal", 4), method="ppo", policy=str(folder / "best.npz")
    )
    assert result.objective > 2.0 * untrained


def test_a_folder_of_another_training_is_refused(tmp_path: Path) -> None:
    """Another configuration or seed never goes on from a checkpoint that is not its own."""
    config = configs.config_of("policy")
    (tmp_path / "run").mkdir()
    TrainingRun(tmp_path / "run", config, 0)
    TrainingRun(tmp_path / "run", config, 0)
    with pytest.raises(InputError, match="seed"):
        TrainingRun(tmp_path / "run", config, 1)
    with pytest.raises(InputError, match="observation"):
        TrainingRun(tmp_path / "run", configs.config_of("published"), 0)
    (tmp_path / "run" / "run.json").write_text("[]", encoding="utf-8")
    with pytest.raises(InputError, match="not the file of a training"):
        TrainingRun(tmp_path / "run", config, 0)


BRIEF = replace(
    configs.config_of("policy"),
    kinds={"few": fields.Fields(targets=(3, 5))},
    missions=2,
    rollout=16,
    batch=8,
    epochs=2,
    slots=2,
    models=(),
    network={"width": 8, "layers": 1},
)
"""A configuration with rollouts of 32 steps."""


def _model(seed: int = 0) -> tuple[MaskablePPO, MissionVecEnv]:
    """A model that learns in them."""
    config = BRIEF
    env = MissionVecEnv(2, tuple(config.kinds.values()), slots=2, seed=seed)
    return trainer.model_of(config, env, seed, "cpu"), env


def _go_on(model: MaskablePPO, env: MissionVecEnv) -> dict[str, torch.Tensor]:
    """The weights after two more rollouts in a new environment."""
    env.seed(5)
    model._last_obs = None
    model.learn(64, reset_num_timesteps=False)
    return {name: tensor.clone() for name, tensor in model.policy.state_dict().items()}


@pytest.mark.slow
def test_a_checkpoint_holds_all_of_a_model(tmp_path: Path) -> None:
    """A model made of a checkpoint goes on bit for bit as the one that wrote it."""
    path = tmp_path / "checkpoint.safetensors"
    model, env = _model()
    model.learn(32)
    write_checkpoint(model, path, 1.5, -math.inf)
    expected = _go_on(model, env)
    other, env = _model(seed=1)
    read_checkpoint(other, path)
    assert read_state(path) == {"steps": 32, "updates": 2, "seconds": 1.5, "best": -math.inf}
    found = _go_on(other, env)
    assert expected.keys() == found.keys()
    assert all(torch.equal(expected[name], found[name]) for name in expected)
    assert (model.num_timesteps, model._n_updates) == (other.num_timesteps, other._n_updates)


def test_damaged_checkpoints_are_refused(tmp_path: Path) -> None:
    """Nothing but a whole checkpoint of the same network is gone on from, in one sentence."""
    path = tmp_path / "checkpoint.safetensors"
    model, _ = _model()
    write_checkpoint(model, path, 1.0, 2.0)
    whole = path.read_bytes()
    tensors, state = load(whole), {"steps": 3, "updates": 1, "seconds": 1.0, "best": 2.0}
    out_of_range = tensors["random.numpy"].clone()
    out_of_range[-1] = 10**6
    contents = [b"", whole[:100], whole[:-1], whole + b"0", pickle.dumps(tensors)]
    for change in (
        {"policy.network.score.bias": torch.zeros(3)},
        {"policy.network.score.bias": torch.zeros(1, dtype=torch.float64)},
        {"random.numpy": out_of_range},
        {"random.torch": torch.zeros_like(tensors["random.torch"])},
        {"optimizer.0.step": torch.zeros(())},
        {"more": torch.zeros(1)},
    ):
        contents.append(save(tensors | change, {"state": json.dumps(state)}))
    for change in (
        {"steps": "3"},
        {"steps": -1},
        {"updates": 1.5},
        {"seconds": "a"},
        {"best": math.nan},
        {"steps": None},
    ):
        contents.append(save(tensors, {"state": json.dumps(state | change)}))
    contents += [save(tensors, meta) for meta in (None, {"state": "[" * 100_000}, {"state": "[]"})]
    for number, content in enumerate(contents):
        path.write_bytes(content)
        with pytest.raises(InputError, match="not the checkpoint") as refused:
            read_checkpoint(model, path)
        assert "\n" not in str(refused.value), number


class _Bomb:
    """Unpickled, it makes a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.path,)


def test_no_checkpoint_is_unpickled(tmp_path: Path) -> None:
    """A pickle in place of a checkpoint is not even opened."""
    run, made = TrainingRun(tmp_path, configs.config_of("policy"), 0), tmp_path / "made"
    assert run.state == {}
    torch.save(_Bomb(made), run.checkpoint)
    with pytest.raises(InputError, match="not the checkpoint"):
        run.state  # noqa: B018
    assert not made.exists()


def test_a_damaged_curve_is_refused(tmp_path: Path) -> None:
    """What is not the curve of a training is neither gone on with nor overwritten."""
    run = TrainingRun(tmp_path, configs.config_of("policy"), 0)
    for text in ("steps,seconds\nmany,1\n", "steps,seconds\n1\n"):
        (tmp_path / "evaluations.csv").write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="not the curve"):
            run.add_to_curve(1, 1.0, {"nominal": 1.0})


def test_a_full_disk_ends_a_training_in_a_sentence(
    tmp_path: Path, full_disk: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A checkpoint that cannot be written ends the training with one sentence."""
    monkeypatch.setattr(trainer, "HeldFields", lambda: HeldFields(count=1))
    with pytest.raises(InputError, match="cannot be written"):
        trainer.train(
            replace(BRIEF, epochs=1, steps=3200),
            tmp_path / "run",
            device="cpu",
            evaluate_every=10**9,
            checkpoint_s=0.0,
            report=lambda done, means: done and full_disk(),
        )


@pytest.mark.slow
def test_two_trainings_never_share_a_folder(tmp_path: Path) -> None:
    """While one runs in a folder another is refused, and a killed one leaves no lock."""
    code = (
        "import sys, time; from pathlib import Path\n"
        "from adr_opt.learning.training.runs import locked\n"
        "with locked(Path(sys.argv[1])): print('in', flush=True); time.sleep(600)"
    )
    other = subprocess.Popen([sys.executable, "-c", code, tmp_path], stdout=subprocess.PIPE)
    assert other.stdout is not None
    assert other.stdout.readline() == b"in\n"
    with pytest.raises(InputError, match="another training runs in it"), locked(tmp_path):
        pass
    other.kill()
    other.wait()
    with locked(tmp_path):
        pass


def test_published_configuration_is_the_appendix() -> None:
    """The named configuration states the published hyperparameters."""
    config = configs.config_of("published")
    stated = (config.rate, config.strength(config.steps), config.batch, config.gamma, config.steps)
    assert stated == (5e-6, 1.0, 2048, 0.99, 10_000_000)
    assert config.network["net_arch"] == [256, 256]
    assert config.observation == "published"


def test_bad_calls_of_train(cli, tmp_path: Path) -> None:
    """What is wrong with a call is said before anything is made."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    for arguments in (
        ("--config", "set", "--out", "run"),
        ("--config", "set-transfer", "--out", "run"),
        ("--out", "run", "--steps", "0"),
        ("--out", "run", "--seed", "-1"),
        ("--out", "run", "--seed", "99999999999999999999"),
        ("--out", "run", "--jobs", "5000"),
        ("--out", "run", "--checkpoint-every", "-1"),
        ("--out", "run", "--batch", "1"),
        ("--out", "run", "--rollout", "0"),
        ("--out", "run", "--rate", "0"),
        ("--out", "run", "--imitate", "-1"),
        ("--out", "run", "--kinds", "clouds"),
        ("--config", "published", "--out", "run", "--imitate", "5"),
        ("--out", "file"),
        ("--out", "file/run"),
    ):
        outcome = cli("train", *arguments)
        assert outcome.status == 2, arguments
        assert "Traceback" not in outcome.err
    assert not (tmp_path / "run").exists()


def test_held_fields_are_not_in_the_library_nor_drawn() -> None:
    """No field that a policy is judged by can be one that it was trained on."""
    library = load_library(Path(__file__).parents[2] / "instances" / "library.json")
    held = range(HELD_SEED, HELD_SEED + HELD_FIELDS)
    for block in splits()["blocks"].values():
        assert block["first"] + block["fields"] <= fields.FIRST_SEED
    names = {instance.name for instance in library.instances}
    assert len(names) >= 350
    assert not names & {f"{family}-{seed}" for family in FAMILIES for seed in held}


def test_a_rate_stays_and_then_falls_to_nothing() -> None:
    """It is whole up to a share of the steps, and falls linearly from there to 0."""
    config = replace(BRIEF, steps=100, constant=0.6)
    assert [config.strength(steps) for steps in (0, 60, 80, 100, 110)] == [1.0, 1.0, 0.5, 0.0, 0.0]


def small(env: MissionVecEnv) -> Any:
    """A model that has hardly learned anything."""
    shape = {"width": 8, "layers": 1}
    tiny: dict[str, Any] = {"n_steps": 8, "batch_size": 16, "n_epochs": 1, "device": "cpu"}
    return MaskablePPO(SetPolicy, env, policy_kwargs=shape, seed=3, **tiny).learn(32)


OWN = fields.Fields("tiny", targets=(6, 6))


def test_a_trained_model_plans(tmp_path: Path, cli: Any) -> None:
    """Saved, loaded and written, it plans from the command line; its scores are the model's."""
    env = MissionVecEnv(4, OWN, slots=2)
    small(env).save(tmp_path / "model.zip")
    model = MaskablePPO.load(tmp_path / "model.zip", device="cpu")
    write_policy(model, tmp_path / "own.npz", name="mine", facts={"who": "me"})
    policy = load_policy(tmp_path / "own.npz")
    assert policy.name == "mine"
    assert (policy.card["steps"], policy.card["seed"], policy.card["who"]) == (32, 3, "me")
    seen, masks = env.reset(), env.action_masks()
    chosen, _ = model.predict(seen, action_masks=masks, deterministic=True)
    scores = policy.scores(seen["moves"], seen["mission"])
    assert scores.argmax(axis=1).tolist() == chosen.tolist()
    instance = adr_opt.generate("tiny", 1, targets=6)
    instance.save(tmp_path / "i.json")
    given = "--method", "ppo", "--policy", tmp_path / "own.npz", "--out", tmp_path / "plan.json"
    outcome = cli("solve", tmp_path / "i.json", *given)
    assert outcome.status == 0, outcome.err
    assert adr_opt.check(instance, adr_opt.load_plan(tmp_path / "plan.json")) == ()


def test_models_that_planners_cannot_run_are_refused(tmp_path: Path) -> None:
    """Each in one sentence, before anything is written."""
    env = MissionVecEnv(4, OWN, observation="published", slots=2)
    flat = MaskablePPO("MlpPolicy", env, n_steps=8, batch_size=16, device="cpu")
    scaled = small(MissionVecEnv(4, OWN, slots=2))
    scaled.set_env(VecNormalize(scaled.get_env(), norm_obs=False))
    scaled._vec_normalize_env = scaled.get_env()
    for model, said in ((flat, "train it with SetPolicy"), (scaled, "VecNormalize")):
        with pytest.raises(InputError, match=said):
            write_policy(model, tmp_path / "own.npz")
        assert not (tmp_path / "own.npz").exists()


def test_evaluations_say_what_a_policy_collects() -> None:
    """Means of a block are those of its fields, gaps are to bounds, and more plans are no worse."""
    kinds = (*FAMILIES, UNCERTAIN)
    greedy, several = (evaluate(fields=2, budget=budget, kinds=kinds) for budget in (1, 3))
    assert tuple(greedy) == kinds
    for family, row in greedy.items():
        first = splits()["blocks"]["test"]["first"]
        assert row.seeds.tolist() == [first, first + 1]
        assert row.mean[0] == row.visits.mean()
        assert (several[family].visits >= row.visits).all()
        if family == UNCERTAIN:
            assert row.visits.sum() < greedy["nominal"].visits.sum()
        known = splits()["blocks"]["test"]["bounds"].get(family, {})
        for seed, visits, bound in zip(row.seeds, row.visits, row.optima, strict=True):
            if str(seed) in known:
                assert visits <= bound == known[str(seed)][1]
    second = evaluate(fields=1, after=1, kinds=FAMILIES)
    assert all(row.visits.tolist() == [greedy[of].visits[1]] for of, row in second.items())
    for wrong in (
        *({"split": "2.1"}, {"budget": 0}, {"fields": 10**6}, {"kinds": ["other"]}),
        *({"after": -1}, {"after": 10_000}),
    ):
        with pytest.raises(InputError):
            evaluate(**wrong)  # type: ignore[arg-type]


def test_a_policy_is_compared_with_beams_field_by_field() -> None:
    """Leads are differences of visits, and a wider beam is the one that collects no less here."""
    found = evaluate(fields=2, beams=(1, 30), kinds=(*FAMILIES, UNCERTAIN))
    for family in FAMILIES:
        of = found[family]
        assert of.lead(30)[0] == (of.visits - of.beams[30].visits).mean()
        assert (of.beams[30].visits >= of.beams[1].visits).all()
        assert (of.beams[30].visits <= np.where(np.isnan(of.optima), 50.0, of.optima)).all()
    assert not found[UNCERTAIN].beams


def test_campaigns_and_clouds_are_evaluated_on_fields_of_their_own() -> None:
    """Three chasers collect more than one does, by the policy and by beams, and no target twice."""
    found = evaluate(fields=1, beams=(1,), kinds=APART)
    first = splits()["blocks"]["test"]["apart"]
    for kind, row in found.items():
        assert row.seeds.tolist() == [first]
        alone = adr_opt.solve(adr_opt.generate(kind, first, chasers=1), "ppo").objective
        assert alone <= row.visits[0] <= 50
        assert (row.visits[0] > alone) == (kind == "campaign")
        beam = adr_opt.solve(adr_opt.generate(kind, first, chasers=1), "beam", width=1).objective
        assert (row.beams[1].visits[0] > beam) == (kind == "campaign")


@over_seeds(range(200), gate=2)
def test_sealed_blocks_are_those_announced(seed: int) -> None:
    """Fields of the block of the test, and of that of the next release, have their digests."""
    names, part = ("test", "2.1"), seed // 2
    block = (splits()["blocks"] | splits()["announced"])[names[seed % 2]]
    assert len(block["digests"]) * block["each"] == block["fields"]
    assert digest(block["first"] + part * block["each"], block["each"]) == block["digests"][part]


def test_no_other_seed_is_in_the_block_of_the_next_release() -> None:
    """It overlaps no block by which anything was judged, and trainings draw from above it."""
    (sealed,) = splits()["announced"].values()
    assert not sealed["bounds"]
    inside = range(sealed["first"], sealed["first"] + sealed["fields"])
    assert inside.stop <= fields.FIRST_SEED
    for block in splits()["blocks"].values():
        for first in (block["first"], block["apart"]):
            assert first not in inside
            assert first + block["fields"] - 1 not in inside


@over_seeds(range(40), gate=2)
def test_what_is_imitated_can_be_played(seed: int) -> None:
    """States of a plan are those that its moves lead to, each of which is legal there."""
    mission = adr_opt.Mission(adr_opt.generate("nominal", 9_500_000 + seed, targets=12))
    plan = adr_opt.solve(mission, "beam", width=30).plan
    assert plan is not None
    states = imitation.states_of(mission, plan)
    assert states[0].to_go == plan.objective
    assert all(state.moves[state.action, LEGAL] == 1.0 for state in states)
    # Prizes of these fields are equal, and only a station has none.
    gained = [one.to_go - next.to_go for one, next in pairwise(states)]
    assert gained == [float(state.moves[state.action, IS_STATION] == 0.0) for state in states[:-1]]


def test_each_chaser_of_a_campaign_is_imitated() -> None:
    """Chasers plan in turn what is left, and all their moves are states that can be played."""
    field = adr_opt.generate("campaign", 9_500_000, targets=14).with_limits(2.0 * 86400.0)
    plans = list[adr_opt.Plan]()
    for mission in chaser_by_chaser(field, plans):
        plan = adr_opt.solve(mission, "beam", width=10, time_limit=math.inf).plan
        assert plan is not None
        plans.append(plan)
    visited = [name for plan in plans for name in plan.destinations if name != "station"]
    assert len(plans) > 1
    assert len(visited) == len(set(visited))
    alone = adr_opt.Mission(field.replace(chasers=field.chasers[:1]))
    states = imitation.states_of(alone, *plans)
    assert len(states) == sum(len(plan.legs) for plan in plans)
    assert all(state.moves[state.action, LEGAL] == 1.0 for state in states)


def test_kinds_of_missions_are_chosen_by_name(tmp_path: Path) -> None:
    """A training has the kinds it was given, and its card names them; others are refused."""
    config = configs.config_of("policy", "campaign, cloud")
    assert dict(config.kinds) == {name: configs.KINDS[name] for name in ("campaign", "cloud")}
    assert dict(configs.config_of("policy").kinds) == {"varied": configs.TRAINED}
    run = TrainingRun(tmp_path, config, 0)
    assert run.card(0)["kinds"] == ["campaign", "cloud"]
    with pytest.raises(InputError, match="'clouds' is unknown; use some of: varied, nominal"):
        configs.config_of("policy", "varied,clouds")


def test_imitation_is_a_better_beginning_than_none(tmp_path: Path) -> None:
    """From plans of few beams a policy begins with far more visits than from random weights."""
    held, begun = HeldFields(count=1), list[float]()
    for imitated in (0, 5):
        config = replace(BRIEF, imitated=imitated, network={"width": 16, "layers": 1}, steps=1)
        told: list[dict[str, float]] = []
        trainer.train(
            config,
            tmp_path / str(imitated),
            report=lambda steps, means, told=told: told.append(dict(means)),
            held_out=held,
        )
        begun.append(next(sum(means.values()) for means in told if means))
    assert begun[1] > 1.5 * begun[0]
    for imitated, first in ((0, ["untrained"]), (5, ["untrained", "imitating"])):
        families = load_policy(tmp_path / str(imitated) / "last.npz").card["families"]
        assert list(families["nominal"]) == [*first, "trained"]
        assert sum(of["untrained"] for of in families.values()) == begun[0]


def test_nothing_is_learned_where_no_move_can_be_imitated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fields whose plans have no move of the environment leave the weights as they are."""
    monkeypatch.setattr(imitation, "states_of", lambda mission, plan: [])
    model, env = _model()
    before = {name: of.clone() for name, of in model.policy.state_dict().items()}
    assert imitation.imitate(model, replace(BRIEF, imitated=2)) == 0
    assert all(torch.equal(of, before[name]) for name, of in model.policy.state_dict().items())
    env.close()


@pytest.mark.slow
def test_training_again_gives_what_is_shipped(tmp_path: Path) -> None:
    """`train` gives a policy within 0.3 visits of the shipped one in each family."""
    card = load_policy().card
    config = replace(configs.config_of("policy"), imitated=card["imitated"], steps=card["steps"])
    trainer.train(config, tmp_path, seed=card["seed"] + 1, evaluate_every=config.steps)
    card_again = load_policy(tmp_path / "last.npz").card
    for family in FAMILIES:
        shipped, again = (of["families"][family]["trained"] for of in (card, card_again))
        assert again >= shipped - 0.3, family
