"""What is wrong with a plan, and by how much a figure may be off before it is."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

TIME_TOLERANCE_S = 1e-3
DELTA_V_TOLERANCE_M_S = 1e-4
"""What figures of a plan may differ by from what they state."""

DRIFT_TOLERANCE_M_S = 1e-3
"""The same for ΔV of drift legs, whose optimum is found by iteration."""

OBJECTIVE_TOLERANCE = 1e-6
"""The same for objective and bound, relative, but no more than a quarter of the difference of
objectives, and of costs; for the gap, which is a share, as it is."""

EXPENSE_TOLERANCE = 1e-9
"""The same for expenses, relative."""


@dataclass(frozen=True)
class Violation:
    """One thing that is wrong with a plan.

    Attributes
    ----------
    leg : int or None
        Number of the leg, from 1; None if it concerns the plan as a whole.
    rule : str
        Short name of the rule that is broken.
    message : str
        What is stated and what is true.
    """

    leg: int | None
    rule: str
    message: str

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)

    def __str__(self) -> str:
        where = "plan" if self.leg is None else f"leg {self.leg}"
        return f"{where}: {self.rule}: {self.message}"
