"""Fewer targets, the nearest ones, where time or memory is short of the timetable of all."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
import numpy.typing as npt

from .campaign import Problem
from .instance import Instance
from .kernels.constants import MU_M3_S2
from .plan import InstanceReference, Unvisited
from .result import Result, status_of
from .timetable_size import estimate

SHARE = 1.0 / 3.0
"""Part of a time limit that the timetable may take: what it holds has to be searched, too."""

PATIENCE = 1.5
"""It may take so many times as long if that is enough for all targets."""

MOMENT_S = 0.5
"""Who interrupts a build waits for it if it will be done that soon [s]."""

LEAST_S = 1.0
"""It may take so long in any case, so that no short limit leaves out a target of a usual field."""


@dataclass(frozen=True)
class Candidates:
    """The mission that is planned: all of it, or the part with the nearest targets.

    Attributes
    ----------
    whole, mission : Mission or Campaign
        The latter with its timetable.
    spent_s : float
        What the timetable took [s].
    whole_s : float
        What it takes with all targets, by the pace so far [s].
    """

    whole: Problem
    mission: Problem
    spent_s: float
    whole_s: float

    @property
    def all(self) -> bool:
        """Whether nothing was left out."""
        return self.mission is self.whole

    @property
    def none(self) -> bool:
        """Whether every target was left out."""
        return not self.all and not self.mission.instance.targets

    @cached_property
    def _cost(self) -> str:
        """What the timetable of everything takes."""
        size = estimate(self.whole.instance)
        memory = "" if size.fits else f" and {size.bytes / 2**30:.3g} GiB of memory"
        return f"the timetable of all targets takes about {self.whole_s:.2g} s{memory}"

    @property
    def note(self) -> str:
        """What was left out, and why."""
        count, total = len(self.mission.instance.targets), len(self.whole.instance.targets)
        planned = f"planned with the nearest {count} of {total} targets, so nothing is proven"
        return f"{planned}: {self._cost}"

    def nothing(self, method: str, seed: int) -> Result:
        """The result where the time was over before there was anything to work on."""
        note = f"there was no time to begin: {self._cost}"
        return Result(
            method, None, None, -math.inf, self.whole.total_prize, "unknown", {}, seed,
            self.spent_s, (note,),
        )  # fmt: skip

    def of_the_whole(self, result: Result) -> Result:
        """What a result of the part says about the whole mission.

        Its bound says nothing. A plan of the whole is no plan of the part once the targets left
        out are dropped from it, because the way past one may be cheaper by way of it; so not even
        the bound and the prizes left out bound the whole together.
        """
        if self.all:
            return result
        notes = (*result.notes, self.note)
        if result.plan is None or result.sequence is None:
            return replace(result, upper_bound=math.inf, status="unknown", notes=notes)
        status = status_of(self.whole, result.objective, math.inf)
        reasons = {entry.target: entry for entry in result.plan.unvisited}
        known = set(self.mission.names)
        unvisited = [
            reasons.get(name) or Unvisited(target=name, reason="not-considered")
            for name in self.whole.names
            if name in reasons or name not in known
        ]
        plan = result.plan.replace(
            instance=InstanceReference(name=self.whole.instance.name, sha256=self.whole.sha256),
            status=status, upper_bound=None, gap=None, cost_bound=None, cost_gap=None,
            cost_status=None, unvisited=unvisited,
            notes=(*result.plan.notes, self.note),
        )  # fmt: skip
        number = {name: body for body, name in enumerate(self.whole.names)}
        routes = tuple(
            tuple(number[leg.destination] for leg in route.legs) for route in plan.routes
        )
        return replace(
            result, sequence=tuple(chain.from_iterable(routes)), routes=routes, plan=plan,
            upper_bound=math.inf, status=status, notes=notes,
        )  # fmt: skip


def candidates(
    whole: Problem,
    limit_s: float,
    *,
    first: Sequence[str] | None,
    interrupted: Callable[[], bool],
    building: Callable[[float], None],
) -> Candidates:
    """Build the timetable of a mission, for as many targets as time and memory allow.

    Parameters
    ----------
    whole : Mission or Campaign
        One that has its timetable is left as it is.
    limit_s : float
        The time limit of everything [s].
    first : sequence of str or None
        Bodies that are wanted before all others, which come in order of their distance. None for
        those to whom a part is of no use: they may spend the whole limit, in any order.
    interrupted : callable
        Whether somebody wants to leave at once.
    building : callable
        Told of the share of the timetable that is built.
    """
    if whole.has_timetable:
        return Candidates(whole, whole, 0.0, 0.0)
    began = time.perf_counter()
    allowed_s = max(LEAST_S, limit_s if first is None else SHARE * limit_s)
    patience = 1.0 if first is None else PATIENCE
    paced, whole_s = math.nan, 0.0

    def enough(done: float) -> bool:
        nonlocal paced, whole_s
        building(done)
        now = time.perf_counter()
        if math.isnan(paced):
            paced = now  # kernels are loaded by now, which is no part of the pace
        whole_s = (now - paced) / done
        late = now - paced > allowed_s and whole_s > patience * allowed_s
        # A quick one is worth the moment: without it there is no plan at all.
        return late or (interrupted() and paced + whole_s - now > MOMENT_S)

    order = None if first is None else nearest_first(whole.instance, first)
    mission = whole.build(order, enough)
    spent_s = time.perf_counter() - began
    return Candidates(whole, mission, spent_s, whole_s)


def nearest_first(instance: Instance, first: Sequence[str]) -> list[int]:
    """All bodies: stations, targets wanted first, then by the ΔV from where a chaser starts.

    Targets without a prize are last.
    """
    wanted = set(first)
    unwanted = [name not in wanted for name in instance.names]
    fixed = range(instance.first_target)
    worthless = [*(False for _ in fixed), *(target.prize == 0.0 for target in instance.targets)]
    from_home = _from_home if instance.given is None else _given_from_home
    cost = np.min([from_home(instance, home) for home in set(instance.starts)], axis=0)
    order = np.lexsort((cost, worthless, unwanted))
    return [*fixed, *(int(body) for body in order if body not in fixed)]


def _from_home(instance: Instance, home: int) -> npt.NDArray[np.float64]:
    """ΔV from a body to each one: of plane, size and eccentricity as they are at t = 0 [m/s]."""
    orbits = instance.orbits()
    radius, inclination, node = orbits[:, 0], orbits[:, 1], orbits[:, 2]
    cosine = np.cos(inclination) * np.cos(inclination[home]) + np.sin(inclination) * np.sin(
        inclination[home]
    ) * np.cos(node - node[home])
    speed = math.sqrt(MU_M3_S2 / radius[home])
    turn = 2.0 * speed * np.sqrt(0.5 * np.maximum(0.0, 1.0 - cosine))
    climb = speed * np.abs(radius - radius[home]) / (2.0 * radius[home])
    vectors = np.array([orbit.eccentricity_vector() for orbit in instance.body_orbits])
    shape = 0.5 * speed * np.linalg.norm(vectors - vectors[home], axis=1)
    cost: npt.NDArray[np.float64] = np.maximum(turn + climb, np.hypot(turn, shape))
    return cost


def _given_from_home(instance: Instance, home: int) -> npt.NDArray[np.float64]:
    """Least cost from a body to each one, where costs are given; +inf for no connection."""
    given = instance.given
    assert given is not None
    there = [given.of_pair(instance.names[home], name)[2] for name in instance.names]
    return np.array([each.min(initial=math.inf) for each in there])
