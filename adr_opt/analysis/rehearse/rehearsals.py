"""Many rehearsals of a mission and their distributions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...common.card import Shown
from ...common.constants import DAY_S
from ...plan.plan import Plan
from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from .outcome import Rehearsal

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True, repr=False)
class Rehearsals(Shown):
    """Rehearsals of a mission by one policy.

    Attributes
    ----------
    instance : Instance
    plan : Plan
        That they begin with.
    uncertainty : Uncertainty
    policy : str
    outcomes : tuple of Rehearsal
        In order of their seeds.
    runtime_s : float
    """

    instance: Instance
    plan: Plan
    uncertainty: Uncertainty
    policy: str
    outcomes: tuple[Rehearsal, ...]
    runtime_s: float

    @property
    def losses(self) -> dict[str, Counter[str]]:
        """How often each target was lost for each reason."""
        found: dict[str, Counter[str]] = {}
        for outcome in self.outcomes:
            for name, reason in outcome.losses.items():
                found.setdefault(name, Counter())[reason] += 1
        return found

    def to_dict(self) -> dict[str, Any]:
        """The distributions as JSON data."""
        outcomes, count = self.outcomes, max(len(self.outcomes), 1)
        reasons = Counter(reason for each in outcomes for reason in each.losses.values())
        targets = sorted(self.losses.items(), key=lambda item: (-item[1].total(), item[0]))
        required = any(target.required for target in self.instance.targets)
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "policy": self.policy,
            "samples": len(outcomes),
            "seed": outcomes[0].seed if outcomes else None,
            "planned_prize": self.plan.objective,
            "prize": summary(each.prize for each in outcomes),
            "expected_prize": summary(each.expected for each in outcomes),
            "required_met": share(each.required_met for each in outcomes) if required else None,
            "returned": share(each.returned for each in outcomes),
            "as_planned": share(each.as_planned for each in outcomes),
            "last_day": summary(each.last_s / DAY_S for each in outcomes),
            "delta_v_m_s": summary(each.delta_v_m_s for each in outcomes),
            "tanks": self._tanks(),
            "losses": {name: number / count for name, number in reasons.most_common()},
            "lost_targets": [
                {
                    "target": name,
                    "share": reason.total() / count,
                    "reasons": {each: n / count for each, n in reason.most_common()},
                }
                for name, reason in targets
            ],
            "runtime_s": self.runtime_s,
        }

    def _tanks(self) -> list[dict[str, Any]]:
        """ΔV left in each tank at its end, over the rehearsals that use it."""
        found: dict[tuple[str, int], list[tuple[float, bool]]] = {}
        for outcome in self.outcomes:
            for chaser, number, left, dry in outcome.tanks:
                found.setdefault((chaser, number), []).append((left, dry))
        return [
            {
                "chaser": chaser,
                "tank": number,
                "flown": len(lefts),
                "left_m_s": summary(left for left, _ in lefts),
                "dry": share(dry for _, dry in lefts),
            }
            for (chaser, number), lefts in sorted(found.items())
        ]


def summary(values: Iterable[float]) -> dict[str, Any]:
    """Mean, its standard error, and quantiles of values."""
    array = np.array(list(values), dtype=np.float64)
    if not array.size:
        return {"mean": None, "standard_error": None, "quantiles": {}}
    # From the first value, so that equal ones have no error to the last bit.
    less = array - array[0]
    error = less.std(ddof=1) / np.sqrt(array.size) if array.size > 1 else None
    return {
        "mean": float(array[0] + less.mean()),
        "standard_error": None if error is None else float(error),
        "quantiles": {f"{q:g}": float(np.quantile(array, q)) for q in QUANTILES},
    }


def share(values: Iterable[bool]) -> dict[str, Any]:
    """Share of cases in which something holds, and its standard error."""
    found = summary(float(value) for value in values)
    return {"share": found["mean"], "standard_error": found["standard_error"]}
