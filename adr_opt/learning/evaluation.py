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
from ..plan.plan import Plan
from ..run.front import solve
from ..sources.generator import generate
from .episodes import Board
from .episodes.worlds import TROUBLED
from .held_out import FAMILIES, HeldFields, chaser_by_chaser
from .policy import SHIPPED, Policy, load_policy, log_probabilities

CONFIDENT = 1.96
"""Half width of an interval of 95 %, in standard errors of a mean."""


class Rival(NamedTuple):
    """What a beam collects on the same fields.

    Attributes
    ----------
    visits : (fields,) float64
    seconds, table_seconds : float
        Processor time per field: of the beam with the check of its plan, and of the timetable [s].
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
        Visits of the policy, and the least upper bound known; NaN where there is none.
    seconds, table_seconds : float
        Processor time per field: of decoding, a mean of the kinds of missions on it, and of the
        timetable that these share [s].
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
        """Share of the fields with a known bound on which no plan can collect more."""
        known = ~np.isnan(self.optima)
        return _interval(self.visits[known] >= self.optima[known] - 1e-9)[0]

    def lead(self, width: int) -> tuple[float, float]:
        """Mean lead over a beam in visits, paired by field, and half the width of its interval."""
        return _interval(self.visits - self.beams[width].visits)


def _interval(of: npt.NDArray[Any]) -> tuple[float, float]:
    if of.size < 2:
        return float(of.mean()) if of.size else math.nan, math.nan
    return float(of.mean()), float(CONFIDENT * of.std(ddof=1) / math.sqrt(of.size))


UNCERTAIN = "uncertain"
"""Nominal fields, each in a world of :data:`.episodes.worlds.TROUBLED`."""

APART = ("campaign", "cloud")
"""Families with fields of their own: campaigns are played chaser by chaser."""

KINDS = (*FAMILIES, UNCERTAIN, *APART)
"""Kinds of missions that are measured."""

Evaluation = Mapping[str, Measured]
"""What is measured, by kind of missions."""


@cache
def splits() -> dict[str, Any]:
    """The file of blocks of fields: each with its seeds and the bounds known of its fields."""
    path = Path(str(files(__package__))) / "weights" / "splits.json"
    found: dict[str, Any] = loaded(path.read_text(encoding="utf-8"))
    return found


def digest(first: int, count: int) -> str:
    """Digest of the nominal fields of consecutive seeds, to check that others draw the same."""
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
    kinds: Sequence[str] = KINDS,
    after: int = 0,
) -> Evaluation:
    """Evaluate a policy on a block of fields.

    Parameters
    ----------
    policy : Policy, str or path
        See :func:`.policy.load_policy`.
    split : str
        "val", on which trainings are watched, or "test", which none of them has seen.
    budget : int
        Plans made for each field, of which the best counts: the greedy one, and others drawn from
        the policy. In uncertain worlds only the greedy one.
    fields : int, optional
        How many fields of the block; all that there are if None.
    seed : int
        Seed of the draws.
    beams : sequence of int
        Widths of beams to compare with, in known worlds.
    kinds : sequence of str
        Which missions: the three benchmark families, "uncertain", "campaign" and "cloud".
    after : int
        How many fields of the block to pass over, such as those that others have looked at.

    Raises
    ------
    InputError
        There is no such block or kind, or a number is out of range.
    """
    learned = policy if isinstance(policy, Policy) else load_policy(policy)
    blocks = splits()["blocks"]
    if split not in blocks:
        raise InputError(f"split {split!r} is unknown; use one of: {', '.join(blocks)}")
    block = blocks[split]
    count = block["fields"] - after if fields is None else fields
    for name, value, least, most in (
        ("budget", budget, 1, 10**6),
        ("after", after, 0, block["fields"] - 1),
        ("fields", count, 1, block["fields"] - after),
    ):
        if not least <= value <= most:
            raise InputError(f"{name} = {value}: must be between {least} and {most}")
    known = {"nominal": (*FAMILIES, UNCERTAIN)} | {kind: (kind,) for kind in APART}
    for kind in kinds:
        if kind not in KINDS:
            raise InputError(f"kind {kind!r} is unknown; use some of: {', '.join(KINDS)}")
    found: dict[str, Measured] = {}
    for family, group in known.items():
        if wanted := [kind for kind in group if kind in kinds]:
            first = block["apart" if family in APART else "first"] + after
            began = time.process_time()
            held_out = HeldFields(first, count, family)
            table_s = (time.process_time() - began) / count
            visits, spent_s = _collected(learned, held_out, group, budget, seed)
            seeds = list(range(first, first + count))
            for kind in wanted:
                bounds = block["bounds"].get(kind, {})
                found[kind] = Measured(
                    np.array(seeds),
                    visits[kind].astype(float),
                    np.array([bounds.get(str(each), (0.0, math.nan))[1] for each in seeds]),
                    spent_s / count,
                    table_s,
                    {} if kind == UNCERTAIN else _rivals(kind, seeds, beams),
                )
    return {kind: found[kind] for kind in kinds}


def _collected(
    policy: Policy, held_out: HeldFields, kinds: tuple[str, ...], budget: int, seed: int
) -> tuple[dict[str, npt.NDArray[np.int64]], float]:
    """Most visits of some plans on each field, and the time for a kind in known worlds [s]."""
    greedy, rng = partial(chosen, policy), np.random.default_rng(seed)
    certain = tuple(kind for kind in kinds if kind != UNCERTAIN)
    began = time.process_time()
    best = held_out.visits(greedy, families=certain)
    for _ in range(budget - 1):
        drawn = held_out.visits(partial(chosen, policy, rng=rng), families=certain)
        best = {kind: np.maximum(best[kind], drawn[kind]) for kind in certain}
    spent_s = (time.process_time() - began) / len(certain)
    if UNCERTAIN in kinds:
        best[UNCERTAIN] = held_out.visits(greedy, families=("nominal",), model=TROUBLED)["nominal"]
    return best, spent_s


def _rivals(family: str, seeds: list[int], widths: Sequence[int]) -> dict[int, Rival]:
    """What beams collect on the fields of a family, chaser by chaser."""
    visits = {width: np.zeros(len(seeds)) for width in widths}
    spent, table = dict.fromkeys(widths, 0.0), dict.fromkeys(widths, 0.0)
    for at, seed in enumerate(seeds):
        for width in widths:
            plans = list[Plan]()
            began = time.process_time()
            for mission in chaser_by_chaser(generate(family, seed), plans):
                _ = mission.timetable
                table[width] += time.process_time() - began
                # What a mission makes once is no part of a beam.
                solve(mission, "beam", width=1, time_limit=math.inf)
                began = time.process_time()
                found = solve(mission, "beam", width=width, time_limit=math.inf)
                spent[width] += time.process_time() - began
                visits[width][at] += found.objective
                plans += [] if found.plan is None else [found.plan]
                began = time.process_time()
    each = len(seeds)
    return {
        width: Rival(visits[width], spent[width] / each, table[width] / each) for width in widths
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
