"""Dry masses of families of rocket stages, by the names that public catalogues give them.

Stages of a family are alike, so that a name says more than the kind of an object. A family is here
if a public source was read for it:

A   M. Wade, Encyclopedia Astronautica, and R. Braeunig, Rocket & Space Technology, on Zenit-2 and
    Kosmos-3M. For the second stage of Zenit-2 sources have 8,300 to 9,300 kg.
B   The inventory of emissions of launches and re-entries,
    github.com/cbarker211/Emissions_API: figures of user manuals, Space Launch Report and
    Spaceflight101, of which manuals go before; else the mean.
C   ISTI-CNR, Uncontrolled re-entries of massive space objects, 4th International Space Debris
    Re-entry Workshop, ESA/ESOC 2018, after DISCOS.
D   Space Rocket History 15 (spacerockethistory.com), on the third stage of Vostok.
"""

from __future__ import annotations

from typing import NamedTuple


class StageFamily(NamedTuple):
    """Dry mass [kg], and length and diameter where the source has them [m]."""

    mass: float
    source: str
    length: float | None = None
    diameter: float | None = None


STAGES = {
    "SL-16 R/B": StageFamily(9000.0, "A", 11.5, 3.9),
    "SL-8 R/B": StageFamily(1435.0, "A", 6.0, 2.4),
    "SL-3 R/B": StageFamily(1472.0, "D", 5.1, 2.4),
    "SL-12 R/B(2)": StageFamily(2440.0, "B"),
    "SL-23 R/B": StageFamily(9300.0, "C"),
    "ATLAS 5 CENTAUR R/B": StageFamily(2030.0, "B"),
    "BREEZE-M R/B": StageFamily(2370.0, "B"),
    "CZ-2C R/B": StageFamily(4000.0, "B"),
    "CZ-2D R/B": StageFamily(4000.0, "B"),
    "CZ-4B R/B": StageFamily(2000.0, "B"),
    "CZ-4C R/B": StageFamily(2000.0, "B"),
    "DELTA 4 R/B": StageFamily(3420.0, "B"),
    "FALCON 9 R/B": StageFamily(4250.0, "B"),
    "FREGAT R/B": StageFamily(1000.0, "B"),
    "H-2A R/B": StageFamily(3100.0, "B"),
    "PEGASUS R/B": StageFamily(108.0, "B"),
    "PSLV R/B": StageFamily(670.0, "B"),
    "VEGA R/B": StageFamily(688.0, "B"),
}
"""By name in catalogues; the letter is that of the source above."""


def stage_of(name: str) -> StageFamily | None:
    """The stage that a name says, also among other words; None for other objects."""
    words = f" {name.upper()} "
    return next((stage for mark, stage in STAGES.items() if f" {mark} " in words), None)
