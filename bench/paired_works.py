"""Short works by the public API, timed when they are asked for: a side of `paired_commits.py`.

    echo timetable | python bench/paired_works.py

The script knows of any version of ``adr_opt`` only what its users know, and it is limited in work
and not in time. A name read is a work done: a line of JSON says what it took by the clock and of
processors [s], and what came out, so that nobody compares the times of different results.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import random
import sys
import time
from collections.abc import Callable
from functools import cached_property
from typing import Any, TextIO

import adr_opt

LIMIT_S = 3600.0
"""Never reached."""

MOST_LABELS = 100_000
"""Maximum number of labels per search."""

FIELDS: dict[bool, dict[str, tuple[str, int, dict[str, int]]]] = {
    False: {
        "alone": ("nominal", 1, {}),
        "drifting": ("rocket-bodies", 0, {"targets": 20}),
        "several": ("campaign", 0, {"targets": 40}),
        "cloud": ("cloud", 0, {"targets": 24}),
    },
    True: {
        "alone": ("tiny", 0, {}),
        "drifting": ("tiny", 0, {}),
        "several": ("tiny", 0, {"chasers": 2}),
        "cloud": ("tiny", 0, {}),
    },
}
"""Family, seed and sizes of each field: those that are measured on, and tiny ones."""

STEPS = {False: 3000, True: 30}
CHECKS = {False: 40, True: 2}
"""Repetitions within one work of what takes milliseconds."""


class Works:
    """The measured works; fields and timetables are prepared before the clock starts.

    Parameters
    ----------
    tiny : bool
        On tiny fields, to see that all is well.
    """

    def __init__(self, tiny: bool) -> None:
        self._tiny = tiny
        self.all: dict[str, Callable[[], Any]] = {
            "timetable": self.timetable,
            "sweeps": self.sweeps,
            "beam": self.beam,
            "auto": self.auto,
            "exact": self.exact,
            "strings": self.strings,
            "campaign": self.campaign,
            "environment": self.environment,
            "check": self.check,
            "cloud-table": self.cloud_table,
            "cloud-proof": self.cloud_proof,
            "drift-table": self.drift_table,
        }

    def _field(self, name: str) -> adr_opt.Instance:
        family, seed, sizes = FIELDS[self._tiny][name]
        return adr_opt.generate(family, seed, **sizes)

    @cached_property
    def _mission(self) -> adr_opt.Mission:
        return _ready(self._field("alone"))

    @cached_property
    def _drifting(self) -> adr_opt.Mission:
        return _ready(self._field("drifting"))

    @cached_property
    def _several(self) -> adr_opt.Instance:
        return self._field("several")

    @cached_property
    def _cloud(self) -> adr_opt.Instance:
        return _by_free_burns(self._field("cloud"))

    @cached_property
    def _ellipses(self) -> adr_opt.Instance:
        """Legs of months between eccentricities up to 0.015."""
        rng, field = random.Random(0), self._field("drifting")
        targets = []
        for target in field.targets:
            assert target.orbit is not None
            shape = {
                "eccentricity": 0.015 * rng.random(),
                "argument_of_perigee_deg": 360.0 * rng.random(),
            }
            targets.append(target.replace(orbit=target.orbit.replace(**shape)))
        return _by_free_burns(field.replace(targets=tuple(targets)))

    @cached_property
    def _plan(self) -> adr_opt.Plan:
        plan = adr_opt.solve(self._mission, "greedy-guarded", time_limit=LIMIT_S).plan
        assert plan is not None
        return plan

    @cached_property
    def _env(self) -> Any:
        from adr_opt.learning.environment import MissionEnv

        return MissionEnv(self._mission.instance)

    def timetable(self) -> Any:
        """The timetable of one chaser, on one core."""
        return adr_opt.Timetable(self._mission.instance, 1).entries

    def cloud_table(self) -> Any:
        """The timetable of a cloud, on one core."""
        return adr_opt.Timetable(self._cloud, 1).entries

    def drift_table(self) -> Any:
        """The timetable of drifts between eccentric orbits, on one core."""
        return adr_opt.Timetable(self._ellipses, 1).entries

    def cloud_proof(self) -> Any:
        """A proof of a cloud, its timetable included."""
        return self._solved(_ready(self._cloud), "exact", 10, most_labels=MOST_LABELS)

    def sweeps(self) -> Any:
        """Network and sweeps of the bound by walks, from a ready timetable."""
        return _outcome(
            adr_opt.bound(self._mission, "lagrangian", time_limit=LIMIT_S, iterations=5, jobs=1)
        )

    def beam(self) -> Any:
        """The beam as it is by default."""
        return _outcome(adr_opt.solve(self._mission, "beam", time_limit=LIMIT_S))

    def auto(self) -> Any:
        """Beams, recreations and a first sweep."""
        return self._solved(self._mission, "auto", 2, most_labels=MOST_LABELS)

    def exact(self) -> Any:
        """A proof with sweeps and searches by labels."""
        return self._solved(self._mission, "exact", 10, most_labels=MOST_LABELS)

    def strings(self) -> Any:
        """Orders annealed where planes drift, without a proof."""
        return self._solved(self._drifting, "auto", 2, prove=False)

    def campaign(self) -> Any:
        """Routes of several chasers and a first bound; timetables are kept from the first time."""
        return self._solved(self._several, "exact", 1)

    def environment(self) -> Any:
        """Steps with masks and observations; the choice of actions is next to nothing."""
        self._env.reset(seed=0)
        total = 0.0
        for k in range(STEPS[self._tiny]):
            legal = self._env.action_masks().nonzero()[0]
            _, reward, over, cut, _ = self._env.step(legal[k % len(legal)])
            total += reward
            if over or cut:
                self._env.reset()
        return total

    def check(self) -> Any:
        """The checker, on the plan of the guarded greedy again and again."""
        instance, plan = self._mission.instance, self._plan
        return [len(adr_opt.check(instance, plan)) for _ in range(CHECKS[self._tiny])]

    def _solved(self, problem: Any, method: str, iterations: int, **options: Any) -> Any:
        return _outcome(
            adr_opt.solve(
                problem, method, time_limit=LIMIT_S, iterations=iterations, jobs=1, **options
            )
        )


def _by_free_burns(instance: adr_opt.Instance) -> adr_opt.Instance:
    """The same under J2, by free burns where the version has their price."""
    field = instance.replace(dynamics="j2")
    if not hasattr(field.transfer, "burns"):
        return field
    return field.replace(transfer=field.transfer.replace(burns="free"))


def _ready(instance: adr_opt.Instance) -> adr_opt.Mission:
    """The mission with its timetable."""
    mission = adr_opt.Mission(instance)
    _ = mission.timetable
    return mission


def _outcome(result: adr_opt.Result) -> Any:
    """Bound, counters and routes, for comparison."""
    routes = [] if result.plan is None else result.plan.routes
    return {
        "objective": result.objective,
        "upper_bound": result.upper_bound,
        "counters": dict(result.counters),
        "routes": [[leg.destination for leg in route.legs] for route in routes],
    }


def serve(works: Works, asked: TextIO, answers: TextIO) -> None:
    """Do what is asked for, a name a line, until there is no more."""
    greeting = {"code": adr_opt.__file__, "works": list(works.all)}
    print(json.dumps(greeting), file=answers, flush=True)
    for line in asked:
        work = works.all[line.strip()]
        began, spent = time.perf_counter(), time.process_time()
        outcome = work()
        row = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - spent}
        print(json.dumps({**row, "outcome": outcome}), file=answers, flush=True)


def main() -> None:
    """Serve requests on standard input."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--tiny", action="store_true", help="on tiny fields")
    arguments = parser.parse_args()
    answers = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        serve(Works(arguments.tiny), sys.stdin, answers)


if __name__ == "__main__":
    main()
