"""Drawn missions with what they cost, and limits of crews and kits."""

from __future__ import annotations

import numpy as np
from random_rules import carrying, limited, mixed_campaign, priced, random_campaign, towing

from adr_opt.problem.instance import Instance


def drawn(seed: int, draw) -> Instance:
    """A campaign, or one chaser, by expense or not, with limits or without."""
    rng = np.random.default_rng([12, seed])
    makes = (random_campaign, mixed_campaign, lambda seed, draw: draw(seed))
    instance = makes[int(rng.integers(3))](seed, draw)
    if rng.random() < 0.9:
        instance = carrying(instance, seed)
    if rng.random() < 0.25 and instance.given is None:
        instance = towing(instance, seed)
    by_expense, empties = rng.random(2)
    if by_expense < 0.75:
        instance = priced(instance, seed)
    if by_expense >= 0.75 or empties < 0.5:
        instance = limited(instance, seed)
    return instance


def laden_campaign(seed: int, draw) -> Instance:
    """A campaign, mostly with kits, and with tows where connections are not given."""
    instance = (random_campaign, mixed_campaign)[seed % 2](seed, draw)
    if seed % 3:
        instance = carrying(instance, seed)
    return towing(instance, seed) if seed % 4 == 0 and instance.given is None else instance
