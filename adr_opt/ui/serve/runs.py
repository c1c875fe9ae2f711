"""Results of planning runs, from the first plan that is found to the last."""

from __future__ import annotations

from pathlib import Path

from ...common.wording import counted, status_words
from ...plan.plan import Plan
from ...problem.instance import Instance
from .looks import PlannedRun
from .project.plan_files import EARLY, INSTANCE, PLAN
from .project.result_record import ResultRecord
from .project.results import Results


class PlannedRuns:
    """Keeps the plans of runs, each run in the folder of one result.

    While a run goes on the folder has its best plan so far, which counts as a result once the run
    has ended, or when the project is opened after a kill. Runs follow one after another.

    Parameters
    ----------
    results : Results
    """

    def __init__(self, results: Results) -> None:
        self._results = results
        self._open: tuple[Instance, int, Path] | None = None
        self._best: Plan | None = None

    def found(self, instance: Instance, plan: Plan | None) -> ResultRecord | None:
        """Keep the best plan so far; returns the result if the run has ended with the last one.

        Parameters
        ----------
        instance : Instance
        plan : Plan or None
            None where the run has ended without a result of its own.
        """
        if plan is None:
            return self._end(instance)
        if self._open is None or self._open[0] is not instance:
            number, place = self._results.begin("solve")
            self._open = instance, number, place
            instance.save(place / INSTANCE)
        plan.save(self._open[2] / PLAN)
        self._best = plan
        return None

    def done(self, instance: Instance, plan: Plan | None) -> ResultRecord | None:
        """Keep the plan that a run has ended with; returns its result, None if there is none."""
        if plan is None:
            return self._end(instance)
        begun = self._begun(instance)
        self._open = self._best = None
        return self._results.keep_plan("solve", plan.method, instance, plan, begun)

    def _end(self, instance: Instance) -> ResultRecord | None:
        begun, plan = self._begun(instance), self._best
        self._open = self._best = None
        if begun is None:
            return None
        if plan is None:  # none of them could be stored
            self._results.drop(begun[1])
            return None
        return self._results.keep_plan("solve", plan.method, instance, plan, begun, said=EARLY)

    def _begun(self, instance: Instance) -> tuple[int, Path] | None:
        if self._open is None or self._open[0] is not instance:
            return None
        return self._open[1:]


def told(instance: Instance, result: PlannedRun) -> str:
    """A message about the result of a run."""
    plan = result.plan
    notes = "".join(f"; {note}" for note in result.notes)
    if plan is None:
        why = "infeasible: no plan services all required targets"
        return f"no plan: {why if result.status == 'infeasible' else result.status}{notes}"
    visits = len(set(plan.destinations) - set(instance.station_names))
    return f"{counted(visits, 'target')} visited, {status_words(plan.status)}{notes}"
