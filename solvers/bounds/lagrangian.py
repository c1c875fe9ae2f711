"""An upper bound by Lagrangian relaxation, tightened by ng-routes (docs/model.md section 8)."""

from __future__ import annotations

from collections.abc import Iterable

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ..proof.proof import ProofOptions, bounded


class LagrangianOptions(ProofOptions, method="lagrangian"):
    """Options of the bound ``lagrangian``."""


def lagrangian(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    options: LagrangianOptions = LagrangianOptions(),
) -> Result:
    """Upper bound on the prize of any plan, by Lagrangian relaxation.

    Rounds of :class:`solvers.proof.proof.Proof`: multipliers, then searches for plans worth a
    little less than the bound. If the answer is a plan that meets the bound, it is optimal and is
    returned. Every value on the way is a valid bound and the least is kept; the trivial one is the
    sum of all prizes. Where all prizes are multiples of a step the bound is rounded down to one,
    because the objective is. Where the network of all connections takes too much memory there is a
    bound all the same (:class:`solvers.proof.large_proof.LargeProof`): by least times, then by
    walks that pay for their ΔV over legs in whole numbers, and no search.

    Deterministic but for the time limit. An iteration is one evaluation of the bound, one search,
    or :data:`solvers.labels.label_search.EFFORT` labels of a search. Ends by itself when the bound
    is met, or when it can do no more.

    Parameters
    ----------
    mission : Mission
    seed : int
        Not used.
    stop, progress
    start : sequence of int, optional
        A plan: bodies in order. The bound may prove it optimal.
    """
    return bounded("lagrangian", mission, stop, progress, seed=seed, start=start, options=options)
