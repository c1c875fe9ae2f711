"""Train the learned choice of the next leg, which `rehearse --policy learned` flies by.

    python bench/train_next_leg.py --seed 0 --out adr_opt/learning/next_leg/weights/next-leg.npz

Rounds of imitation: missions are walked through, first by the moves that beams find best, then by
the policy of the round before; at many decisions the moves that look best are judged by narrow
beams that go on from them, and by the rest of the plan, if the walk began with one; a network is
fitted to how much each of them is worth. In most walks legs cost more or less than planned, and
services take longer. Fields have seeds from 1,000,000 on; after each round the policy flies held
fields with lower seeds, as they are planned, without any plan. Needs the extra `[rl]`.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from next_leg.drawn import drawn_mission
from next_leg.fitting import NextLegNetwork, fit
from next_leg.held import held_missions, means
from next_leg.walks import Decision, walk

from adr_opt.learning.next_leg.scorer import LegScorer, load_scorer

WALKS = 4
"""Number of walks through each mission."""


def main() -> None:
    """Train and write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rounds", type=int, nargs="+", default=[1500, 3000])
    parser.add_argument("--epochs", type=int, default=30)
    parser.add_argument("--width", type=int, default=48)
    parser.add_argument("--held", type=int, default=12)
    parser.add_argument("--nominal", action="store_true", help="no drawn budgets and durations")
    parser.add_argument("--start", help="file of weights that the first round walks by")
    parser.add_argument("--decisions", type=Path, help="file to keep judged decisions in")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    began = time.process_time()
    rng = np.random.default_rng(arguments.seed)
    torch.manual_seed(arguments.seed)
    held = held_missions(arguments.held)
    decisions: list[Decision] = []
    scorer = None if arguments.start is None else load_scorer(arguments.start)
    print("| round | decisions | best chosen | loss | nominal | fuel | time | processor |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    for number, wanted in enumerate(arguments.rounds, start=1):
        made: list[Decision] = []
        while len(made) < wanted:
            mission = drawn_mission(rng, domain_randomised=not arguments.nominal)
            for _ in range(WALKS):
                made += walk(mission, rng, scorer)
        decisions += made
        if arguments.decisions is not None:
            columns = zip(*decisions, strict=True)
            np.savez(arguments.decisions, *(np.stack(column) for column in columns))
        mixed = [decisions[at] for at in rng.permutation(len(decisions))]
        network = NextLegNetwork(arguments.width)
        fitted = fit(network, mixed, arguments.epochs, arguments.seed)
        facts = {
            "seed": arguments.seed, "rounds": arguments.rounds[:number],
            "epochs": arguments.epochs, "decisions": len(decisions),
            "domain_randomised": not arguments.nominal,
        }  # fmt: skip
        scorer = LegScorer(network.layers(), facts)
        scorer.save(arguments.out)
        found = means(held, scorer)
        print(
            f"| {number} | {len(decisions)} | {fitted.agreement:.1%} | {fitted.regret:.3f} | "
            + " | ".join(f"{mean:.2f}" for mean in found.values())
            + f" | {time.process_time() - began:.0f} s |",
            flush=True,
        )


if __name__ == "__main__":
    main()
