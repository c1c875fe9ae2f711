"""Work to be planned: trials, each one field in one iteration."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.instance import Instance
from adr_opt.run.front import spec_of
from adr_opt.run.methods import BOUNDS
from adr_opt.sources.generator import FAMILIES, draw_zones

from .methods import Method

PUBLISHED_SUITES = ("nominal", "reduced-time", "reduced-fuel")
"""The scenarios of the published study and its companion: the suite ``all``."""

DEFAULT_ZONES = 6
MOST_ITERATIONS = 1000


@dataclass(frozen=True, order=True)
class Trial:
    """One field with the zones of one iteration: the same mission for every method.

    Attributes
    ----------
    suite : str
        A family of the generator.
    field, iteration : int
        From 0. The field of a suite is ``generate(suite, seed=field)``.
    zones : int
        Number of keep-out zones.
    """

    suite: str
    field: int
    iteration: int
    zones: int

    @property
    def zone_seed(self) -> int:
        """Seed of the zones: 1000 · field + iteration, the same in every suite."""
        return MOST_ITERATIONS * self.field + self.iteration

    def instance(self) -> Instance:
        """The instance; without zones it is the generator's, name and all."""
        field = adr_opt.generate(self.suite, self.field)
        if self.zones == 0:
            return field
        return field.replace(
            name=f"{field.name}-z{self.zones}-i{self.iteration:02d}",
            keep_out_zones=draw_zones(self.zone_seed, self.zones, field.mission.duration_s),
        )


@dataclass(frozen=True)
class BoundCall:
    """A bound to prove once for each trial, and its time limit [s]."""

    name: str
    limit_s: float

    @property
    def bounds_campaigns(self) -> bool:
        """Whether it is one for several chasers too."""
        return spec_of(self.name, BOUNDS).several


class Wanted(NamedTuple):
    """A row that is wanted: a method, or a bound, on a trial.

    Attributes
    ----------
    trial : Trial
    what : Method or BoundCall
    seed : int
        Of a planner.
    best : float
        The largest objective known of a legal plan, −inf if none: a bound that meets it may stop.
        The row is not known by it.
    """

    trial: Trial
    what: Method | BoundCall
    seed: int
    best: float = -math.inf

    def key(self) -> dict[str, Any]:
        """What the row is known by, as JSON data."""
        trial = asdict(self.trial)
        if isinstance(self.what, BoundCall):
            return {**trial, "bound": self.what.name, "limit_s": self.what.limit_s}
        return {**trial, "method": self.what.key, "seed": self.seed}


@dataclass(frozen=True)
class Protocol:
    """All that a run is to bring about: every method on every trial that it can plan."""

    suites: tuple[str, ...]
    fields: int
    iterations: int
    zones: int
    methods: tuple[Method, ...]
    seed: int
    bound: BoundCall | None

    def methods_for(self, suite: str) -> tuple[Method, ...]:
        """The methods that plan a suite: of several chasers not those that are for one."""
        several = FAMILIES[suite].chasers > 1
        return tuple(each for each in self.methods if each.plans_campaigns or not several)

    def bound_for(self, suite: str) -> BoundCall | None:
        """The bound, if it is one of a suite."""
        if self.bound is None or FAMILIES[suite].chasers == 1 or self.bound.bounds_campaigns:
            return self.bound
        return None

    def wanted(self, trial: Trial) -> tuple[Wanted, ...]:
        """All rows of a trial, the bound last."""
        bound = self.bound_for(trial.suite)
        whats = (*self.methods_for(trial.suite), *([] if bound is None else [bound]))
        return tuple(Wanted(trial, what, self.seed) for what in whats)

    def trials(self) -> list[Trial]:
        """Iteration by iteration, so that a run cut short has seen every field."""
        return [
            Trial(suite, field, iteration, self.zones)
            for suite in self.suites
            for iteration in range(self.iterations)
            for field in range(self.fields)
        ]


def parse_suites(texts: Iterable[str]) -> tuple[str, ...]:
    """The suites of comma-separated lists, each once; ``all`` stands for the published three.

    Raises
    ------
    InputError
        Unknown suite; the sentence lists them.
    """
    found: dict[str, None] = {}
    for name in (part.strip() for text in texts for part in text.split(",")):
        if name != "all" and name not in FAMILIES:
            raise InputError(
                f"--suite: {name!r} is unknown; use all or one of {', '.join(FAMILIES)}"
            )
        found.update(dict.fromkeys(PUBLISHED_SUITES if name == "all" else (name,)))
    return tuple(found)
