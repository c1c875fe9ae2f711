"""Random instances: the benchmark families.

Every number is drawn from raw PCG-64 output (whose stream NumPy guarantees) by IEEE arithmetic and
rounded to the digits of the file, so one seed gives one file, byte for byte, on any machine.

`belt` holds the field of the published study, `cloud` a fragmentation cloud and `fragments` a large
one, `rocket_bodies` and `sso` fields whose nodes drift, `removal` and `electric` the removal of two
kinds of rocket bodies with kits and by tows of low thrust; `families` lists what is drawn from
them, with limits; `zones` draws keep-out zones.
"""

from __future__ import annotations

from .families import FAMILIES, Family, family
from .make import EPOCH, by_name, draw_zones, family_of, generate
from .stream import LARGEST_SEED

__all__ = [
    "EPOCH",
    "FAMILIES",
    "LARGEST_SEED",
    "Family",
    "by_name",
    "draw_zones",
    "family",
    "family_of",
    "generate",
]
