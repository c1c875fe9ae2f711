"""The common beginning of futures, and what became of them."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from ...problem.instance import Instance
from .launches import Launch
from .population import ObjectPopulation
from .records import YearRecord
from .settings import ScenarioSettings

Future = dict[str, list[YearRecord]]
"""Case → records of all years and of the end."""


@dataclass(frozen=True)
class ScenarioStart:
    """What all futures of a scenario have in common.

    Attributes
    ----------
    population : ObjectPopulation
    epoch : datetime
        Of year 0.
    template : Instance or None
        Of campaigns.
    launches : tuple of Launch
    settings : ScenarioSettings
    """

    population: ObjectPopulation
    epoch: datetime
    template: Instance | None
    launches: tuple[Launch, ...]
    settings: ScenarioSettings

    def launched_before(self, year: int) -> int:
        """Number of objects launched in earlier years."""
        return sum(
            launch.count
            for before in range(year)
            for launch in self.launches
            if launch.is_in(before)
        )


@dataclass(frozen=True)
class Scenario:
    """A scenario over several seeds.

    Attributes
    ----------
    start : ScenarioStart
    futures : tuple of dict
        One for each seed: "with" and "without" campaigns → a record for each year and the end.
    left_out : dict of str to int
        Reasons → objects of the catalogue that are not here.
    """

    start: ScenarioStart
    futures: tuple[Future, ...]
    left_out: dict[str, int]
