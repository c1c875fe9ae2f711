"""Runs stopped at a tenth of the time of their proof: the share of the optimum that they have.

    python bench/tenth.py
    python bench/tenth.py --families nominal campaign --count 3 --limit 120

Plans ``--count`` fields of each family until they are proven, and again within a tenth of that
time, from nothing, both with a ready timetable and in one process, so that kernels are compiled.
Families are those of `adr-opt generate` and the kinds of drawn orienteering
(``contest/orienteering.py``). Fields that are not proven within the limit are left out, and so are
those proven within ``--least`` seconds, of which a tenth is no time to measure.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Iterator
from typing import NamedTuple

from contest.orienteering import KINDS, draw, instance_of
from machine import heading

import adr_opt
from adr_opt.mission.problem import problem_of

FAMILIES = ("nominal", "reduced-time", "rocket-bodies", "campaign", "removal", *KINDS)


class Stopped(NamedTuple):
    """A field, planned twice.

    Attributes
    ----------
    proven_s : float
        Time of the proof [s].
    optimum, stopped : float
        Prizes of the proven plan, and after a tenth of the time.
    """

    proven_s: float
    optimum: float
    stopped: float


def instance_named(family: str, seed: int) -> adr_opt.Instance:
    """A field of a family or of a kind of orienteering."""
    if family in KINDS:
        return instance_of(draw(family, seed, 100))
    return adr_opt.generate(family, seed)


def planned(instance: adr_opt.Instance, limit_s: float) -> adr_opt.Result:
    """A plan within a limit that starts with a ready timetable."""
    problem = problem_of(instance)
    for mission in problem.missions:
        mission.rules  # noqa: B018  builds the timetable
    result = adr_opt.solve(problem, "auto", time_limit=limit_s)
    assert result.plan is None or adr_opt.check(instance, result.plan) == ()
    return result


def stopped(instance: adr_opt.Instance, limit_s: float, least_s: float) -> Stopped | None:
    """Plan a field twice; None where the proof takes too long, or hardly any time."""
    whole = planned(instance, limit_s)
    if whole.status != "optimal" or whole.runtime_s < least_s:
        return None
    early = planned(instance, 0.1 * whole.runtime_s)
    return Stopped(whole.runtime_s, whole.objective, early.objective if early.plan else 0.0)


def lines(
    families: list[str], seeds: range, limit_s: float, least_s: float
) -> Iterator[tuple[str, list[float]]]:
    """A line of the table for each family, with the shares of its fields."""
    for family in families:
        tried = [stopped(instance_named(family, seed), limit_s, least_s) for seed in seeds]
        found = [each for each in tried if each is not None]
        shares = [each.stopped / each.optimum for each in found]
        if not found:
            yield f"| {family} | 0 of {len(tried)} | – | – | – |", []
            continue
        times = statistics.median(each.proven_s for each in found)
        yield (
            f"| {family} | {len(found)} of {len(tried)} | {times:.1f} s "
            f"| {statistics.mean(shares):.1%} | {min(shares):.1%} |",
            shares,
        )


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--families", nargs="+", default=list(FAMILIES))
    parser.add_argument("--count", type=int, default=5, help="fields of each family [5]")
    parser.add_argument("--first-seed", type=int, default=0, help="seed of the first of them [0]")
    parser.add_argument("--limit", type=float, default=120.0, help="of a proof [120 s]")
    parser.add_argument("--least", type=float, default=0.5, help="shortest proof [0.5 s]")
    parsed = parser.parse_args()
    print(heading())
    print("| family | proven | time, median | share, mean | share, least |\n|---|---|---|---|---|")
    planned(instance_named("tiny", 0), 5.0)  # compiles
    every: list[float] = []
    seeds = range(parsed.first_seed, parsed.first_seed + parsed.count)
    for line, shares in lines(parsed.families, seeds, parsed.limit, parsed.least):
        print(line, flush=True)
        every += shares
    if every:
        print(f"\n{len(every)} fields: {statistics.mean(every):.1%} of the optimum in the mean")
    return 0


if __name__ == "__main__":
    sys.exit(main())
