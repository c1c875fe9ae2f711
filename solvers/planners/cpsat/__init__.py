"""Method `cpsat`: the time-expanded network as a model for OR-Tools CP-SAT."""

from __future__ import annotations

from collections.abc import Iterable

from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ...models.course import ModelOptions, prove
from .model import CpSatModel

__all__ = ["cpsat"]


class CpsatOptions(ModelOptions, method="cpsat"):
    """Options of the method ``cpsat``."""


def cpsat(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    options: CpsatOptions = CpsatOptions(),
) -> Result:
    """The best plan and an upper bound, by constraint programming over all connections.

    See :func:`solvers.models.course.prove` for the course and :mod:`solvers.planners.mip` for the
    same network as a mixed-integer program. A small mission (some four targets for a day) is
    solved whole; a large one as far as reduced costs leave a network of ``most_arcs``, otherwise
    the bound is that of the multipliers. CP-SAT works with one thread: with several, one seed
    would not give one plan. An iteration is an evaluation of the multipliers' bound or one call
    of CP-SAT.

    Parameters
    ----------
    mission, seed, stop, progress
    start : sequence of int, optional
        A plan: bodies in order. As much of it as is in the network is given as hints.
    """
    return prove(
        "cpsat",
        CpSatModel,
        mission,
        seed=seed,
        stop=stop,
        progress=progress,
        start=start,
        options=options,
    )
