"""Local search by our own loop, and by the package `alns` with operators of the same kernels.

    python bench/local_search.py --count 5 --time-limit 5

Both begin from the guarded greedy plan and have the same time. The operators given to `alns`:
destroy cuts the plan at a random move or takes a random stretch out of it; repair builds a new end
by a narrow noisy beam, or inserts targets greedily, each candidate timed by the kernel that our
own loop uses. Needs the extra [peers].
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import STATION
from solvers.beams.beams import BeamSettings, beam_search
from solvers.orders.timed_order import make_labels, time_order, with_refuelling


class State:
    """A plan as `alns` wants it: smaller objective is better."""

    def __init__(self, mission: adr_opt.Mission, sequence: tuple[int, ...]) -> None:
        self.mission = mission
        self.sequence = sequence

    def objective(self) -> float:
        """Prizes first, then how early the plan ends."""
        timing = self.mission.time(self.sequence)
        end = float(timing.ends[-1]) if timing.made else 0.0
        return -timing.objective + 0.5 * end / self.mission.rules.duration


def cut(state: State, rng: np.random.Generator) -> State:
    """Destroy: keep a random beginning."""
    return State(state.mission, state.sequence[: int(rng.integers(0, len(state.sequence)))])


def thin(state: State, rng: np.random.Generator) -> State:
    """Destroy: take up to five consecutive moves out; keep what is still legal."""
    first = int(rng.integers(0, max(1, len(state.sequence) - 5)))
    rest = state.sequence[:first] + state.sequence[first + int(rng.integers(1, 6)) :]
    return State(state.mission, rest[: state.mission.time(rest).made])


def rebuild(state: State, rng: np.random.Generator) -> State:
    """Repair: a narrow noisy beam from the beginning that is left."""
    settings = BeamSettings(100, 0.17, 0.38, crowding=2.0, noise=float(rng.uniform(0.0, 0.5)))
    prefix = np.array(state.sequence, dtype=np.int64)
    found = beam_search(state.mission, settings, prefix=prefix, seed=int(rng.integers(2**31)))[0]
    return State(state.mission, tuple(int(j) for j in found))


def insert(state: State, rng: np.random.Generator) -> State:
    """Repair: insert the target that delays the end least, as long as one fits."""
    rules = state.mission.rules
    targets = len(state.mission.instance.targets)
    order = [j for j in state.sequence if j != STATION]
    labels = make_labels(state.mission)
    reference = np.empty(targets + 1)
    while True:
        best, best_order = np.inf, None
        for j in set(range(1, targets + 1)) - set(order):
            for place in range(len(order) + 1):
                trial = np.array([*order[:place], j, *order[place:]], dtype=np.int64)
                end = time_order(rules, trial, trial.size, 0, labels, trial.size, reference, np.inf)
                if end < best:
                    best, best_order = end, trial
        if best_order is None:
            break
        order = [int(j) for j in best_order]
    if not order:
        return State(state.mission, ())
    final = np.array(order, dtype=np.int64)
    if np.isinf(time_order(rules, final, final.size, 0, labels, final.size, reference, np.inf)):
        return state
    found = with_refuelling(final, final.size, labels)
    return State(state.mission, tuple(int(j) for j in found))


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5)
    parser.add_argument("--time-limit", type=float, default=5.0)
    arguments = parser.parse_args()
    try:
        from alns import ALNS
        from alns.accept import RecordToRecordTravel
        from alns.select import RouletteWheel
        from alns.stop import MaxRuntime
    except ImportError:
        sys.exit("this comparison needs the package alns: pip install -e '.[peers]'")
    print(heading())
    print("| field | guarded greedy | local-search | alns |\n|---|---|---|---|")
    warm = adr_opt.Mission(adr_opt.generate("tiny", 0))
    adr_opt.solve(warm, "local-search", iterations=1, time_limit=60.0)
    means = []
    for seed in range(arguments.count):
        mission = adr_opt.Mission(adr_opt.generate("nominal", seed))
        start = adr_opt.solve(mission, "greedy-guarded").sequence or ()
        ours = adr_opt.solve(mission, "local-search", time_limit=arguments.time_limit, start=start)
        search = ALNS(np.random.default_rng(0))
        for destroy in (cut, thin):
            search.add_destroy_operator(destroy)
        for repair in (rebuild, insert):
            search.add_repair_operator(repair)
        initial = State(mission, start)
        theirs = search.iterate(
            initial,
            RouletteWheel([5, 2, 1, 0.5], 0.9, 2, 2),
            RecordToRecordTravel(1.0, 0.01, 1e-3),
            MaxRuntime(arguments.time_limit),
        ).best_state
        row = [mission.time(s).objective for s in (start, ours.sequence or (), theirs.sequence)]
        means.append(row)
        print(f"| nominal-{seed:03d} | " + " | ".join(f"{value:g}" for value in row) + " |")
    print("| mean | " + " | ".join(f"{value:.2f}" for value in np.mean(means, axis=0)) + " |")


if __name__ == "__main__":
    main()
