"""Refined plans on eccentric orbits: planned against flown, in total and leg by leg.

    python bench/refine_clouds.py [CATALOGUE...]

Clouds as drawn, nominal fields with eccentricities up to 0.02, and catalogue files, all under J2:
planned, refined with the plan's own burns and with free ones, and flown by `fly`. Errors are those
of what was planned, as shares of what is flown. Without catalogues those of the folder
ADR_OPT_EXTERNAL_DATA are taken, if it is named.

    python bench/refine_clouds.py --change-weights 0.001 0.5 0.667 1 --first 3 --seeds 4

The plan's own burns alone, on nominal fields of circles too, for other weights of what they are
changed by: next to nothing is the least ΔV at the plan's times.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from machine import heading

import adr_opt
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.flight.refined_result import RefinedFlight
from adr_opt.fly.refine import one_leg
from adr_opt.fly.refine.own_burns import cheapest_near
from adr_opt.plan.refined_plan import Freedom, RefinedPlan
from adr_opt.sources.catalogue import read, to_instance

ECCENTRICITY = 0.02
"""Largest eccentricity of the modified nominal fields."""

TOTAL, LEG, POSITION_M, SPEED_M_S = 0.05, 0.15, 10.0, 0.01
"""Targets: error in total, mean error of a leg, and largest misses of an arrival."""

FREEDOMS: tuple[Freedom, ...] = "planned", "free"


def eccentric(family: str, seed: int) -> adr_opt.Instance:
    """A field of circles with other shapes: eccentricities and perigees drawn uniform."""
    instance = adr_opt.generate(family, seed)
    rng = np.random.default_rng(seed)
    targets = tuple(
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=ECCENTRICITY * float(rng.random()),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            )
        )
        for target in instance.targets
    )
    return instance.replace(targets=targets)


def fields(seeds: range, catalogues: list[Path], targets: int) -> Iterator[tuple[str, str, object]]:
    """Names, names of kinds, and instances, drawn ones first."""
    for seed in seeds:
        instance = adr_opt.generate("cloud", seed).replace(dynamics="j2")
        yield instance.name, "clouds as drawn", instance
    for seed in seeds:
        instance = eccentric("nominal", seed).replace(dynamics="j2")
        yield f"{instance.name}, e to {ECCENTRICITY:g}", "nominal, eccentric", instance
    for path in catalogues:
        found = to_instance(read(path), max_targets=targets, skip_bad=True)
        yield path.stem, "catalogues", found.instance


def errors(*plans: RefinedPlan) -> tuple[float, float]:
    """Differences between planned and flown ΔV: in total, and the mean of the legs."""
    planned = np.array([leg.planned_delta_v_m_s for plan in plans for leg in plan.legs])
    flown = np.array([leg.flown_delta_v_m_s for plan in plans for leg in plan.legs])
    return float(planned.sum() / flown.sum() - 1.0), float(np.abs(planned / flown - 1.0).mean())


def worst(flights: list[RefinedFlight]) -> tuple[float, float]:
    """Largest misses, in position and in velocity."""
    return (
        max(flight.worst_miss_m for flight in flights),
        max(flight.worst_miss_m_s for flight in flights),
    )


def print_weights(
    weights: list[float], seeds: range, catalogues: list[Path], arguments: argparse.Namespace
) -> None:
    """Print what the plan's own burns come to for weights of their changes."""
    circles = (adr_opt.generate("nominal", seed).replace(dynamics="j2") for seed in seeds)
    found: dict[str, dict[float, list[RefinedPlan]]] = {}
    for kind, instance in (
        *(("nominal, circles", instance) for instance in circles),
        *(one[1:] for one in fields(seeds, catalogues, arguments.targets)),
    ):
        assert isinstance(instance, adr_opt.Instance)
        plan = adr_opt.solve(instance, arguments.method, time_limit=100.0, seed=0).plan
        assert plan is not None
        for weight in weights:
            with patch.object(one_leg, "cheapest_near", partial(cheapest_near, weight=weight)):
                refined = adr_opt.refine(instance, plan, freedom="planned", jobs=arguments.jobs)
            assert not refined.missing
            found.setdefault(kind, {}).setdefault(weight, []).append(refined)
    print("\n| fields |" + "".join(f" {weight:g} | worst field |" for weight in weights))
    print("|---" * (1 + 2 * len(weights)) + "|")
    for kind, by_weight in found.items():
        cells = []
        for plans in by_weight.values():
            total, leg = errors(*plans)
            farthest = max((errors(one)[0] for one in plans), key=abs)
            cells += [f"{total:+.1%}, {leg:.1%}", f"{farthest:+.1%}"]
        print(f"| {kind} | {' | '.join(cells)} |")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("catalogues", nargs="*", type=Path, metavar="CATALOGUE")
    parser.add_argument("--seeds", type=int, default=3, help="of either family")
    parser.add_argument("--first", type=int, default=0, help="of the seeds")
    parser.add_argument("--change-weights", type=float, nargs="+", metavar="WEIGHT")
    parser.add_argument("--targets", type=int, default=60, help="taken of each catalogue")
    parser.add_argument("--method", default="greedy-guarded")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    catalogues = arguments.catalogues
    if not catalogues and (folder := os.environ.get("ADR_OPT_EXTERNAL_DATA")):
        catalogues = sorted([*Path(folder).glob("tle/*.txt"), *Path(folder).glob("omm/cele*.csv")])
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    print(heading())
    if arguments.change_weights:
        print_weights(arguments.change_weights, seeds, catalogues, arguments)
        return
    print(
        f"\nplanned by {arguments.method}; planned against flown: in total, mean error of a leg\n\n"
        "| field | legs | planned m/s | missing | own burns | a leg | free burns | a leg | "
        "worst miss |"
    )
    print("|---" * 9 + "|")
    sums: dict[str, dict[Freedom, list[RefinedPlan]]] = {}
    held = []
    for name, kind, instance in fields(seeds, catalogues, arguments.targets):
        assert isinstance(instance, adr_opt.Instance)
        plan = adr_opt.solve(instance, arguments.method, time_limit=100.0, seed=0).plan
        assert plan is not None
        both = {
            freedom: adr_opt.refine(instance, plan, freedom=freedom, jobs=arguments.jobs)
            for freedom in FREEDOMS
        }
        position, speed = worst([fly_refined(instance, one) for one in both.values()])
        missing = sum(len(one.missing) for one in both.values())
        held.append(position <= POSITION_M and speed <= SPEED_M_S and not missing)
        cells = [cell for one in both.values() for cell in _cells(one)]
        print(
            f"| {name} | {len(plan.legs)} | {plan.delta_v_m_s:.1f} | {missing} | "
            f"{' | '.join(cells)} | {1e3 * position:.2g} mm, {1e6 * speed:.2g} µm/s |",
            flush=True,
        )
        for freedom, one in both.items():
            sums.setdefault(kind, {}).setdefault(freedom, []).append(one)
    for kind, by_freedom in sums.items():
        cells = []
        for plans in by_freedom.values():
            cells += _cells(*plans)
        legs = sum(len(plan.legs) for plan in plans)
        planned = sum(plan.planned_delta_v_m_s for plan in plans)
        print(f"| **{kind}** | {legs} | {planned:.1f} | | {' | '.join(cells)} | |")
    print(
        f"\nWanted: {TOTAL:.0%} in total, {LEG:.0%} for a leg, {POSITION_M:g} m and "
        f"{SPEED_M_S:g} m/s. Misses are within that on {sum(held)} of {len(held)} fields."
    )


def _cells(*plans: RefinedPlan) -> list[str]:
    total, leg = errors(*plans)
    return [f"{total:+.1%}", f"{leg:.1%}"]


if __name__ == "__main__":
    main()
