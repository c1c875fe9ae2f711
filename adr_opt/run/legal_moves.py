"""The legal beginning of a sequence of bodies, and why its next move is not legal."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile

from ..common.errors import InputError
from ..kernels.rules.loads import most_kits
from ..mission.mission import Mission
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
    rules, j = mission.rules, moves[made]
    body = moves[made - 1] if made else rules.start
    name = repr(mission.names[j])
    if rules.is_station[j] and (rules.is_station[body] or body == rules.start):
        return "refuels, but no target was visited since the last refuelling"
    if j == body:
        return f"goes from {name} to itself"
    if not rules.is_station[j] and j in moves[:made]:
        return f"goes to {name}, which was visited before"
    if not rules.is_station[j] and sum(i >= rules.first_target for i in moves[:made]) == (
        rules.most_targets
    ):
        return f"goes to {name}, one more target than the {rules.most_targets} of the chaser"
    kits, most = mission.schedules.kits_for(tuple(moves[: made + 1])), most_kits(rules.loads)
    if rules.loads is not None and kits > most:
        return f"goes to {name}, one more kit than the {most} of the chaser"
    return why_not_flown(mission, moves, made)
