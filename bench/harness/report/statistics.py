"""Means, intervals and paired tests; the field is the unit that is independent.

The iterations of one field share its targets, so they are averaged first: a hundred fields with ten
iterations are a hundred numbers, not a thousand.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

LEVEL = 0.95

Mission = tuple[int, int, int]
"""Field, iteration and seed of the planner."""


def field_means(values: Mapping[Mission, float]) -> dict[int, float]:
    """Mean over the iterations of each field."""
    sums: dict[int, list[float]] = {}
    for (field, _, _), value in values.items():
        sums.setdefault(field, []).append(value)
    return {field: math.fsum(found) / len(found) for field, found in sorted(sums.items())}


def interval(values: Sequence[float]) -> tuple[float, float]:
    """Mean and half width of its 95 % interval by Student's t; NaN below two values."""
    if not values:
        return math.nan, math.nan
    mean = math.fsum(values) / len(values)
    if len(values) < 2:
        return mean, math.nan
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return mean, float(stats.t.ppf(0.5 + 0.5 * LEVEL, len(values) - 1)) * error


@dataclass(frozen=True)
class Paired:
    """Two methods on the missions that both have.

    Attributes
    ----------
    first, second : hashable
    fields : int
    difference, half_width : float
        Mean over fields of first − second, and its 95 % interval.
    better, equal, worse : int
        Fields on which the first is so.
    p : float
        Wilcoxon's signed-rank test of the differences by field, adjusted by Holm over all pairs
        that were compared together.
    """

    first: Hashable
    second: Hashable
    fields: int
    difference: float
    half_width: float
    better: int
    equal: int
    worse: int
    p: float


def pairs(values: Mapping[Hashable, Mapping[Mission, float]]) -> list[Paired]:
    """Every pair of methods, in the order given, with p-values adjusted together."""
    names = list(values)
    found = []
    for number, first in enumerate(names):
        for second in names[number + 1 :]:
            both = values[first].keys() & values[second].keys()
            means = field_means({key: values[first][key] - values[second][key] for key in both})
            # Means of whole numbers differ by rounding where they are equal.
            differences = [round(value, 9) for value in means.values()]
            if differences:
                mean, half = interval(differences)
                found.append(
                    Paired(
                        first,
                        second,
                        len(differences),
                        mean,
                        half,
                        sum(value > 0.0 for value in differences),
                        sum(value == 0.0 for value in differences),
                        sum(value < 0.0 for value in differences),
                        signed_rank(differences),
                    )
                )
    adjusted = holm([pair.p for pair in found])
    return [Paired(**{**vars(pair), "p": p}) for pair, p in zip(found, adjusted, strict=True)]


def signed_rank(differences: Sequence[float]) -> float:
    """Two-sided p of Wilcoxon's signed-rank test; 1 where no difference is left to rank."""
    if not any(differences):
        return 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # small samples: p says it by being large
        return float(stats.wilcoxon(differences).pvalue)


def holm(p_values: Sequence[float]) -> list[float]:
    """P-values adjusted by Holm's step-down method, in the order given."""
    adjusted = [1.0] * len(p_values)
    largest = 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = largest
    return adjusted
