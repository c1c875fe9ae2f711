"""Flown cost of legs from what is known before: formulas fitted, and judged on other legs.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/refine_fit.py

The instances of `refine_loop.py`, planned once and refined. Of each instance's legs of a kind a
fourth is held back in turn, the formula is fitted on the others by least squares in m/s, and its
error on those held back is told: mean of the legs, and mean size of the error in total of the
instances. Formulas are sums of the terms named, each times a coefficient: P is the planned ΔV, T
that of the turn of the plane alone, E = v |Δe| / 2, and 1/days what phase costs the more of the
less time there is.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

import numpy as np
from machine import heading
from refine_loop import instances

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.trajectory.bodies import body_states
from adr_opt.kernels.orbits.eccentricity import matchings
from adr_opt.plan.refined_plan import RefinedLeg
from adr_opt.problem.instance import Instance

FOLDS = 4

LEAST_LEGS = 8
"""Least number of legs of a kind; an instance with fewer is omitted."""

Terms = Callable[[float, float, float, float], list[float]]

FORMULAS: dict[str, Terms] = {
    "P": lambda p, t, e, days: [p],
    "P + 1": lambda p, t, e, days: [p, 1.0],
    "P + 1/days": lambda p, t, e, days: [p, 1.0 / days],
    "P + E": lambda p, t, e, days: [p, e],
    "P + T": lambda p, t, e, days: [p, t],
    "P + T + E": lambda p, t, e, days: [p, t, e],
    "hypot(T, P − T)": lambda p, t, e, days: [math.hypot(t, p - t)],
    "P + hypot(T, P − T)": lambda p, t, e, days: [p, math.hypot(t, p - t)],
}


def known(instance: Instance, leg: RefinedLeg, matching: np.ndarray) -> tuple[float, ...]:
    """P, T and E of a leg [m/s], and its days."""
    states = [
        [each[0] for each in body_states(instance, name, leg.standoff_s)]
        for name in (leg.origin, leg.destination)
    ]
    normals = [np.cross(*state) for state in states]
    first, second = (normal / np.linalg.norm(normal) for normal in normals)
    turn = float(np.linalg.norm(states[1][1]) * np.linalg.norm(first - second))
    number = instance.names.index
    shape = float(matching[number(leg.origin), number(leg.destination)])
    days = (leg.standoff_s - leg.burns[0].time_s) / DAY_S
    return leg.planned_delta_v_m_s, turn, shape, days


def judged(terms: Terms, legs: list[tuple[tuple[float, ...], float]]) -> tuple[np.ndarray, float]:
    """Errors of the legs, each by a fit that has not seen it, and their error in total."""
    rows = np.array([terms(*given) for given, _ in legs])
    flown = np.array([cost for _, cost in legs])
    fold = np.random.default_rng(0).permutation(flown.size) % FOLDS
    told = np.empty(flown.size)
    for one in range(FOLDS):
        fitted = np.linalg.lstsq(rows[fold != one], flown[fold != one], rcond=None)[0]
        told[fold == one] = rows[fold == one] @ fitted
    return told / flown - 1.0, float(told.sum() / flown.sum() - 1.0)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--method", default="greedy-guarded")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="instances whose name holds this")
    arguments = parser.parse_args()
    print(heading())
    found: dict[tuple[str, str], list[list[tuple[tuple[float, ...], float]]]] = {}
    for instance in instances():
        if arguments.only not in instance.name:
            continue
        plan = adr_opt.solve(instance, arguments.method, time_limit=30.0, seed=0).plan
        assert plan is not None
        matching = matchings(instance.orbits(), 0.0)
        for freedom in ("free", "planned"):
            refined = adr_opt.refine(instance, plan, freedom=freedom, jobs=arguments.jobs)
            for kind in ("short", "drift"):
                legs = [
                    (known(instance, leg, matching), leg.flown_delta_v_m_s)
                    for leg in refined.legs
                    if leg.kind == kind
                ]
                if len(legs) >= LEAST_LEGS:
                    found.setdefault((freedom, kind), []).append(legs)
    print("\n| burns, legs | instances, legs |" + "".join(f" {name} |" for name in FORMULAS))
    print("|---" * (2 + len(FORMULAS)) + "|")
    for (freedom, kind), by_instance in found.items():
        cells = []
        for terms in FORMULAS.values():
            errors, totals = zip(*(judged(terms, legs) for legs in by_instance), strict=True)
            leg = np.abs(np.concatenate(errors)).mean()
            cells.append(f"{leg:.1%}, {np.abs(totals).mean():.1%}")
        count = f"{len(by_instance)}, {sum(map(len, by_instance))}"
        print(f"| {freedom}, {kind} | {count} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
