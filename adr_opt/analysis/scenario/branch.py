"""One future, year by year, with or without campaigns (docs/scenarios.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import timedelta
from typing import NamedTuple

import numpy as np

from ...common.errors import InputError
from ...kernels.orbits.keyed_draws import mixed
from ...problem.air import YEAR_S
from ...sources.worth.pairs import INDICES
from .campaign import offer
from .events import (
    EXPLOSION_FRAGMENTS,
    FragmentCloud,
    collisions_of,
    explosions_of,
    fragments_by_shell,
    rings_of,
)
from .futures import Collision, Explosion, FlownCampaign, ScenarioStart, YearRates, YearRecord
from .launches import launched
from .population import ObjectPopulation


class YearDraws(NamedTuple):
    """Rates and draws of a year, and the objects to which they belong."""

    numbers: INDICES
    clouds: tuple[FragmentCloud, ...]
    rates: YearRates
    collisions: list[Collision]
    explosions: list[Explosion]


@dataclass
class Branch:
    """The state of a future at the beginning of a year.

    Attributes
    ----------
    start : ScenarioStart
    seed : int
    removes : bool
        Whether campaigns take place.
    fly : callable
        Flies a campaign on what is offered, as :func:`.campaign.campaign` does.
    population : ObjectPopulation
    clouds : list of FragmentCloud
    pending : list of (float, int)
        Removals under way: year of each, and number of the object.
    year : int
    due : int
        Year of the next campaign.
    drawn : YearDraws or None
        Rates and draws of the last year.
    keep : callable
        Called with the year and the texts of the instance and of the first plan of a campaign.
    """

    start: ScenarioStart
    seed: int
    removes: bool
    fly: Callable[..., FlownCampaign | None]
    population: ObjectPopulation
    clouds: list[FragmentCloud] = field(default_factory=list)
    pending: list[tuple[float, int]] = field(default_factory=list)
    year: int = 0
    due: int = 0
    drawn: YearDraws | None = None
    keep: Callable[[int, str, str], None] = lambda year, instance, plan: None

    @classmethod
    def of(
        cls,
        start: ScenarioStart,
        seed: int,
        fly: Callable[..., FlownCampaign | None],
        *,
        removes: bool,
    ) -> Branch:
        """The beginning of a future."""
        return cls(start, seed, removes and start.template is not None, fly, start.population)

    def live(
        self, known: YearRecord | None = None, other: Branch | None = None, jobs: int = 1
    ) -> YearRecord:
        """Go through the year; returns its record.

        Parameters
        ----------
        known : YearRecord, optional
            Of an earlier run, from which plans, rates and draws are taken.
        other : Branch, optional
            Of the same seed, which has gone through this year; where the same objects are there,
            its rates and draws hold.
        jobs : int
            Threads.

        Raises
        ------
        InputError
            The known record is not of this future.
        """
        settings, year = self.start.settings, self.year
        last = year == settings.years
        new = self._launch()
        counts = tuple(tuple(row) for row in self.population.by_shell(settings.shells).tolist())
        fragments = fragments_by_shell(
            self.clouds, float(year), settings.shells, settings.activity, drag=settings.drag
        )
        if known is None:
            flown = None if last else self._campaign(jobs)
            drawn = self._draw(None if other is None else other.drawn, jobs)
        else:
            flown = known.campaign
            drawn = YearDraws(
                self.population.numbers,
                tuple(self.clouds),
                known.rates,
                list(known.collisions),
                list(known.explosions),
            )
        self.drawn = drawn
        _, _, rates, collisions, explosions = drawn
        self._take_on(flown)
        happened = self._events(collisions, explosions)
        decayed = 0 if last else self._age()
        self.year += 1
        record = YearRecord(
            counts,
            tuple(fragments.tolist()),
            rates,
            flown,
            tuple(collisions),
            tuple(explosions),
            *happened,
            decayed,
            new,
        )
        if known is not None and record != known:
            raise InputError(
                f"year {year} of seed {self.seed}: the file of an earlier run has a different "
                "year; name another folder"
            )
        return record

    def _launch(self) -> int:
        start, year = self.start, self.year
        first = len(start.population) and int(start.population.numbers[-1]) + 1
        new = launched(
            start.launches,
            year,
            self.seed,
            first + start.launched_before(year),
            start.epoch + timedelta(seconds=YEAR_S * year),
        )
        if new is None:
            return 0
        self.population = self.population.joined(new)
        return len(new)

    def _draw(self, other: YearDraws | None, jobs: int) -> YearDraws:
        settings, population, year = self.start.settings, self.population, self.year
        clouds = tuple(self.clouds)
        if (
            other is not None
            and other.clouds == clouds
            and np.array_equal(other.numbers, population.numbers)
        ):
            return other
        rings = rings_of(self.clouds, float(year), settings.activity, drag=settings.drag)
        rates, collisions = collisions_of(population, rings, self.seed, year, jobs)
        explosions = explosions_of(population, settings, self.seed, year)
        last = year == settings.years
        return YearDraws(
            population.numbers,
            clouds,
            rates,
            collisions if settings.collisions and not last else [],
            [] if last else explosions,
        )

    def _campaign(self, jobs: int) -> FlownCampaign | None:
        template, settings, year = self.start.template, self.start.settings, self.year
        if not self.removes or template is None or year < self.due or len(self.population) < 2:
            return None
        taken = {number for _, number in self.pending}
        since = (self.start.epoch - template.epoch).total_seconds() / YEAR_S
        offered = offer(template, self.population, taken, settings, year, since, jobs)
        return self.fly(
            offered,
            settings,
            self.seed,
            year,
            lambda instance, plan: self.keep(year, instance.to_json(), plan.to_json()),
        )

    def _take_on(self, flown: FlownCampaign | None) -> None:
        """Register a campaign's removals; one that failed at launch is repeated the next year."""
        settings, year = self.start.settings, self.year
        if self.removes and year >= self.due:
            lost = flown is not None and flown.failed
            # The next in the usual order, unless it is made up for before.
            usual = year - year % settings.every + settings.every
            self.due = year + 1 if lost else usual
        if flown is not None:
            self.pending += [
                (year + each.time_s / YEAR_S, each.number)
                for each in flown.attempts
                if each.succeeded
            ]
            self.pending.sort()

    def _events(
        self, collisions: list[Collision], explosions: list[Explosion]
    ) -> tuple[tuple[int, int], tuple[tuple[int, int, int], ...], int]:
        """Removals, collisions and explosions of the year, in order of time."""
        year, population, shells = self.year, self.population, self.start.settings.shells
        place = {number: at for at, number in enumerate(population.numbers.tolist())}
        if year == self.start.settings.years:
            return (0, 0), (), 0
        now = [each for each in self.pending if each[0] < year + 1]
        self.pending = [each for each in self.pending if each[0] >= year + 1]
        queue: list[tuple[float, int, int, Collision | None]]
        queue = [(time - year, 0, number, None) for time, number in now]
        queue += [(each.time, 1, each.one, each) for each in collisions]
        queue += [(each.time, 2, each.one, None) for each in explosions]
        gone: set[int] = set()
        removed, void, took_place = list[tuple[int, int, int]](), 0, [0, 0]
        numbers = shells.numbers(population.altitudes_m)
        kinds = population.kinds

        def there(number: int) -> bool:
            return number in place and number not in gone

        for time, what, number, hit in sorted(queue, key=lambda each: each[:3]):
            if what == 0:
                if there(number):
                    gone.add(number)
                    at = place[number]
                    removed.append((number, int(kinds[at]), int(numbers[at])))
                else:
                    void += 1
            elif what == 1 and hit is not None:
                both = [hit.one] if hit.other < 0 else [hit.one, hit.other]
                if all(map(there, both)):
                    gone |= set(both if hit.catastrophic else both[1:])
                    self.clouds.append(self._debris(hit, [place[number] for number in both]))
                    took_place[0] += 1
            elif there(number):
                gone.add(number)
                at = place[number]
                self.clouds.append(
                    FragmentCloud(
                        year + time,
                        float(population.altitudes_m[at]),
                        _split(EXPLOSION_FRAGMENTS, population, [at]),
                        float(population.bodies.tilts[at]),
                        number,
                    )
                )
                took_place[1] += 1
        self.population = population.without(gone)
        return (took_place[0], took_place[1]), tuple(removed), void

    def _debris(self, hit: Collision, places: list[int]) -> FragmentCloud:
        counts = _split(hit.fragments, self.population, places)
        tilt = float(self.population.bodies.tilts[places[0]])
        number = int(self.population.numbers[places[-1]])
        if hit.other < 0 and not hit.catastrophic:
            # The object stays, and may make other clouds.
            number = int(mixed(mixed(number, -1 - hit.other), self.year))
        return FragmentCloud(self.year + hit.time, hit.altitude_m, counts, tilt, number)

    def _age(self) -> int:
        settings = self.start.settings
        self.population, down = self.population.a_year_later(settings.activity, drag=settings.drag)
        return len(down)


def _split(
    fragments: float, population: ObjectPopulation, places: list[int]
) -> tuple[float, float]:
    """Fragments of rocket bodies and of spacecraft, each object's share by its mass."""
    masses = population.bodies.masses[places]
    stages = np.array([population.bodies.kinds[at] == "rocket body" for at in places])
    share = float(masses[stages].sum() / masses.sum())
    return fragments * share, fragments * (1.0 - share)
