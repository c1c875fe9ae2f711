"""Plans refined onto ephemerides, against the same legs refined under J2.

    ADR_OPT_EXTERNAL_DATA=FOLDER python bench/refine_ephemerides.py [CATALOGUE...]

Imports the 60 targets with the nearest planes, for a week, with their element sets beside the
instance; plans, refines onto SGP4 in the field to J4, and flies the result. By default that is done
with the catalogues of Iridium 33 in the folder. Each leg is compared with itself between the bodies
that the plan was made with: their mean elements, drag included, with the short-period variations of
J2, in the field of J2; once as refinement under J2 has them, and once with the constant part of the
eccentricity that was fitted, too. Prints the legs of the first plan and the totals of all as
Markdown, the misses that ``fly`` finds, the estimated ΔV of holding, and the time that refinement
takes; before them, where a chaser is that is let go on a state by SGP4, and the ΔV of holding by
the number of impulses in a revolution.
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
from adr_opt.fly.refine.bodies import Gravity, moved
from adr_opt.fly.refine.one_leg import refine_leg
from adr_opt.fly.refine.reported import following_m_s
from adr_opt.kernels.orbits import elements
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import Array, osculating
from adr_opt.plan.plan import Leg, Plan
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.sources import catalogue
from adr_opt.sources.ephemerides import ephemerides_of
from adr_opt.sources.ephemerides.imported import with_ephemerides

TARGETS, DAYS = 60, 7.0
METHODS = ("auto", "greedy-guarded", "beam")
TIME_LIMIT_S = 60.0

LET_GO_S = 6000.0

REVOLUTION_S = 5900.0
"""About that of the objects."""


class PlannedBodies:
    """Bodies where the plan has them: mean elements with short-period variations of J2.

    With ``whole`` the fitted constant part of the eccentricity is added.
    """

    gravity: Gravity = "j2"

    def __init__(self, instance: Instance, *, whole: bool) -> None:
        fits = {target.name: target.fit for target in instance.targets if whole}
        self._offsets = {name: fit.eccentricity_offset for name, fit in fits.items() if fit}
        self._rows = {
            name: np.array(orbit.row(OBLATENESS_M2, instance.decay_of(name)))
            for name, orbit in zip(instance.names, instance.body_orbits, strict=True)
        }
        self.epoch_states = {name: self.state(name, 0.0) for name in self._rows}

    def state(self, name: str, time_s: float) -> Array:
        """Osculating state at a time, shape (6,)."""
        mean, frame = elements.equinoctial_at(self._rows[name], time_s)
        mean[1:3] += self._offsets.get(name, (0.0, 0.0))
        return osculating(mean, frame, FIELDS["j2"])

    def following(self, name: str, time_s: float, length_m: float) -> Array:
        """State of the point behind a body, shape (6,)."""
        speed = math.hypot(*self.state(name, time_s)[3:])
        return self.state(name, time_s - length_m / speed)


class Compared(NamedTuple):
    """A plan, refined both ways."""

    plan: Plan
    onto: RefinedPlan
    under_j2: dict[int, float]
    on_fits: dict[int, float]
    flight: RefinedFlight
    seconds: float


def main() -> None:
    """Measure and print."""
    files = [Path(path) for path in sys.argv[1:]] or _default()
    print(f"{heading()}\n")
    found: dict[tuple[str, str], Compared] = {}
    for path in files:
        with tempfile.TemporaryDirectory() as folder:
            instance = _imported(path, Path(folder))
            if not found:
                _print_holding(instance)
            for method in METHODS:
                found[path.stem, method] = _compare(instance, method)
    first = next(iter(found.values()))
    print("The first plan, leg by leg:\n")
    print(
        "| leg | planned m/s | J2 | fitted | onto SGP4 | to J2 % | to fitted % | holding m/s "
        "| stand-off m | mm/s |\n|---|---|---|---|---|---|---|---|---|---|"
    )
    for leg, flown in zip(first.onto.legs, first.flight.legs, strict=True):
        befores = [one.get(leg.leg, math.nan) for one in (first.under_j2, first.on_fits)]
        shares = [f"{100.0 * (leg.flown_delta_v_m_s / before - 1.0):+.2f}" for before in befores]
        print(
            f"| {leg.leg} | {leg.planned_delta_v_m_s:.1f} | {befores[0]:.1f} | {befores[1]:.1f} "
            f"| {leg.flown_delta_v_m_s:.1f} | {' | '.join(shares)} | {leg.holding_m_s:.2f} "
            f"| {flown.standoff_miss_m:.1e} | {1e3 * flown.standoff_miss_m_s:.1e} |"
        )
    print(
        "\n| catalogue | planner | legs | refined | planned m/s | onto SGP4 "
        "| to J2: median leg % | 90 % | total % | to fitted: median leg % | 90 % | total % "
        "| worst miss | holding m/s | a revolution | s |\n"
        f"{'|---' * 16}|"
    )
    for (name, method), one in found.items():
        print(f"| {name} | `{method}` | {_row(one)}")


def _default() -> list[Path]:
    folder = Path(os.environ["ADR_OPT_EXTERNAL_DATA"])
    return [*folder.glob("tle/*iridium-33*"), *folder.glob("omm/*iridium-33*")]


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


def _print_holding(instance: Instance) -> None:
    """Objects of an instance, a day after the epoch."""
    known = ephemerides_of(instance)
    states = [known.of(name) for name in known.bodies]
    away = []
    for ephemeris in states:
        begin, end = ephemeris.state([DAY_S, DAY_S + LET_GO_S])
        away.append(math.dist(moved(begin, LET_GO_S, "j4")[:3], end[:3]))
    print(
        f"Let go on a state by SGP4, {LET_GO_S:g} s later {np.median(away):.0f} m away in the "
        f"median over {len(away)} objects, {max(away):.0f} m at most.\n"
    )
    print("| impulses a revolution | holding m/s a revolution | 90 % | most |\n|---|---|---|---|")
    for impulses in (4, 8, 12, 24, 60):
        times = DAY_S + np.linspace(0.0, 5.0 * REVOLUTION_S, 5 * impulses + 1)
        taken = [following_m_s(one.state(times), times, "j4") / 5.0 for one in states]
        print(
            f"| {impulses} | {np.median(taken):.2f} | {np.quantile(taken, 0.9):.2f} "
            f"| {max(taken):.2f} |"
        )
    print()


def _compare(instance: Instance, method: str) -> Compared:
    plan = adr_opt.solve(instance, method, time_limit=TIME_LIMIT_S).plan
    assert plan is not None
    adr_opt.refine(instance, plan, ephemerides=True)  # kernels are loaded on first use
    begin = time.perf_counter()
    onto = adr_opt.refine(instance, plan, ephemerides=True)
    seconds = time.perf_counter() - begin
    under_j2, on_fits = (
        dict(_between(instance, PlannedBodies(instance, whole=whole), plan.legs))
        for whole in (False, True)
    )
    return Compared(plan, onto, under_j2, on_fits, fly_refined(instance, onto), seconds)


def _between(
    instance: Instance, bodies: PlannedBodies, legs: tuple[Leg, ...]
) -> Iterator[tuple[int, float]]:
    for number, leg in enumerate(legs, start=1):
        try:
            yield number, refine_leg(instance, bodies, number, leg, "free").flown_delta_v_m_s
        except ArithmeticError as error:
            print(f"leg {number}: {error}", file=sys.stderr)


def _shares(one: Compared, before: dict[int, float]) -> str:
    legs = [leg for leg in one.onto.legs if leg.leg in before]
    ratios = np.array([leg.flown_delta_v_m_s / before[leg.leg] for leg in legs]) - 1.0
    total = math.fsum(leg.flown_delta_v_m_s for leg in legs)
    total = total / math.fsum(before[leg.leg] for leg in legs) - 1.0
    shares = float(np.median(ratios)), float(np.quantile(ratios, 0.9)), total
    return " | ".join(f"{100.0 * share:+.2f}" for share in shares)


def _row(one: Compared) -> str:
    beside_s = math.fsum(
        leg.states[0].time_s - leg.ready_s + leg.end_s - leg.arrival_s for leg in one.onto.legs
    )
    return (
        f"{len(one.plan.legs)} | {len(one.onto.legs)} | {one.onto.planned_delta_v_m_s:.1f} "
        f"| {one.onto.flown_delta_v_m_s:.1f} | {_shares(one, one.under_j2)} "
        f"| {_shares(one, one.on_fits)} "
        f"| {1e3 * one.flight.worst_miss_m:.1f} mm, {1e3 * one.flight.worst_miss_m_s:.1e} mm/s "
        f"| {one.onto.holding_m_s:.1f} | {one.onto.holding_m_s / (beside_s / REVOLUTION_S):.2f} "
        f"| {one.seconds:.1f} |"
    )


if __name__ == "__main__":
    main()
