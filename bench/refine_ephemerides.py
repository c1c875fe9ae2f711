"""Plans refined onto ephemerides, against the same legs refined under J2.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/refine_ephemerides.py [CATALOGUE]

Imports the 60 targets of Iridium 33 with the nearest planes, for a week, with their element sets
beside the instance; plans, refines onto SGP4 in the field to J4, and flies the result. Each leg is
compared with itself between the bodies that the plan was made with: their mean elements, drag
included, with the short-period variations of J2, in the field of J2. Prints legs and totals as
Markdown, the misses that ``fly`` finds, the estimated ΔV of holding, and the time that it takes.
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from machine import heading

import adr_opt
from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.fly.flight import RefinedFlight, fly_refined
from adr_opt.fly.refine.bodies import Gravity
from adr_opt.fly.refine.one_leg import refine_leg
from adr_opt.kernels.orbits import elements
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import Array, osculating
from adr_opt.plan.plan import Leg, Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue
from adr_opt.sources.ephemerides.imported import with_ephemerides

TARGETS, DAYS = 60, 7.0
METHODS = ("auto", "greedy-guarded", "beam")
TIME_LIMIT_S = 60.0


class PlannedBodies:
    """Bodies where the plan has them: mean elements with short-period variations of J2."""

    gravity: Gravity = "j2"

    def __init__(self, instance: Instance) -> None:
        self._rows = {
            name: np.array(orbit.row(OBLATENESS_M2, instance.decay_of(name)))
            for name, orbit in zip(instance.names, instance.body_orbits, strict=True)
        }
        self.epoch_states = {name: self.state(name, 0.0) for name in self._rows}

    def state(self, name: str, time_s: float) -> Array:
        """Osculating state at a time, shape (6,)."""
        return osculating(*elements.equinoctial_at(self._rows[name], time_s), FIELDS["j2"])

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of the point behind a body, shape (6,)."""
        speed = math.hypot(*self.state(name, time_s)[3:])
        return self.state(name, time_s - length_m / speed)


class Compared(NamedTuple):
    """A plan, refined both ways."""

    plan: Plan
    onto: RefinedPlan
    under_j2: dict[int, float]
    flight: RefinedFlight
    seconds: float


def main() -> None:
    """Measure and print."""
    path = Path(sys.argv[1]) if sys.argv[1:] else _default()
    print(f"{heading()}\n")
    with tempfile.TemporaryDirectory() as folder:
        instance = _imported(path, Path(folder))
        found = {method: _compare(instance, method) for method in METHODS}
    first = found[METHODS[0]]
    print(f"`{METHODS[0]}`, leg by leg:\n")
    print(
        "| leg | planned m/s | refined, J2 | onto SGP4 | more % | holding m/s "
        "| stand-off m | mm/s |\n|---|---|---|---|---|---|---|---|"
    )
    for leg, flown in zip(first.onto.legs, first.flight.legs, strict=True):
        before = first.under_j2.get(leg.leg, math.nan)
        print(
            f"| {leg.leg} | {leg.planned_delta_v_m_s:.1f} | {before:.1f} "
            f"| {leg.flown_delta_v_m_s:.1f} | {100.0 * (leg.flown_delta_v_m_s / before - 1.0):+.2f}"
            f" | {leg.holding_m_s:.2f} | {flown.standoff_miss_m:.1e} "
            f"| {1e3 * flown.standoff_miss_m_s:.1e} |"
        )
    print(
        "\n| planner | legs | refined | planned m/s | refined, J2 | onto SGP4 | median leg % "
        "| 90 % | total % | worst miss | holding m/s | a revolution | s |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    )
    for method, one in found.items():
        print(f"| `{method}` | {_row(one)} |")


def _default() -> Path:
    (found,) = Path(os.environ["ADR_OPT_EXTERNAL_DATA"]).glob("tle/*iridium-33*")
    return found


def _imported(path: Path, folder: Path) -> Instance:
    """The targets with the nearest planes, fitted, with their element sets beside them."""
    made = catalogue.to_instance(
        catalogue.read(path, skip_bad=True),
        max_targets=TARGETS,
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=DAYS * DAY_S),
    )
    with_ephemerides(made, folder / "field.json").write(folder / "field.json")
    return adr_opt.load(folder / "field.json")


def _compare(instance: Instance, method: str) -> Compared:
    plan = adr_opt.solve(instance, method, time_limit=TIME_LIMIT_S).plan
    assert plan is not None
    adr_opt.refine(instance, plan, ephemerides=True)  # kernels are loaded on first use
    begin = time.perf_counter()
    onto = adr_opt.refine(instance, plan, ephemerides=True)
    seconds = time.perf_counter() - begin
    bodies = PlannedBodies(instance)
    under_j2 = dict(_under_j2(instance, bodies, plan.legs))
    return Compared(plan, onto, under_j2, fly_refined(instance, onto), seconds)


def _under_j2(
    instance: Instance, bodies: PlannedBodies, legs: tuple[Leg, ...]
) -> Iterator[tuple[int, float]]:
    for number, leg in enumerate(legs, start=1):
        try:
            yield number, refine_leg(instance, bodies, number, leg, "free").flown_delta_v_m_s
        except ArithmeticError as error:
            print(f"leg {number} under J2: {error}", file=sys.stderr)


def _row(one: Compared) -> str:
    legs = [leg for leg in one.onto.legs if leg.leg in one.under_j2]
    ratios = np.array([leg.flown_delta_v_m_s / one.under_j2[leg.leg] for leg in legs]) - 1.0
    before = math.fsum(one.under_j2[leg.leg] for leg in legs)
    total = math.fsum(leg.flown_delta_v_m_s for leg in legs) / before - 1.0
    revolutions = math.fsum(
        (leg.states[0].time_s - leg.ready_s + leg.end_s - leg.arrival_s) for leg in one.onto.legs
    )
    return (
        f"{len(one.plan.legs)} | {len(one.onto.legs)} | {one.onto.planned_delta_v_m_s:.1f} "
        f"| {before:.1f} | {one.onto.flown_delta_v_m_s:.1f} | {100.0 * np.median(ratios):+.2f} "
        f"| {100.0 * np.quantile(ratios, 0.9):+.2f} | {100.0 * total:+.2f} "
        f"| {1e3 * one.flight.worst_miss_m:.1f} mm, {1e3 * one.flight.worst_miss_m_s:.1e} mm/s "
        f"| {one.onto.holding_m_s:.1f} | {one.onto.holding_m_s / (revolutions / 5900.0):.2f} "
        f"| {one.seconds:.1f} |"
    )


if __name__ == "__main__":
    main()
