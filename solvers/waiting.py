"""An upper bound that lets chasers wait and choose: looser than it must be, but soon there."""

from __future__ import annotations

from collections.abc import Iterable

from adr_opt.errors import InputError
from adr_opt.mission import Mission
from adr_opt.planner import Progress
from adr_opt.practice import practises
from adr_opt.result import Result
from adr_opt.stop import Stop

from .proof import bounded

MOST_EVENTS = 5_000_000
"""Missions with more departure events have too many connections: some ten for each."""


@practises(rounds=12)
def waiting(
    mission: Mission,
    *,
    seed: int,
    stop: Stop,
    progress: Progress,
    start: Iterable[int] | None = None,
    jobs: int = 0,
    delta_v_slot_m_s: float = 50.0,
    most_labels: int = 8_000_000,
) -> Result:
    """No plan is worth more than this, not even one whose chaser waits and chooses its sequences.

    A plan takes the next departure event and the sequence that the time value picks; here every
    connection of all later events is open (:mod:`solvers.relaxation`), so what is proven holds for
    plans as well. The freer mission is the easier one to bound: labels are compared across times.
    What it cannot prove is that a plan is optimal where waiting would help.

    Rounds of :class:`solvers.proof.Proof`, deterministic but for the time limit; an iteration is
    as for ``lagrangian``. Ends by itself when the bound is met, or when it can do no more.

    Parameters
    ----------
    mission : Mission
    seed : int
        Not used.
    stop, progress
    start : sequence of int, optional
        A plan: bodies in order. The bound may prove it optimal.
    jobs : int
        Threads, 0 for all cores. The result does not depend on it.
    delta_v_slot_m_s : float
        Slot of ΔV [m/s]: a finer one gives a tighter bound and takes longer.
    most_labels : int
        Most labels of a search.

    Raises
    ------
    InputError
        An option is out of range, or the mission is too large.
    """
    if mission.timetable.entries > MOST_EVENTS:
        raise InputError(
            f"method 'waiting' takes up to {MOST_EVENTS} departure events, and this mission has "
            f"{mission.timetable.entries}; take fewer targets or a shorter mission"
        )
    return bounded(
        "waiting", mission, stop, progress, seed=seed, start=start, jobs=jobs,
        delta_v_slot_m_s=delta_v_slot_m_s, most_labels=most_labels, waiting=True,
    )  # fmt: skip
