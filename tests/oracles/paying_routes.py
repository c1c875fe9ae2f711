"""All routes of a chaser, one by one, and what each pays for cuts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from adr_opt.mission.evidence import Cut
from adr_opt.mission.mission import Mission


def routes_of(mission: Mission, moves: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """All orders of targets and refuellings that can be flown, and end where a mission may end."""
    if mission.may_stop(moves):
        yield moves
    for body in range(len(mission.names)):
        after = (*moves, body)
        if mission.time(after).made == len(after):
            yield from routes_of(mission, after)


def toll_of(route: Sequence[int], cuts: Sequence[Cut]) -> float:
    """What a route pays: at every even service of a row that it remembers to be one."""
    paid = []
    for rows, memory, multiplier in cuts:
        odd = False
        for body in route:
            odd = odd and body in memory
            if body in rows:
                if odd:
                    paid.append(multiplier)
                odd = not odd
    return math.fsum(paid)


def random_cuts(rng: np.random.Generator, mission: Mission, most: int = 80) -> list[Cut]:
    """Cuts over three targets, or as many as there are, with any memory and multiplier."""
    first, bodies = mission.instance.first_target, len(mission.names)
    scale = float(mission.planning_prizes.max(initial=0.0))
    share = float(rng.choice([0.3, 0.7, 1.0]))
    number = int(rng.integers(1, most if rng.random() < 0.3 else 5))
    return [
        Cut(
            tuple(int(j) for j in rng.choice(np.arange(first, bodies), 3, replace=False)),
            frozenset(np.flatnonzero(rng.random(bodies) < share).tolist()),
            scale * float(rng.uniform(0.0, 0.6)),
        )
        for _ in range(number)
    ]
