"""Variants of the learned choice of the next leg, each on each family, known and uncertain.

    python bench/compare_next_legs.py nominal.npz reduced-fuel.npz reduced-time.npz

The weights that come with the package are compared with those given, of
``bench/train_next_leg.py --variant``. Fields have other seeds than those by which weights were
chosen there; without a plan, one world a field.
"""

from __future__ import annotations

import argparse

from machine import heading
from next_leg.held import held_missions, means
from next_leg.rivals import CheapestLegs

from adr_opt.learning.next_leg.scorer import load_scorer, shipped

FIRST_SEED = 550


def main() -> None:
    """Compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("weights", nargs="*", help="files of weights")
    parser.add_argument("--fields", type=int, default=24)
    arguments = parser.parse_args()
    held = held_missions(arguments.fields, FIRST_SEED)
    print(heading())
    print(f"\n| weights | {' | '.join(f'{family}, {world}' for family, world in held)} |")
    print(f"|{'---|' * (len(held) + 1)}")
    scorers = [shipped(), *map(load_scorer, arguments.weights), CheapestLegs()]
    for scorer in scorers:
        name = scorer.facts.get("variant", "cheapest leg, same guard")
        found = means(held, scorer)  # type: ignore[arg-type]
        print(f"| {name} | {' | '.join(f'{mean:.2f}' for mean in found.values())} |", flush=True)


if __name__ == "__main__":
    main()
