"""The result whose plan is shown, with its changes."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any, get_args

from ...common.errors import InputError
from ...common.wording import proof_words
from ...plan.plan import Plan
from ...problem.instance import Instance
from .drafts import Draft, Part, amount_of, unit_of
from .history import History
from .planning import in_percent
from .project.results import Results


class ShownPlan:
    """The result whose plan is shown.

    Parameters
    ----------
    results : Results

    Attributes
    ----------
    result : int or None
        Its number, also while it is hidden; None if there is none.
    hidden : bool
        Whether it is not shown, as the last run has ended without a plan.
    count : int
        Counts the plans that were shown.
    """

    def __init__(self, results: Results) -> None:
        self._results = results
        self.result: int | None = None
        self.hidden = False
        self.count = 0

    def show(self, number: int) -> None:
        """Show the plan of a result."""
        self.result, self.hidden = number, False
        self.count += 1

    @property
    def visible(self) -> int | None:
        """Number of the shown result; None if there is none or it is hidden."""
        return None if self.hidden else self.result

    def hide(self) -> None:
        """Hide the plan; it remains available as a start plan."""
        self.hidden = True

    def reopen(self, number: int) -> None:
        """Show the plan that was shown when the project was left, unless it is damaged."""
        with suppress(InputError):
            self._results.plan(number)
            self.show(number)

    def take_up(self, numbers: Iterable[int], instance_sha256: str) -> None:
        """Show the last of an instance's plans, unless a better one is shown."""
        for number in numbers:
            record = self._results.record(number)
            if record.instance_sha256 != instance_sha256:
                continue
            known = None if self.result is None else self._results.record(self.result)
            alike = known is not None and known.instance_sha256 == instance_sha256
            if not alike or known is None or (known.objective or 0.0) <= (record.objective or 0.0):
                self.show(number)

    def known(self) -> tuple[int, Instance, Plan] | None:
        """Number of the result, instance and plan; None if none is shown.

        Raises
        ------
        InputError
            Its files are spoilt.
        """
        return None if self.result is None else (self.result, *self._results.plan(self.result))

    def given(
        self, instance: Instance, plan: Plan, label: str = "", inputs: tuple[int, ...] = ()
    ) -> int:
        """Number of the result that holds a plan: an existing one, or a new one.

        Parameters
        ----------
        instance : Instance
        plan : Plan
        label : str
            Of a new one; by default the method.
        inputs : tuple of int
            Results that a new one comes from.
        """
        for record in reversed(self._results.all()):
            alike = record.instance_sha256 == instance.sha256
            if alike and record.has_plan and self._results.plan(record.number)[1] == plan:
                return record.number
        kept = self._results.keep_plan("solve", label or plan.method, instance, plan, inputs=inputs)
        return kept.number


PARTS = (*get_args(Part), "dynamics")
"""Parts of an instance that forms edit."""


def told(history: History, shown: tuple[Instance, Plan] | None, number: int) -> dict[str, Any]:
    """The draft and the plan that is shown, as JSON data.

    Parameters
    ----------
    history : History
    shown : (Instance, Plan), optional
    number : int
        Counts the plans that were shown.
    """
    moves = {"undoes": history.undoes, "redoes": history.redoes}
    if not history.has_mission:
        return {
            "name": None,
            **moves,
            "targets": [],
            "duration_s": None,
            "first_duration_s": None,
            "epoch": None,
            "chasers": [],
            "plan": None,
            "instance": None,
        }
    draft, base = history.draft, history.base.field
    field = draft.field
    visited = set() if shown is None else set(shown[1].destinations)
    first = {chaser.name: amount_of(chaser) for chaser in base.chasers}
    content: dict[str, Any] = field.model_dump(mode="json", include=set(PARTS))
    return {
        "name": field.name,
        **moves,
        "targets": [
            [
                target.name,
                target.greatest_prize,
                target.required,
                target.name in draft.excluded,
                target.name in visited,
                list(target.window_s),
                target.removal,
                target.mass_kg,
            ]
            for target in field.targets
        ],
        "duration_s": field.mission.duration_s,
        "epoch": field.epoch.isoformat(),
        "first_duration_s": base.mission.duration_s,
        "chasers": [
            {
                "name": chaser.name,
                "amount": amount_of(chaser),
                "first": first.get(chaser.name, amount_of(chaser)),
                "unit": unit_of(chaser),
                "delta_v_m_s": chaser.tank.delta_v_m_s,
            }
            for chaser in field.chasers
        ],
        "plan": None if shown is None else _of_plan(*shown, draft, number),
        "instance": {name: content.get(name) for name in PARTS},
    }


def _of_plan(instance: Instance, plan: Plan, draft: Draft, number: int) -> dict[str, Any]:
    targets = {target.name for target in instance.targets}
    return {
        "number": number,
        "sha256": plan.instance.sha256,
        "fits": plan.instance.sha256 == draft.sha256,
        "objective": plan.objective,
        "upper_bound": plan.upper_bound,
        "gap": plan.gap,
        "gap_words": in_percent(plan.gap),
        "status": proof_words(plan.status, plan.cost_status),
        "method": plan.method,
        "visits": len(targets & set(plan.destinations)),
        "targets": len(targets),
        "notes": list(plan.notes),
    }
