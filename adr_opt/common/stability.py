"""Promises about public names: which are stable, and which may change before version 1.0."""

from __future__ import annotations

from typing import Literal

Stability = Literal["stable", "provisional"]

STABLE = (
    "Certificate", "InputError", "Instance", "Matrices", "MissingExtra", "Mission", "Plan",
    "Result", "Timetable", "Verdict", "Violation", "__version__", "bound", "check", "generate",
    "load", "load_certificate", "load_plan", "plan_of", "solve", "verify",
)  # fmt: skip
"""Names of ``adr_opt`` that keep their arguments and their meaning."""

PROVISIONAL = ("RefinedPlan", "RefinedResult", "load_refined", "refine", "solve_refined")
"""Names of ``adr_opt`` that may change in any version before 1.0, with a line in the changelog."""


def stability(name: str) -> Stability | None:
    """Stability of a public name of ``adr_opt``; None if it is not public."""
    if name in STABLE:
        return "stable"
    return "provisional" if name in PROVISIONAL else None
