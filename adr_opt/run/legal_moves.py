"""The legal beginning of a sequence of bodies, and why its next move is not legal."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile

from ..common.errors import InputError
from ..mission.mission import Mission
from ..mission.orders import told, why_broken
from ..mission.refused_legs import why_not_flown


def legal_beginning(
    mission: Mission, destinations: Iterable[str], *, repair: bool
) -> tuple[int, ...]:
    """The bodies with these names, up to the first that the mission lacks.

    Raises
    ------
    InputError
        Without ``repair``: a move is illegal; the sentence says which and why.
    """
    index = {name: number for number, name in enumerate(mission.names)}
    moves = [index[name] for name in takewhile(index.__contains__, destinations)]
    timing = mission.time(moves)
    if timing.made < len(moves) and not repair:
        # Next to impossible for a plan that was checked: rounding at the very edge of the slack.
        raise InputError(
            f"start plan: leg {timing.made + 1} {why_illegal(mission, moves, timing.made)}; "
            "correct it, or repair: keep the legal beginning only"
        )
    return tuple(moves[: timing.made])


def why_illegal(mission: Mission, moves: list[int], made: int) -> str:
    """Reason why the first illegal move of a sequence is illegal."""
    why = why_broken(mission.rules, moves[: made + 1], mission.schedules.kits_for)
    if why:
        return told(mission.rules, why, mission.names[moves[made]])
    return why_not_flown(mission, moves, made)
