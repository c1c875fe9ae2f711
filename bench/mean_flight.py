"""Accuracy of flight in mean motion against integrated motion, and its speed.

    python bench/mean_flight.py

Fields whose nodes drift, with eccentric orbits, planned by ``greedy-guarded``: what each family of
legs is planned with, what `solve` says that it takes on the true orbits, and what the plan's own
burns take when they are refined in the field J2, by an integrator that shares nothing with mean
motion but the way in which burns are chosen.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator

import numpy as np

import adr_opt
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.fly.refine import refine
from adr_opt.problem.instance import Instance


def eccentric(instance: Instance, most: float, seed: int) -> Instance:
    """The field under J2, with eccentricities drawn up to some value."""
    rng = np.random.default_rng(seed)
    targets = tuple(
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=float(rng.uniform(0.0, most)),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            )
        )
        for target in instance.targets
    )
    return instance.replace(dynamics="j2", targets=targets)


def fields(seeds: int) -> Iterator[tuple[str, Instance]]:
    """The fields by name."""
    for seed in range(seeds):
        yield f"cloud-{seed:03d}", adr_opt.generate("cloud", seed).replace(dynamics="j2")
    for seed in range(seeds):
        nominal = adr_opt.generate("nominal", seed)
        yield f"nominal-{seed:03d}, e to 0.02", eccentric(nominal, 0.02, seed)
    for seed in range(seeds):
        bodies = adr_opt.generate("rocket-bodies", seed)
        yield f"rocket-bodies-{seed:03d}, e to 0.015", eccentric(bodies, 0.015, seed)


def row(name: str, instance: Instance) -> list[str]:
    """Results of one field."""
    plan = adr_opt.solve(instance, "greedy-guarded", time_limit=60.0).plan
    assert plan is not None
    began = time.process_time()
    flight = fly_mean(instance, plan)
    assert flight is not None
    took = time.process_time() - began
    began = time.process_time()
    refined = refine(instance, plan, gravity="j2", freedom="planned", jobs=1)
    refining = time.process_time() - began
    both = [
        (flown, leg.flown_delta_v_m_s)
        for leg in refined.legs
        if (flown := flight.flown[leg.leg]) is not None
    ]
    planned = [leg for leg in plan.legs if leg.kind != "launch"]
    mean, true = (math.fsum(side) for side in zip(*both, strict=True))
    apart = [abs(flown / integrated - 1.0) for flown, integrated in both]
    return [
        name,
        str(len(planned)),
        str(sum(leg.kind == "drift" for leg in planned)),
        f"{math.fsum(leg.delta_v_m_s for leg in planned):.1f} m/s",
        f"{mean:.1f} m/s",
        f"{true:.1f} m/s",
        f"{100.0 * (mean / true - 1.0):+.2f} %, {100.0 * math.fsum(apart) / len(apart):.2f} %",
        f"{len(flight.problems)}, {len(refined.missing)}",
        f"{took / len(planned):.3f} s, {refining / len(planned):.2f} s",
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2, help="fields of each family")
    seeds = parser.parse_args().seeds
    headings = [
        "field",
        "legs",
        "drifts",
        "planned",
        "mean motion",
        "integrated",
        "apart: total, a leg",
        "not led: mean, integrated",
        "a leg takes",
    ]
    first = next(fields(1))[1]
    fly_mean(first, adr_opt.solve(first, "greedy-guarded").plan)  # compiles
    print("| " + " | ".join(headings) + " |")
    print("|" + "---|" * len(headings))
    for name, instance in fields(seeds):
        print("| " + " | ".join(row(name, instance)) + " |", flush=True)


if __name__ == "__main__":
    main()
