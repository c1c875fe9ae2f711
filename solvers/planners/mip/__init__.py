"""Method `mip`: the time-expanded network as a mixed-integer program for HiGHS."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from importlib.util import find_spec

from ortools.sat.python import cp_model  # noqa: F401 — loaded before highspy, see below

from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.progress import Progress
from adr_opt.common.stop import Stop
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result

from ...models.course import MakeModel, ModelOptions, prove

__all__ = ["mip"]

PACKAGES = ("pyomo",)


def _model() -> MakeModel:
    """The model class; its module needs the extra, so it is loaded on use."""
    for package in PACKAGES:
        if find_spec(package) is None:
            raise MissingExtra("method 'mip'", package, "mip")
    # OR-Tools and some versions of highspy bring shared libraries of one name; the second one to
    # be loaded fails (google/or-tools#5246). OR-Tools is needed by others, so it comes first.
    try:
        from .model import MipModel
    except ImportError as error:
        raise InputError(
            f"method 'mip' cannot load highspy {version('highspy')} beside OR-Tools ({error}): "
            "install a version of highspy without a shared library, such as 1.14"
        ) from error
    return MipModel


class MipOptions(ModelOptions, method="mip"):
    """Options of the method ``mip``."""


def mip(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    options: MipOptions = MipOptions(),
) -> Result:
    """The best plan and an upper bound, by mixed-integer programming over all connections.

    See :func:`solvers.models.course.prove` for the course. A small mission (some four targets for
    a day) is solved whole; a large one as far as reduced costs leave a network of ``most_arcs``,
    otherwise the bound is that of the multipliers. HiGHS can be interrupted while it branches, not
    while it solves its first linear program. An iteration is an evaluation of the multipliers'
    bound or one call of HiGHS.

    Parameters
    ----------
    mission, seed, stop, progress
    start : sequence of int, optional
        A plan: bodies in order. HiGHS begins from as much of it as is in the network.

    Raises
    ------
    MissingExtra
        Pyomo is not installed.
    InputError
        Highspy cannot be loaded.
    """
    return prove(
        "mip",
        _model(),
        mission,
        seed=seed,
        stop=stop,
        progress=progress,
        start=start,
        options=options,
    )
