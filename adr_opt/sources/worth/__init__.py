"""Worth of removing objects: expected fragment-years avoided, from a catalogue.

`read_satcat` has masses and sizes, `bodies_of` gives each object of a catalogue its own, with the
source; `worth_of` sums encounters over all pairs, and `prizes_of` makes prizes that add up. The
equations are numbered in docs/worth.md.

>>> from adr_opt.sources import catalogue, worth
>>> found = catalogue.read("examples/catalogue/cloud.tle")  # doctest: +SKIP
>>> made = worth.worth_of(worth.bodies_of(found.records), years=50.0)  # doctest: +SKIP
>>> made.of_set(made.best(10))  # doctest: +SKIP
"""

from .answer import answer, reason
from .bodies import Bodies, bodies_of
from .measures import Measures, MeasuresTable, read_measures
from .prizes import RemovalPrizes, prizes_of
from .satcat import Satcat, read_satcat
from .worth import RemovalWorth, worth_of
from .worth_file import SetWorths, load_set_worths, pairs_json

__all__ = [
    "Bodies",
    "Measures",
    "MeasuresTable",
    "RemovalPrizes",
    "RemovalWorth",
    "Satcat",
    "SetWorths",
    "answer",
    "bodies_of",
    "load_set_worths",
    "pairs_json",
    "prizes_of",
    "read_measures",
    "read_satcat",
    "reason",
    "worth_of",
]
