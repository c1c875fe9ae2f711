"""Storage of an editing session in its project folder: the project, and plans of runs."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from ...common.errors import InputError
from ...common.wording import counted, proof_words
from ...plan.plan import Plan
from ...problem.instance import Instance
from .drafts import Draft
from .folder import Folder
from .history import History, Step
from .planning import PlannedRun
from .project.drafts_kept import DraftsKept
from .project.plan_files import EARLY, INSTANCE, PLAN
from .project.record import DroppedFile, ProjectRecord, ResultRecord, StepRecord
from .project.results import Results
from .shown_plan import ShownPlan

MOST_BYTES = 2**28
"""Maximum size of all instances of a history; beyond it the earliest are forgotten [bytes]."""


def restored(record: ProjectRecord, kept: DraftsKept) -> History:
    """The history of a project; drafts are read on demand."""

    def loading(key: str, excluded: frozenset[str]) -> Callable[[], Draft]:
        return lambda: Draft(kept.load(key), excluded)

    steps = [
        Step(
            None,
            step.words,
            base=step.base,
            record=step,
            load=None if step.draft is None else loading(step.draft, frozenset(step.excluded)),
        )
        for step in record.steps
    ]
    return History.of(steps, record.at)


def to_record(history: History, kept: DraftsKept) -> tuple[StepRecord, ...]:
    """The steps for the file of the project; their instances must be stored already.

    Parameters
    ----------
    history : History
        Forgets its earliest steps where all are too large.
    kept : DraftsKept
    """
    before: str | None = None
    changed = False
    for step in history.steps:
        record = step.record
        if record is None:
            draft = step.draft
            key = None if draft is None else kept.keep(draft.field, before)
            excluded = () if draft is None else tuple(sorted(draft.excluded))
            record = StepRecord(draft=key, excluded=excluded, words=step.words, base=step.base)
            changed = True
        elif record.base != step.base:
            record = record.replace(base=step.base)
        step.record, before = record, record.draft
    if changed:
        _shorten(history, kept)
    return tuple(step.record for step in history.steps if step.record is not None)


def forget_unused(history: History, kept: DraftsKept) -> None:
    """Remove the instances of no step; none may be in use."""
    kept.forget({str(step.record.draft) for step in history.steps if step.record is not None})


def _shorten(history: History, kept: DraftsKept) -> None:
    """Forget the earliest steps if all instances together are too large."""

    def sizes() -> dict[str, int]:
        keys = {step.record.draft for step in history.steps if step.record is not None}
        return {key: kept.size(key) for key in keys if key is not None}

    while history.at > 1 and sum(sizes().values()) > MOST_BYTES:
        history.drop_first()


class ProjectKeeper:
    """Stores the file of the project, and the draft and the plan at hand.

    Parameters
    ----------
    folder : Folder
    """

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        self._at_hand: int | None = None

    def keep(
        self, history: History, shown: ShownPlan, files: tuple[DroppedFile, ...], worth: int | None
    ) -> None:
        """Store a state.

        Parameters
        ----------
        history : History
        shown : ShownPlan
        files : tuple of DroppedFile
        worth : int or None
            Result that rates the objects of the catalogue.

        Raises
        ------
        InputError, OSError
            It cannot be stored.
        """
        folder = self._folder
        draft = history.draft if history.has_mission else None
        steps = to_record(history, folder.drafts)
        folder.keep(
            ProjectRecord(steps=steps, at=history.at, shown=shown.result, files=files, worth=worth)
        )
        known = shown.known()
        if known is not None and known[0] != self._at_hand:
            folder.keep_plan(*known[1:])
            self._at_hand = known[0]
        if draft is None:
            folder.keep_draft(None, planned=False)
        else:
            planned = known is not None and known[2].instance.sha256 == draft.sha256
            folder.keep_draft(draft.instance, planned=planned)


class PlannedRuns:
    """Keeps the plans of runs, each run in the folder of one result.

    While a run goes on the folder has its best plan so far, which counts as a result once the run
    has ended, or when the project is opened after a kill. Runs follow one after another.

    Parameters
    ----------
    results : Results
    words : callable
        Names a variant of the mission by what it differs in; empty for the mission itself.
    """

    def __init__(self, results: Results, words: Callable[[Instance], str]) -> None:
        self._results, self._words = results, words
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
        """Keep the final plan of a run; returns its result, or None."""
        if plan is None:
            return self._end(instance)
        self._settle()
        return self._keep(instance, plan, self._begun(instance))

    def _end(self, instance: Instance) -> ResultRecord | None:
        """Keep the best plan of a finished run; a later run is left alone."""
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
        label = ": ".join(filter(None, (plan.method, self._words(instance))))
        record = self._results.keep_plan("solve", label, instance, plan, begun, **more)
        if begun is not None:
            self._open, self._best, self._over = None, None, False
        return record

    def _settle(self) -> None:
        """Finish keeping a run's plan, so that the next run has a folder of its own.

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


def run_told(instance: Instance, result: PlannedRun) -> str:
    """A message about the result of a run."""
    plan = result.plan
    notes = "".join(f"; {note}" for note in result.notes)
    if plan is None:
        why = "infeasible: no plan services all required targets"
        return f"no plan: {why if result.status == 'infeasible' else result.status}{notes}"
    visits = len(set(plan.destinations) - set(instance.station_names))
    return (
        f"{counted(visits, 'target')} visited, {proof_words(plan.status, plan.cost_status)}{notes}"
    )
