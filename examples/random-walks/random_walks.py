"""A planner in a package of its own: the best of many random missions."""

import math
import time

import numpy as np

from adr_opt.mission.certified import certify


def random_walks(mission, *, seed, stop, progress, walks=100):
    """Take the targets in random order, each if it is legal now or after refuelling.

    Parameters
    ----------
    walks : int
        Number of missions to draw.
    """
    rng, rules = np.random.default_rng(seed), mission.rules
    began = time.perf_counter()
    best, most, walk = [], 0.0, 0
    while walk < walks and not stop(most, math.inf):
        moves, collected = [], 0.0
        for target in rng.permutation(np.arange(rules.first_target, len(mission.names))):
            for more in ([target], *([station, target] for station in range(rules.stations))):
                timing = mission.time(moves + more)
                if timing.made == len(moves + more):
                    moves, collected = moves + more, timing.objective
                    break
        if collected > most and mission.may_stop(mission.closed(moves)):
            best, most = moves, collected
            progress(most, math.inf)
        walk += 1
    runtime = time.perf_counter() - began
    return certify(
        mission, "random-walks", best, seed=seed, runtime_s=runtime, counters={"walks": walk}
    )
