"""An editing session: drafts, their plans, storage, and the planner."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from ...common.errors import InputError
from ...judge.admit import admit
from ...plan.plan import Plan
from ...problem.instance import Instance
from . import captures, shown_plan
from .drafts import Draft, Edit
from .folder import Folder
from .history import History
from .planning import Done, Found, PlannedRun, PlanningOrder, PlanningProgress, PlanningWork
from .project.points import plan_of_point
from .project.record import DroppedFile, ProjectRecord, ResultRecord, StepRecord
from .project.results import Results
from .project_keeper import PlannedRuns, ProjectKeeper, forget_unused, restored
from .project_keeper import run_told as told
from .shown_plan import ShownPlan
from .variants import differences


class EditingSession:
    """State shown and changed by the page.

    Parameters
    ----------
    instance : Instance or None
        None to go on from what is in the folder, or to begin without a mission.
    plan : Plan or None
        Of the instance.
    folder : Folder
    planner : callable
        Makes what plans, from what handles a result, and plans that are found before it.

    Attributes
    ----------
    folder : Folder
    files : tuple of DroppedFile
    worth : int or None
        Result that rates the objects of the catalogue.
    revision : int
        Counts changes.

    Raises
    ------
    InputError
        The plan belongs to another instance or has violations, or the folder cannot be written to
        or is spoilt.
    """

    def __init__(
        self,
        instance: Instance | None,
        plan: Plan | None,
        folder: Folder,
        planner: Callable[[Done, Found], PlanningWork],
    ) -> None:
        if instance is not None and plan is not None:
            admit(instance, plan)
        self._lock = threading.RLock()
        self.folder = folder
        self._shown = ShownPlan(folder.results)
        self._runs = PlannedRuns(folder.results, self._variant)
        self._keeper = ProjectKeeper(folder)
        self._trouble = ""
        self._ended_with: int | None = None  # the result of the last run
        self.files: tuple[DroppedFile, ...] = ()
        self.worth: int | None = None
        self.revision = 0
        folder.make()
        record = folder.read()
        if record is None:
            # From here on what is in the folder is known as the project's, even after a kill.
            folder.keep(ProjectRecord(steps=(StepRecord(draft=None),), at=0))
            self._history = History(None if instance is None else Draft(instance))
        else:
            self._history = restored(record, folder.drafts)
            self.files, self.worth = record.files, record.worth
            if instance is not None:
                self._history.begin_anew(Draft(instance), f"{instance.name} opened")
            elif record.shown is not None:
                self._shown.reopen(record.shown)
            if self._history.has_mission:
                self._shown.take_up(folder.results.found_again, self._history.draft.sha256)
        if instance is not None and plan is not None:
            self._shown.show(self._shown.given(instance, plan))
        self._keep()
        forget_unused(self._history, folder.drafts)
        self._work = planner(self._planned, self._found)

    @property
    def results(self) -> Results:
        """Results of the project."""
        return self.folder.results

    def edit(self, edit: Edit) -> None:
        """Change the draft.

        Raises
        ------
        InputError
            The edit is not valid, or there is no mission; nothing changes.
        """
        self._go(lambda: self._history.edit(edit))

    def begin_anew(self, instance: Instance, words: str) -> None:
        """Continue with another instance, as one edit."""
        self._go(lambda: self._history.begin_anew(Draft(instance), words))

    def undo(self) -> None:
        """Undo the last edit."""
        self._go(self._history.undo)

    def redo(self) -> None:
        """Redo the last undone edit."""
        self._go(self._history.redo)

    def plan(self, order: PlanningOrder) -> None:
        """Plan the current draft; a running plan is stopped first.

        Raises
        ------
        InputError
            The order is not valid, or there is no mission.
        """
        with self._lock:
            shown = self._shown.known()
            known = None if shown is None else shown[2]
            self._work.begin(self._history.draft.instance, order, known)

    def stop(self) -> None:
        """Ask the planner for its best plan."""
        self._work.stop()

    def prepare(self) -> None:
        """Let the planner load what it needs."""
        with self._lock:
            mission = self._history.draft.field if self._history.has_mission else None
        self._work.prepare(drifts=mission is None or mission.nodes_drift)

    def close(self, seconds: float) -> bool:
        """Stop, and wait for pending writes; returns whether all is finished."""
        self._work.stop()
        over = self._work.wait(seconds)
        self._work.close()
        return over

    def progress(self) -> PlanningProgress:
        """Progress of the planner."""
        return self._work.progress()

    def show(self, number: int) -> None:
        """Show the plan of a result, and continue with its instance, as one edit.

        Raises
        ------
        InputError
            There is no such result, or it has no plan.
        """
        instance, _ = self.results.plan(number)
        with self._lock:
            # What is left out is left out still where the plan is of the draft as it is.
            if not self._history.has_mission or self._history.draft.sha256 != instance.sha256:
                self._history.begin_anew(Draft(instance), f"result {number} shown")
            self._shown.show(number)
            self._settle()

    def show_point(self, number: int, point: int) -> None:
        """Show the plan of a point of a trade-off, which becomes a result of its own.

        Raises
        ------
        InputError
            There is no such result or point, or it has no plan.
        """
        instance, plan = plan_of_point(self.results.place(number), point)
        label = f"point {point} of result {number}"
        self.show(self._shown.given(instance, plan, label, (number,)))

    def adopt(self, plan: Plan, name: str) -> None:
        """Show a plan that was dropped.

        Raises
        ------
        InputError
            It belongs to no instance of the project.
        """
        with self._lock:
            wanted, instance = plan.instance.sha256, None
            if self._history.has_mission and self._history.draft.sha256 == wanted:
                instance = self._history.draft.instance
            known = self.results.newest_of(wanted)
            if instance is None and known is not None:
                instance = self.results.plan(known)[0]
        if instance is None:
            raise InputError(
                f"{name}: the plan belongs to another instance, {plan.instance.name!r}; drop that "
                "first"
            )
        self.show(self._shown.given(instance, plan))

    def target_names(self) -> tuple[str, ...]:
        """Names of the targets of the draft, excluded ones left out; empty without a mission."""
        with self._lock:
            if not self._history.has_mission:
                return ()
            return tuple(target.name for target in self._history.draft.instance.targets)

    def note(
        self, *, files: tuple[DroppedFile, ...] | None = None, worth: int | None = None
    ) -> None:
        """Note dropped files, or the result that rates the objects in them."""
        with self._lock:
            if files is not None:
                self.files = files
            self.worth = worth
            self._settle()

    def shown(self) -> tuple[int, Instance, Plan] | None:
        """The plan that is shown: number of its result, instance and plan; None if there is none.

        A run that ends without a plan leaves none, lest another one be taken for its own.

        Raises
        ------
        InputError
            Its files are spoilt.
        """
        with self._lock:
            return None if self._shown.hidden else self._shown.known()

    def instance(self) -> Instance:
        """The instance as edited, without excluded targets.

        Raises
        ------
        InputError
            There is no mission.
        """
        with self._lock:
            return self._history.draft.instance

    def without_found_windows(self) -> Instance:
        """The mission as edited, with excluded targets and its original windows.

        Raises
        ------
        InputError
            There is no mission, or the result that found others is spoilt.
        """
        with self._lock:
            return captures.without(self._history.draft.field, self.results)

    def take_windows(self, number: int) -> bool:
        """Use the windows of a result, as one edit; returns whether they belong to this mission."""
        with self._lock:
            made = captures.found_for(self._history.draft.field, self.results, number)
            if made is not None:
                self._go(lambda: self._history.go_on(made, "captures in windows"))
            return made is not None

    def lift_windows(self) -> None:
        """Discard found windows, as one edit."""
        with self._lock:
            made = self.without_found_windows()
            self._go(lambda: self._history.go_on(made, "captures at any time"))

    def state(self) -> dict[str, Any]:
        """State of the page apart from report and run, as JSON data."""
        with self._lock:
            shown = self.shown()
            plan = None if shown is None else shown[1:]
            return {
                "revision": self.revision,
                "folder": str(self.folder.path),
                **shown_plan.told(self._history, plan, self._shown.count),
                "result": self._shown.visible,
                "of_last_run": self._shown.visible in (None, self._ended_with),
                "trouble": self._trouble,
                "captures": captures.whose(self._history, self.results),
            }

    def _variant(self, instance: Instance) -> str:
        """Differences of an instance from the original mission, in words."""
        with self._lock:
            if not self._history.has_mission:
                return ""
            return differences(self._history.base.field, instance)

    def _go(self, move: Callable[[], bool]) -> None:
        """Switch to another draft, and to its plan if there is one."""
        with self._lock:
            if not move():
                return
            if self._history.has_mission:
                known = self.results.newest_of(self._history.draft.sha256)
                if known is not None:
                    self._shown.show(known)
            self._settle()

    def _settle(self) -> None:
        """Count and store a change; if storing fails, the change stands, and the page says so."""
        self.revision += 1
        try:
            self._keep()
            self._trouble = ""
        except (InputError, OSError) as error:
            self._trouble = str(error)

    def _keep(self) -> None:
        """Store the project with its current instance and plan."""
        self._keeper.keep(self._history, self._shown, self.files, self.worth)

    def _found(self, instance: Instance, plan: Plan | None) -> None:
        """Keep the best plan so far of a run, in the planner's thread."""
        if plan is None:
            self._end(lambda: self._runs.found(instance, None))
        else:
            self._runs.found(instance, plan)

    def _planned(self, instance: Instance, result: PlannedRun) -> str:
        """Adopt a result, in the planner's thread; returns the message about it."""
        self._end(lambda: self._runs.done(instance, result.plan))
        return told(instance, result)

    def _end(self, kept: Callable[[], ResultRecord | None]) -> None:
        """Show the final plan of a run; none if it has no stored plan."""
        record = None
        try:
            record = kept()
        finally:
            with self._lock:
                if record is None:
                    self._shown.hide()
                else:
                    self._shown.show(record.number)
                self._ended_with = self._shown.visible
                self._settle()
