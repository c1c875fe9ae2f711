"""What a proof over the network of all connections takes: time and memory, before it is made."""

from __future__ import annotations

import math

from adr_opt.common.memory import available_bytes
from adr_opt.kernels.rules.loads import most_kits
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of

SET_UP_S_PER_EVENT = 3e-6
SWEEP_S_PER_ENTRY = 3.3e-8
"""Time that setting up a proof takes, which cannot be broken off, for each timetable entry.

By `bench/set_up.py` on one core 0.6 to 0.9 µs on fields of 50 and 100 targets over 3 to 10 days,
and 2.0 µs on one with six zones; more where limits of altitude are wide, see
:data:`adr_opt.kernels.legs.phasing.WIDE`."""

BYTES_PER_EVENT = 900
"""Memory that a proof takes up to its first labels for each timetable entry.

By `bench/set_up.py` 490 to 870 bytes on the same fields, the values of the finer walks included."""

CONNECTIONS_PER_EVENT = 10
"""An entry has about so many there."""

MEMORY_SHARE = 0.5
"""Part of the free memory that the network may take."""


TOO_LARGE = (
    "the network of all connections takes too much memory, so the bound is that of walks whose "
    "ΔV is paid for, or of least times"
)
"""What is said of a bound that no network was made for."""


def fits_memory(problem: Mission | Problem) -> bool:
    """Whether there is memory for the network of a proof."""
    return BYTES_PER_EVENT * _entries(problem) <= MEMORY_SHARE * available_bytes()


def set_up_s(problem: Mission | Problem) -> float:
    """About how long setting up a proof takes [s]."""
    return SET_UP_S_PER_EVENT * _entries(problem)


def sweep_s(problem: Mission | Problem) -> float:
    """About how long the values of all walks take for one set of multipliers [s]."""
    layers = max(
        1 + int(most_kits(mission.rules.loads)) for mission in problem_of(problem).missions
    )
    return SWEEP_S_PER_ENTRY * layers * _entries(problem)


def _entries(problem: Mission | Problem) -> float:
    """Timetable entries; where connections are listed, and counted, as many as have so many.

    Of each kind of chasers that has a network of its own.
    """
    problem = problem_of(problem)
    kinds = len(problem.networks)
    timetable, connecting = problem.missions[0].timetable, problem.connecting
    if not timetable.is_whole:
        return math.inf
    entries = timetable.entries
    if not connecting.is_listed:
        return kinds * entries
    return kinds * sum(connecting.counts.values()) / CONNECTIONS_PER_EVENT


def bound_notes(problem: Mission | Problem) -> list[str]:
    """What a reader of a bound has to know."""
    notes = _rounded(problem)
    if not fits_memory(problem):
        notes.append(
            f"nothing was proven: there is no memory for the network of about "
            f"{CONNECTIONS_PER_EVENT * _entries(problem):.2g} connections; take fewer targets or a "
            "shorter mission"
        )
    return notes


def proof_notes(problem: Mission | Problem) -> list[str]:
    """The same where :func:`proof_of` chose how to prove."""
    return [*_rounded(problem), *([] if fits_memory(problem) else [TOO_LARGE])]


def _rounded(problem: Mission | Problem) -> list[str]:
    step = problem.prize_step
    return [f"the bound is rounded down: all objectives are multiples of {step:g}"] if step else []
