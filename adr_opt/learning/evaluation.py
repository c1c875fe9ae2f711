"""What a policy collects on fields that no training saw, beside proven optima and bounds."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError
from ..common.json_text import loaded
from .episodes import Board
from .held import FAMILIES, HeldFields
from .policy import SHIPPED, Policy, load_policy, log_probabilities

CONFIDENT = 1.96
"""Half width of an interval of 95 %, in standard errors of a mean."""


class Measured(NamedTuple):
    """What a policy collects on the fields of a family.

    Attributes
    ----------
    seeds : (fields,) int64
    visits, optima : (fields,) float64
        Visits of the policy, and the least bound known; NaN where none is.
    seconds, table_seconds : float
        Processor time of a field, for all families: of decoding, and of its timetable [s].
    """

    seeds: npt.NDArray[np.int64]
    visits: npt.NDArray[np.float64]
    optima: npt.NDArray[np.float64]
    seconds: float
    table_seconds: float

    @property
    def mean(self) -> tuple[float, float]:
        """Mean number of visits, and half the width of its interval of 95 %."""
        return _interval(self.visits)

    @property
    def gap(self) -> tuple[float, float]:
        """Mean gap, (bound − visits) / bound, and half the width of its interval of 95 %."""
        known = ~np.isnan(self.optima)
        return _interval(1.0 - self.visits[known] / self.optima[known])

    @property
    def optimal(self) -> float:
        """Share of the fields with a bound on which nothing collects more."""
        known = ~np.isnan(self.optima)
        return _interval(self.visits[known] >= self.optima[known] - 1e-9)[0]


def _interval(of: npt.NDArray[Any]) -> tuple[float, float]:
    if of.size < 2:
        return float(of.mean()) if of.size else math.nan, math.nan
    return float(of.mean()), float(CONFIDENT * of.std(ddof=1) / math.sqrt(of.size))


Evaluation = Mapping[str, Measured]
"""What is measured, by family."""


@cache
def splits() -> dict[str, Any]:
    """Blocks of fields by name, with the bounds that are known of them."""
    path = Path(str(files(__package__))) / "weights" / "splits.json"
    found: dict[str, Any] = loaded(path.read_text(encoding="utf-8"))
    return found


def evaluate(
    policy: Policy | str | os.PathLike[str] = SHIPPED,
    *,
    split: str = "test",
    budget: int = 1,
    fields: int | None = None,
    seed: int = 0,
) -> Evaluation:
    """Evaluate a policy on a block of fields.

    Parameters
    ----------
    policy : Policy, str or path
        See :func:`.policy.load_policy`.
    split : str
        "val", by which trainings are watched, or "test", at which none has looked.
    budget : int
        Plans of a field: the greedy one, and draws besides.
    fields : int, optional
        The first so many of the block; all if None.
    seed : int
        Of the draws.

    Raises
    ------
    InputError
        There is no such block, or a number is out of range.
    """
    learned = policy if isinstance(policy, Policy) else load_policy(policy)
    blocks = splits()["blocks"]
    if split not in blocks:
        raise InputError(f"split {split!r} is unknown; use one of: {', '.join(blocks)}")
    block = blocks[split]
    count = block["fields"] if fields is None else fields
    for name, value, most in (("budget", budget, 10**6), ("fields", count, block["fields"])):
        if not 1 <= value <= most:
            raise InputError(f"{name} = {value}: must be between 1 and {most}")
    began = time.process_time()
    held = HeldFields(block["first"], count)
    made = time.process_time()
    best = held.visits(partial(chosen, learned))
    rng = np.random.default_rng(seed)
    for _ in range(budget - 1):
        drawn = held.visits(partial(chosen, learned, rng=rng))
        best = {family: np.maximum(best[family], drawn[family]) for family in FAMILIES}
    spent = (time.process_time() - made) / count, (made - began) / count
    seeds = block["first"] + np.arange(count)
    return {
        family: Measured(
            seeds,
            best[family].astype(float),
            np.array(
                [
                    block["bounds"].get(family, {}).get(str(number), (0.0, math.nan))[1]
                    for number in seeds.tolist()
                ]
            ),
            *spent,
        )
        for family in FAMILIES
    }


def chosen(
    policy: Policy, board: Board, rng: np.random.Generator | None = None
) -> npt.NDArray[np.int64]:
    """Moves of a policy: the best ones, or drawn by their probability with ``rng``."""
    scores = policy.scores(board.choices.moves, board.choices.mission)
    if rng is not None:
        scores = log_probabilities(scores) + rng.gumbel(size=scores.shape).astype(np.float32)
    found: npt.NDArray[np.int64] = scores.argmax(axis=1)
    return found
