"""Answers of verbs, as figures and as a sentence."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ....common.wording import counted
from ..project.plan_files import INSTANCE, PLAN, load_kept, of_plan


def figures_of(place: Path, answer: dict[str, Any]) -> dict[str, Any]:
    """Figures of a result, from the plan that was made or else from the answer of the verb.

    Parameters
    ----------
    place : path
        The folder of the result.
    answer : dict
        What the verb has printed.
    """
    if (place / PLAN).is_file() and (place / INSTANCE).is_file():
        return of_plan(load_kept(place))
    found = {
        "objective": answer.get("objective"),
        "bound": answer.get("upper_bound"),
        "gap": answer.get("gap"),
        "delta_v_m_s": answer.get("flown_delta_v_m_s"),
    }
    figures: dict[str, Any] = {
        name: float(value)
        for name, value in found.items()
        if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    }
    status = answer.get("status")
    return figures | ({"status": status} if isinstance(status, str) else {})


def said_of(verb: str, answer: dict[str, Any], status: int) -> str:
    """An answer in a few words.

    Parameters
    ----------
    verb : str
    answer : dict
        What the verb has printed.
    status : int
        Its exit status, 1 where the answer is no.
    """
    if verb == "check":
        count = len(answer.get("violations") or ())
        return counted(count, "violation") if count else "no violations"
    if verb == "verify":
        reasons = answer.get("reasons") or ("refused",)
        return "verified" if answer.get("verified") else f"refused: {reasons[0]}"
    bound = answer.get("upper_bound")
    if verb == "bound" and isinstance(bound, (int, float)):
        return f"no plan collects more than {bound:.6g}"
    return NO.get(verb, "done, but the answer is no") if status else "done"


NO = {
    "bound": "infeasible",
    "compare": "a plan has violations",
    "fly": "a leg misses, or a tank does not suffice",
    "refine": "a leg is missing",
    "rehearse": "no rehearsal services all required targets",
    "replan": "the rest has no plan",
    "report": "a tank does not suffice, or a leg misses",
    "tradeoff": "a point has no plan",
}
"""What exit status 1 means."""
