"""Training: runs, resumes after a kill, and learns."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import adr_opt

for package in ("torch", "gymnasium", "sb3_contrib", "tensorboard", "safetensors", "onnx"):
    pytest.importorskip(package)

from adr_opt.env import fields  # noqa: E402
from adr_opt.library import load_library  # noqa: E402
from solvers.learned import load_policy  # noqa: E402
from solvers.ppo import configs  # noqa: E402
from solvers.ppo.held import FAMILIES, HELD_FIELDS, HELD_SEED  # noqa: E402
from solvers.ppo.runs import Run  # noqa: E402


def _call(folder: Path, *more: str) -> list[str]:
    return [
        sys.executable, "-m", "adr_opt", "train", "--config", "set-transfer", "--out", str(folder),
        "--evaluate-every", "16384", "--checkpoint-every", "0", *more,
    ]  # fmt: skip


def _curve(folder: Path) -> list[dict[str, str]]:
    with (folder / "evaluations.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _steps(folder: Path) -> int:
    """Steps of the last checkpoint."""
    state = folder / "state.json"
    return int(json.loads(state.read_text(encoding="utf-8"))["steps"]) if state.exists() else 0


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
    after = json.loads((folder / "state.json").read_text(encoding="utf-8"))
    assert after["steps"] >= 65536
    steps = [int(row["steps"]) for row in _curve(folder)]
    assert steps == sorted(set(steps))
    assert not list(folder.glob("*.part*"))
    assert load_policy(folder / "last.onnx").facts["steps"] == steps[-1]
    again = subprocess.run(_call(folder, "--steps", "65536"), capture_output=True, text=True)
    assert again.returncode == 0
    assert json.loads((folder / "state.json").read_text(encoding="utf-8")) == after


@pytest.mark.slow
def test_a_minute_of_training_beats_random(tmp_path: Path) -> None:
    """After a minute the greedy policy services more than twice what an untrained one does."""
    folder = tmp_path / "run"
    training = subprocess.Popen(_call(folder, "--steps", "10000000", "--quiet"))
    time.sleep(90.0)  # the pool of fields takes about half a minute of these
    training.send_signal(signal.SIGINT)
    assert training.wait(timeout=120.0) == 0
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
    Run(tmp_path / "run", config, 0)
    Run(tmp_path / "run", config, 0)
    with pytest.raises(adr_opt.errors.InputError, match="seed"):
        Run(tmp_path / "run", config, 1)
    with pytest.raises(adr_opt.errors.InputError, match="observation"):
        Run(tmp_path / "run", configs.config("published"), 0)
    (tmp_path / "run" / "run.json").write_text("[]", encoding="utf-8")
    with pytest.raises(adr_opt.errors.InputError, match="not the file of a training"):
        Run(tmp_path / "run", config, 0)


def test_a_damaged_state_is_refused(tmp_path: Path) -> None:
    """Half of a state file ends in a sentence, and not in a training that begins anew."""
    run = Run(tmp_path, configs.config("set"), 0)
    assert run.state == {}
    (tmp_path / "checkpoint.zip").write_bytes(b"")
    for text in ('{"steps": 16', "[]", '{"steps": 3}', '{"steps": "a", "seconds": 1, "best": 1}'):
        (tmp_path / "state.json").write_text(text, encoding="utf-8")
        with pytest.raises(adr_opt.errors.InputError, match="not the state of a training"):
            run.state  # noqa: B018


@pytest.mark.slow
def test_a_training_stopped_after_its_last_step_is_ended(tmp_path: Path) -> None:
    """The same call again evaluates and keeps the last weights, and then says what they are."""
    from solvers.ppo import trainer

    config = configs.config("published")
    calls = {
        "steps": 1, "seed": 0, "jobs": 1, "device": "cpu", "evaluate_every": 10**9,
        "checkpoint_s": 0.0,
    }  # fmt: skip
    steps: list[int] = []
    trainer.train(
        config, tmp_path, **calls, enough=lambda: bool(steps and steps[-1] > 0),
        report=lambda done, _: steps.append(done),
    )  # fmt: skip
    (tmp_path / "last.onnx").unlink(missing_ok=True)
    heard: list[dict[str, float]] = []
    for _ in range(2):
        trainer.train(
            config, tmp_path, **calls, enough=lambda: False,
            report=lambda _, means: heard.append(dict(means)),
        )  # fmt: skip
        assert (tmp_path / "last.onnx").is_file()
    assert heard[-1].keys() == set(FAMILIES)


def test_published_configuration_is_the_appendix() -> None:
    """The named configuration states the published hyperparameters."""
    config = configs.config("published")
    stated = (
        config.learning_rate, config.final_learning_rate, config.batch, config.gamma, config.clip,
        config.steps, config.network["net_arch"], config.observation,
    )  # fmt: skip
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
    library = load_library(Path(__file__).parent.parent / "instances" / "library.json")
    held = range(HELD_SEED, HELD_SEED + HELD_FIELDS)
    assert held.stop <= fields.FIRST_SEED
    names = {instance.name for instance in library.instances}
    assert len(names) >= 350
    assert not names & {f"{family}-{seed}" for family in FAMILIES for seed in held}
