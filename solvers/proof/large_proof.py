"""Proof for networks too large for memory: a bound at every size.

First every service is taken at its least time and ΔV (:mod:`solvers.walks.floors`), which takes no
time to speak of. Then, if the legs of all origins fit into memory and can be made in time, as whole
numbers (:mod:`solvers.networks.packed_legs`), walks over them bring the bound down, one evaluation
after the other: first those that pay for ΔV (:mod:`solvers.walks.priced_walks`), and when they come
to their end, if there is memory and time for it, those that know how much is left of a tank
(:mod:`solvers.walks.tank_walks`). How fine ΔV is counted is found out by making the legs of a few
origins. Nothing is searched for: labels need the network.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from adr_opt.common.clock import now_s
from adr_opt.common.memory import available_bytes
from adr_opt.common.stop import Stop, TimeIsOver
from adr_opt.legs.connection_finder import estimate
from adr_opt.mission.mission import Mission

from ..networks.packed_legs import MOST, LegSource, NoRoom, Stream
from ..progress.gap import GapTracker
from ..walks.floors import floor_evidence
from ..walks.multipliers import Descent
from ..walks.priced_walks import PooledBound
from ..walks.tank_walks import BYTES, TankBound, width_of

LEG_BYTES = 8
"""Memory per leg [bytes]."""

STATE_BYTES = 16
"""Memory per time step at a body [bytes]."""

ROOM_BYTES = 3.0 * 2**30
"""Maximum memory of all legs [bytes]."""

STATES_BYTES = 2.0**29
"""Maximum memory of all values [bytes]."""

MEMORY_SHARE = 0.5
"""Share of free memory for the legs."""

TIME_SHARE = 0.7
"""Share of the time for making the legs, as evaluations must follow."""

UNITS_M_S = (5.0, 20.0, 50.0, 150.0)
"""Units of ΔV, of which the finest that fits is used [m/s]."""

TANK_UNITS_M_S = (25.0, 50.0, 100.0)
"""Units of ΔV for walks that track the tank [m/s]."""

PAYING_SHARE = 0.25
"""Share of the time after which paying walks must have converged, if others follow."""

TANK_BYTES = 4.0 * 2**30
"""Maximum memory of the values of walks that track the tank [bytes]."""

TANK_S = 4e-9
"""Time of one evaluation per leg and unit, on one core [s]."""

TANK_EVALUATIONS = 25
"""Number of evaluations for which there must be time."""

STEP_SHARE = 1.0 / 60.0
"""Time step as a share of the shortest leg."""

FIRST_EVALUATIONS = 8
"""Evaluations in the first round: a concurrent planner has rounds of many seconds."""

SAMPLED = 4
"""Number of origins whose legs are made to estimate the total."""

SAMPLED_PAIRS = 8
"""Number of pairs whose connections are listed first, if they are listed."""

HOPELESS = 2.0
"""Largest ratio of the number of undominated legs at the finest steps to that at coarser ones."""

LIGHTER = 0.25
"""Least time to make all legs, as a share of the timetable's."""

SPARE = 1.2
"""Ratio of available storage to the estimated number of legs."""


class Layout(NamedTuple):
    """Discretisation of legs.

    Attributes
    ----------
    length, unit : float
        Of a step of time [s], and of ΔV [m/s].
    legs : float
        How many there are, about.
    takes_s : float
        What making them takes on one core [s].
    """

    length: float
    unit: float
    legs: float
    takes_s: float


