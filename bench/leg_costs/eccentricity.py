"""Cost of matching eccentricity vectors, flown optimally, and the accuracy of closed forms."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from fields import planned
from tables import head, row

import adr_opt
from adr_opt.common.constants import DAY_S, MU_M3_S2
from adr_opt.kernels.legs import co_elliptic, precession
from adr_opt.kernels.orbits import ephemeris
from adr_opt.sources.catalogue import MissionOutline, read, to_instance

from .relative_optimum import Case, flown, free

RADIUS_M, CLIMB_M, ECCENTRICITY, TURN_DEG = 7.15e6, 100e3, 0.02, 3.0
"""Random legs: mean radius; largest difference of radii, eccentricity and angle of planes."""

SPARE_M, MOST_LAPS = 50e3, 12
"""Phasing radii outside those of the ends are so far from the origin at most; largest k."""

PLACES, FLOWN = 200, 40
"""Legs that are optimised with impulses at the burns of the sequence, and in two-body motion."""

DYNAMICS: tuple[Literal["two-body", "j2"], ...] = "two-body", "j2"

Form = Callable[[Case, float], float]


def planar(case: Case) -> float:
    """Changes along the velocity by the burns of the sequence, as shares of the speed."""
    return 0.5 * (abs(case.phasing) + abs(case.climb - case.phasing))


def _least(case: Case, weight: float = 0.5) -> float:
    return case.speed * math.hypot(weight * abs(case.across), case.turn)


def _grown(case: Case) -> float:
    circle = math.hypot(planar(case), case.turn)
    return case.speed * (math.hypot(circle, 0.5 * abs(case.across)) - circle)


FORMS: dict[str, Form] = {
    "nothing": lambda case, circles: circles,
    "+ v·\\|Δe\\|/2": lambda case, circles: circles + 0.5 * case.speed * abs(case.across),
    "+ its growth in quadrature": lambda case, circles: circles + _grown(case),
    "at least hypot(0.4 v·\\|Δe\\|, v·θ)": lambda case, circles: max(circles, _least(case, 0.4)),
    "at least hypot(v·\\|Δe\\|/2, v·θ)": lambda case, circles: max(circles, _least(case)),
    "at least hypot(0.6 v·\\|Δe\\|, v·θ)": lambda case, circles: max(circles, _least(case, 0.6)),
    "hypot(max(v·planar, v·\\|Δe\\|/2), v·θ) instead": lambda case, circles: (
        case.speed * math.hypot(max(planar(case), 0.5 * abs(case.across)), case.turn)
    ),
}


def random_cases(count: int) -> Iterator[tuple[Case, complex]]:
    """Legs, and the eccentricity vector that each begins with."""
    rng = np.random.default_rng(0)
    speed = math.sqrt(MU_M3_S2 / RADIUS_M)
    for _ in range(count):
        climb = rng.uniform(-CLIMB_M, CLIMB_M) / RADIUS_M
        steep = rng.random() < 0.5
        turn = TURN_DEG * (rng.random() if steep else 10.0 ** rng.uniform(-2.5, 0.0))
        between = rng.random() < 0.8
        phasing = climb * rng.random() if between else rng.uniform(-SPARE_M, SPARE_M) / RADIUS_M
        sizes = ECCENTRICITY * rng.choice([0.1, 0.3, 1.0]) * rng.random(2)
        start, end = (cmath.rect(e, rng.uniform(0.0, 2.0 * math.pi)) for e in sizes)
        laps = int(rng.integers(0, MOST_LAPS + 1))
        yield Case(climb, phasing, math.radians(turn), end - start, laps, speed), start


def case_of(
    instance: adr_opt.Instance, ends: tuple[int, int], laps: int, departure: float, arrival: float
) -> Case:
    """A short connection of an instance as a leg, with the elements as they are on departure."""
    rows, rule = instance.orbits(), instance.transfer_rule()
    first, second = rows[ends[0]], rows[ends[1]]
    pair = co_elliptic.prepare(first, second, 0.0, rule, 0.0)
    stand_off = arrival - rule.approach_revolutions * 2.0 * math.pi / pair.rate_j
    if instance.dynamics == "j2":
        departure = precession.leaving(pair, rule, laps, departure, stand_off)
    radius = co_elliptic.phasing_radius(pair, rule, laps, stand_off - departure)
    alpha_i, alpha_j, theta = ephemeris.relative_node(
        ephemeris.inclination_at(first, departure),
        ephemeris.node_at(first, departure),
        ephemeris.inclination_at(second, departure),
        ephemeris.node_at(second, departure),
    )
    vectors = [
        cmath.rect(
            ephemeris.eccentricity_at(row, departure), ephemeris.perigee_at(row, departure) - alpha
        )
        for row, alpha in ((first, alpha_i), (second, alpha_j))
    ]
    behind = math.cos(ephemeris.latitude_at(first, departure) - alpha_i) < 0.0
    mean = 0.5 * (pair.radius_i + pair.radius_j)
    return Case(
        (pair.radius_j - pair.radius_i) / mean,
        (radius - pair.radius_i) / mean,
        theta,
        (vectors[1] - vectors[0]) * (-1.0 if behind else 1.0),
        laps,
        math.sqrt(MU_M3_S2 / mean),
    )


def patient_cases(instance: adr_opt.Instance, count: int) -> Iterator[Case]:
    """Cheapest connections of random pairs that leave in the first hours of a random day."""
    rng = np.random.default_rng(0)
    timetable = adr_opt.Timetable(instance)
    bodies = len(timetable.names)
    while count > 0:
        i, j = (int(body) for body in rng.choice(bodies, 2, replace=False))
        days = float(rng.choice([1.0, 2.0]))
        ready = rng.uniform(0.0, instance.mission.duration_s - days * DAY_S)
        found = timetable.connections(i, j, ready)
        there = (found.revolutions >= 0) & (found.arrival <= ready + days * DAY_S)
        if not there.any():
            continue
        c = np.flatnonzero(there)[np.argmin(found.delta_v[there])]
        case = case_of(
            instance, (i, j), int(found.revolutions[c]), found.departure[c], found.arrival[c]
        )
        if math.degrees(case.turn) <= TURN_DEG:
            count -= 1
            yield case


def hurried_cases(instance: adr_opt.Instance) -> Iterator[Case]:
    """The short legs of a greedy plan."""
    names = instance.names
    for leg in planned(instance).legs:
        if leg.kind == "short":
            ends = names.index(leg.origin), names.index(leg.destination)
            yield case_of(instance, ends, leg.phasing_revolutions, leg.departure_s, leg.arrival_s)


def _forms(name: str, cases: list[Case]) -> None:
    """Print how near the forms are to the optimum, in total and leg by leg."""
    least = np.array([free(case) for case in cases])
    circle = sum(free(case._replace(across=0j)) for case in cases)
    sequence = np.array([case.between_circles() for case in cases])
    print(
        f"\n**{name}**, {len(cases)} legs: the optimum costs {least.sum():.0f} m/s, "
        f"between circles {circle:.0f}; the sequence between circles {sequence.sum():.0f}, "
        f"{sequence.sum() / circle - 1.0:+.1%}"
    )
    head("charged for eccentricity", "m/s", "total", "mean error of a leg", "least", "most")
    for form, charged in FORMS.items():
        whole = np.array([charged(*both) for both in zip(cases, sequence, strict=True)])
        off = whole / least - 1.0
        row(
            form,
            f"{(whole - sequence).sum():.0f}",
            f"{whole.sum() / least.sum() - 1.0:+.1%}",
            f"{np.abs(off).mean():.1%}",
            f"{off.min():+.0%}",
            f"{off.max():+.0%}",
        )


def eccentricity(*catalogues: Path, pairs: int = 4000, legs: int = 150, clouds: int = 3) -> None:
    """Cost of matching eccentricities, flown optimally, and the accuracy of closed forms.

    Random legs between orbits like those of real clouds, half of them to choose a form by and half
    held back; then legs of clouds, drawn and from catalogue files: each the cheapest of all
    connections that arrive within a day or two days (patient), or one of a greedy plan (hurried).
    The reference is the least ΔV of all impulses that do what the leg has to do in its time. The
    approach is left out on both sides.
    """
    drawn = list(random_cases(pairs))
    truth = [flown(case, RADIUS_M, start) for case, start in drawn[:FLOWN]]
    total, linear = sum(cost for cost, _ in truth), sum(free(case) for case, _ in drawn[:FLOWN])
    print(
        f"The optimum flown in two-body motion: {total / linear - 1.0:+.2%} ({len(truth)} legs; "
        f"worst miss {max(miss for _, miss in truth):.1f} m)."
    )
    half = len(drawn) // 2
    _forms("random legs to choose by", [case for case, _ in drawn[:half]])
    _forms("random legs held back", [case for case, _ in drawn[half:]])
    fields = [adr_opt.generate("cloud", seed) for seed in range(clouds)]
    for path in catalogues:
        fields += [
            to_instance(
                read(path),
                max_targets=60,
                skip_bad=True,
                mission=MissionOutline(name=path.stem, dynamics=dynamics),
            ).instance
            for dynamics in DYNAMICS
        ]
    for field in fields:
        name = f"{field.name}, {field.dynamics}"
        _forms(f"{name}, patient", list(patient_cases(field, legs)))
        _forms(f"{name}, hurried", list(hurried_cases(field)))
