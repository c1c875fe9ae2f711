"""A small campaign of kits whose targets share worth with each other, for tests of designs."""

from __future__ import annotations

import json

import numpy as np
from launched import campaign

from adr_opt.problem.instance import Instance
from adr_opt.sources.worth import SetWorths


def rated(seed: int = 0, targets: int = 5, chasers: int = 1, kits: int = 2) -> Instance:
    """Launches of chasers with kits to a few of the targets, drawn by seed."""
    whole = campaign("j2", chasers=chasers, kits=kits)
    names = [target.name for target in whole.targets]
    chosen = np.random.default_rng([31, seed]).permutation(len(names))[:targets]
    return whole.part([names[at] for at in sorted(chosen)])


def worths_of_sets(instance: Instance, seed: int = 0) -> SetWorths:
    """Drawn worths of an instance's targets, of which half is shared among them at most."""
    random = np.random.default_rng([32, seed])
    count = len(instance.targets)
    pairs = np.triu(random.exponential(1.0, (count, count)), 1)
    pairs += pairs.T
    alone = pairs.sum(axis=1) * random.uniform(1.0, 3.0, count)
    names = tuple(target.name for target in instance.targets)
    return SetWorths(names, alone, pairs, 1e-4, float(3.0 * alone.sum()), 50.0, names)


def pairs_text(worths: SetWorths) -> str:
    """The file of worths, as `worth --pairs` writes it."""
    objects = [
        {"object": name, "name": name, "alone": float(alone)}
        for name, alone in zip(worths.names, worths.alone, strict=True)
    ]
    pairs = [[float(shared) for shared in row[at + 1 :]] for at, row in enumerate(worths.pairs)]
    return json.dumps(
        {
            "format": "adr-opt-worth/1",
            "unit": "fragment-years",
            "years": worths.years,
            "activity": "mean",
            "total": worths.total,
            "prize_unit": worths.prize_unit,
            "objects": objects,
            "pairs": pairs,
        }
    )
