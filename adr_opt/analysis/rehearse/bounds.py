"""Bounds on every policy: clairvoyant optima of drawn worlds, with information penalties.

Perfect information and penalties: Brown, Smith, Sun, Operations Research 58(4), 2010. See
docs/model.md section 13.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import ConfigDict

from ...common.clock import now_s
from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.stop import MaxRuntime, Stop
from ...mission.problem import Problem
from ...problem.instance import Instance
from ...problem.support import refuse
from ...problem.uncertainty import Uncertainty
from ...problem.world import DrawnWorld
from ...run.front import bound, solve
from ...run.method_call import spec_of
from ...run.methods import BOUNDS
from ...study import Place, Study, check_file, run
from .known_world import known_problem, refuse_bounds
from .mission_facts import FOLLOWS, MissionFacts
from .rehearsals import Rehearsals, share, summary
from .worlds import EXACT, InProcess, check_worlds, worlds_study
from .worths import (
    Worth,
    clairvoyant_worth,
    penalised_worth,
    refused_price,
    required_worth,
    takes_uncertain_time,
)

METHOD = "exact"
TIME_LIMIT_S = 20.0

LEAST_S = 0.1
"""Least time limit of a proof after the search for a start plan [s]."""

CONFIDENT = 1.959964
"""Half width of a 95 % confidence interval in standard errors."""

Told = Callable[[int, int], None]


class BoundSetting(NamedTuple):
    """Common settings of all bounds.

    Attributes
    ----------
    instance : Instance
    uncertainty : Uncertainty
    method : str
        Name of a bound.
    time_limit_s : float
        Of each proof [s].
    per_day : float
        Price of the time of services in penalties [prize per day].
    """

    instance: Instance
    uncertainty: Uncertainty
    method: str
    time_limit_s: float
    per_day: float = 0.0

    def study(self) -> Study[int, WorldBounds]:
        """The study whose rows are bounds, by the seeds of worlds.

        They depend on the time of proofs, too, but whatever is proven by then is valid.
        """
        of = {
            "instance": self.instance.sha256,
            "method": self.method,
            "price of time": repr(self.per_day),
            "uncertainty": self.uncertainty.to_json(),
        }
        return worlds_study("bounds", _Proofs(self).row, of, WorldBounds)


class _Proofs(InProcess[BoundSetting]):
    """Bounds computed in one process, with their shared data."""

    def row(self, seed: int, place: Place) -> WorldBounds:
        """The bounds of the world of a seed."""
        return world_bounds(self.facts(place), self.setting, seed)


@dataclass(frozen=True)
class WorldBounds:
    """Bounds on what any policy collects in one world.

    Attributes
    ----------
    seed : int
    perfect : float
        Most prize that a clairvoyant collects.
    penalised : float
        Most prize less penalties; its mean bounds the mean prize of any policy.
    required : bool
        Whether all required targets may be serviced; True unless disproven.
    proven : bool
        Whether plans were found that meet the bounds.
    """

    __pydantic_config__: ClassVar[ConfigDict] = EXACT

    seed: int
    perfect: float
    penalised: float
    required: bool
    proven: bool


@dataclass(frozen=True)
class Bounds:
    """Bounds on policies from a number of worlds.

    Attributes
    ----------
    worlds : tuple of WorldBounds
    has_captures, has_required : bool
        Whether captures may fail or targets be gone; whether some target is required.
    runtime_s : float
    """

    worlds: tuple[WorldBounds, ...]
    has_captures: bool
    has_required: bool
    runtime_s: float

    def to_dict(self) -> dict[str, Any]:
        """The bounds as JSON data."""
        return {
            "samples": len(self.worlds),
            "proven": sum(each.proven for each in self.worlds),
            "perfect": summary(each.perfect for each in self.worlds),
            "penalised": summary(each.penalised for each in self.worlds),
            "required_met": share(each.required for each in self.worlds)
            if self.has_required
            else None,
            "runtime_s": self.runtime_s,
        }

    def gaps(self, made: Rehearsals) -> dict[str, Any]:
        """Gaps of a policy to both bounds, over the worlds of its rehearsals.

        The gap to the penalised bound compares what tries are worth on average, which has the
        mean of the prize and less variance.
        """
        outcomes = {each.seed: each for each in made.outcomes}
        both = [(each, outcomes[each.seed]) for each in self.worlds if each.seed in outcomes]
        return {
            "perfect": gap([w.perfect for w, _ in both], [o.prize for _, o in both]),
            "penalised": gap([w.penalised for w, _ in both], [o.expected for _, o in both]),
        }


def gap(bounds: Sequence[float], prizes: Sequence[float]) -> dict[str, Any]:
    """Relative gap of prizes to bounds of the same worlds, with a 95 % confidence interval.

    That of a ratio of means, by the delta method.

    Returns
    -------
    dict
        ``gap``, ``low`` and ``high``; None where there is nothing to compare.
    """
    count, above = len(bounds), np.array(bounds, dtype=np.float64)
    if not count or above.mean() <= 0.0:
        return {"gap": None, "low": None, "high": None, "samples": count}
    below = above - np.array(prizes, dtype=np.float64)
    found = float(below.mean() / above.mean())
    error = math.inf
    if count > 1:
        error = float((below - found * above).std(ddof=1) / math.sqrt(count) / above.mean())
    half = CONFIDENT * error
    known = math.isfinite(half)
    return {
        "gap": found,
        "low": found - half if known else None,
        "high": found + half if known else None,
        "samples": count,
    }


def bounds(  # noqa: PLR0913
    instance: Instance,
    uncertainty: Uncertainty,
    *,
    samples: int = 100,
    seed: int = 0,
    method: str = METHOD,
    time_limit: float = TIME_LIMIT_S,
    time_price: float = 0.0,
    jobs: int = 1,
    cluster: str | None = None,
    path: str | os.PathLike[str] | None = None,
    stop: Stop | None = None,
    told: Told = lambda done, of: None,
) -> Bounds:
    """Bounds on every policy of a mission, from worlds of consecutive seeds.

    Parameters
    ----------
    instance : Instance
    uncertainty : Uncertainty
    samples : int
        Number of worlds.
    seed : int
        Of the first world.
    method : str
        Name of an installed bound.
    time_limit : float
        Of each proof; what is proven by then is valid [s].
    time_price : float
        Price of the time of services in penalties [prize per day]. What a plan collects in a day
        is a good one, and any is valid at which no target is worth less than the time of its
        service. Times that are drawn are priced where targets are tried once and not towed.
    jobs, cluster, path, stop, told
        As :func:`.sampling.rehearse` takes them.

    Raises
    ------
    InputError
        Something does not fit the instance, or the file.
    """
    began = now_s()
    setting = BoundSetting(instance, uncertainty.of(instance), method, time_limit, time_price)
    check_worlds(samples, seed, jobs, cluster)
    check_bounds(setting, path)
    made = run(
        setting.study(),
        range(seed, seed + samples),
        path,
        jobs=jobs,
        cluster=cluster,
        stop=stop,
        told=told,
    )
    required = any(target.required for target in instance.targets)
    captures = has_captures(instance, setting.uncertainty)
    return Bounds(tuple(made.values()), captures, required, now_s() - began)


def check_bounds(setting: BoundSetting, path: str | os.PathLike[str] | None) -> None:
    """Refuse, before any work, a mission that cannot be bounded or a file that cannot be resumed.

    Parameters
    ----------
    setting : BoundSetting
    path : path, optional
        Of the file; None without one.

    Raises
    ------
    InputError
        Something does not fit the instance, or the file; the bound is unknown.
    """
    refuse(setting.instance, FOLLOWS)
    refuse_bounds(setting.instance, setting.uncertainty)
    spec_of(setting.method, BOUNDS)
    _check_price(setting)
    MaxRuntime(setting.time_limit_s)
    check_file(path, setting.study())


def _check_price(setting: BoundSetting) -> None:
    """Refuse a price of time that is negative or not a valid penalty.

    Raises
    ------
    InputError
        It is negative or not finite, too high, or services of uncertain times are tried again.
    """
    price, uncertainty = setting.per_day, setting.uncertainty
    if not 0.0 <= price < math.inf:
        raise InputError(f"time price = {price!r}: must be 0 or more, in prize per day")
    if price == 0.0:
        return
    refused = refused_price(MissionFacts(setting.instance), uncertainty, price / DAY_S)
    if refused is not None:
        raise InputError(f"time price = {price:g}: {refused}")


def has_captures(instance: Instance, uncertainty: Uncertainty) -> bool:
    """Whether captures may fail, or targets be gone."""
    return any(
        uncertainty.success_of(target.name) < 1.0 or uncertainty.gone_of(target.name) > 0.0
        for target in instance.targets
    )


def has_penalties(setting: BoundSetting) -> bool:
    """Whether penalties reduce the clairvoyant's prize at all."""
    instance, uncertainty = setting.instance, setting.uncertainty
    is_uncertain = any(takes_uncertain_time(uncertainty, each.name) for each in instance.targets)
    return has_captures(instance, uncertainty) or (setting.per_day > 0.0 and is_uncertain)


