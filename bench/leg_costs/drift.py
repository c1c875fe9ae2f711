"""The closed form of drifts against published legs, and against the burns that it is flown with."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
from outside.gtoc9.legs import read_legs
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.kernels.legs import drift as drifting
from adr_opt.kernels.legs import drift_pair
from adr_opt.kernels.legs.co_elliptic import TransferRule
from adr_opt.legs.families.drift_burns import flown
from adr_opt.problem.orbit import Orbit

DRIFTED_D = (1.0, 90.0)
"""Shortest and longest of random drifts."""

SPREADS_DEG = {71.0: 0.15, 86.4: 0.05, 98.0: 0.08}
"""Inclinations, and how far the nodes of a pair are apart for each day (standard deviation)."""

WIDER = (1.0, 6.0)
"""The same times as much, by turns."""

CLASSES_M_S = (0.0, 30.0, 60.0, 120.0, 250.0, 1500.0, 2500.0)


def drift(gtoc9: Path | None = None, drifts: int = 1000) -> None:
    """Drifts: the closed form against flown ones, and what leaving later would save.

    First the closed form at departure and arrival of the legs of the winning solution of GTOC9;
    without its folder that is left out. Then the burns that a drift is flown with against the
    closed form, over random drifts, by inclination and cost.
    """
    if gtoc9 is not None:
        _published(gtoc9)
    rule = adr_opt.generate("tiny", 0).replace(dynamics="j2").transfer_rule()
    _burns(rule, drifts)
    _later(rule, len(SPREADS_DEG) * drifts)


def _published(folder: Path) -> None:
    """Print the closed form, and its first order, against the legs as flown."""
    legs = read_legs(folder)
    true, days, *forms = np.array(
        [(leg.flown, leg.days, leg.closed_form, leg.first_order) for leg in legs]
    ).T
    for least_d in (0.0, 3.0):
        some = days > least_d
        print(f"\n{some.sum()} legs of more than {least_d:g} d, {true[some].sum():.0f} m/s flown")
        head("estimate", "total", "mean absolute error", "largest")
        for name, found in zip(("closed form", "first order, no phase"), forms, strict=True):
            off = found[some] / true[some] - 1.0
            total = found[some].sum() / true[some].sum() - 1.0
            row(name, f"{total:+.2%}", f"{np.abs(off).mean():.2%}", f"{np.abs(off).max():.1%}")


def _body(rng: np.random.Generator, inclination_deg: float, raan_deg: float) -> np.ndarray:
    """A row of a circle between 650 and 950 km."""
    orbit = Orbit(
        semi_major_axis_m=EARTH_RADIUS_M + rng.uniform(650e3, 950e3),
        eccentricity=0.0,
        inclination_deg=inclination_deg,
        raan_deg=raan_deg,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=rng.uniform(0.0, 360.0),
    )
    return np.array(orbit.row(OBLATENESS_M2))


def _burns(rule: TransferRule, number: int) -> None:
    """Print what the burns of random drifts add up to, against the closed form, by its classes."""
    head("inclination", "closed form", "legs", "total", "least", "largest")
    whole, unmet = np.zeros(2), 0
    for inclination, spread in SPREADS_DEG.items():
        rng, legs = np.random.default_rng(round(10 * inclination)), list[tuple[float, float]]()
        while len(legs) < number:
            days = math.exp(rng.uniform(*np.log(DRIFTED_D)))
            node = rng.uniform(0.0, 360.0)
            apart = rng.normal(0.0, spread * days * float(rng.choice(WIDER)))
            nodes = node, node + apart
            first, second = (_body(rng, inclination + rng.normal(0.0, 0.1), at) for at in nodes)
            start = rng.uniform(0.0, 30.0) * DAY_S
            end = start + days * DAY_S
            pair = drift_pair.prepare(first, second, rule, 0.0)
            cost = float(drifting.delta_v(pair, start, end))
            if cost > CLASSES_M_S[-1]:
                continue
            try:
                legs.append((flown(first, second, rule, start, end).delta_v, cost))
            except InputError:
                unmet += 1
        found, planned = np.array(legs).T
        whole += found.sum(), planned.sum()
        for low, high in pairwise(CLASSES_M_S):
            some = (low <= planned) & (planned < high)
            if some.any():
                off = found[some] / planned[some]
                ratios = found[some].sum() / planned[some].sum(), off.min(), off.max()
                cells = (f"{each:.3f}" for each in ratios)
                row(f"{inclination:g}°", f"{low:g} to {high:g} m/s", some.sum(), *cells)
    row("all", "", 3 * number, f"{whole[0] / whole[1]:.3f}", "", "")
    print(f"\nNo burns were found for {unmet}.")


def _later(rule: TransferRule, number: int) -> None:
    """Print what leaving later and arriving earlier would save, by the closed form."""
    rng, rows = np.random.default_rng(3), list[tuple[float, float, float]]()
    free = np.linspace(0.0, 0.5 * DAY_S, 13)
    while len(rows) < number:
        inclination, spread = list(SPREADS_DEG.items())[len(rows) % len(SPREADS_DEG)]
        days = math.exp(rng.uniform(math.log(2.0), math.log(30.0)))
        apart = rng.normal(0.0, spread * days * float(rng.choice(WIDER)))
        bodies = [_body(rng, inclination + rng.normal(0.0, 0.1), raan) for raan in (0.0, apart)]
        start = rng.uniform(0.0, 30.0) * DAY_S
        ends = start + free, start + days * DAY_S - free
        found = drifting.splits(drift_pair.prepare(*bodies, rule, 0.0), *ends)
        if found[0, 0, 0] <= CLASSES_M_S[-1]:
            rows.append((days, found[0, 0, 0], found[:, :, 0].min()))
    table = np.array(rows)
    head("days", "legs", "total", "cheapest up to half a day later and earlier", "most saved")
    for low, high in ((2.0, 4.0), (4.0, 8.0), (8.0, 30.0)):
        some = table[(low <= table[:, 0]) & (table[:, 0] < high)]
        sums = (f"{some[:, at].sum():.0f} m/s" for at in (1, 2))
        saved = (some[:, 1] - some[:, 2]).max()
        row(f"{low:g} to {high:g}", len(some), *sums, f"{saved:.2f} m/s")
