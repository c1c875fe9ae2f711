"""Configurations of training: the policy of the package, and the published one to compare with."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.uncertainty import (
    CaptureUncertainty,
    Delay,
    LegUncertainty,
    LognormalFactor,
    ServiceUncertainty,
    Uncertainty,
)
from ..environment.fields import BRIEF, FULL, LEAN, PUBLISHED, VARIED, Fields, Limits
from ..environment.variants import REDUCED_FUEL, REDUCED_TIME
from ..episodes.worlds import TROUBLED

TRAINED = replace(
    VARIED,
    share_of_family=0.8,
    limits=(*(FULL,) * 3, *(BRIEF,) * 4, *(LEAN,) * 3),
    share_of_limits=0.85,
)
"""As varied as :data:`VARIED`, but more often the three benchmark families, and short missions more
often than long ones, which have more moves."""

KINDS = {
    "varied": TRAINED,
    "nominal": PUBLISHED,
    "reduced-time": REDUCED_TIME,
    "reduced-fuel": REDUCED_FUEL,
    "campaign": replace(
        VARIED, family="campaign", delta_v_m_s=(500.0, 2000.0), limits=(LEAN,), share_of_limits=0.5
    ),
    "cloud": replace(
        VARIED,
        family="cloud",
        duration_s=(3.0 * DAY_S, 10.0 * DAY_S),
        limits=(Limits(4000.0, 10.0 * DAY_S),),
        share_of_limits=0.5,
    ),
}
"""Kinds of missions to train on: the usual mixture of the three benchmark families and others like
them, each family alone, campaigns, and clouds of fragments."""

DEAR = LegUncertainty(delta_v_factor=LognormalFactor(lognormal_sigma=0.1))
SLOW = LognormalFactor(lognormal_sigma=0.5)
CAPTURES = CaptureUncertainty(success=0.8, tries=2)

MODELS = (
    *(Uncertainty() for _ in range(10)),
    TROUBLED,
    Uncertainty(legs=DEAR),
    Uncertainty(capture=CAPTURES, gone=0.05),
    Uncertainty(service_s=ServiceUncertainty(factor=SLOW, added=Delay(chance=0.1, mean_s=14400.0))),
    Uncertainty(legs=DEAR, service_s=ServiceUncertainty(factor=SLOW), capture=CAPTURES, gone=0.05),
)
"""Worlds, of which each mission draws one: in two thirds of them all goes as planned."""


@dataclass(frozen=True)
class Config:
    """A training, without its seed.

    Attributes
    ----------
    name : str
    observation : {"choices", "published"}
    kinds : dict of str to Fields
        Kinds of missions by name, each as often as the others.
    models : tuple of Uncertainty
        Models of uncertainty, of which each mission draws one; without any, all goes as planned.
    steps : int
        Environment steps of the whole training, at least.
    missions, slots, refresh_every : int
        ``count``, ``slots`` and ``refresh_every`` of the
        :class:`adr_opt.learning.environment.MissionVecEnv`.
    rollout : int
        Steps of each mission between two updates of the network.
    batch, epochs, rate, gamma, gae_lambda, entropy
        Of PPO. From the share ``constant`` of all steps on, rate and entropy fall linearly to 0,
        and batches grow to four times their size.
    constant : float
    reward_scale : float
        Factor of the rewards while training.
    imitated : int
        Number of fields on which plans of beams are imitated before the first step.
    network : dict
        Options of :class:`.network.SetPolicy`, or, if it has ``net_arch``, of Stable-Baselines3's
        multilayer perceptron.

    Raises
    ------
    InputError
        A number out of range.
    """

    name: str
    observation: str
    kinds: Mapping[str, Fields]
    models: tuple[Uncertainty, ...]
    steps: int
    missions: int
    rollout: int
    batch: int
    epochs: int
    rate: float
    gamma: float
    gae_lambda: float
    entropy: float
    constant: float
    reward_scale: float
    slots: int = 48
    refresh_every: int = 8192
    imitated: int = 0
    network: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("steps", "rollout", "batch"):
            value = operator.index(getattr(self, name))
            least = 2 if name == "batch" else 1
            if not least <= value <= 10**12:
                raise InputError(f"--{name} = {value}: must be between {least} and {10**12}")
        if not 0 <= self.imitated <= 10**6:
            raise InputError(f"--imitate = {self.imitated}: must be between 0 and {10**6}")
        if self.imitated and self.observation != "choices":
            raise InputError(f"--imitate: {self.name!r} sees no choices, which are imitated")
        if not 0.0 < self.rate <= 1.0:
            raise InputError(f"--rate = {self.rate:g}: must be positive, and at most 1")

    def strength(self, steps: int) -> float:
        """Factor of the rate after a number of steps."""
        falling = self.steps * (1.0 - self.constant)
        return min(1.0, max(0.0, (self.steps - steps) / falling)) if falling else 1.0


POLICY = Config(
    name="policy",
    observation="choices",
    kinds={"varied": TRAINED},
    models=MODELS,
    steps=6_000_000,
    missions=256,
    rollout=64,
    batch=1024,
    epochs=2,
    rate=1e-3,
    gamma=1.0,
    gae_lambda=0.97,
    entropy=0.008,
    constant=0.15,
    reward_scale=0.1,
    slots=128,
    refresh_every=4096,
    network={"width": 48, "layers": 2},
)

PUBLISHED_CONFIG = Config(
    name="published",
    observation="published",
    kinds={"nominal": PUBLISHED},
    models=(),
    steps=10_000_000,
    missions=128,
    # Not in the appendix: Stable-Baselines3's own defaults, but for the length of a rollout, which
    # is shared out over many missions.
    rollout=128,
    batch=2048,
    epochs=10,
    rate=5e-6,
    gamma=0.99,
    gae_lambda=0.95,
    entropy=0.0,
    constant=1.0,
    reward_scale=1.0,
    network={"net_arch": [256, 256]},
)
"""The published appendix: two layers of 256 units, which see no costs of moves."""

CONFIGS = {config.name: config for config in (POLICY, PUBLISHED_CONFIG)}
"""The configurations by name."""


def config_of(name: str, kinds: str | None = None, **changed: Any) -> Config:
    """The configuration with a name, with other kinds of missions or numbers if they are not None.

    Parameters
    ----------
    name : str
    kinds : str, optional
        Names in :data:`KINDS`, separated by commas.
    **changed
        Numbers of :class:`Config` by name.

    Raises
    ------
    InputError
        There is no configuration or kind of that name, or a number is out of range.
    """
    if name not in CONFIGS:
        raise InputError(f"config {name!r} is unknown; use one of: {', '.join(CONFIGS)}")
    if kinds is not None:
        chosen = [kind.strip() for kind in kinds.split(",")]
        for kind in chosen:
            if kind not in KINDS:
                raise InputError(f"--kinds: {kind!r} is unknown; use some of: {', '.join(KINDS)}")
        changed["kinds"] = {kind: KINDS[kind] for kind in chosen}
    return replace(CONFIGS[name], **{key: of for key, of in changed.items() if of is not None})
