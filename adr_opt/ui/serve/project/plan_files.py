"""Plans in folders of results, also of runs that a killed server left unfinished."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ....common.errors import InputError
from ....judge.admit import Admitted, admit
from ....plan.plan import Plan
from ....problem.instance import Instance
from .private import refuse_link
from .record import ResultRecord

INSTANCE, PLAN = "instance.json", "plan.json"

FIELD = "field.json"
"""The mission for which windows were found."""

EARLY = "stopped early: the best plan found so far"


NOT_LEGAL = "not legal"
"""Status of a plan with violations, whatever it states."""


def of_plan(admitted: Admitted[Plan]) -> dict[str, Any]:
    """Fields of a record from a plan."""
    instance, plan = admitted.instance, admitted.plan
    targets = {target.name for target in instance.targets}
    visited = tuple(name for name in plan.destinations if name in targets)
    return {
        "instance_sha256": plan.instance.sha256,
        "plan_sha256": plan.legs_sha256,
        "objective": plan.objective,
        "bound": plan.upper_bound,
        "gap": plan.gap,
        "delta_v_m_s": plan.delta_v_m_s,
        "targets": len(set(visited)),
        "visited": visited,
        "status": plan.status if admitted.holds else NOT_LEGAL,
    }


def load_kept(place: Path) -> Admitted[Plan]:
    """The plan in a folder, with its instance; violations head the page that shows it.

    Raises
    ------
    InputError
        One of them is spoilt, or a link, or the plan is of another instance.
    """
    instance = Instance.load(refuse_link(place / INSTANCE))
    return admit(instance, Plan.load(refuse_link(place / PLAN)), unjudged=True)


def unfinished(place: Path, number: int, verb: str) -> ResultRecord | None:
    """The record of a planning run from the best plan so far in its folder; None without one.

    Parameters
    ----------
    place : path
    number : int
    verb : str
        Whose folder it is.
    """
    if verb != "solve" or not (place / PLAN).is_file():
        return None
    try:
        admitted = load_kept(place)
        made_at = datetime.fromtimestamp(int((place / PLAN).stat().st_mtime), UTC)
    except (InputError, OSError):
        return None
    return ResultRecord(
        number=number,
        verb=verb,
        label=admitted.plan.method,
        made_at=made_at,
        said=EARLY,
        **of_plan(admitted),
    )
