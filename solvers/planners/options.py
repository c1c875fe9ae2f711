"""Options of the planners ``auto`` and ``exact``, and the goals that they set their engines."""

from __future__ import annotations

from dataclasses import dataclass

from adr_opt.common.options import option

from ..beams.beams import USUAL
from ..proof.proof import MOST_LABELS, ProofOptions


@dataclass(frozen=True)
class Goals:
    """Goals of planning by rounds.

    Attributes
    ----------
    proves : bool
        Whether to work on the bound.
    until_done : bool
        End when the proof can do no more.
    cost : bool
        Go on to the least cost of plans that collect as much, once the prizes are proven, with the
        plan made cheaper first.
    prizes_alone : bool
        The plan need not be cheap: no time is kept for that.
    """

    proves: bool = True
    until_done: bool = False
    cost: bool = False
    prizes_alone: bool = False


@dataclass(frozen=True)
class AutoOptions(ProofOptions, method="auto"):
    """Options of the planner ``auto``."""

    prove: bool = option(
        True, "Work on the bound as well; otherwise only beams and local search run."
    )
    time_value_m_s_per_h: float = option(
        USUAL,
        "Value of time: of all connections to a target, beams consider the one of least ΔV + value "
        "· (arrival − ready). Below 0: 110, and less where planes drift.",
        unit="m/s per h",
    )
    cost: bool = option(
        True, "Spend the time that is left once the prizes are proven on the least cost."
    )

    @property
    def goals(self) -> Goals:
        """Goals of the engine, from these options."""
        return Goals(proves=self.prove, cost=self.cost and self.prove)


@dataclass(frozen=True)
class ExactOptions(ProofOptions, method="exact"):
    """Options of the method ``exact``."""

    most_labels: int = option(50_000_000, MOST_LABELS, least=1)
    cost: bool = option(
        False,
        "After the prizes, also prove the least cost among plans of equal prize: ΔV, the end of "
        "the last service, or the expense of a campaign.",
    )

    @property
    def goals(self) -> Goals:
        """Goals of the engine, from these options."""
        return Goals(until_done=True, cost=self.cost)
