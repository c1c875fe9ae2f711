"""What is asked of an import of chosen objects."""

from __future__ import annotations

from typing import NamedTuple

from ....sources import catalogue


class ImportWanted(NamedTuple):
    """What is asked of an import.

    Attributes
    ----------
    filters : Filters
    max_targets : int or None
    station : str or None
    mission : MissionOutline
    crew : Crew
    demands : Demands
        Without a table of prizes.
    ephemerides : bool
        Whether element sets are kept, and orbits fitted to their states.
    """

    filters: catalogue.Filters
    max_targets: int | None
    station: str | None
    mission: catalogue.MissionOutline
    crew: catalogue.Crew
    demands: catalogue.Demands
    ephemerides: bool
