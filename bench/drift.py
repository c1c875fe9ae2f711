"""Long transfers: how near they are to flown ones, and how fast they are worked out.

    python bench/drift.py --gtoc9 FOLDER

First the closed form at departure and arrival of the 113 legs of the winning solution of GTOC9, and
what else was tried; without a folder that is left out. Then the burns that a drift is flown with
against the closed form, over random drifts. Then what connections take: one long transfer before
any is left out, and all of fields of 20 and of 60 bodies over a year, each in a process of its own.
"""

from __future__ import annotations

import argparse
import itertools
import os
import resource
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from machine import heading
from outside.gtoc9.legs import Leg, read_legs

import adr_opt
from adr_opt.drift_burns import flown
from adr_opt.errors import InputError
from adr_opt.kernels import drift
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.kernels.drift import costs
from adr_opt.orbit import Orbit

LENGTHS_D = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0)
"""Legs of GTOC9 by their length."""

DRIFTED_D = (2.0, 5.0, 10.0, 30.0, 90.0, 365.0)
"""Lengths of random drifts."""

SPLITS = 40

Judge = Callable[[np.ndarray], np.ndarray]


def shares(estimated: np.ndarray, true: np.ndarray) -> str:
    """Error of the total, mean absolute error, and the largest, as cells of a table."""
    off = estimated / true - 1.0
    total = estimated.sum() / true.sum() - 1.0
    return f"{total:+.2%} | {np.abs(off).mean():.2%} | {np.abs(off).max():.1%}"


def print_legs(legs: list[Leg]) -> None:
    """Print the closed form, and what else was tried, against the legs as flown."""
    true = np.array([leg.flown for leg in legs])
    closed = np.array([leg.closed_form for leg in legs])
    least = np.array([leg.least_sum for leg in legs])
    print(f"\n{len(legs)} legs, {true.sum():.0f} m/s flown\n")
    print("| estimate | total | mean absolute error | largest |\n|---|---|---|---|")
    print(f"| closed form | {shares(closed, true)} |")
    print(f"| least sum of the two changes | {shares(least, true)} |")
    print(f"| the same × 1.02 | {shares(1.02 * least, true)} |")
    print("\n| fitted on one half, judged on the other | total, ± | mean absolute error |")
    print("|---|---|---|")
    days = np.array([leg.days for leg in legs])
    for name, fit in (
        ("closed form", lambda fitted: lambda rest: closed[rest]),
        ("closed form × a factor", lambda fitted: factor(closed, true, fitted)),
        ("least sum × a factor", lambda fitted: factor(least, true, fitted)),
        ("least sum × (a + b e^(−T/3 d))", lambda fitted: shortened(least, true, days, fitted)),
    ):
        total, error = held_back(fit, true)
        print(f"| {name} | {total:.2%} | {error:.2%} |")
    print("\n| length | legs | closed form, mean | mean absolute error |\n|---|---|---|---|")
    for low, high in itertools.pairwise(LENGTHS_D):
        there = (low <= days) & (days < high)
        if there.any():
            off = closed[there] / true[there] - 1.0
            print(
                f"| {low:g} to {high:g} d | {there.sum()} | {off.mean():+.1%} | "
                f"{np.abs(off).mean():.1%} |"
            )


def factor(estimated: np.ndarray, true: np.ndarray, fitted: np.ndarray) -> Judge:
    """One factor for all, by the total of those that it is fitted on."""
    by = true[fitted].sum() / estimated[fitted].sum()
    return lambda rest: by * estimated[rest]


def shortened(
    estimated: np.ndarray, true: np.ndarray, days: np.ndarray, fitted: np.ndarray
) -> Judge:
    """A factor that is another one for short legs, by least squares of relative errors."""
    terms = np.stack([estimated, estimated * np.exp(-days / 3.0)], axis=1)
    by = np.linalg.lstsq(terms[fitted] / true[fitted, None], np.ones(fitted.size), rcond=None)[0]
    return lambda rest: terms[rest] @ by


