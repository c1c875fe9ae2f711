"""Distributions of missions for environments: a family and ranges of its parameters."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...kernels.orbits.ephemeris import planes_drift
from ...problem.instance import Instance
from ...sources.generator import family, generate
from ..episodes import playing_time_s

FIRST_SEED, LAST_SEED = 10_000_000, 2**31 - 1
"""Seeds of fields drawn at random start here, so that library instances, and the blocks by which
policies are judged, remain unseen by those trained on random fields."""


Range = tuple[float, float]
Dynamics = Literal["two-body", "j2"]


def _between(value: Any, least: float, most: float) -> bool:
    try:
        return bool(least <= value <= most)
    except TypeError:
        return False


@dataclass(frozen=True)
class Limits:
    """ΔV budget and duration of one mission.

    Attributes
    ----------
    delta_v_m_s, duration_s : float

    Raises
    ------
    InputError
        A number that is not finite or not positive.
    """

    delta_v_m_s: float
    duration_s: float

    def __post_init__(self) -> None:
        for name in ("delta_v_m_s", "duration_s"):
            if not _between(getattr(self, name), 1e-300, 1e300):
                raise InputError(f"{name} = {getattr(self, name)!r}: must be a positive number")


@dataclass(frozen=True)
class Fields:
    """A distribution of missions.

    Attributes
    ----------
    family : str
        Family of the generator; it sets what is None below.
    targets : (int, int), optional
        Smallest and largest number of targets, both included; the family's number if None.
    zones : (int, int)
        Smallest and largest number of keep-out zones.
    delta_v_m_s, duration_s : (float, float), optional
        Smallest and largest ΔV budget [m/s] and duration [s], drawn uniformly for every mission;
        the family's if None.
    limits : tuple of Limits
        Pairs of ΔV budget and duration to draw from as well; plain pairs and dictionaries become
        :class:`Limits`.
    share_of_limits : float
        Probability that a mission has one of ``limits``, each equally likely, instead of a draw
        from the ranges.
    share_of_family : float
        Probability that a field has the family's number of targets instead of a drawn one.
    dynamics : {"two-body", "j2"}, optional
        The family's if None.

    Raises
    ------
    InputError
        A range that is empty or not positive, or a share that is not between 0 and 1.
    """

    family: str = "nominal"
    targets: tuple[int, int] | None = None
    zones: tuple[int, int] = (0, 0)
    delta_v_m_s: Range | None = None
    duration_s: Range | None = None
    limits: tuple[Limits, ...] = ()
    share_of_limits: float = 0.0
    share_of_family: float = 0.0
    dynamics: Dynamics | None = None

    def __post_init__(self) -> None:
        family(self.family)
        try:
            pairs = tuple(_limits_of(limits) for limits in self.limits)
        except TypeError:
            raise InputError(
                f"limits = {self.limits!r}: give pairs of ΔV budget and duration"
            ) from None
        object.__setattr__(self, "limits", pairs)
        for name in ("targets", "zones", "delta_v_m_s", "duration_s"):
            span = getattr(self, name)
            if span is None:
                continue
            least = {"targets": 1, "zones": 0}.get(name, 1e-9)
            whole = name in ("targets", "zones")
            try:
                low, high = span
                object.__setattr__(self, name, (low, high))  # a list in JSON
                good = least <= low <= high < float("inf")
                if whole:
                    good = good and (operator.index(low), operator.index(high)) == (low, high)
            except (TypeError, ValueError):
                good = False
            if not good:
                what = "whole numbers" if whole else "numbers"
                raise InputError(
                    f"{name} = {span!r}: give a pair of {what} (least, largest), least at least "
                    f"{least:g}"
                )
        for name in ("share_of_limits", "share_of_family"):
            if not _between(getattr(self, name), 0.0, 1.0):
                raise InputError(f"{name} = {getattr(self, name)!r}: must be between 0 and 1")
        if self.dynamics is not None and self.dynamics not in get_args(Dynamics):
            known = " or ".join(map(repr, get_args(Dynamics)))
            raise InputError(f"dynamics = {self.dynamics!r}: must be {known}, or None")
        if self.share_of_limits > 0.0 and not self.limits:
            raise InputError("share_of_limits is positive, but there are no limits to draw from")

    @classmethod
    def from_options(cls, options: dict[str, Any] | None, base: Fields) -> Fields:
        """A distribution changed by a dictionary, as passed to ``reset(options=…)``.

        Raises
        ------
        InputError
            An option that does not exist.
        """
        known = [field.name for field in fields(cls)]
        for name in options or {}:
            if name not in known:
                raise InputError(f"option {name!r} is unknown; use one of: {', '.join(known)}")
        return replace(base, **(options or {}))

    @property
    def most_targets(self) -> int:
        """Maximum number of targets of a field."""
        most = family(self.family).targets[1]
        if self.targets is None:
            return most
        return max(self.targets[1], most) if self.share_of_family > 0.0 else self.targets[1]

    @property
    def chasers(self) -> int:
        """How many chasers of a mission are played one after another."""
        return family(self.family).chasers

    @property
    def drifts(self) -> bool:
        """Whether planes drift."""
        return family(self.family).drifts if self.dynamics is None else self.dynamics == "j2"

    @property
    def longest_s(self) -> float:
        """Longest duration of a mission [s]."""
        return self._largest("duration_s")

    @property
    def largest_delta_v_m_s(self) -> float:
        """Largest ΔV budget of a mission [m/s]."""
        return self._largest("delta_v_m_s")

    def _largest(self, name: str) -> float:
        found = [getattr(limits, name) for limits in self.limits]
        if self.share_of_limits < 1.0:
            span = getattr(self, name)
            found.append(getattr(family(self.family), name) if span is None else span[1])
        return float(max(found))

    def draw_field(self, rng: np.random.Generator) -> Instance:
        """A random field for the longest mission with the largest budget."""
        seed = int(rng.integers(FIRST_SEED, LAST_SEED))
        targets = None
        if self.targets is not None and rng.random() >= self.share_of_family:
            targets = int(rng.integers(self.targets[0], self.targets[1] + 1))
        zones = int(rng.integers(self.zones[0], self.zones[1] + 1))
        field = generate(self.family, seed, targets=targets, zones=zones)
        if self.dynamics is not None:
            field = field.replace(dynamics=self.dynamics)
        return field.with_limits(duration_s=self.longest_s, delta_v_m_s=self.largest_delta_v_m_s)

    def draw_limits(self, rng: np.random.Generator) -> Limits:
        """Random ΔV budget and duration of one mission."""
        budgets, durations = self.draw_many_limits(rng, 1)
        return Limits(float(budgets[0]), float(durations[0]))

    def draw_many_limits(
        self, rng: np.random.Generator, count: int
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Random ΔV budgets [m/s] and durations [s] of missions, each of shape (count,)."""
        base = family(self.family)
        budgets = np.full(count, base.delta_v_m_s)
        durations = np.full(count, base.duration_s)
        if self.delta_v_m_s is not None:
            budgets = rng.uniform(*self.delta_v_m_s, size=count)
        if self.duration_s is not None:
            durations = rng.uniform(*self.duration_s, size=count)
        if self.share_of_limits > 0.0:
            chosen = np.flatnonzero(rng.random(count) < self.share_of_limits)
            for index, which in zip(
                chosen.tolist(), rng.integers(len(self.limits), size=chosen.size), strict=True
            ):
                budgets[index] = self.limits[which].delta_v_m_s
                durations[index] = self.limits[which].duration_s
        return budgets, durations


