"""The closed form of drifts against published legs, its own burns, and free ones."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from fields import eccentric, external
from outside.gtoc9.legs import read_legs
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, EARTH_RADIUS_M, OBLATENESS_M2
from adr_opt.common.errors import InputError
from adr_opt.fly.refine.bodies import TrueBodies
from adr_opt.fly.refine.one_leg import refine_leg
from adr_opt.kernels.legs import drift as drifting
from adr_opt.kernels.legs import drift_pair
from adr_opt.kernels.legs.co_elliptic import TransferRule
from adr_opt.legs.families.drift_burns import flown
from adr_opt.mission.build_legs import transfer_leg
from adr_opt.mission.mission import Mission
from adr_opt.plan.leg_kinds import DRIFT, leg_kinds
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.sources.catalogue import read, to_instance

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


STEP_S, SHORT_D, BUDGET_M_S = 0.25 * DAY_S, (1.0, 3.0), 600.0
"""Grid [s], span [d] and largest ΔV [m/s] of short drifts."""

LEAST_ECCENTRICITY = 0.004
"""Least eccentricity of the more eccentric end of a short drift."""


def short_drifts(*catalogues: Path, legs: int = 30, cuts: int = 3, seeds: int = 2) -> None:
    """Drifts of one to three days between eccentric orbits: both prices against flown legs.

    Legs are drawn of parts of catalogues, of clouds as drawn, and of nominal fields with
    eccentricities up to 0.02, all under J2, and refined with free burns. Errors are those of what
    is said, as shares of what is flown.
    """
    head("field", "legs", "price", "flown m/s", "total", "within 10 %", "within 5 %", "a leg")
    for kind, instances in _short_fields(catalogues, cuts, seeds):
        found = np.concatenate([_short_legs(each, n, legs) for n, each in enumerate(instances)])
        for said, price in zip(found.T[:2], ("(3.1)", "free burns"), strict=True):
            taken = found[:, 2]
            off = said / taken - 1.0
            near = (f"{np.mean(np.abs(off) <= share):.0%}" for share in (0.1, 0.05))
            total = f"{said.sum() / taken.sum() - 1.0:+.1%}"
            extremes = f"{off.min():+.0%} to {off.max():+.0%}"
            row(kind, len(found), price, f"{taken.sum():.0f}", total, *near, extremes)


def _short_fields(
    catalogues: tuple[Path, ...], cuts: int, seeds: int
) -> Iterator[tuple[str, list[Instance]]]:
    """Kinds of fields, and their fields under J2."""
    for path in catalogues or external("tle/*.txt", "omm/cele*.csv"):
        found = read(path, skip_bad=True)
        parts = [replace(found, records=found.records[cut::cuts]) for cut in range(cuts)]
        yield path.stem, [to_instance(part, skip_bad=True).instance for part in parts]
    yield "clouds as drawn", [adr_opt.generate("cloud", seed) for seed in range(seeds)]
    nominal = [
        eccentric(adr_opt.generate("nominal", seed), 0.02, seed).replace(dynamics="j2")
        for seed in range(seeds)
    ]
    yield "nominal, e to 0.02", nominal


def _short_legs(instance: Instance, seed: int, legs: int) -> np.ndarray:
    """ΔV by both prices, and flown, of drifts that are drawn of a field, (legs, 3) [m/s]."""
    grid = {
        "max_drift_s": SHORT_D[1] * DAY_S,
        "drift_step_s": STEP_S,
        "departure_spacing_s": STEP_S,
    }
    field = instance.replace(
        dynamics="j2",
        transfer=instance.transfer.replace(burns="free", delta_v_resolution_m_s=0.1, **grid),
        mission=instance.mission.replace(duration_s=12.0 * DAY_S),
    )
    mission, rng, found = Mission(field), np.random.default_rng(seed), list[tuple[float, ...]]()
    sequence = field.transfer_rule()._replace(free=False)
    bodies = field.body_orbits
    for _ in range(40 * legs):
        i, j = (int(each) for each in rng.integers(field.first_target, len(bodies), 2))
        if i == j or max(bodies[i].eccentricity, bodies[j].eccentricity) < LEAST_ECCENTRICITY:
            continue
        listed = mission.connecting.of_pair(i, j, field.transfer.delta_v_resolution_m_s)
        days = (listed.arrival - listed.departure) / DAY_S
        of_kind = np.array([DRIFT is leg_kinds()[each] for each in listed.family], bool)
        near = (days >= SHORT_D[0]) & (days <= SHORT_D[1]) & (listed.delta_v < BUDGET_M_S)
        rows = np.flatnonzero(of_kind & near)
        if not rows.size:
            continue
        at = int(rng.choice(rows))
        leg = transfer_leg(mission, (i, j), float(listed.departure[at]), listed, at)
        ends = TrueBodies(field, "j2", [leg.origin, leg.destination])
        taken = refine_leg(field, ends, 1, leg, "free").flown_delta_v_m_s
        pair = drift_pair.prepare(*field.orbits()[[i, j]], sequence, 0.0)
        told = float(drifting.delta_v(pair, leg.departure_s, leg.arrival_s))
        found.append((told, leg.delta_v_m_s, taken))
        if len(found) == legs:
            break
    return np.array(found)
