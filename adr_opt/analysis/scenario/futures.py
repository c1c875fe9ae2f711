"""Futures: their common start, and their records year by year, as stored in files."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Any, NamedTuple

from pydantic import ConfigDict, Field, TypeAdapter

from ...common.json_text import loaded, validated
from ...problem.instance import Instance
from .launches import Launch
from .population import ObjectPopulation
from .settings import ScenarioSettings

CASES = ("with", "without")
"""Futures with campaigns and without."""


class Attempt(NamedTuple):
    """A capture: its end within the mission, the object, and whether it succeeded.

    Attributes
    ----------
    time_s : float
        Since the epoch of the campaign.
    number : int
    name : str
    prize : float
        [fragment-years].
    succeeded : bool
    """

    time_s: float
    number: int
    name: str
    prize: float
    succeeded: bool


class FlownCampaign(NamedTuple):
    """A campaign of a scenario.

    Attributes
    ----------
    failed : bool
        Whether it was lost at its launch.
    offered : int
        Number of targets.
    planned : int
        Number of those that its first plan visits.
    replanned : int
        How often it was planned anew.
    delta_v_m_s : float
        Of the first plan.
    attempts : tuple of Attempt
        In order of time.
    """

    failed: bool
    offered: int
    planned: int
    replanned: int
    delta_v_m_s: float
    attempts: tuple[Attempt, ...]

    def to_list(self) -> list[Any]:
        """The campaign as JSON data."""
        return [*self[:-1], [list(each) for each in self.attempts]]


class Collision(NamedTuple):
    """A drawn collision.

    Attributes
    ----------
    time : float
        Within the year.
    one, other : int
        Numbers of the objects, the heavier one first. A fragment has no number: of one the second
        is -1 less the number of its cloud.
    altitude_m : float
    fragments : float
        Of 10 cm and more.
    catastrophic : bool
        Whether both break up; else only the lighter one does, and of a fragment nothing is told.
    """

    time: float
    one: int
    other: Annotated[int, Field(ge=-(2**31), lt=2**31)]
    altitude_m: float
    fragments: float
    catastrophic: bool


class Explosion(NamedTuple):
    """A drawn explosion: its time in the year, and its object."""

    time: float
    one: int


class YearRates(NamedTuple):
    """Expected counts of a year.

    Attributes
    ----------
    encounters, catastrophic : float
        Of pairs of objects.
    fragments : float
        Made by all collisions.
    fragment_encounters, fragment_catastrophic : float
        Of objects with fragments of earlier events.
    """

    encounters: float
    catastrophic: float
    fragments: float
    fragment_encounters: float
    fragment_catastrophic: float


@dataclass(frozen=True)
class YearRecord:
    """A year of one future.

    Attributes
    ----------
    objects : (kind, shells + 2) nested tuple of int
        At its beginning, by shell; the first below all, the last above.
    fragments : tuple of float
        Likewise, of drawn events.
    rates : YearRates
        Of the pairs that are there at its beginning.
    campaign : FlownCampaign or None
        Launched at its beginning.
    collisions, explosions : tuple
        As drawn; those that find an object gone do not take place.
    took_place : (int, int)
        Numbers of collisions and explosions that did.
    removed : tuple of (int, int, int)
        Numbers of the objects, their kinds, and their shells.
    void : int
        Removals that found their object gone.
    decayed, launched : int
    """

    objects: tuple[tuple[int, ...], ...]
    fragments: tuple[float, ...]
    rates: YearRates
    campaign: FlownCampaign | None = None
    collisions: tuple[Collision, ...] = ()
    explosions: tuple[Explosion, ...] = ()
    took_place: tuple[int, int] = (0, 0)
    removed: tuple[tuple[int, int, int], ...] = ()
    void: int = 0
    decayed: int = 0
    launched: int = 0

    def to_dict(self) -> dict[str, Any]:
        """The year as JSON data."""
        return {
            **{name: getattr(self, name) for name in self.__dataclass_fields__},
            "campaign": None if self.campaign is None else self.campaign.to_list(),
        }


RECORDS = TypeAdapter(
    dict[str, YearRecord], config=ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
)


def records_of(line: bytes) -> dict[str, YearRecord]:
    """The records of both cases, from JSON data of :meth:`YearRecord.to_dict` by case.

    Raises
    ------
    ValueError
        It is not JSON, a part is missing, or a value is of another type.
    """
    found, whole = validated(RECORDS, line), loaded(line)
    fields = YearRecord.__dataclass_fields__.keys()
    if whole.keys() != set(CASES) or any(whole[case].keys() != fields for case in CASES):
        raise ValueError("a part is missing or superfluous")
    return {case: found[case] for case in CASES}


Future = dict[str, list[YearRecord]]
"""Case → records of all years and of the end."""


@dataclass(frozen=True)
class ScenarioStart:
    """The common start of all futures of a scenario.

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
