"""Variants of the learned choice of the next leg, each on each family, known and uncertain.

    python bench/compare_next_legs.py nominal.npz reduced-fuel.npz reduced-time.npz

The weights that come with the package are compared with those given, of
``bench/train_next_leg.py --variant``. Fields have other seeds than those by which weights were
chosen there; one world a field. Without a plan, but for `planned`: with that of a beam, in the
scenarios of ``bench/rehearsals.py`` as well.
"""

from __future__ import annotations

import argparse
from typing import Any

from machine import heading
from next_leg.held import held_missions, means
from next_leg.rivals import CheapestLegs
from rehearsals import SCENARIOS

from adr_opt.learning.next_leg.scorer import LegScorer, load_scorer, shipped

FIRST_SEED = 508
NAMES = ("cheapest leg, same guard", "as shipped")


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("weights", nargs="*", help="files of weights")
    parser.add_argument("--fields", type=int, default=24)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    arguments = parser.parse_args()
    held = held_missions(arguments.fields, arguments.first_seed)
    for scenario, uncertainty in SCENARIOS.items():
        held["planned", scenario] = [
            mission._replace(uncertainty=uncertainty) for mission in held["planned", "uncertain"]
        ]
    print(heading())
    print(f"\n| weights | {' | '.join(f'{family}, {world}' for family, world in held)} |")
    print(f"|{'---|' * (len(held) + 1)}")
    scorers: list[Any] = [shipped(), *map(load_scorer, arguments.weights), CheapestLegs()]
    for scorer in scorers:
        name = scorer.facts.get("variant", NAMES[type(scorer) is LegScorer])
        found = means(held, scorer)
        print(f"| {name} | {' | '.join(f'{mean:.2f}' for mean in found.values())} |", flush=True)


if __name__ == "__main__":
    main()
