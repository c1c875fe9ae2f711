"""Partial timetables, or none, where time or memory is short.

How many pairs there are is decided by how much work they are expected to be, not by the clock, so
that a plan does not depend on what else the machine does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from ..common.clock import now_s
from ..common.processors import usable_cores
from ..kernels.tables.timetable import source_of
from ..kernels.tables.timetable_making import WAVE
from ..legs.connection_finder import estimate
from ..legs.nearest_pairs import nearest_pairs, neighbours
from ..legs.timetable import Timetable
from ..legs.timetable_size import TABLE_BYTES, Size
from ..mission.problem import Problem
from ..mission.result import Result, proven_of

SHARE = 1.0 / 3.0
"""Share of a time limit that building the timetable may take, as searching it needs time, too."""

PATIENCE = 1.5
"""Factor by which that share may be exceeded if it completes the timetable."""

MOMENT_S = 0.5
"""Remaining build time for which an interruption waits [s]."""

RANKS = 300
"""Number of nearest destinations examined per body when rows are computed on demand; required
targets are always added."""

LEAST_S = 0.6
"""Minimum build time, so that a short limit omits no pair of an ordinary field [s]."""

GIVEN_UP = 0.8
"""Share of a time limit after which building ends by the clock, on a machine that is far slower
than expected."""


@dataclass(frozen=True)
class TableBudget:
    """The part of the timetable available for planning: all of it, or the nearest pairs.

    Attributes
    ----------
    mission : Problem
        With its timetable.
    spent_s : float
        What the timetable took [s].
    whole_s : float
        What it takes of all pairs, as expected [s].
    needed : bool
        Whether the method plans on it.
    """

    mission: Problem
    spent_s: float
    whole_s: float
    needed: bool = True

    @property
    def all(self) -> bool:
        """Whether the timetable is complete, or not needed."""
        return not self.needed or self.mission.is_whole

    @property
    def none(self) -> bool:
        """Whether not even the nearest destinations of one body are available."""
        timetable = self.mission.missions[0].timetable
        if timetable.is_on_demand:
            return False
        return not self.all and timetable.built < min(WAVE, timetable.pairs.near.shape[1])

    @cached_property
    def _cost(self) -> str:
        """Time and memory of the whole timetable."""
        size, timetable = estimate(self.mission.instance), self.mission.missions[0].timetable
        takes = [f"{self.whole_s:.2g} s"] if self.whole_s else []
        if timetable.is_on_demand or timetable.pairs.near.shape[1] < size.near:
            takes.append(f"{size.bytes / 2**30:.3g} GiB of memory")
        return f"the timetable of all pairs takes about {' and '.join(takes)}"

    def note(self, *, bounded: bool) -> str:
        """A note on omissions and their reason; ``bounded`` tells whether a bound exists."""
        timetable = self.mission.missions[0].timetable
        bodies = len(timetable.names)
        if timetable.is_on_demand:
            near = looked_at(timetable)
            proven = "" if bounded else "; nothing is proven"
            return (
                f"planned without a timetable, on connections computed on demand to the nearest "
                f"{near} of {bodies - 1} destinations of each body{proven}: {self._cost}"
            )
        near = math.ceil(timetable.built / bodies)
        proven = "" if bounded else ", so nothing is proven"
        return (
            f"planned on the timetable of the nearest {near} of {bodies - 1} destinations of each "
            f"body{proven}: {self._cost}"
        )

    def nothing(self, method: str, seed: int) -> Result:
        """The result where time ran out before anything was available."""
        note = f"there was no time to begin: {self._cost}"
        bound = self.mission.total_prize
        return Result(method, upper_bound=bound, seed=seed, runtime_s=self.spent_s, notes=(note,))

    def of_the_whole(self, result: Result, *, of_all: bool = False) -> Result:
        """A result restated for the whole mission: a bound over some pairs does not bound all.

        Parameters
        ----------
        result : Result
        of_all : bool
            Whether its bound holds of all pairs; that of the cost does not.
        """
        if self.all:
            return result
        bound = result.upper_bound if of_all else math.inf
        note = self.note(bounded=math.isfinite(bound))
        notes = (*result.notes, note)
        if result.plan is None or result.sequence is None:
            if math.isfinite(bound):
                return result  # nothing was planned, on whatever timetable
            return replace(result, upper_bound=bound, evidence=None, status="unknown", notes=notes)
        proven = proven_of(self.mission, result.objective, bound)
        return replace(
            result,
            plan=proven.of(result.plan, notes=(*result.plan.notes, note)),
            upper_bound=bound if proven.upper_bound is None else proven.upper_bound,
            status=proven.status,
            notes=notes,
            evidence=result.evidence if of_all else None,
        )


def no_table(whole: Problem) -> TableBudget:
    """A mission without a timetable, for methods that do without."""
    if not whole.has_timetable:
        whole.do_without()
    return TableBudget(whole, 0.0, 0.0, needed=False)


LARGE_ENTRIES = 5_000_000
"""Size below which timetables are always built if there is a second for it."""


def looked_at(timetable: Timetable) -> float:
    """Number of destinations examined per body by planners."""
    source = source_of(timetable.table)
    return timetable.built / len(timetable.names) if source is None else source.near.shape[2]


MOST_EVENTS = 2000
"""Maximum number of departure events, about two months: beyond it, schedules of as many visits as a
search finds at once would take longer than the search."""


def may_work_on_demand(whole: Problem) -> bool:
    """Whether rows may be computed on demand: in a large field and a mission of weeks."""
    if whole.has_timetable or not whole.connecting.may_be_on_demand:
        return False
    size = estimate(whole.instance)
    return size.entries >= LARGE_ENTRIES and size.events <= MOST_EVENTS


def _allowed_s(limit_s: float) -> float:
    """Time allowed to build a timetable [s]."""
    return max(LEAST_S, SHARE * limit_s)


def _whole_s(whole: Problem, size: Size) -> float:
    """Expected time for the timetable of all pairs [s]."""
    # Rows that are given are looked up in Python, one thread at a time.
    return size.build_s / (1 if whole.instance.given is not None else usable_cores())


def has_first_routes(whole: Problem, limit_s: float) -> bool:
    """Whether rows on demand give a plan long before a timetable, which is never complete."""
    if not may_work_on_demand(whole):
        return False
    return _whole_s(whole, estimate(whole.instance)) > PATIENCE * _allowed_s(limit_s)


def ask_for_rows(whole: Problem) -> None:
    """Let rows be computed on demand, to the nearest destinations and required targets."""
    required = sum(target.required for target in whole.instance.targets)
    whole.ask(neighbours(whole.instance, RANKS + required))


def may_go_without(whole: Problem) -> bool:
    """Whether arrivals are functions of time, or the timetable of a tour of targets is large."""
    if whole.has_timetable or whole.missions[0].has_functions:
        return not whole.has_timetable
    return whole.asks_for_least_end and estimate(whole.instance).entries >= LARGE_ENTRIES


def candidates(
    whole: Problem,
    limit_s: float,
    *,
    first: Sequence[str] | None,
    interrupted: Callable[[], bool],
    building: Callable[[float], None],
    table_bytes: float = TABLE_BYTES,
    hasty: bool = False,
    on_demand: bool = False,
) -> TableBudget:
    """Build the timetable of a mission for as many pairs as time and memory allow.

    Parameters
    ----------
    whole : Problem
        One that has its timetable is left as it is; else it gets one.
    limit_s : float
        The time limit of everything [s].
    first : sequence of str or None
        Bodies that are wanted before all others, which come in order of their distance. None for
        those that do not need some of the pairs: they may spend the whole limit.
    interrupted : callable
        Whether the user has interrupted.
    building : callable
        Called with the share of the timetable that is built.
    table_bytes : float
        Memory that it may take.
    hasty : bool
        Whether the timetable is of use if it is that of all pairs alone: otherwise it is given up
        as soon as that is known.
    on_demand : bool
        Whether rows on demand are an alternative where not all pairs can be
        built: then there are no others.
    """
    if whole.has_timetable and (on_demand or not whole.missions[0].timetable.is_on_demand):
        return TableBudget(whole, 0.0, 0.0)
    began, size = now_s(), estimate(whole.instance)
    on_demand = on_demand and may_work_on_demand(whole)
    needs_all, whole_s = first is None, _whole_s(whole, size)
    allowed_s = max(LEAST_S, limit_s) if needs_all else _allowed_s(limit_s)
    affordable = whole_s <= (1.0 if needs_all else PATIENCE) * allowed_s
    given_up_s = max(LEAST_S, limit_s if needs_all else GIVEN_UP * limit_s)

    most = None if affordable else min(size.pairs, int(allowed_s / whole_s * size.pairs))
    share = 1.0 if most is None else most / size.pairs

    def enough(done: float) -> bool:
        building(done)
        late = interrupted() or now_s() - began > given_up_s
        # A quick one is worth the moment: without it there is no plan at all.
        return late and (share - done) * whole_s > MOMENT_S

    pairs = None
    slots = room = size.slots(table_bytes)
    if most is not None:  # none for what is not built
        slots = min(slots, WAVE * max(1, math.ceil(most / (size.bodies * WAVE))))
    if first is not None and not (on_demand and (slots < size.bodies or not affordable)):
        if hasty and not (affordable and slots >= size.bodies):
            slots = min(slots, WAVE)
        pairs = nearest_pairs(whole.instance, first, min(slots, size.near))
    if first is not None and room < size.bodies:
        whole.connecting.kept.limit(min(size.room_bytes, table_bytes))
    built = pairs is not None or not on_demand
    if built:
        whole.build(pairs, enough, most)
    if on_demand and not (built and whole.is_whole):
        ask_for_rows(whole)
    return TableBudget(whole, now_s() - began, whole_s)
