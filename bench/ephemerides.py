"""Ephemerides and forces: what fits leave, plans refined onto ephemerides, all forces.

    python bench/ephemerides.py fits [CATALOGUE...]
    python bench/ephemerides.py refined [CATALOGUE...]
    python bench/ephemerides.py forces

By default catalogues are those of the folder that ADR_OPT_EXTERNAL_DATA names.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from all_forces import forces
from fields import external, planned
from tables import experiment, head, row, timed

import adr_opt
from adr_opt.common.constants import DAY_S, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.fly.flight import RefinedFlight, fly_refined
from adr_opt.fly.refine.bodies import Gravity, moved
from adr_opt.fly.refine.one_leg import refine_leg
from adr_opt.fly.refine.reported import following_m_s
from adr_opt.kernels.orbits import elements
from adr_opt.kernels.orbits.ephemeris import secular_rates
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import Array, osculating
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Fit
from adr_opt.sources import catalogue
from adr_opt.sources.ephemerides import ephemerides_of
from adr_opt.sources.ephemerides.ephemeris import TurningAxes
from adr_opt.sources.ephemerides.fit import FittedOrbit, fitted, sample_times
from adr_opt.sources.ephemerides.imported import with_ephemerides
from adr_opt.sources.ephemerides.interpolation import interpolated
from adr_opt.sources.ephemerides.left_over import left_over
from adr_opt.sources.ephemerides.of_instance import ByElements

TARGETS = 60


def _made(path: Path, days: float, targets: int) -> catalogue.Imported:
    """The import of the targets of a catalogue with the nearest planes."""
    return catalogue.to_instance(
        catalogue.read(path, skip_bad=True),
        max_targets=targets,
        skip_bad=True,
        mission=catalogue.MissionOutline(duration_s=days * DAY_S),
    )


def _bodies(path: Path, days: float) -> list[tuple[ByElements, FittedOrbit]]:
    """Ephemerides of the targets, and their orbits as SGP4 has them at the epoch."""
    made = _made(path, days, TARGETS)
    instance = made.instance
    assert instance.frame is not None
    axes = TurningAxes(instance.epoch, instance.frame)
    found = []
    for target in instance.targets:
        assert target.orbit is not None
        ephemeris = ByElements(target.name, made.records[target.name], instance.epoch, axes)
        try:
            ephemeris.state(np.linspace(0.0, days * DAY_S, 100))
        except InputError as error:
            print(f"left out: {error}", file=sys.stderr)
            continue
        found.append((ephemeris, FittedOrbit(target.orbit, 0.0, Fit())))
    return found


def fits(*catalogues: Path, days: tuple[float, ...] = (7.0, 30.0)) -> None:
    """Distances that fitted orbits leave to the ephemerides of real objects.

    Mean elements as SGP4 has them at the epoch, moved by J2 alone, and those fitted to SGP4 over
    the mission; medians over the 60 targets with the nearest planes, the 90th percentile along the
    track, and the worst object. Then the rates of nodes that fits leave, and how far nodes are off
    with a common rate and with one of each body; and the accuracy of tables: states of a day
    between those of messages with a state every 60, 120 and 180 s.
    """
    paths = catalogues or tuple(external("tle/*.txt", "omm/celestrak*.csv"))
    cases = [(path, each) for path in paths for each in days]
    head(
        *("catalogue", "days", "elements", "bodies", "epoch km", "along km", "90 %", "across km"),
        *("m/s a leg", "worst along the track"),
    )
    for path, each in cases:
        _compared(path, each)
    head(
        *("catalogue", "days", "rate of nodes left °/day", "middle 90 %", "node off km"),
        *("with a common rate", "with one of each"),
    )
    for path, each in cases:
        _nodes(path, each)
    head("step s", "Lagrange, 8 states: m", "Hermite, 4 states: m")
    bodies, times = _bodies(paths[0], 7.0), np.linspace(0.0, DAY_S, 5001)
    for step_s in (60.0, 120.0, 180.0):
        knots = np.arange(-10.0 * step_s, DAY_S + 10.0 * step_s, step_s)
        errors = [
            [
                np.linalg.norm((interpolated(knots, table, times, method, 7) - true)[:, :3], axis=1)
                for method in ("LAGRANGE", "HERMITE")
            ]
            for table, true in ((one.state(knots), one.state(times)) for one, _ in bodies)
        ]
        lagrange, hermite = np.median(np.max(errors, axis=2), axis=0)
        row(f"{step_s:g}", f"{lagrange:.4f}", f"{hermite:.3f}")


def _compared(path: Path, days: float) -> None:
    """Print how far objects are from elements of the epoch, and from fitted ones."""
    bodies = _bodies(path, days)
    fitting = [(one, fitted(one, days * DAY_S)) for one, _ in bodies]
    for name, orbits in (("SGP4's at the epoch", bodies), ("fitted", fitting)):
        left = [left_over(*both, days * DAY_S) for both in orbits]
        epoch, along, across = (
            np.array([getattr(one, field) for one in left]) / 1e3
            for field in ("epoch_m", "along_m", "across_m")
        )
        worst = int(np.argmax(along))
        row(
            path.stem,
            f"{days:g}",
            name,
            len(left),
            f"{np.median(epoch):.2f}",
            f"{np.median(along):.2f}",
            f"{np.quantile(along, 0.9):.2f}",
            f"{np.median(across):.2f}",
            f"{np.median([one.leg_m_s for one in left]):.1f}",
            f"{left[worst].body}, {along[worst]:,.1f} km",
        )


def _nodes(path: Path, days: float) -> None:
    """Rates of nodes beyond those of J2, and the largest distance of nodes; medians over bodies."""
    times = sample_times(days * DAY_S)
    rates, nodes, arcs = [], [], []
    for ephemeris, _ in _bodies(path, days):
        orbit = fitted(ephemeris, days * DAY_S).orbit
        tilt = math.radians(orbit.inclination_deg)
        rate, _, _ = secular_rates(orbit.semi_major_axis_m, orbit.eccentricity, tilt, OBLATENESS_M2)
        normal = np.cross(*np.split(ephemeris.state(times), 2, axis=1))
        node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1])) - rate * times
        rates.append(np.polyfit(times, node, 1)[0])
        nodes.append(node)
        arcs.append(orbit.semi_major_axis_m * math.sin(tilt) / 1e3)
    common, off = float(np.median(rates)), []
    for taken in (np.zeros(len(rates)), np.full(len(rates), common), np.array(rates)):
        left = np.array(nodes) - taken[:, None] * times
        off.append(np.abs(left - left.mean(axis=1)[:, None]).max(axis=1) * arcs)
    low, high = np.degrees(np.quantile(rates, (0.05, 0.95))) * DAY_S
    row(
        path.stem,
        f"{days:g}",
        f"{math.degrees(common) * DAY_S:.5f}",
        f"{low:.5f} to {high:.5f}",
        *(f"{np.median(one):.2f}" for one in off),
    )


@contextmanager
def nearest(path: Path, targets: int = TARGETS) -> Iterator[Instance]:
    """A week with the targets of the nearest planes, their element sets beside the instance."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "field.json"
        with_ephemerides(_made(path, 7.0, targets), file).write(file)
        yield adr_opt.load(file)


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
    """A plan onto ephemerides, ΔV of its legs under J2 and on fits, its flight, and time."""

    onto: RefinedPlan
    under_j2: dict[int, float]
    on_fits: dict[int, float]
    flight: RefinedFlight
    seconds: float


