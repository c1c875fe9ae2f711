"""The state of an editing session as the page shows it."""

from __future__ import annotations

from typing import Any, get_args

from ...common.wording import status_words
from ...plan.plan import Plan
from ...problem.chasers import TankByMass
from ...problem.instance import Instance
from .drafts import Draft, Part, amount_of
from .history import History
from .looks import in_percent

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
                "unit": "kg" if isinstance(chaser.tank, TankByMass) else "m/s",
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
        "status": status_words(plan.status),
        "method": plan.method,
        "visits": len(targets & set(plan.destinations)),
        "targets": len(targets),
        "notes": list(plan.notes),
    }
