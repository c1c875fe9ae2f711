"""A plan that holds with a required confidence, and how it was found."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from ...mission.result import Result
from ...plan.plan import Plan, Status
from .careful_problem import Levels
from .promise import Promise


class Caution(NamedTuple):
    """A plan tried in the search, with its level of caution.

    Attributes
    ----------
    levels : Levels
        That were asked for.
    worth : float
        What it collects on average; −inf without one.
    kept : float
        Share of rehearsals in which it was kept; 0 where its promise has too small a chance.
    """

    levels: Levels
    worth: float
    kept: float


@dataclass(frozen=True)
class RobustPlan:
    """A plan that holds with a required confidence.

    Attributes
    ----------
    plan : Plan or None
        The best one found, of the instance as it is; None if none keeps its promise.
    promise : Promise or None
        Its promise.
    confidence : float
        The required one.
    worth : float
        What the plan collects on average; −inf without one.
    upper_bound : float
        Proven: no plan that keeps its promise with the confidence collects more on average.
    infeasible : bool
        Whether it is proven that no such plan services all required targets.
    kept : float
        Share of rehearsals in which it was kept when it was followed, in worlds of their own.
    worlds : int
        Number of these rehearsals.
    rounds : tuple of Caution
    method : str
    seed : int
    runtime_s : float
    """

    plan: Plan | None
    promise: Promise | None
    confidence: float
    worth: float
    upper_bound: float
    infeasible: bool
    kept: float
    worlds: int
    rounds: tuple[Caution, ...]
    method: str
    seed: int
    runtime_s: float

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the confidence for readers of the plan."""
        notes = []
        if self.promise is not None:
            chances = f"all tanks hold with a chance of {self.promise.tanks_chance:.4g}"
            if self.promise.stays or self.promise.launches:
                chances += f", every stay and launch with {self.promise.least_chance:.4g} or more"
            notes.append(
                f"made to be kept with a confidence of {self.confidence:g}: {chances}; followed, "
                f"{100.0 * self.kept:.1f} % of {self.worlds} rehearsals were as planned"
            )
        if math.isfinite(self.upper_bound):
            notes.append(
                f"no plan that is kept with this confidence collects more than "
                f"{self.upper_bound:.6g} on average"
            )
        return tuple(notes)

    @property
    def result(self) -> Result:
        """The plan as a planner's result; its bound covers only plans that hold as well."""
        plan, notes = self.plan, self.notes
        made = Result(self.method, seed=self.seed, runtime_s=self.runtime_s)
        status: Status = "infeasible" if self.infeasible else "unknown"
        if plan is None:
            return replace(made, status=status, notes=notes)
        plan = plan.replace(
            notes=(*plan.notes, *notes),
            method=self.method,
            seed=self.seed,
            runtime_s=self.runtime_s,
        )
        return replace(
            made, plan=plan, objective=plan.objective, status=plan.status, notes=plan.notes
        )
