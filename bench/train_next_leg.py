"""Train the learned choice of the next leg, which `rehearse --policy learned` flies by.

    python bench/train_next_leg.py --seed 0 --out adr_opt/learning/next_leg/weights/next-leg.npz
    python bench/train_next_leg.py --variant reduced-fuel --out reduced-fuel.npz

Rounds of imitation first: drawn missions are rehearsed in drawn worlds, at first by the moves that
are judged best, then by the policy of the round before. Half of the decisions are judged: moves by
what beams go on with, those that seem best by a wider one, and by the rest of the best plan that is
known of the mission, which is proven for small ones; a network is fitted to how much each move is
worth. Then PPO, in other missions and worlds. After each step the policy flies held fields,
without any plan, and the weights that collect most there in the families of the variant are
written. Fields have seeds from 1,000,000 on, held ones from 500 on. Needs the extra `[rl]`.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from next_leg.drawn import VARIANTS
from next_leg.fitting import fit
from next_leg.held import FAMILIES, Held, held_missions, means
from next_leg.imitation import Decision, gathered
from next_leg.network import NextLegNetwork
from next_leg.policy_gradient import FLIGHTS, RATE, flown, improve

from adr_opt.learning.next_leg.scorer import LegScorer


class Training:
    """A policy in training, and the best weights so far."""

    def __init__(self, arguments: argparse.Namespace, held: Held) -> None:
        self._arguments, self._held = arguments, held
        self._began, self._best = time.process_time(), -np.inf
        self.rng = np.random.default_rng(arguments.seed)
        torch.manual_seed(arguments.seed)

    def heading(self) -> None:
        """Print the heads of the rows."""
        families = [f"{family}, {world}" for family, world in self._held]
        print(f"| step | of | | {' | '.join(families)} | processor |")
        print(f"|{'---|' * (len(families) + 4)}", flush=True)

    def judge(self, step: str, of: str, said: str, scorer: LegScorer) -> None:
        """Fly held fields, print a row, and write the weights if they are the best so far."""
        found, arguments = means(self._held, scorer), self._arguments
        variant = arguments.variant
        counted = [family for family in FAMILIES if variant in (family, VARIANTS[-1])]
        # Each family and each kind of world as much as another one.
        quality = float(np.mean([found[key] / _usual(key) for key in found if key[0] in counted]))
        cells = [step, of, said, *(f"{mean:.2f}" for mean in found.values())]
        best = quality > self._best
        spent = f"{time.process_time() - self._began:.0f} s"
        print(f"| {' | '.join(cells)} | {spent}{', best' if best else ''} |", flush=True)
        if best:
            self._best = quality
            scorer.save(arguments.out)

    def facts(self, decisions: int, episodes: int) -> dict[str, object]:
        """How weights were made."""
        arguments = self._arguments
        return {
            "variant": arguments.variant,
            "seed": arguments.seed,
            "rounds": arguments.rounds,
            "epochs": arguments.epochs,
            "decisions": decisions,
            "episodes": episodes,
        }


def _usual(key: tuple[str, str]) -> float:
    """About what policies collect."""
    size = {"reduced-time": 12.0, "campaign": 40.0}.get(key[0], 25.0)
    return size if key[1] == "known" else 0.85 * size


def imitated(training: Training, arguments: argparse.Namespace) -> tuple[NextLegNetwork, int]:
    """The network after the last round, and the number of decisions judged."""
    decisions: list[Decision] = []
    scorer: LegScorer | None = None
    network = NextLegNetwork(arguments.width)
    for number, wanted in enumerate(arguments.rounds, start=1):
        more = gathered(wanted, arguments.variant, training.rng, scorer)
        decisions += more.decisions
        mixed = [decisions[at] for at in training.rng.permutation(len(decisions))]
        network = NextLegNetwork(arguments.width)
        fitted = fit(network, mixed, arguments.epochs, arguments.seed)
        scorer = LegScorer(network.layers(), training.facts(len(decisions), 0))
        said = (
            f"{more.proven} of {more.missions} missions proven, best chosen "
            f"{fitted.agreement:.1%}, loss {fitted.regret:.3f}"
        )
        training.judge(f"imitation {number}", f"{len(decisions)} decisions", said, scorer)
    return network, len(decisions)


def main() -> None:
    """Train and write."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--variant", choices=VARIANTS, default=VARIANTS[-1])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rounds", type=int, nargs="+", default=[800, 1200])
    parser.add_argument("--epochs", type=int, default=30)
    parser.add_argument("--width", type=int, default=48, help="hidden units")
    parser.add_argument("--improvements", type=int, default=5, help="steps of PPO")
    parser.add_argument("--missions", type=int, default=24, help="of each step of PPO")
    parser.add_argument("--held", type=int, default=8, help="held fields of each family")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    training = Training(arguments, held_missions(arguments.held))
    training.heading()
    network, decisions = imitated(training, arguments)
    optimiser = torch.optim.Adam(network.parameters(), lr=RATE)
    scorer = LegScorer(network.layers(), training.facts(decisions, 0))
    for number in range(1, arguments.improvements + 1):
        done = flown(arguments.missions, arguments.variant, training.rng, scorer)
        clipped = improve(network, optimiser, done)
        episodes = number * arguments.missions * FLIGHTS
        scorer = LegScorer(network.layers(), training.facts(decisions, episodes))
        said = f"drawn flights {done.mean:.2f}, {clipped:.0%} clipped"
        training.judge(f"PPO {number}", f"{episodes} flights", said, scorer)


if __name__ == "__main__":
    main()
