"""A model trained elsewhere with Stable-Baselines3 becomes a file for ``--policy``."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from conftest import Cli

import adr_opt

for package in ("torch", "gymnasium", "sb3_contrib", "tensorboard", "safetensors", "onnx"):
    pytest.importorskip(package)

from sb3_contrib import MaskablePPO  # noqa: E402
from stable_baselines3.common.vec_env import VecNormalize  # noqa: E402

from adr_opt.common.errors import InputError  # noqa: E402
from adr_opt.learning.environment import Fields, MissionVecEnv  # noqa: E402
from solvers.policies import load_policy  # noqa: E402
from solvers.training import SetPolicy, write_policy  # noqa: E402

FIELDS = Fields("tiny", targets=(6, 6))
TINY = {"n_steps": 8, "batch_size": 16, "n_epochs": 1, "device": "cpu", "seed": 3}


def env(observation: str) -> MissionVecEnv:
    """Four missions on two fields."""
    return MissionVecEnv(4, FIELDS, observation=observation, slots=2, threads=1)


def small(observation: str) -> Any:
    """A model that has hardly learned anything."""
    if observation == "published":
        made = MaskablePPO("MlpPolicy", env(observation), policy_kwargs={"net_arch": [8]}, **TINY)
    else:
        shape = {"width": 8, "rounds": 1}
        made = MaskablePPO(SetPolicy, env(observation), policy_kwargs=shape, **TINY)
    return made.learn(32)


@pytest.mark.parametrize(
    "observation", ["transfer", pytest.param("published", marks=pytest.mark.slow)]
)
def test_a_trained_model_plans(observation: str, tmp_path: Path, cli: Cli) -> None:
    """Saved, loaded and written, it plans from the command line; its scores are the model's."""
    small(observation).save(tmp_path / "model.zip")
    model = MaskablePPO.load(tmp_path / "model.zip", device="cpu")
    path = tmp_path / "own.onnx"
    write_policy(model, path, name="mine", facts={"who": "me"})
    policy = load_policy(path)
    assert (policy.name, policy.observation) == ("mine", observation)
    assert policy.facts["steps"] == 32
    assert (policy.facts["seed"], policy.facts["who"]) == (3, "me")
    world = env(observation)
    seen, masks = world.reset(), world.action_masks()
    scores, _ = policy.judge(seen, masks)
    chosen, _ = model.predict(seen, action_masks=masks, deterministic=True)
    assert scores.argmax(axis=1).tolist() == chosen.tolist()
    instance = adr_opt.generate("tiny", 1, targets=6)
    instance.save("i.json")
    outcome = cli("solve", "i.json", "--method", "ppo", "--policy", path, "--out", "plan.json")
    assert outcome.status == 0, outcome.err
    assert adr_opt.check(instance, adr_opt.load_plan("plan.json")) == ()
    assert json.loads(Path("plan.json").read_text())["method"] == "ppo"


@pytest.mark.slow
def test_models_that_planners_cannot_run_are_refused(tmp_path: Path) -> None:
    """Each in one sentence, before anything is written."""
    path = tmp_path / "own.onnx"
    flat = MaskablePPO("MultiInputPolicy", env("transfer"), **TINY)
    odd = MaskablePPO(
        "MlpPolicy",
        env("published"),
        policy_kwargs={"activation_fn": __import__("torch").nn.GELU},
        **TINY,
    )
    scaled = MaskablePPO("MlpPolicy", VecNormalize(env("published")), **TINY)
    strange = MaskablePPO("MlpPolicy", "CartPole-v1", **TINY)
    for model, said in (
        (flat, "SetPolicy"),
        (odd, "that no policy has"),
        (scaled, "VecNormalize"),
        (strange, "other observations"),
    ):
        with pytest.raises(InputError, match=said) as error:
            write_policy(model, path)
        assert "\n" not in str(error.value)
        assert not path.exists()


@pytest.mark.slow
def test_the_recipe_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """docs/policy.md, with a network, fields and a training as small as they can be."""
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[2] / "docs" / "policy.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    for large, little in (
        (
            'MissionVecEnv(256, VARIED, observation="transfer", slots=64, refresh_every=4096)',
            'MissionVecEnv(4, SMALL, observation="transfer", slots=2)',
        ),
        ("n_steps=64, batch_size=512", "n_steps=8, batch_size=16"),
        ("1_000_000", "32"),
    ):
        assert large in code
        code = code.replace(large, little)
    names: dict[str, Any] = {"SMALL": FIELDS}
    exec(code, names)
    assert adr_opt.check(names["instance"], names["result"].plan) == ()