class LargeProof:
    """Bound of one mission, lowered as far as time and memory allow.

    Parameters
    ----------
    mission : Mission
        Its timetable may be that of some pairs: connections are worked out of all.
    certificate : GapTracker
        Told of every bound.
    stop : Stop
        Its time alone counts here.
    jobs : int
        Threads.

    Attributes
    ----------
    done : bool
        Nothing is left to do.
    latest : None
        There is nothing to guide a search.
    """

    latest: None = None

    def __init__(self, mission: Mission, certificate: GapTracker, stop: Stop, jobs: int) -> None:
        self._mission, self._certificate, self._stop = mission, certificate, stop
        self._jobs = jobs
        self._descent: Descent | None = None
        self._bound: PooledBound | TankBound | None = None
        self._before = 0
        self._unit = math.nan
        self._layout: Layout | None = None
        self._pays, self._until_s = True, -math.inf
        self._evaluations = FIRST_EVALUATIONS
        self.done = certificate.proven

    def begin(self) -> None:
        """Set a bound that takes no time."""
        self._certificate.lower(*floor_evidence(self._mission))
        self.done = self.done or self._certificate.proven

    def advance(self, enough: Callable[[], bool]) -> None:
        """Make the legs in the first round, then evaluate, twice as often in each round."""
        with suppress(TimeIsOver):
            if self._descent is None:
                self._set_up()
            elif self._pays and (self._descent.done or self._stop.remaining_s() < self._until_s):
                self._know_tanks(self._descent)
            for _ in range(self._evaluations):
                if self._descent is None or self._descent.done or enough():
                    break
                self._descent.step()
                self._lower(self._descent)
                if self._certificate.proven:
                    break
        self._evaluations *= 2
        over = self._descent is None or (self._descent.done and not self._tank_layouts())
        self.done = over or self._certificate.proven

    def _lower(self, descent: Descent) -> None:
        """Report a bound with its evidence."""
        assert self._bound is not None
        evidence = self._bound.evidence(descent.value, descent.multipliers)
        self._certificate.lower(descent.value, evidence)

    def _over(self) -> bool:
        return self._stop.remaining_s() <= 0.0

    def _set_up(self) -> None:
        """Make the legs, as fine as memory allows."""
        source = LegSource(self._mission)
        most = min(ROOM_BYTES, MEMORY_SHARE * available_bytes()) / LEG_BYTES
        remaining_s = TIME_SHARE * self._jobs * self._stop.remaining_s()
        for layout in layouts(source, self._mission, most, remaining_s, self._over):
            room = math.ceil(SPARE * layout.legs) + 1000
            if room > most or layout.takes_s > remaining_s:
                continue
            stream = self._made(source, layout, room)
            if stream is not None and stream.least > 0:
                self._bound = PooledBound(self._mission, stream, jobs=self._jobs, over=self._over)
                self._descent, self._unit = Descent(self._bound), layout.unit
                self._layout = layout
                self._until_s = (1.0 - PAYING_SHARE) * self._stop.remaining_s()
                return

    def _tank_layouts(self) -> list[Layout]:
        """Affordable discretisations with tanks, finest first."""
        found, rules = [], self._mission.rules
        if not self._pays or rules.loads is not None or self._layout is None:
            return []
        most = min(TANK_BYTES, MEMORY_SHARE * available_bytes())
        for unit in TANK_UNITS_M_S:
            width = width_of(rules.budget, unit)
            least = BYTES * width * len(self._mission.names) * rules.duration / most
            layout = self._layout._replace(length=max(self._layout.length, least), unit=unit)
            takes_s = layout.takes_s + TANK_EVALUATIONS * TANK_S * layout.legs * width
            if takes_s < self._jobs * self._stop.remaining_s():
                found.append(layout)
        return found

    def _know_tanks(self, paying: Descent) -> None:
        """Continue with walks that track the tank, if memory and time allow."""
        ways, start = self._tank_layouts(), paying.multipliers[:-1]
        self._pays = False
        if not ways:
            return
        self._before = paying.evaluations
        del paying
        self.close()
        self._bound = self._descent = None  # their legs make room for others
        for layout in ways:
            stream = self._made(
                LegSource(self._mission), layout, math.ceil(SPARE * layout.legs) + 1000
            )
            if stream is not None and stream.least > 0:
                self._bound = TankBound(
                    self._mission, stream, start=start, jobs=self._jobs, over=self._over
                )
                self._descent, self._unit = Descent(self._bound), layout.unit
                return

    def _made(self, source: LegSource, layout: Layout, room: int) -> Stream | None:
        """The legs, or None if they exceed the estimate."""
        try:
            return source.stream(layout.length, layout.unit, room, jobs=self._jobs, over=self._over)
        except NoRoom:
            return None

    @property
    def counters(self) -> dict[str, float]:
        """Work counters."""
        evaluations = self._before + (0 if self._descent is None else self._descent.evaluations)
        counted: dict[str, float] = {"evaluations": evaluations, "searches": 0, "labels": 0}
        if self._descent is not None:
            counted["delta_v_unit_m_s"] = self._unit
        return counted

    def close(self) -> None:
        """End the threads."""
        if self._bound is not None:
            self._bound.close()


def layouts(
    source: LegSource,
    mission: Mission,
    most: float,
    most_s: float,
    over: Callable[[], bool] = lambda: False,
) -> Iterator[Layout]:
    """Discretisations of legs, finest first, from a sample of origins.

    Where a service changes what is left of a tank, ΔV is not counted at all.

    Parameters
    ----------
    source : LegSource
    mission : Mission
        Of the source.
    most, most_s : float
        There is nothing where far more legs are to be expected, or far more time on one core [s].
    over : callable
        Whether the time is over.

    Raises
    ------
    TimeIsOver
        It is.
    """
    rules = mission.rules
    wanted = UNITS_M_S if rules.loads is None else (math.inf,)
    units = [unit for unit in wanted if rules.budget / unit <= MOST]
    if source.bodies > MOST or not units or LIGHTER * estimate(mission.instance).build_s > most_s:
        return
    if _listing_s(mission) > most_s:
        return

    def of(i: int, length: float, unit: float) -> tuple[np.ndarray, int]:
        if over():
            raise TimeIsOver
        return source.of(i, length, unit)

    # A first look, at steps that are as short as can be, says how long the shortest leg is.
    finest = max(rules.duration, 1.0) / (MOST - 2)
    origins = {round(place) for place in np.linspace(0, source.bodies - 1, SAMPLED)}
    shortest, count, took_s = math.inf, 0, 0.0
    for i in sorted(origins):
        began = now_s()
        legs, least = of(i, finest, units[-1])
        took_s += now_s() - began
        count += legs.size
        shortest = min(shortest, finest * least) if legs.size else shortest
        if source.bodies * count > HOPELESS * len(origins) * most or took_s > most_s:
            return
    length = max(finest, STATE_BYTES * source.bodies * rules.duration / STATES_BYTES)
    if math.isfinite(shortest):
        length = max(length, STEP_SHARE * shortest)
    share = source.bodies / len(origins)
    for unit in units:
        began = now_s()
        count = sum(of(i, length, unit)[0].size for i in origins)
        took_s = now_s() - began
        yield Layout(length, unit, share * count, share * took_s)


def _listing_s(mission: Mission) -> float:
    """Estimated time to list the connections of all pairs, from a few of them; 0 for none [s].

    A single origin may take minutes, and cannot be interrupted.
    """
    bodies = len(mission.names)
    if not mission.connecting.is_listed or bodies < 2:
        return 0.0
    began = now_s()
    for number in range(SAMPLED_PAIRS):
        i = number * bodies // SAMPLED_PAIRS
        mission.connecting.found(i, (i + bodies // 2) % bodies)
    return (now_s() - began) / SAMPLED_PAIRS * bodies**2
