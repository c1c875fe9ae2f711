"""Planning with a confidence, for ``solve``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...common.errors import InputError
from . import take
from .live import wanted
from .work import say_notes, work

if TYPE_CHECKING:
    from ...mission.result import Result
    from ...problem.instance import Instance
    from ...run.run_options import RunOptions


@dataclass(frozen=True)
class Confident:
    """What is asked for with ``--confidence``.

    Attributes
    ----------
    confidence : float or None
        None if it is not given.
    uncertainty_path : str or None
    """

    confidence: float | None
    uncertainty_path: str | None

    def check(self, others: dict[str, bool]) -> None:
        """Refuse options that do not go together.

        Parameters
        ----------
        others : mapping of str to bool
            Options that do not go with it, and whether each is given.

        Raises
        ------
        InputError
            One of the two is missing, or another option is given.
        """
        if (self.confidence is None) != (self.uncertainty_path is None):
            given, missing = "--confidence", "--uncertainty"
            if self.confidence is None:
                given, missing = missing, given
            raise InputError(f"{given} needs {missing}; give both")
        for option, is_given in others.items():
            if self.confidence is not None and is_given:
                raise InputError(f"{option} does not go with --confidence; leave one of them out")


confident_options = take.together(
    take.number(
        "--confidence", "C", "Chance with which the plan is to be kept; with --uncertainty."
    ),
    take.file("--uncertainty", "Uncertainty file.", name="uncertainty_path"),
)
"""The options of planning with a confidence."""


def run_confident(
    instance: Instance,
    method: str,
    asked: Confident,
    given: RunOptions,
    *,
    as_json: bool,
    quiet: bool,
) -> Result:
    """Plan with a confidence, and print the notes."""
    from ...analysis.robust.robust import robust
    from ...problem.uncertainty import Uncertainty

    assert asked.confidence is not None
    assert asked.uncertainty_path is not None
    confidence, uncertainty = asked.confidence, Uncertainty.load(asked.uncertainty_path)
    result = work(
        lambda stop, progress: robust(
            instance,
            uncertainty,
            confidence,
            method,
            time_limit=given.time_limit,
            seed=given.seed,
            bound=given.bound,
            jobs=given.jobs,
            stop=stop,
            progress=progress,
            **given.options,
        ),
        live=wanted(as_json, quiet),
        quiet=quiet,
    ).result
    say_notes(result, quiet)
    return result
