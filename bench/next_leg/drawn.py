"""Missions and worlds on which the choice of the next leg is trained."""

from __future__ import annotations

import numpy as np

from adr_opt.learning.environment.fields import FIRST_SEED, LAST_SEED, VARIED
from adr_opt.problem.bodies import DisposalCircle
from adr_opt.problem.chasers import TankByMass
from adr_opt.problem.instance import Instance
from adr_opt.problem.uncertainty import Uncertainty
from adr_opt.sources.generator import generate

VARIANTS = ("nominal", "reduced-fuel", "reduced-time", "domain-randomised")
"""What a policy is trained for: one family each, or all that is drawn here."""

KINDS = (
    *("nominal", "reduced-fuel", "reduced-time", "varied", "many", "dense"),
    *("campaign", "kits", "towed"),
)
"""Kinds of missions of the last variant: the families; budgets, durations and numbers of targets
as the environment draws them; fields of 70 to 160, and of 200 to 600 targets; several chasers, each
with a tank in ΔV; chasers that carry kits, or tow what they service, with tanks by mass."""

CHANCES = (0.19, 0.15, 0.15, 0.17, 0.1, 0.08, 0.08, 0.04, 0.04)

PRIZES, WINDOWS, REQUIRED = 0.35, 0.2, 0.15
"""Shares of missions with unequal prizes, with windows and with required targets."""

SMALL, SMALLEST, LARGEST = 0.2, 12, 24
"""Share of missions that are small enough to be proven, and numbers of their targets."""

MIXED = Uncertainty(
    legs={"delta_v_factor": {"lognormal_sigma": 0.1}},
    service_s={"factor": {"lognormal_sigma": 0.5}},
    capture={"success": 0.8, "tries": 2},
    gone=0.05,
)
"""All kinds of events at once."""

KNOWN = 0.25
"""Share of worlds in which all goes as planned."""


def drawn_instance(rng: np.random.Generator, variant: str, *, dense: bool = True) -> Instance:
    """A mission of a variant; of the randomised one with other rules now and then.

    Parameters
    ----------
    rng : Generator
    variant : str
    dense : bool
        Whether fields of more than 160 targets may be drawn, in which to judge a move takes long.
    """
    small, randomised = rng.random() < SMALL, variant == VARIANTS[-1]
    if small or not randomised:
        name = str(rng.choice(VARIANTS[:-1])) if randomised else variant
        targets = int(rng.integers(SMALLEST, LARGEST + 1)) if small else None
        return generate(name, int(rng.integers(FIRST_SEED, LAST_SEED)), targets=targets)
    kind = str(rng.choice(KINDS, p=CHANCES))
    while kind == "dense" and not dense:
        kind = str(rng.choice(KINDS, p=CHANCES))
    return _with_wishes(_of_kind(kind, rng), rng)


def _of_kind(kind: str, rng: np.random.Generator) -> Instance:
    seed = int(rng.integers(FIRST_SEED, LAST_SEED))
    if kind in ("many", "dense"):
        least, most = (70, 160) if kind == "many" else (200, 600)
        return generate("nominal", seed, targets=int(rng.integers(least, most + 1)))
    if kind == "varied":
        limits = VARIED.draw_limits(rng)
        return VARIED.draw_field(rng).with_limits(limits.duration_s, limits.delta_v_m_s)
    if kind == "campaign":
        family = str(rng.choice(["nominal", "reduced-fuel", "reduced-time"]))
        chasers, stations = int(rng.integers(2, 4)), int(rng.integers(1, 3))
        return generate(family, seed, chasers=chasers, stations=stations)
    if kind in ("kits", "towed"):
        tank = TankByMass(
            dry_mass_kg=float(rng.uniform(300.0, 700.0)),
            propellant_kg=float(rng.uniform(300.0, 900.0)),
            isp_s=300.0,
        )
        targets, chasers = int(rng.integers(16, 41)), int(rng.integers(1, 3))
        if kind == "kits":
            return generate(
                "nominal",
                seed,
                targets=targets,
                chasers=chasers,
                tank=tank,
                kits=int(rng.integers(3, 12)),
                kit_mass_kg=float(rng.uniform(5.0, 30.0)),
            )
        return generate(
            "nominal",
            seed,
            targets=targets,
            chasers=chasers,
            tank=tank,
            towed_kg=float(rng.uniform(50.0, 300.0)),
            disposal=DisposalCircle(circle_m=500e3),
        )
    return generate(kind, seed)


def drawn_uncertainty(rng: np.random.Generator) -> Uncertainty:
    """Nothing uncertain, or some of dear legs, long services, failed captures, and targets gone."""
    content: dict[str, object] = {}
    if rng.random() >= KNOWN:
        if rng.random() < 0.5:
            sigma = float(rng.choice([0.03, 0.1, 0.2]))
            content["legs"] = {"delta_v_factor": {"lognormal_sigma": sigma}}
        if rng.random() < 0.4:
            service: dict[str, object] = {
                "factor": {"lognormal_sigma": float(rng.choice([0.3, 0.5]))}
            }
            if rng.random() < 0.5:
                service["added"] = {"chance": 0.1, "mean_s": 14400.0}
            content["service_s"] = service
        if rng.random() < 0.5:
            content["capture"] = {
                "success": float(rng.uniform(0.7, 0.95)),
                "tries": int(rng.integers(1, 4)),
            }
        if rng.random() < 0.4:
            content["gone"] = float(rng.uniform(0.02, 0.1))
    return Uncertainty(**content)  # type: ignore[arg-type]


def _with_wishes(instance: Instance, rng: np.random.Generator) -> Instance:
    """The instance with prizes, windows or required targets of its own, now and then."""
    targets, duration_s = list(instance.targets), instance.mission.duration_s
    if rng.random() < PRIZES:
        drawn = np.round(rng.gamma(2.0, 0.5, len(targets)) + 0.1, 2)
        targets = [
            each.replace(prize=float(prize)) for each, prize in zip(targets, drawn, strict=True)
        ]
    if rng.random() < WINDOWS:
        for at in rng.choice(len(targets), len(targets) // 3, replace=False):
            opens = float(rng.uniform(0.0, 0.6)) * duration_s
            closes = opens + float(rng.uniform(0.15, 0.5)) * duration_s
            targets[at] = targets[at].replace(window_s=(opens, closes))
    if rng.random() < REQUIRED:
        for at in rng.choice(len(targets), 3, replace=False):
            targets[at] = targets[at].replace(required=True)
    return instance.replace(targets=tuple(targets))
