"""An instance with a record at every place of the format."""

from __future__ import annotations

import adr_opt
from adr_opt.problem.instance import Instance


def rich() -> Instance:
    """An instance with a record at every place."""
    instance = adr_opt.generate("tiny", 0, targets=5, zones=1)
    orbit = instance.targets[0].orbit
    targets = [each.replace(fit={"eccentricity_offset": (0.0, 0.0)}) for each in instance.targets]
    second = instance.chaser.replace(name="second", start={"orbit": orbit}, expense={"fixed": 1.0})
    return instance.replace(targets=tuple(targets), chasers=(second, instance.chaser))


PLACES = (
    "",
    "mission",
    "transfer",
    "objective",
    "stations[]",
    "stations[].orbit",
    "targets[]",
    "targets[].orbit",
    "targets[].fit",
    "chasers[]",
    "chasers[].tank",
    "chasers[].start",
    "chasers[].start.orbit",
    "chasers[].expense",
    "keep_out_zones[]",
)
