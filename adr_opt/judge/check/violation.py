"""Violations of a plan, and tolerances on its figures."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

TIME_TOLERANCE_S = 1e-3
DELTA_V_TOLERANCE_M_S = 1e-4
"""Tolerance on ΔV figures of plans."""

DRIFT_TOLERANCE_M_S = 1e-3
"""Tolerance on the ΔV of drift legs, whose optimum is found by iteration."""

LOW_THRUST_TOLERANCE_M_S = 1e-2
"""Tolerance on the ΔV of low-thrust legs, whose times of thrust are found by iteration, too."""

OBJECTIVE_TOLERANCE = 1e-6
"""Relative tolerance on objective and bound, at most a quarter of the difference between objectives
or costs; absolute for the gap."""

EXPENSE_TOLERANCE = 1e-9
"""Relative tolerance on expenses."""


ALTITUDE_TOLERANCE_M = 10.0
"""Tolerance on altitudes of mean orbits."""

MOST_RELEASE_OFF_M = 10e3
"""Largest distance of perigee and apogee of a released object from the circle of disposal."""


@dataclass(frozen=True)
class Violation:
    """An error in a plan.

    Attributes
    ----------
    leg : int or None
        Number of the leg, from 1; None if it concerns the plan as a whole.
    rule : str
        Short name of the rule that is broken.
    message : str
        The stated and the recomputed value.
    """

    leg: int | None
    rule: str
    message: str

    def to_dict(self) -> dict[str, Any]:
        """The violation as plain data."""
        return asdict(self)

    def __str__(self) -> str:
        where = "plan" if self.leg is None else f"leg {self.leg}"
        return f"{where}: {self.rule}: {self.message}"
