"""Results of planning runs, from the first plan that is found to the last."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from ...common.errors import InputError
from ...common.wording import counted, status_words
from ...plan.plan import Plan
from ...problem.instance import Instance
from .planning import PlannedRun
from .project.plan_files import EARLY, INSTANCE, PLAN
from .project.record import ResultRecord
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
        self._over = False

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
        self._settle()
        if self._open is None or self._open[0] is not instance:
            number, place = self._results.begin("solve")
            try:
                instance.save(place / INSTANCE)
            except BaseException:
                self._results.drop(place)
                raise
            self._open, self._best = (instance, number, place), None
        plan.save(self._open[2] / PLAN)
        self._best = plan
        return None

    def done(self, instance: Instance, plan: Plan | None) -> ResultRecord | None:
        """Keep the plan that a run has ended with; returns its result, None if there is none."""
        if plan is None:
            return self._end(instance)
        self._settle()
        return self._keep(instance, plan, self._begun(instance))

    def _end(self, instance: Instance) -> ResultRecord | None:
        """Keep the best plan of a run that is over; another one that goes on is left alone."""
        begun, plan = self._begun(instance), self._best
        if begun is None:
            return None
        if plan is None:  # none of them could be stored
            self._open = None
            self._results.drop(begun[1])
            return None
        return self._keep(instance, plan, begun, said=EARLY)

    def _keep(
        self, instance: Instance, plan: Plan, begun: tuple[int, Path] | None, **more: str
    ) -> ResultRecord:
        """Keep a plan; if that fails, its run is still open with it."""
        if begun is not None:
            self._best, self._over = plan, True
        record = self._results.keep_plan("solve", plan.method, instance, plan, begun, **more)
        if begun is not None:
            self._open, self._best, self._over = None, None, False
        return record

    def _settle(self) -> None:
        """Keep at last the plan of a run that is over, so that the next one has its own folder.

        If that fails again, it is in the folder, and a result once the project is reopened.
        """
        if self._over and self._open is not None:
            with suppress(InputError, OSError):
                self._end(self._open[0])
            self._open, self._best, self._over = None, None, False

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
