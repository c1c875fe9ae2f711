"""Means, intervals and paired tests; the field is the unit that is independent.

The iterations of one field share its targets, so they are averaged first: a hundred fields with ten
iterations are a hundred numbers, not a thousand. A p-value is given only where it could have told
something: if two methods are equally good, all signs of the differences of n fields are equally
likely, so that no two-sided test comes below 2^−(n−1), nor, adjusted over m pairs, below m times
that.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace

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
        that were compared together; None where so few fields cannot tell anything.
    """

    first: Hashable
    second: Hashable
    fields: int
    difference: float
    half_width: float
    better: int
    equal: int
    worse: int
    p: float | None


def least_p(fields: int, together: int = 1) -> float:
    """Least p of a paired test on this number of fields, adjusted for several tests."""
    return min(1.0, together * 2.0 ** (1 - fields)) if fields else 1.0


def fields_needed(together: int = 1) -> int:
    """The fewest fields of which a paired test can give a p of 5 %."""
    return 1 + math.ceil(math.log2(together / (1.0 - LEVEL)))


def pairs(values: Mapping[Hashable, Mapping[Mission, float]]) -> list[Paired]:
    """Every pair of methods, in the order given, with p-values adjusted together.

    None where the fields are too few for any to be at most 5 %.
    """
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
    enough = fields_needed(len(found)) if found else 0
    told = iter(holm([pair.p for pair in found if pair.p is not None and pair.fields >= enough]))
    return [replace(pair, p=next(told) if pair.fields >= enough else None) for pair in found]


def signed_rank(differences: Sequence[float]) -> float:
    """Two-sided p of Wilcoxon's signed-rank test, exactly; 1 where no difference is left to rank.

    Fields without a difference are left out, equal differences share their ranks, and all signs are
    counted: what is usual for large samples would come below what so few fields can give.
    """
    left = np.array([value for value in differences if value])
    if not left.size:
        return 1.0
    doubled = np.rint(2.0 * stats.rankdata(np.abs(left))).astype(np.int64)  # whole, ties or not
    total = int(doubled.sum())
    ways = np.zeros(total + 1)
    ways[0] = 1.0
    for rank in doubled:
        ways[rank:] += ways[:-rank].copy()
        ways *= 0.5
    positive = int(doubled[left > 0.0].sum())
    tail = min(positive, total - positive)
    return min(1.0, 2.0 * float(ways[: tail + 1].sum()))


def holm(p_values: Sequence[float]) -> list[float]:
    """P-values adjusted by Holm's step-down method, in the order given."""
    adjusted = [1.0] * len(p_values)
    largest = 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = largest
    return adjusted