def refined(
    *catalogues: Path,
    methods: tuple[str, ...] = ("auto", "greedy-guarded", "beam"),
    limit: float = 60.0,
) -> None:
    """Plans refined onto ephemerides, against the same legs refined under J2.

    The 60 targets with the nearest planes of each catalogue of Iridium 33, for a week, planned,
    refined onto SGP4 in the field to J4, and flown. Each leg is compared with itself between the
    bodies that the plan was made with: their mean elements, drag included, with the short-period
    variations of J2, in the field of J2; once as refinement under J2 has them, and once with the
    constant part of the eccentricity that was fitted, too. Before that, where a chaser is that is
    let go on a state by SGP4, and the ΔV of holding by the number of impulses in a revolution.
    """
    found: dict[tuple[str, str], Compared] = {}
    for path in catalogues or external("tle/*iridium-33*", "omm/*iridium-33*"):
        with nearest(path) as instance:
            if not found:
                _holding(instance)
            for method in methods:
                found[path.stem, method] = _onto(instance, method, limit)
    head(
        *("catalogue", "planner", "legs", "planned m/s", "onto SGP4", "to J2: median leg %"),
        *("90 %", "total %", "to fitted: median leg %", "90 %", "total %", "worst miss"),
        *("holding m/s", "a revolution", "s"),
    )
    for (name, method), one in found.items():
        onto, flight = one.onto, one.flight
        beside_s = math.fsum(
            leg.states[0].time_s - leg.ready_s + leg.end_s - leg.arrival_s for leg in onto.legs
        )
        row(
            name,
            f"`{method}`",
            len(onto.legs),
            f"{onto.planned_delta_v_m_s:.1f}",
            f"{onto.flown_delta_v_m_s:.1f}",
            *_shares(onto, one.under_j2),
            *_shares(onto, one.on_fits),
            f"{1e3 * flight.worst_miss_m:.1f} mm, {1e3 * flight.worst_miss_m_s:.1e} mm/s",
            f"{onto.holding_m_s:.1f}",
            f"{onto.holding_m_s / (beside_s / REVOLUTION_S):.2f}",
            f"{one.seconds:.1f}",
        )