def held_back(fit: Callable[[np.ndarray], Judge], true: np.ndarray) -> tuple[float, float]:
    """Means, over all splits, of the error of the total, without its sign, and of that of a leg.

    Each half is judged by what was fitted on the other, and a total is that of one half.
    """
    totals, errors = [], []
    for split in range(SPLITS):
        order = np.random.default_rng(split).permutation(true.size)
        for half in (order[::2], order[1::2]):
            judged = fit(np.setdiff1d(order, half))(half)
            totals.append(abs(judged.sum() / true[half].sum() - 1.0))
            errors.append(float(np.abs(judged / true[half] - 1.0).mean()))
    return statistics.mean(totals), statistics.mean(errors)


def print_burns(number: int) -> None:
    """Print what the burns of random drifts add up to, against the closed form."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    rule = instance.transfer_rule()
    rng = np.random.default_rng(0)
    print(f"\nBurns against the closed form, {number} random drifts of each length\n")
    print("| length | closed form, median | burns less it: median | 10 % | 90 % | no phase met |")
    print("|---|---|---|---|---|---|")
    for days in DRIFTED_D:
        planned, burnt, none = [], [], 0
        for _ in range(number):
            inclination = float(rng.choice([50.0, 71.0, 98.0, 110.0]))
            node, spread = rng.uniform(0.0, 360.0), 1.0 + 0.1 * days
            first, second = (
                np.array(
                    body(rng, inclination + rng.normal(0.0, 0.2), node + rng.normal(0, spread))
                )
                for _ in range(2)
            )
            start = rng.uniform(0.0, 100.0) * DAY_S
            pair = drift.prepare(first, second, rule.min_radius, rule.max_radius, OBLATENESS_M2)
            cost = drift.delta_v(pair, start, start + days * DAY_S)
            try:
                burns = flown(first, second, rule, start, start + days * DAY_S).delta_v
            except InputError:
                none += 1
                continue
            planned.append(cost)
            burnt.append(burns)
        off = np.array(burnt) / np.array(planned) - 1.0
        low, middle, high = np.quantile(off, [0.1, 0.5, 0.9])
        print(
            f"| {days:g} d | {np.median(planned):.0f} m/s | {middle:+.2%} | {low:+.2%} | "
            f"{high:+.2%} | {none} |"
        )


def body(rng: np.random.Generator, inclination_deg: float, raan_deg: float) -> tuple[float, ...]:
    """A row of a circle between 650 and 950 km."""
    return orbit(rng, inclination_deg, raan_deg, (650e3, 950e3)).row(OBLATENESS_M2)


def orbit(
    rng: np.random.Generator,
    inclination_deg: float,
    raan_deg: float,
    altitudes_m: tuple[float, float],
) -> Orbit:
    """A circle at an altitude between two."""
    return Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + rng.uniform(*altitudes_m),
        eccentricity=0.0,
        inclination_deg=inclination_deg,
        raan_deg=raan_deg,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=rng.uniform(0.0, 360.0),
    )


@kernel
def _all_costs(pair, step, node, shape, cost):
    """The long transfers of a pair on a grid of times, none left out; how many."""
    count = 0
    for begin in range(node.size):
        costs(pair, step, node, shape, begin, node.size - 1, cost)
        count += node.size - 1 - begin
    return count


def print_long(runs: int) -> None:
    """Print what a long transfer takes before any is left out."""
    rng = np.random.default_rng(0)
    first, second = (np.array(body(rng, 71.0, raan)) for raan in (0.0, 20.0))
    pair = drift.prepare(first, second, EARTH_RADIUS_M + 3e5, EARTH_RADIUS_M + 2e6, OBLATENESS_M2)
    times = 2000
    node, shape = (
        np.array([of(pair, t * DAY_S) for t in range(times)])
        for of in (drift.node_left, drift.shape_left)
    )
    cost = np.empty(times)
    took = []
    for _ in range(runs + 1):
        began = time.perf_counter()
        count = _all_costs(pair, DAY_S, node, shape, cost)
        took.append((time.perf_counter() - began) / count)
    print(f"\nA long transfer, none left out, 1 core: {statistics.median(took[1:]) * 1e9:.1f} ns")


def field(bodies: int, step_d: float, spacing_d: float, seed: int) -> adr_opt.Instance:
    """A year of sun-synchronous bodies: 97 to 99.5°, 600 to 900 km, nodes all around."""
    rng = np.random.default_rng(seed)

    def drawn() -> dict[str, float]:
        raan, inclination = rng.uniform(0.0, 360.0), rng.uniform(97.0, 99.5)
        made: dict[str, float] = orbit(rng, inclination, raan, (600e3, 900e3)).model_dump()
        return made

    return adr_opt.Instance.model_validate(
        {
            "format": "adr-opt-instance/2",
            "name": f"drift-{bodies}",
            "epoch": "2026-01-01T00:00:00Z",
            "dynamics": "j2",
            "stations": [{"name": "station", "orbit": drawn()}],
            "targets": [{"name": f"body-{b:03d}", "orbit": drawn()} for b in range(1, bodies)],
            "chasers": [
                {
                    "name": "chaser",
                    "start": {"station": "station"},
                    "tank": {"delta_v_m_s": 3000.0},
                }
            ],
            "mission": {"duration_s": 365.0 * DAY_S, "service_s": DAY_S},
            "transfer": {
                "departure_spacing_s": spacing_d * DAY_S,
                "drift_step_s": step_d * DAY_S,
                "max_drift_s": 365.0 * DAY_S,
                "delta_v_resolution_m_s": 5.0,
            },
        }
    )


def build(bodies: int, step_d: float, spacing_d: float) -> tuple[int, float, float]:
    """Connections of a field, seconds that building its timetable takes, GB that are held.

    In a process that did nothing before but a small field, so that kernels are loaded.
    """
    adr_opt.Timetable(field(3, step_d, spacing_d, 1))
    instance = field(bodies, step_d, spacing_d, 0)
    began = time.perf_counter()
    made = adr_opt.Timetable(instance)
    took = time.perf_counter() - began
    count = sum(made.connecting.counts.values())
    return count, took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0 / 1e9


def print_fields(runs: int) -> None:
    """Print what connections of whole fields take."""
    cores = os.cpu_count() or 1
    print(f"\nConnections of a year, 5 m/s apart at least, {cores} cores, median of {runs}\n")
    print("| bodies | grid | departures apart | connections | time | process |")
    print("|---|---|---|---|---|---|")
    for bodies, step_d, spacing_d in ((20, 1.0, 1.0), (20, 2.5, 1.0), (60, 2.5, 1.0), (60, 5, 2)):
        found = []
        for _ in range(runs):
            with ProcessPoolExecutor(1, get_context("spawn")) as pool:
                found.append(pool.submit(build, bodies, step_d, spacing_d).result())
        took = statistics.median(row[1] for row in found)
        print(
            f"| {bodies} | {step_d:g} d | {spacing_d:g} d | {found[0][0]} | {took:.1f} s | "
            f"{max(row[2] for row in found):.2f} GB |",
            flush=True,
        )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    given = os.environ.get("ADR_OPT_EXTERNAL_DATA")
    parser.add_argument("--gtoc9", type=Path, default=Path(given) / "gtoc9" if given else None)
    parser.add_argument("--drifts", type=int, default=100)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    print(heading())
    if arguments.gtoc9 is not None:
        print_legs(read_legs(arguments.gtoc9))
    print_burns(arguments.drifts)
    print_long(9)
    print_fields(arguments.runs)


if __name__ == "__main__":
    main()
