"""Claims of leads in paired samples, corrected for their number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import ttest_rel, wilcoxon

SIGNIFICANT = 0.01


def chance(better: np.ndarray, worse: np.ndarray) -> float:
    """Chance of so large a lead in paired samples if neither were better (Wilcoxon, one-sided)."""
    ahead = better - worse
    if not ahead.any():
        return 1.0
    return float(wilcoxon(ahead, alternative="greater").pvalue)


def chance_of_mean(better: np.ndarray, worse: np.ndarray) -> float:
    """The same of so large a lead of the mean (paired t-test, one-sided)."""
    ahead = better - worse
    if ahead.size < 2 or not ahead.std() > 0.0:
        return 0.0 if ahead.mean() > 0.0 else 1.0
    return float(ttest_rel(better, worse, alternative="greater").pvalue)


def holds(mine: np.ndarray, other: np.ndarray, at: int) -> float:
    """Chance of a lead in prize, or in time, by both tests, if there were neither.

    Parameters
    ----------
    mine, other : (fields, 3) float64
        Of :class:`Run`.
    at : int
        Column of the time that counts.
    """
    both = max(chance(mine[:, 0], other[:, 0]), chance_of_mean(mine[:, 0], other[:, 0]))
    return min(1.0, 2.0 * min(both, chance(other[:, at], mine[:, at])))


def holm(chances: Sequence[float]) -> list[float]:
    """Chances corrected for their number by Holm's procedure."""
    order, found, most = np.argsort(chances), [1.0] * len(chances), 0.0
    for place, at in enumerate(order):
        most = max(most, min(1.0, (len(chances) - place) * chances[at]))
        found[at] = most
    return found


def print_claims(claims: dict[str, float]) -> None:
    """Print which points are held, by chances corrected for their number."""
    print("\n| where | policy | against | p | p by Holm | |")
    print("|---|---|---|---|---|---|")
    for (claim, p), corrected in zip(claims.items(), holm(list(claims.values())), strict=True):
        held = "held" if corrected < SIGNIFICANT else ""
        print(f"| {claim} | {p:.2g} | {corrected:.2g} | {held} |")
