"""An editing session: drafts, their plans, storage, and the planner."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from typing import Any

from ...common.errors import InputError
from ...common.wording import counted, status_words
from ...mission.result import Result
from ...plan.plan import Plan
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from ...run.front import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from ...run.methods import BOUNDS, PLANNERS, names
from ..report import page
from .drafts import Draft, Edit, History, amount_of
from .folder import Folder
from .work import Look, PlanningOrder, Work, in_percent

PARTS = ("chasers", "stations", "mission", "transfer", "objective")
"""Parts of an instance that forms edit."""

PLANS_KEPT = 32
"""Number of drafts whose plans are remembered, for undo."""


class EditingSession:
    """State shown and changed by the page.

    Parameters
    ----------
    instance : Instance
    plan : Plan or None
        Of the instance.
    folder : Folder

    Raises
    ------
    InputError
        The plan belongs to another instance, or the folder cannot be written to.
    """

    def __init__(self, instance: Instance, plan: Plan | None, folder: Folder) -> None:
        if plan is not None and plan.instance.sha256 != instance.sha256:
            raise InputError(
                f"the plan belongs to another instance, {plan.instance.name!r}; "
                "give the one that it was made of, or no plan"
            )
        self._lock = threading.RLock()
        self._first = instance
        self._history = History(Draft(instance))
        self.folder = folder
        self._work = Work(self._planned)
        self._plans: OrderedDict[str, tuple[Instance, Plan]] = OrderedDict()
        self._shown: tuple[Instance, Plan] | None = None
        self._page: tuple[str, str] | None = None
        self._trouble = ""
        self._number = 0
        self.revision = 0
        folder.make()
        if plan is not None:
            self._keep(instance, plan)
        self._keep_draft()

    def edit(self, edit: Edit) -> None:
        """Change the draft.

        Raises
        ------
        InputError
            The edit is not valid; nothing changes.
        """
        self._go(lambda: self._history.edit(edit))

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
            The order is not valid.
        """
        with self._lock:
            known = None if self._shown is None else self._shown[1]
            self._work.begin(self._history.draft.instance, order, known)

    def stop(self) -> None:
        """Ask the planner for its best plan."""
        self._work.stop()

    def close(self, seconds: float) -> bool:
        """Stop, and wait for pending writes; returns whether all is finished."""
        self._work.stop()
        return self._work.wait(seconds)

    def look(self) -> Look:
        """Progress of the planner."""
        return self._work.look()

    def report(self) -> str | None:
        """Report page of the displayed plan; None without one.

        Raises
        ------
        InputError
            There can be none, as where plotly is not installed.
        """
        with self._lock:
            shown = self._shown
        if shown is None:
            return None
        instance, plan = shown
        key = plan.to_json()
        made = self._page
        if made is None or made[0] != key:
            made = self._page = key, page(instance, plan)
        return made[1]

    def state(self) -> dict[str, Any]:
        """State of the page apart from report and run, as JSON data."""
        with self._lock:
            draft, history = self._history.draft, self._history
            field, shown = draft.field, self._shown
            visited = set() if shown is None else set(shown[1].destinations)
            first = {chaser.name: amount_of(chaser) for chaser in self._first.chasers}
            return {
                "revision": self.revision,
                "name": field.name,
                "folder": str(self.folder.path),
                "undoes": history.undoes,
                "redoes": history.redoes,
                "targets": [
                    [
                        target.name, target.greatest_prize, target.required,
                        target.name in draft.excluded,
                        target.name in visited,
                    ]
                    for target in field.targets
                ],
                "duration_s": field.mission.duration_s,
                "first_duration_s": self._first.mission.duration_s,
                "chasers": [
                    {
                        "name": chaser.name,
                        "amount": amount_of(chaser),
                        "first": first[chaser.name],
                        "unit": "kg" if isinstance(chaser.tank, TankByMass) else "m/s",
                        "delta_v_m_s": chaser.tank.delta_v_m_s,
                    }
                    for chaser in field.chasers
                ],
                "plan": None if shown is None else self._of_plan(*shown, draft),
                "trouble": self._trouble,
            }  # fmt: skip

    def parts(self) -> dict[str, Any] | None:
        """Parts of the instance that forms edit, as in its file."""
        with self._lock:
            field = self._history.draft.field
        content: dict[str, Any] = field.model_dump(mode="json")
        return {name: content.get(name) for name in PARTS}

    def _of_plan(self, instance: Instance, plan: Plan, draft: Draft) -> dict[str, Any]:
        targets = {target.name for target in instance.targets}
        return {
            "number": self._number,
            "sha256": plan.instance.sha256,
            "fits": plan.instance.sha256 == draft.sha256,
            "objective": plan.objective,
            "upper_bound": plan.upper_bound,
            "gap": plan.gap,
            "gap_words": in_percent(plan.gap),
            "status": status_words(plan.status),
            "method": plan.method,
            "visits": len(targets & set(plan.destinations)),
            "targets": len(targets),
            "notes": list(plan.notes),
        }

    def _go(self, move: Callable[[], bool]) -> None:
        """Switch to another draft, and to its plan if there is one."""
        with self._lock:
            if not move():
                return
            self.revision += 1
            known = self._plans.get(self._history.draft.sha256)
            try:
                if known is not None:
                    self._keep(*known)
                self._keep_draft()
                self._trouble = ""
            except (InputError, OSError) as error:  # the edit stands, and the page says so
                self._trouble = str(error)

    def _keep_draft(self) -> None:
        draft, shown = self._history.draft, self._shown
        planned = shown is not None and shown[1].instance.sha256 == draft.sha256
        self.folder.keep_draft(draft.instance, planned=planned)

    def _planned(self, instance: Instance, result: Result) -> str:
        """Adopt a result, in the planner's thread; returns the message about it."""
        plan = result.plan
        notes = "".join(f"; {note}" for note in result.notes)
        if plan is None:
            why = "infeasible: no plan services all required targets"
            return f"no plan: {why if result.status == 'infeasible' else result.status}{notes}"
        with self._lock:
            self.revision += 1
            self._keep(instance, plan)
            self._keep_draft()
        visits = len(set(plan.destinations) - set(instance.station_names))
        return f"{counted(visits, 'target')} visited, {status_words(plan.status)}{notes}"

    def _keep(self, instance: Instance, plan: Plan) -> None:
        """Show, remember and store a plan."""
        key = plan.instance.sha256
        self._plans[key] = instance, plan
        self._plans.move_to_end(key)
        while len(self._plans) > PLANS_KEPT:
            self._plans.popitem(last=False)
        self._shown = instance, plan
        self._number += 1
        self.folder.keep_plan(instance, plan)


def choices() -> dict[str, Any]:
    """Choices offered by the page: methods, bounds and their defaults."""
    return {
        "methods": list(names(PLANNERS)),
        "bounds": list(names(BOUNDS)),
        "method": DEFAULT_METHOD,
        "time_limit_s": DEFAULT_TIME_LIMIT_S,
    }
