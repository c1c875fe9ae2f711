"""Safety ellipses about drawn targets, each burn missed in turn."""

from __future__ import annotations

import math

import numpy as np
from tables import head, row

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.judge.check.missed import CAPTURE_REVOLUTIONS, begun, nearest_m, rule_of
from adr_opt.problem.agreement import ROUNDEST
from adr_opt.problem.approach import approach_of
from adr_opt.problem.settings import TransferSettings

VARIANTS: tuple[dict[str, float], ...] = (
    {},
    {"approach_revolutions": 1},
    {"approach_revolutions": 5},
    {"inspection_revolutions": 10},
    {"keep_out_m": 720.0},
    {"standoff_m": 5000.0},
)
HIGHEST_M = 1.2e6
"""Greatest altitude of perigees."""


def drawn(targets: int, seed: int) -> np.ndarray:
    """Elements of targets at the stand-off: perigees from 300 km up, any plane, e up to 0.02."""
    rng = np.random.default_rng(seed)
    e = rng.uniform(0.0, ROUNDEST, targets)
    perigee = EARTH_RADIUS_M + rng.uniform(300e3, HIGHEST_M, targets)
    tilt = np.arccos(rng.uniform(-1.0, 1.0, targets))
    angles = rng.uniform(0.0, math.tau, (3, targets))
    return np.stack([perigee / (1.0 - e), e, tilt, *angles], axis=1)


def missed(targets: int = 1000, seed: int = 2026) -> None:
    """Least distances under J2, up to eight revolutions after each missed burn of the approach."""
    head(
        *("settings", "ρ m", "revolutions", "ΔV m/s at 800 km", "targets", "burns"),
        *("least m", "below keep-out"),
    )
    orbits = drawn(targets, seed)
    for changes in VARIANTS:
        settings = TransferSettings(approach="safety-ellipse").replace(**changes)
        approach = approach_of(settings)
        target, chaser, motion = begun(orbits, settings.standoff_m)
        judged = approach.burns[:, 0] <= approach.revolutions - CAPTURE_REVOLUTIONS
        revolution = math.tau / motion[:, 0]
        times = approach.burns[judged, :1] * revolution
        least = nearest_m(target, chaser, times, rule_of(approach.burns, motion), revolution)
        n = math.sqrt(MU_M3_S2 / (EARTH_RADIUS_M + 800e3) ** 3)
        row(
            ", ".join(f"`{name}` {value:g}" for name, value in changes.items()) or "defaults",
            f"{approach.oscillation_m:.0f}",
            f"{approach.revolutions:g}",
            f"{n * approach.length_m:.2f}",
            targets,
            int(judged.sum()),
            f"{least.min():.0f}",
            int((least.min(axis=0) < settings.keep_out_m).sum()),
        )
