"""Training: runs, resumes after a kill, and learns."""

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
from pathlib import Path
from typing import Any

import pytest

import adr_opt

for package in ("torch", "gymnasium", "sb3_contrib", "tensorboard", "safetensors", "onnx"):
    pytest.importorskip(package)

import torch  # noqa: E402
from safetensors.torch import load, save  # noqa: E402
from sb3_contrib import MaskablePPO  # noqa: E402

from adr_opt.learning.environment import fields  # noqa: E402
from adr_opt.learning.environment.vector import MissionVecEnv  # noqa: E402
from adr_opt.sources.library import load_library  # noqa: E402
from solvers.policies import load_policy  # noqa: E402
from solvers.training import configs, trainer  # noqa: E402
from solvers.training.checkpoints import read_checkpoint, read_state, write_checkpoint  # noqa: E402
from solvers.training.runs import TrainingRun, locked  # noqa: E402
from solvers.training.trainer import FAMILIES, HELD_FIELDS, HELD_SEED  # noqa: E402


def _call(folder: Path, *more: str) -> list[str]:
    return [
        sys.executable,
        "-m",
        "adr_opt",
        "train",
        "--config",
        "set-transfer",
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
    steps = [int(row["steps"]) for row in _curve(folder)]
    assert steps == sorted(set(steps))
    assert load_policy(folder / "best.onnx").targets is None
    assert load_policy(folder / "last.onnx").facts["steps"] == steps[-1]
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
    assert int(curve[0]["steps"]) == 0
    untrained = float(curve[0]["nominal"])
    assert max(float(row["nominal"]) for row in curve) > 2.0 * untrained
    result = adr_opt.solve(
        adr_opt.generate("nominal", 4), method="ppo", policy=str(folder / "best.onnx")
    )
    assert result.objective > 2.0 * untrained


def test_a_folder_of_another_training_is_refused(tmp_path: Path) -> None:
    """Another configuration or seed never goes on from a checkpoint that is not its own."""
    config = configs.config("set")
    (tmp_path / "run").mkdir()
    TrainingRun(tmp_path / "run", config, 0)
    TrainingRun(tmp_path / "run", config, 0)
    with pytest.raises(adr_opt.common.errors.InputError, match="seed"):
        TrainingRun(tmp_path / "run", config, 1)
    with pytest.raises(adr_opt.common.errors.InputError, match="observation"):
        TrainingRun(tmp_path / "run", configs.config("published"), 0)
    (tmp_path / "run" / "run.json").write_text("[]", encoding="utf-8")
    with pytest.raises(adr_opt.common.errors.InputError, match="not the file of a training"):
        TrainingRun(tmp_path / "run", config, 0)


BRIEF = replace(
    configs.config("set-transfer"),
    fields=fields.Fields(targets=(3, 5)),
    missions=2,
    rollout=16,
    batch=8,
    epochs=2,
    slots=2,
)
"""A configuration with rollouts of 32 steps."""


def _model(seed: int = 0) -> tuple[MaskablePPO, MissionVecEnv]:
    """A model that learns in them."""
    config = BRIEF
    env = MissionVecEnv(2, config.fields, observation=config.observation, slots=2, seed=seed)
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
        {"policy.network.lead": torch.zeros(3)},
        {"policy.network.lead": torch.zeros((), dtype=torch.float64)},
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
        with pytest.raises(adr_opt.common.errors.InputError, match="not the checkpoint") as refused:
            read_checkpoint(model, path)
        assert "\n" not in str(refused.value), number


class _Bomb:
    """Unpickled, it makes a file."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.path,)


def test_no_checkpoint_is_unpickled(tmp_path: Path) -> None:
    """A checkpoint of an older version, or a pickle in place of one, is not even opened."""
    run, made = TrainingRun(tmp_path, configs.config("set"), 0), tmp_path / "made"
    assert run.state == {}
    torch.save(_Bomb(made), tmp_path / "checkpoint.zip")
    with pytest.raises(adr_opt.common.errors.InputError, match="no longer read"):
        run.state  # noqa: B018
    torch.save(_Bomb(made), run.checkpoint)
    with pytest.raises(adr_opt.common.errors.InputError, match="not the checkpoint"):
        run.state  # noqa: B018
    assert not made.exists()


def test_a_damaged_curve_is_refused(tmp_path: Path) -> None:
    """What is not the curve of a training is neither gone on with nor overwritten."""
    run = TrainingRun(tmp_path, configs.config("set"), 0)
    for text in ("steps,seconds\nmany,1\n", "steps\n\n"):
        (tmp_path / "evaluations.csv").write_text(text, encoding="utf-8")
        with pytest.raises(adr_opt.common.errors.InputError, match="not the curve"):
            run.add_to_curve(1, 1.0, {"nominal": 1.0})


def test_a_full_disk_ends_a_training_in_a_sentence(
    tmp_path: Path,
    full_disk: Callable[[], None],
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What TensorBoard or the checkpoint cannot write ends the training with one sentence."""
    config = replace(BRIEF, epochs=1)
    calls: dict[str, Any] = {
        "steps": 3200,
        "seed": 0,
        "jobs": 1,
        "device": "cpu",
        "evaluate_every": 10**9,
        "enough": lambda: False,
        "report": lambda done, means: done and full_disk(),
    }
    monkeypatch.setattr("solvers.training.trainer.HELD_FIELDS", 1)
    for checkpoint_s in (0.0, 1e9):
        with pytest.raises(adr_opt.common.errors.InputError, match="cannot be written"):
            trainer.train(config, tmp_path / str(checkpoint_s), checkpoint_s=checkpoint_s, **calls)
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.slow
def test_two_trainings_never_share_a_folder(tmp_path: Path) -> None:
    """While one runs in a folder another is refused, and a killed one leaves no lock."""
    code = (
        "import sys, time; from pathlib import Path; from solvers.training.runs import locked\n"
        "with locked(Path(sys.argv[1])): print('in', flush=True); time.sleep(600)"
    )
    other = subprocess.Popen([sys.executable, "-c", code, tmp_path], stdout=subprocess.PIPE)
    assert other.stdout is not None
    assert other.stdout.readline() == b"in\n"
    with (
        pytest.raises(adr_opt.common.errors.InputError, match="another training runs in it"),
        locked(tmp_path),
    ):
        pass
    other.kill()
    other.wait()
    with locked(tmp_path):
        pass


@pytest.mark.slow
def test_a_training_stopped_after_its_last_step_is_ended(tmp_path: Path) -> None:
    """The same call again evaluates and keeps the last weights, and then says what they are."""
    config = configs.config("published")
    calls = {
        "steps": 1,
        "seed": 0,
        "jobs": 1,
        "device": "cpu",
        "evaluate_every": 10**9,
        "checkpoint_s": 0.0,
    }
    steps: list[int] = []
    trainer.train(
        config,
        tmp_path,
        **calls,
        enough=lambda: bool(steps and steps[-1] > 0),
        report=lambda done, _: steps.append(done),
    )
    (tmp_path / "last.onnx").unlink(missing_ok=True)
    heard: list[dict[str, float]] = []
    for _ in range(2):
        trainer.train(
            config,
            tmp_path,
            **calls,
            enough=lambda: False,
            report=lambda _, means: heard.append(dict(means)),
        )
        assert (tmp_path / "last.onnx").is_file()
    assert heard[-1].keys() == set(FAMILIES)


def test_published_configuration_is_the_appendix() -> None:
    """The named configuration states the published hyperparameters."""
    config = configs.config("published")
    stated = (
        config.learning_rate,
        config.final_learning_rate,
        config.batch,
        config.gamma,
        config.clip,
        config.steps,
        config.network["net_arch"],
        config.observation,
    )
    assert stated == (5e-6, 5e-6, 2048, 0.99, 0.2, 10_000_000, [256, 256], "published")


def test_bad_calls_of_train(cli, tmp_path: Path) -> None:
    """What is wrong with a call is said before anything is made."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    for arguments in (
        ("--config", "other", "--out", "run"),
        ("--config", "set", "--out", "run", "--steps", "0"),
        ("--config", "set", "--out", "run", "--seed", "-1"),
        ("--config", "set", "--out", "run", "--seed", "99999999999999999999"),
        ("--config", "set", "--out", "run", "--jobs", "5000"),
        ("--config", "set", "--out", "run", "--checkpoint-every", "-1"),
        ("--config", "set", "--out", "file"),
        ("--config", "set", "--out", "file/run"),
    ):
        outcome = cli("train", *arguments)
        assert outcome.status == 2, arguments
        assert outcome.err.count("\n") == 1
        assert "Traceback" not in outcome.err
    assert not (tmp_path / "run").exists()


def test_held_fields_are_not_in_the_library_nor_drawn() -> None:
    """No field that a policy is judged by can be one that it was trained on."""
    library = load_library(Path(__file__).parents[2] / "instances" / "library.json")
    held = range(HELD_SEED, HELD_SEED + HELD_FIELDS)
    assert held.stop <= fields.FIRST_SEED
    names = {instance.name for instance in library.instances}
    assert len(names) >= 350
    assert not names & {f"{family}-{seed}" for family in FAMILIES for seed in held}