def _limits_of(given: Any) -> Limits:
    if isinstance(given, Limits):
        return given
    return Limits(**given) if isinstance(given, Mapping) else Limits(*given)


@dataclass(frozen=True)
class Alone:
    """The distribution of one instance, with its own budget and duration.

    Attributes
    ----------
    instance : Instance

    Raises
    ------
    InputError
        It has no targets, or several chasers.
    """

    instance: Instance

    def __post_init__(self) -> None:
        _ = self.instance.chaser  # an episode is that of one; several are refused
        if not self.instance.targets:
            raise InputError("the instance has no targets; there is nothing to decide")

    @property
    def most_targets(self) -> int:
        """Number of its targets."""
        return len(self.instance.targets)

    @property
    def chasers(self) -> int:
        """Its only chaser is played."""
        return 1

    @property
    def drifts(self) -> bool:
        """Whether planes drift."""
        return bool(planes_drift(self.instance.oblateness_m2))

    @property
    def limits(self) -> tuple[float, float]:
        """Its ΔV budget [m/s] and duration [s], possibly 0."""
        return self.instance.chaser.tank.delta_v_m_s, playing_time_s(self.instance)

    def draw_field(self, rng: np.random.Generator) -> Instance:
        """The instance."""
        return self.instance

    def draw_many_limits(
        self, rng: np.random.Generator, count: int
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Its ΔV budget [m/s] and duration [s], each of shape (count,)."""
        delta_v_m_s, duration_s = self.limits
        return np.full(count, delta_v_m_s), np.full(count, duration_s)


AnyFields = Fields | str | Mapping[str, Any]
"""A distribution of missions, the name of a family, or the fields of :class:`Fields` by name."""


def fields_of(given: AnyFields) -> Fields:
    """The distribution of missions that a caller passes.

    Raises
    ------
    InputError
        It is not one; see :class:`Fields`.
    """
    if isinstance(given, Fields):
        return given
    if isinstance(given, str):
        return Fields(given)
    if isinstance(given, Mapping):
        return Fields.from_options(dict(given), PUBLISHED)
    raise InputError(
        f"fields = {given!r}: must be an adr_opt.learning.environment.Fields, the name of a "
        "family, or a dictionary"
    )


PUBLISHED = Fields()
"""The published scenario: 50 targets, 7 days, 3 km/s."""

FULL, BRIEF, LEAN = (
    Limits(3000.0, 7.0 * DAY_S),
    Limits(3000.0, 3.0 * DAY_S),
    Limits(1000.0, 7.0 * DAY_S),
)
"""Limits of the three benchmark families."""

VARIED = Fields(
    targets=(20, 60),
    share_of_family=0.6,
    delta_v_m_s=(700.0, 4000.0),
    duration_s=(1.5 * DAY_S, 7.0 * DAY_S),
    limits=(FULL, FULL, BRIEF, LEAN),
    share_of_limits=0.75,
)
"""Domain randomisation over budget, duration and number of targets, including the three benchmark
families."""
