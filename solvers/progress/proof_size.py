"""Time and memory that a proof will need, estimated before building its network."""

from __future__ import annotations

import math

from adr_opt.common.memory import available_bytes
from adr_opt.kernels.rules.loads import most_kits
from adr_opt.mission.mission import Mission
from adr_opt.mission.problem import Problem, problem_of

SET_UP_S_PER_EVENT = 3e-6
SWEEP_S_PER_ENTRY = 3.3e-8
"""Set-up time of a proof per timetable entry, which cannot be interrupted.

By `bench/proofs.py set-up` on one core 0.6 to 0.9 µs on fields of 50 and 100 targets over 3 to 10
days, and 2.0 µs on one with six zones; more where limits of altitude are wide, see
:data:`adr_opt.kernels.legs.phasing.WIDE`."""

BYTES_PER_EVENT = 900
"""Memory of a proof up to its first labels per timetable entry.

By `bench/proofs.py set-up` 490 to 870 bytes on the same fields, the values of the finer walks
included."""

CONNECTIONS_PER_EVENT = 10
"""Number of listed connections per timetable entry."""

MEMORY_SHARE = 0.5
"""Share of free memory for the network."""


TOO_LARGE = (
    "the network of all connections takes too much memory, so the bound is from walks that pay "
    "for ΔV, or from least times"
)
"""Note of a bound without a network."""


def fits_memory(problem: Mission | Problem) -> bool:
    """Whether the network of a proof fits in memory."""
    return BYTES_PER_EVENT * _entries(problem) <= MEMORY_SHARE * available_bytes()


def set_up_s(problem: Mission | Problem) -> float:
    """Approximate set-up time of a proof [s]."""
    return SET_UP_S_PER_EVENT * _entries(problem)


def sweep_s(problem: Mission | Problem) -> float:
    """Approximate time of one evaluation of all walks [s]."""
    layers = max(
        1 + int(most_kits(mission.rules.loads)) for mission in problem_of(problem).missions
    )
    return SWEEP_S_PER_ENTRY * layers * _entries(problem)


def _entries(problem: Mission | Problem) -> float:
    """Timetable entries, or their equivalent number for listed connections.

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
    """Notes for readers of a bound."""
    notes = _rounded(problem)
    if not fits_memory(problem):
        notes.append(
            f"nothing was proven: too little memory for the network of about "
            f"{CONNECTIONS_PER_EVENT * _entries(problem):.2g} connections; take fewer targets or a "
            "shorter mission"
        )
    return notes


def proof_notes(problem: Mission | Problem) -> list[str]:
    """Notes for readers of a bound by the proof that :func:`proof_of` chose."""
    return [*_rounded(problem), *([] if fits_memory(problem) else [TOO_LARGE])]


def _rounded(problem: Mission | Problem) -> list[str]:
    step = problem.prize_step
    return [f"the bound is rounded down: all objectives are multiples of {step:g}"] if step else []
