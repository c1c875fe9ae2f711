"""Long transfers: accuracy against flown ones, and speed of computation.

    python bench/drift.py --gtoc9 FOLDER

First the closed form at departure and arrival of the 113 legs of the winning solution of GTOC9;
without a folder that is left out. Then the burns that a drift is flown with against the closed
form, over random drifts. Then what connections take: one long transfer before
any is left out, and all of fields of 20 and of 60 bodies over a year, each in a process of its own.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import resource
import statistics
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from machine import heading
from outside.gtoc9.legs import Leg, read_legs

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.common.processors import usable_cores
from adr_opt.kernels.core.compile import kernel
from adr_opt.kernels.legs import drift, drift_pair
from adr_opt.legs.families.drift_burns import flown
from adr_opt.problem.orbit import Orbit

DRIFTED_D = (1.0, 90.0)
"""Shortest and longest of random drifts."""

SPREADS_DEG = {71.0: 0.15, 86.4: 0.05, 98.0: 0.08}
"""Inclinations, and how far the nodes of a pair are apart for each day (standard deviation)."""

WIDER = (1.0, 6.0)
"""The same times as much, by turns."""

CLASSES_M_S = (0.0, 30.0, 60.0, 120.0, 250.0, 1500.0, 2500.0)


def shares(estimated: np.ndarray, true: np.ndarray) -> str:
    """Error of the total, mean absolute error, and the largest, as cells of a table."""
    off = estimated / true - 1.0
    total = estimated.sum() / true.sum() - 1.0
    return f"{total:+.2%} | {np.abs(off).mean():.2%} | {np.abs(off).max():.1%}"


def print_legs(legs: list[Leg]) -> None:
    """Print the closed form, and its first order, against the legs as flown."""
    true = np.array([leg.flown for leg in legs])
    forms = {
        "closed form": np.array([leg.closed_form for leg in legs]),
        "first order, no phase": np.array([leg.first_order for leg in legs]),
    }
    days = np.array([leg.days for leg in legs])
    for least_d in (0.0, 3.0):
        some = days > least_d
        print(f"\n{some.sum()} legs of more than {least_d:g} d, {true[some].sum():.0f} m/s flown\n")
        print("| estimate | total | mean absolute error | largest |\n|---|---|---|---|")
        for name, found in forms.items():
            print(f"| {name} | {shares(found[some], true[some])} |")


def print_burns(number: int) -> None:
    """Print what the burns of random drifts add up to, against the closed form, by its classes."""
    instance = adr_opt.generate("tiny", 0).replace(dynamics="j2")
    rule = instance.transfer_rule()
    print(f"\nBurns against the closed form, {number} random drifts at each inclination\n")
    print(
        "| inclination | closed form | legs | total | least | largest |\n|---|---|---|---|---|---|"
    )
    whole = np.zeros(2)
    unmet = 0
    for inclination, spread in SPREADS_DEG.items():
        rng = np.random.default_rng(round(10 * inclination))
        said, burnt = [], []
        while len(said) < number:
            days = math.exp(rng.uniform(*np.log(DRIFTED_D)))
            node = rng.uniform(0.0, 360.0)
            apart = rng.normal(0.0, spread * days * float(rng.choice(WIDER)))
            nodes = node, node + apart
            first, second = (
                np.array(body(rng, inclination + rng.normal(0.0, 0.1), raan)) for raan in nodes
            )
            start = rng.uniform(0.0, 30.0) * DAY_S
            end = start + days * DAY_S
            cost = float(drift.delta_v(drift_pair.prepare(first, second, rule, 0.0), start, end))
            if cost > CLASSES_M_S[-1]:
                continue
            try:
                burnt.append(flown(first, second, rule, start, end).delta_v)
            except InputError:
                unmet += 1
                continue
            said.append(cost)
        found, planned = np.array(burnt), np.array(said)
        whole += found.sum(), planned.sum()
        for low, high in itertools.pairwise(CLASSES_M_S):
            there = (low <= planned) & (planned < high)
            if there.any():
                off = found[there] / planned[there]
                print(
                    f"| {inclination:g}° | {low:g} to {high:g} m/s | {there.sum()} | "
                    f"{found[there].sum() / planned[there].sum():.3f} | {off.min():.3f} | "
                    f"{off.max():.3f} |"
                )
    print(f"| all | | {3 * number} | {whole[0] / whole[1]:.3f} | | |")
    print(f"\nNo burns were found for {unmet}.")


def print_later(number: int) -> None:
    """Print what leaving later and arriving earlier would save, by the closed form."""
    rule = adr_opt.generate("tiny", 0).replace(dynamics="j2").transfer_rule()
    rng = np.random.default_rng(3)
    print(f"\nThe closed form up to half a day later and earlier, {number} random drifts\n")
    print("| days | legs | total | cheapest later or earlier | most saved |\n|---|---|---|---|---|")
    rows = []
    free = np.linspace(0.0, 0.5 * DAY_S, 13)
    while len(rows) < number:
        inclination, spread = list(SPREADS_DEG.items())[len(rows) % len(SPREADS_DEG)]
        days = math.exp(rng.uniform(math.log(2.0), math.log(30.0)))
        apart = rng.normal(0.0, spread * days * float(rng.choice(WIDER)))
        first, second = (
            np.array(body(rng, inclination + rng.normal(0.0, 0.1), raan)) for raan in (0.0, apart)
        )
        start = rng.uniform(0.0, 30.0) * DAY_S
        end = start + days * DAY_S
        found = drift.splits(drift_pair.prepare(first, second, rule, 0.0), start + free, end - free)
        if found[0, 0, 0] <= CLASSES_M_S[-1]:
            rows.append((days, found[0, 0, 0], found[:, :, 0].min()))
    table = np.array(rows)
    for low, high in ((2.0, 4.0), (4.0, 8.0), (8.0, 30.0)):
        some = table[(low <= table[:, 0]) & (table[:, 0] < high)]
        saved = some[:, 1] - some[:, 2]
        print(
            f"| {low:g} to {high:g} | {len(some)} | {some[:, 1].sum():.0f} m/s | "
            f"{some[:, 2].sum():.0f} m/s | {saved.max():.2f} m/s |"
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
def _all_costs(pair, step, times):
    """The drift legs of a pair on a grid of times, none left out; how many."""
    count = 0
    for begin in range(times):
        for end in range(begin + 1, times):
            drift.delta_v(pair, begin * step, end * step)
            count += 1
    return count


def print_long(runs: int) -> None:
    """Print what a drift leg takes before any is left out."""
    rng = np.random.default_rng(0)
    rule = adr_opt.generate("tiny", 0).replace(dynamics="j2").transfer_rule()
    first, second = (np.array(body(rng, 71.0, raan)) for raan in (0.0, 20.0))
    pair = drift_pair.prepare(first, second, rule, 0.0)
    took = []
    for _ in range(runs + 1):
        began = time.perf_counter()
        count = _all_costs(pair, DAY_S, 500)
        took.append((time.perf_counter() - began) / count)
    print(f"\nA drift leg, none left out, 1 core: {statistics.median(took[1:]) * 1e9:.0f} ns")


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
                {"name": "chaser", "start": {"station": "station"}, "tank": {"delta_v_m_s": 3000.0}}
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
    cores = usable_cores()
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
    parser.add_argument("--drifts", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=3)
    arguments = parser.parse_args()
    print(heading())
    if arguments.gtoc9 is not None:
        print_legs(read_legs(arguments.gtoc9))
    print_burns(arguments.drifts)
    print_later(len(SPREADS_DEG) * arguments.drifts)
    print_long(9)
    print_fields(arguments.runs)


if __name__ == "__main__":
    main()
