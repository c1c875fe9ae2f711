"""Fly a refined plan many times with errors, and find how much its tanks need."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from ...common.errors import InputError
from ...common.processors import usable_cores
from ...judge.admit import TANK, AnyRefined, admit
from ...kernels.orbits.short_periods import Array
from ...plan.launched import as_launched
from ...plan.refined_plan import RefinedLeg, RefinedPlan
from ...plan.routes import several
from ...problem.instance import Instance
from ...problem.uncertainty import TankUncertainty
from ...sources.uncertainty import TargetError
from ..flight.refined import refuse_strangers
from ..flight.tanks import TankLegs, legs_by_tank, refined_routes
from .displaced import DisplacedBodies
from .errors import FlightErrors
from .flown_leg import LegFlights, fly_leg
from .spread import Dispersion, LegDispersion, Linearity, Quantile, TankDispersion

LEAST_SHARE = 0.01
"""Smallest usable share that is stated."""


def tank_dispersions(
    instance: Instance, refined: RefinedPlan, spent: Array, share: float
) -> Iterator[TankDispersion]:
    """Demand on each tank, from the ΔV of legs, shape (legs, flights) [m/s]."""
    for one, taken in _taken(instance, refined, spent):
        legs, budget = one.legs, one.budget_m_s
        refined_m_s = math.fsum(
            part
            for leg in legs
            for part in (leg.flown_delta_v_m_s, leg.removal_m_s, leg.holding_m_s)
        )
        yield TankDispersion(
            tank=one.tank,
            first_leg=legs[0].leg,
            last_leg=legs[-1].leg,
            budget_m_s=budget,
            refined_delta_v_m_s=refined_m_s,
            delta_v_m_s=Quantile.of(taken, share),
            breaks_share=float((taken > budget).mean()),
            chaser=one.chaser.name if several(instance) else None,
        )


def usable_tank(
    instance: Instance, refined: RefinedPlan, dispersion: Dispersion
) -> TankUncertainty:
    """Usable share of a full tank that reproduces the demand of flights with errors.

    A tank that planned legs leave empty, and that flights with errors drain by a factor more, is in
    terms of planned ΔV a smaller one: its share is planned over flown ΔV. The shares of all tanks
    in all flights have the mean and the standard deviation of the uniform distribution that is
    returned, unless it would end above a full tank, where it is cut off.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan
    dispersion : Dispersion
        Of that refined plan.

    Raises
    ------
    InputError
        No tank is planned to give ΔV.
    """
    shares = [
        planned_m_s / taken
        for one, taken in _taken(instance, refined, dispersion.leg_delta_v_m_s)
        if (
            planned_m_s := math.fsum(
                leg.planned_delta_v_m_s + leg.planned_removal_m_s for leg in one.legs
            )
        )
        > 0.0
    ]
    if not shares:
        raise InputError("no leg of the plan takes ΔV: nothing can be learnt about its tanks")
    drawn = np.concatenate(shares)
    half_width = math.sqrt(3.0) * float(drawn.std())
    middle = float(drawn.mean())
    least, most = (
        min(max(end, LEAST_SHARE), 1.0) for end in (middle - half_width, middle + half_width)
    )
    return TankUncertainty(least=least, most=most)


def _taken(
    instance: Instance, refined: RefinedPlan, spent: Array
) -> Iterator[tuple[TankLegs, Array]]:
    """Legs of each tank, and the ΔV that each flight takes from it [m/s]."""
    row = {leg.leg: at for at, leg in enumerate(refined.legs)}
    for one in legs_by_tank(instance, refined):
        removals_m_s = math.fsum(leg.removal_m_s + leg.holding_m_s for leg in one.legs)
        yield one, spent[[row[leg.leg] for leg in one.legs]].sum(axis=0) + removals_m_s


SHARE = 0.95
"""Share of flights for which a tank must suffice."""

WAITING_SHARE = 0.5
"""Largest miss of the stand-off, as a share of its distance from the target, without a wait of one
revolution."""

MOST_FLIGHTS, MOST_CORRECTIONS = 100_000, 10


def sample_flights(  # noqa: PLR0913
    instance: Instance,
    refined: AnyRefined,
    flights: int = 1000,
    errors: FlightErrors | None = None,
    *,
    seed: int = 0,
    corrections: int = 2,
    share: float = SHARE,
    targets: Mapping[str, TargetError] | None = None,
    known_before_s: float | None = None,
    jobs: int | None = None,
    report: Callable[[int, int], None] = lambda done, total: None,
) -> Dispersion:
    """Fly a refined plan many times with errors and corrections.

    Every leg begins docked, near the state that it was planned with; its first burn is made as
    planned, and after it, and after every burn, the state is known. Burns that are left, and some
    for corrections alone, lead to the stand-off, and those of the approach to the target. Times do
    not change.

    Parameters
    ----------
    instance : Instance
    refined : RefinedPlan or Admitted
    flights : int
    errors : FlightErrors, optional
        Those of :class:`FlightErrors` by default.
    seed : int
    corrections : int
        Burns for corrections alone after each burn that has time for them before the next.
    share : float
        Share of the flights that the stated ΔV and times cover.
    targets : mapping, optional
        Position errors by body. A leg begins at the actual place of its origin. It leads to the
        planned place of its destination until the actual one is known, and from then on to that.
    known_before_s : float, optional
        Time before the stand-off from which the destination is known; by default a revolution [s].
    jobs : int, optional
        Threads; all cores by default. The result does not depend on it.
    report : callable
        Called with the number of legs done, and of all legs.

    Raises
    ------
    InputError
        The refined plan belongs to another instance, has violations or has no legs, a
        parameter is out of range, or errors are so large that a flight leads away.
    """
    errors = errors or FlightErrors()
    _check("flights", flights, 1, MOST_FLIGHTS)
    _check("seed", seed, 0, math.inf)
    _check("corrections", corrections, 0, MOST_CORRECTIONS)
    _check("jobs", jobs or 0, 0, math.inf)
    if not 0.0 < share < 1.0:
        raise InputError(f"share = {share:g}: must lie between 0 and 1")
    refined = admit(instance, refined, excused=TANK).plan
    refuse_strangers(instance, refined)
    instance = as_launched(instance, refined.planned)
    if refined.has_thrust:
        raise InputError("the refined plan has low thrust, which cannot be flown with errors")
    if not refined.legs:
        raise InputError("the refined plan has no legs: there is nothing to fly")

    if known_before_s is not None and not 0.0 <= known_before_s < math.inf:
        raise InputError(f"known_before_s = {known_before_s:g}: must be 0 or a positive time")
    displaced = DisplacedBodies(instance, refined, targets or {}, flights, seed)
    for name, times_s in _meetings(refined.legs).items():
        displaced.follow(name, times_s)

    def one(leg: RefinedLeg) -> LegFlights:
        rng = np.random.default_rng([seed, leg.leg])
        return fly_leg(
            leg, refined.gravity, errors, rng, flights, corrections, displaced, known_before_s
        )

    flown: list[LegFlights] = []
    report(0, len(refined.legs))
    with ThreadPoolExecutor(jobs or usable_cores()) as pool:
        for leg_flights in pool.map(one, refined.legs):
            flown.append(leg_flights)
            report(len(flown), len(refined.legs))
    found = _told(instance, refined, flown, errors, seed, corrections, share)
    return replace(found, uncertain=displaced.names, known_before_s=known_before_s)


def _meetings(legs: Iterable[RefinedLeg]) -> dict[str, list[float]]:
    """Times of departure from bodies, and of arrival at stand-offs from them [s]."""
    found: dict[str, list[float]] = {}
    for leg in legs:
        found.setdefault(leg.origin, []).append(leg.states[0].time_s)
        found.setdefault(leg.destination, []).append(leg.standoff_s)
    return found


def _check(name: str, value: int, least: float, most: float) -> None:
    if not least <= value <= most:
        upper = "" if math.isinf(most) else f" and at most {most:,}"
        raise InputError(f"{name} = {value}: must be at least {least}{upper}")


def _told(
    instance: Instance,
    refined: RefinedPlan,
    flown: list[LegFlights],
    errors: FlightErrors,
    seed: int,
    corrections: int,
    share: float,
) -> Dispersion:
    spent = np.array([leg.delta_v_m_s for leg in flown])
    missed = np.array([np.linalg.norm(leg.standoff[:3], axis=0) for leg in flown])
    waiting = missed > WAITING_SHARE * instance.transfer.standoff_m
    revolutions = np.array([leg.revolution_s for leg in flown])
    next_s = _next_departures(instance, refined)
    # A tow waits as long as what follows it allows.
    spare = np.array([next_s[leg.leg] - leg.end_s - leg.removal_s for leg in refined.legs])
    late = (waiting & (revolutions > spare)[:, None]).any(axis=0)
    apart = [np.linalg.norm(leg.standoff[3:], axis=0) for leg in flown]
    legs = tuple(
        LegDispersion(
            leg=leg.leg,
            origin=leg.origin,
            destination=leg.destination,
            refined_delta_v_m_s=leg.flown_delta_v_m_s,
            mean_delta_v_m_s=float(spent[at].mean()),
            delta_v_m_s=Quantile.of(spent[at], share),
            standoff_miss_m=Quantile.of(missed[at], share),
            standoff_miss_m_s=Quantile.of(apart[at], share),
            arrival_miss_m=Quantile.of(flown[at].arrival_m, share),
            waits_share=float(waiting[at].mean()),
            target_off_m=None if (off := flown[at].target_m) is None else Quantile.of(off, share),
        )
        for at, leg in enumerate(refined.legs)
    )
    return Dispersion(
        flights=spent.shape[1],
        seed=seed,
        corrections=corrections,
        errors=errors,
        refined_delta_v_m_s=refined.flown_delta_v_m_s + refined.holding_m_s,
        delta_v_m_s=Quantile.of(
            spent.sum(axis=0)
            + math.fsum(leg.removal_m_s + leg.holding_m_s for leg in refined.legs),
            share,
        ),
        waits_s=Quantile.of(revolutions @ waiting, share),
        late_share=float(late.mean()),
        legs=legs,
        tanks=tuple(tank_dispersions(instance, refined, spent, share)),
        linearity=Linearity(
            flights=flown[0].exact_m_s.size,
            delta_v_m_s=float(np.abs(sum(leg.exact_m_s for leg in flown)).max()),
            standoff_m=max(leg.exact_m for leg in flown),
        ),
        leg_delta_v_m_s=spent,
        leg_standoff_miss_m=missed,
    )


def _next_departures(instance: Instance, refined: RefinedPlan) -> dict[int, float]:
    """Time after each leg and its tow when its chaser leaves again, or the mission ends [s]."""
    found: dict[int, float] = {}
    for _, legs in refined_routes(instance, refined):
        departures = [*(leg.states[0].time_s for leg in legs), instance.mission.duration_s]
        found |= {leg.leg: next_s for leg, next_s in zip(legs, departures[1:], strict=True)}
    return found
