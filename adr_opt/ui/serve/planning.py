"""Orders to plan, and the progress of a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Protocol

from pydantic import Field

from ...common.constants import DAY_S
from ...common.records import Record
from ...plan.plan import Plan, relative_gap
from ...problem.instance import Instance
from ..plot.course import RUN, course_chart
from ..report.charts import drawn
from ..report.text import NOTHING, number

IN_DESK = 380, 190
"""Size of the chart of a run beside the form that starts it [px]."""

Phase = Literal["idle", "waiting", "compiling", "timetable", "planning", "done", "failed"]

LONGEST_S = 7.0 * DAY_S
"""Largest time limit; beyond it, a typing error is assumed."""


class PlanningOrder(Record):
    """Parameters of a planning run.

    Attributes
    ----------
    method : str
    time_limit_s : float
        Wall time [s].
    bound : str or None
        Bound to run beside the planner.
    seed : int
    goes_on : bool
        Whether to begin from the plan that is there, where the method can.
    """

    method: str
    time_limit_s: float
    bound: str | None = None
    seed: Annotated[int, Field(ge=0)] = 0
    goes_on: bool = True


@dataclass(frozen=True)
class PlanningProgress:
    """Progress of a run.

    Attributes
    ----------
    number : int
        Of the run, from 1; 0 before the first.
    phase : Phase
        "waiting" for the run before it to stop.
    stopping : bool
        Whether it was told to stop.
    limit_s : float
        Its time limit [s].
    elapsed_s : float
        Since its clock began, after compiling [s].
    built : float
        Share of the timetable that is built.
    incumbent, bound : float
        −inf and +inf for none yet.
    points : tuple of (float, float, float)
        When each of the two changed [s], and to what.
    said : str
        What became of it, or why it failed.
    """

    number: int = 0
    phase: Phase = "idle"
    stopping: bool = False
    limit_s: float = 0.0
    elapsed_s: float = 0.0
    built: float = 1.0
    incumbent: float = -math.inf
    bound: float = math.inf
    points: tuple[tuple[float, float, float], ...] = ()
    said: str = ""

    @property
    def runs(self) -> bool:
        """Whether it is still running."""
        return self.phase not in ("idle", "done", "failed")

    def to_dict(self) -> dict[str, Any]:
        """The progress as JSON data, with null for numbers that are not finite."""
        known = math.isfinite(self.incumbent) and math.isfinite(self.bound)
        gap = relative_gap(self.incumbent, self.bound) if known else None
        points = [(round(at, 3), finite(a), finite(b)) for at, a, b in self.points]
        chart = course_chart(points, self.elapsed_s)
        return {
            "number": self.number,
            "phase": self.phase,
            "runs": self.runs,
            "stopping": self.stopping,
            "limit_s": self.limit_s,
            "elapsed_s": round(self.elapsed_s, 3),
            "built": round(self.built, 4),
            "incumbent": finite(self.incumbent),
            "bound": finite(self.bound),
            "gap": gap,
            "gap_words": in_percent(gap),
            "points": points,
            "chart": drawn(chart, RUN, IN_DESK, from_zero=False) if points else "",
            "said": self.said,
        }


def in_percent(gap: float | None) -> str:
    """A gap as in the report; empty if there is none."""
    return NOTHING if gap is None else f"{number(100.0 * gap)} %"


def finite(value: float) -> float | None:
    """A number for JSON; None if it is not finite."""
    return float(value) if math.isfinite(value) else None


class PlannedRun(NamedTuple):
    """The part of a run's result that is kept: its plan, proofs and notes."""

    plan: Plan | None
    status: str
    notes: tuple[str, ...]


Done = Callable[[Instance, PlannedRun], str]
"""Handles a result; returns a message about it."""

Found = Callable[[Instance, Plan | None], None]
"""Handles the best plan so far of a run; None means that the run has ended."""


def ignored(instance: Instance, plan: Plan | None) -> None:
    """Ignore the plans of running planners."""


class PlanningWork(Protocol):
    """Interface of planners of one instance after another, in a thread or a child process."""

    def progress(self) -> PlanningProgress:
        """Progress of the last run."""
        ...

    def begin(self, instance: Instance, order: PlanningOrder, known: Plan | None) -> int:
        """Plan, stopping any run in progress; returns the number of the run."""
        ...

    def stop(self) -> None:
        """Ask the run for its best plan."""
        ...

    def wait(self, seconds: float) -> bool:
        """Wait until nothing runs; returns whether that is the case."""
        ...

    def prepare(self, *, drifts: bool) -> None:
        """Load what the default method needs, for missions whose planes drift or do not."""
        ...

    def close(self) -> None:
        """Release the planner; nothing runs."""
        ...