def _start(problem: Problem, setting: BoundSetting) -> list[str] | None:
    """A start plan by beam search, for bounds of one chaser that accept one but do not search."""
    starts = spec_of(setting.method, BOUNDS).starts
    if setting.method == METHOD or not starts or problem.alone is None:
        return None
    plan = solve(problem, "beam", time_limit=setting.time_limit_s / 4).plan
    return None if plan is None else [leg.destination for leg in plan.legs]


def world_bounds(facts: MissionFacts, setting: BoundSetting, seed: int) -> WorldBounds:
    """The bounds of one world."""
    world = DrawnWorld(setting.instance, setting.uncertainty, seed)
    proven, more = True, dict[str, Any]()
    if facts.cores and spec_of(setting.method, BOUNDS).uses_cores:
        more["jobs"] = facts.cores

    def most(worth: Worth) -> float:
        nonlocal proven
        problem = known_problem(facts, world, worth)
        began = now_s()
        start = _start(problem, setting)
        limit_s = max(setting.time_limit_s - (now_s() - began), LEAST_S)
        found = bound(problem, setting.method, time_limit=limit_s, start=start, **more)
        proven = proven and found.status == "optimal"
        return min(found.upper_bound, problem.total_prize)

    perfect = penalised = most(clairvoyant_worth(facts, world))
    if has_penalties(setting):
        penalised = most(penalised_worth(facts, world, setting.per_day / DAY_S))
    required = sum(target.required for target in setting.instance.targets)
    may = True
    if required:
        may = most(required_worth(facts, world)) > required - 0.5
    return WorldBounds(seed, perfect, penalised, may, proven)