def _holding(instance: Instance) -> None:
    """Print what letting go and holding do to objects of an instance, a day after the epoch."""
    known = ephemerides_of(instance)
    states = [known.of(name) for name in known.bodies]
    away = []
    for ephemeris in states:
        begin, end = ephemeris.state([DAY_S, DAY_S + 6000.0])
        away.append(math.dist(moved(begin, 6000.0, "j4")[:3], end[:3]))
    print(
        f"Let go on a state by SGP4, 6000 s later {np.median(away):.0f} m away in the median over "
        f"{len(away)} objects, {max(away):.0f} m at most."
    )
    head("impulses a revolution", "holding m/s a revolution", "90 %", "most")
    for impulses in (4, 8, 12, 24, 60):
        times = DAY_S + np.linspace(0.0, 5.0 * REVOLUTION_S, 5 * impulses + 1)
        taken = [following_m_s(one.state(times), times, "j4") / 5.0 for one in states]
        row(impulses, *(f"{each:.2f}" for each in np.quantile(taken, (0.5, 0.9, 1.0))))


def _onto(instance: Instance, method: str, limit_s: float) -> Compared:
    """A plan refined onto ephemerides, and its legs between the bodies that it was made with."""
    plan = planned(instance, method, limit_s)
    adr_opt.refine(instance, plan, ephemerides=True)  # kernels are loaded on first use
    onto, seconds, _ = timed(lambda: adr_opt.refine(instance, plan, ephemerides=True))
    costs: list[dict[int, float]] = [{}, {}]
    for whole, cost in enumerate(costs):
        bodies = PlannedBodies(instance, whole=bool(whole))
        for number, leg in enumerate(plan.legs, start=1):
            try:
                found = refine_leg(instance, bodies, number, leg, "free")
                cost[number] = found.flown_delta_v_m_s
            except ArithmeticError as error:
                print(f"leg {number}: {error}", file=sys.stderr)
    return Compared(onto, *costs, fly_refined(instance, onto), seconds)


def _shares(onto: RefinedPlan, before: dict[int, float]) -> list[str]:
    """Median leg, nine of ten, and total, over those before, less 1."""
    both = [(leg.flown_delta_v_m_s, before[leg.leg]) for leg in onto.legs if leg.leg in before]
    flown, was = np.array(both).T
    ratios = flown / was - 1.0
    shares = np.median(ratios), np.quantile(ratios, 0.9), flown.sum() / was.sum() - 1.0
    return [f"{100.0 * share:+.2f}" for share in shares]


if __name__ == "__main__":
    sys.exit(experiment(__doc__, fits, refined, forces))
