"""What a policy collects on fields that no training saw, beside proven optima and bounds."""

from __future__ import annotations

import hashlib
import math
import os
import time
from collections.abc import Mapping, Sequence
from functools import cache, partial
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError
from ..common.json_text import loaded
from ..mission.mission import Mission
from ..run.front import solve
from ..sources.generator import generate
from .episodes import Board
from .episodes.worlds import TROUBLED
from .held import FAMILIES, HeldFields
from .policy import SHIPPED, Policy, load_policy, log_probabilities

CONFIDENT = 1.96
"""Half width of an interval of 95 %, in standard errors of a mean."""


class Rival(NamedTuple):
    """What a beam collects on the same fields.

    Attributes
    ----------
    visits : (fields,) float64
    seconds, table_seconds : float
        Processor time of a field, of the beam with its checked plan and of its timetable [s].
    """

    visits: npt.NDArray[np.float64]
    seconds: float
    table_seconds: float


class Measured(NamedTuple):
    """What a policy collects on the fields of a family.

    Attributes
    ----------
    seeds : (fields,) int64
    visits, optima : (fields,) float64
        Visits of the policy, and the least bound known; NaN where none is.
    seconds, table_seconds : float
        Processor time of a field: of decoding, a mean of all families, and of the timetable that
        they share [s].
    beams : dict of int to Rival
        By width.
    """

    seeds: npt.NDArray[np.int64]
    visits: npt.NDArray[np.float64]
    optima: npt.NDArray[np.float64]
    seconds: float
    table_seconds: float
    beams: Mapping[int, Rival]

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

    def lead(self, width: int) -> tuple[float, float]:
        """Mean visits more than a beam, paired by field, and half the width of its interval."""
        return _interval(self.visits - self.beams[width].visits)


def _interval(of: npt.NDArray[Any]) -> tuple[float, float]:
    if of.size < 2:
        return float(of.mean()) if of.size else math.nan, math.nan
    return float(of.mean()), float(CONFIDENT * of.std(ddof=1) / math.sqrt(of.size))


UNCERTAIN = "uncertain"
"""Nominal fields, each in a world of :data:`.episodes.worlds.TROUBLED`."""

Evaluation = Mapping[str, Measured]
"""What is measured, by family."""


@cache
def splits() -> dict[str, Any]:
    """Blocks of fields by name, with the bounds that are known of them."""
    path = Path(str(files(__package__))) / "weights" / "splits.json"
    found: dict[str, Any] = loaded(path.read_text(encoding="utf-8"))
    return found


def digest(first: int, count: int) -> str:
    """Digest of the nominal fields of some seeds, by which others see that theirs are the same."""
    found = hashlib.sha256()
    for seed in range(first, first + count):
        found.update(generate("nominal", seed).to_json().encode())
    return found.hexdigest()[:16]


def evaluate(
    policy: Policy | str | os.PathLike[str] = SHIPPED,
    *,
    split: str = "test",
    budget: int = 1,
    fields: int | None = None,
    seed: int = 0,
    beams: Sequence[int] = (),
) -> Evaluation:
    """Evaluate a policy on a block of fields.

    Parameters
    ----------
    policy : Policy, str or path
        See :func:`.policy.load_policy`.
    split : str
        "val", by which trainings are watched, or "test", at which none has looked.
    budget : int
        Plans of a field: the greedy one, and draws besides. In uncertain worlds there is one.
    fields : int, optional
        The first so many of the block; all if None.
    seed : int
        Of the draws.
    beams : sequence of int
        Widths of beams to compare with, in known worlds.

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
    greedy = partial(chosen, learned)
    best = held.visits(greedy)
    rng = np.random.default_rng(seed)
    for _ in range(budget - 1):
        drawn = held.visits(partial(chosen, learned, rng=rng))
        best = {family: np.maximum(best[family], drawn[family]) for family in FAMILIES}
    decoded = time.process_time()
    best[UNCERTAIN] = held.visits(greedy, families=("nominal",), model=TROUBLED)["nominal"]
    spent = (decoded - made) / (count * len(FAMILIES)), (made - began) / count
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
            {} if family == UNCERTAIN else _rivals(family, seeds.tolist(), beams),
        )
        for family in best
    }


def _rivals(family: str, seeds: list[int], widths: Sequence[int]) -> dict[int, Rival]:
    """What beams collect on the fields of a family."""
    visits = {width: np.zeros(len(seeds)) for width in widths}
    spent, table = dict.fromkeys(widths, 0.0), 0.0
    for at, seed in enumerate(seeds if widths else ()):
        began = time.process_time()
        mission = Mission(generate(family, seed), threads=1)
        _ = mission.timetable
        table += time.process_time() - began
        # What a mission makes once is no part of a beam.
        solve(mission, "beam", width=1, time_limit=math.inf)
        for width in widths:
            began = time.process_time()
            visits[width][at] = solve(mission, "beam", width=width, time_limit=math.inf).objective
            spent[width] += time.process_time() - began
    each = len(seeds)
    return {width: Rival(visits[width], spent[width] / each, table / each) for width in widths}


def chosen(
    policy: Policy, board: Board, rng: np.random.Generator | None = None
) -> npt.NDArray[np.int64]:
    """Moves of a policy: the best ones, or drawn by their probability with ``rng``."""
    scores = policy.scores(board.choices.moves, board.choices.mission)
    if rng is not None:
        scores = log_probabilities(scores) + rng.gumbel(size=scores.shape).astype(np.float32)
    found: npt.NDArray[np.int64] = scores.argmax(axis=1)
    return found
