"""Campaigns of a scenario: the targets offered to each, and its outcome.

Its instance is the template, with the objects most worth removing that year. It is planned, flown
with failures, and replanned after each.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import timedelta
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M, OBLATENESS_M2
from ...common.errors import InputError
from ...common.stop import Proven
from ...kernels.orbits.ephemeris import secular_rates
from ...kernels.orbits.keyed_draws import keyed_draws
from ...plan.plan import Leg, Plan
from ...problem.air import YEAR_S
from ...problem.bodies import Target
from ...problem.chasers import InOrbit
from ...problem.frame import Frame
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, Follower
from ...problem.support import refuse
from ...run.front import solve
from ...sources.worth.prizes import usual_unit
from ...sources.worth.worth import worth_of
from ..replan.chaser_states import states_at
from ..replan.replanning import replan
from .events import CAMPAIGN_LOSSES, CAPTURES
from .futures import Attempt, FlownCampaign
from .population import NODE, TILT, ObjectPopulation, true_anomalies
from .settings import ScenarioSettings


class Offer(NamedTuple):
    """Objects offered to a campaign.

    Attributes
    ----------
    instance : Instance or None
        None if no object is worth anything.
    numbers : dict of str to int
        Targets by name → numbers of the objects.
    unit : float
        Of prizes [fragment-years].
    """

    instance: Instance | None
    numbers: dict[str, int]
    unit: float


FOLLOWS = Follower(
    "--campaign",
    (FIRST | CAMPAIGNS | MODELLED | {"lifetimes", "controlled re-entry", "end of life"})
    - {
        "given connections",
        "bodies without an orbit",
        "ephemerides",
        "keep-out zones",
        "fixed planes",
    },
)
"""Rules of campaigns in later years: they are planned by the model on the objects in orbit by then,
without known windows; objects towed to a circle leave the population above it."""


def check_template(template: Instance) -> None:
    """Refuse an instance from which campaigns of later years cannot be made.

    Raises
    ------
    InputError
    """
    refuse(template, FOLLOWS)
    if not template.targets:
        raise InputError(
            f"--campaign {template.name!r}: no target states a removal (visit, kit or tow); give "
            "one"
        )


def offer(
    template: Instance,
    population: ObjectPopulation,
    taken: set[int],
    settings: ScenarioSettings,
    year: int,
    start_years: float,
    jobs: int,
) -> Offer:
    """The instance of a campaign on the objects in orbit.

    Parameters
    ----------
    template : Instance
        Of its targets only the first counts, for the kind of its service.
    population : ObjectPopulation
    taken : set of int
        Numbers of objects that a campaign under way is to remove.
    settings : ScenarioSettings
    year : int
    start_years : float
        From the template's epoch to year 0.
    jobs : int
        Threads.
    """
    worth = worth_of(population.bodies, settings.worth_years, settings.activity, jobs)
    places = np.flatnonzero(_eligible(template, population, taken, settings))
    ranks = np.argsort(-worth.alone[places], kind="stable")
    chosen = places[ranks[: settings.targets]]
    if not len(chosen):
        return Offer(None, {}, 1.0)
    floors = np.maximum(worth.floors(chosen, jobs), 0.0)
    unit = usual_unit(float(floors.max()))
    prizes = np.floor(floors / unit)
    chosen, prizes = chosen[prizes > 0.0], prizes[prizes > 0.0]
    if not len(chosen):
        return Offer(None, {}, unit)
    anomalies = true_anomalies(population.orbits[chosen])
    names = set(template.station_names) | {chaser.name for chaser in template.chasers}
    numbers: dict[str, int] = {}
    targets = []
    first = template.targets[0]
    for at, prize, anomaly in zip(chosen, prizes, anomalies, strict=True):
        name = population.bodies.records[at].label
        if name in names or name in numbers:
            name = f"{name} [{population.numbers[at]}]"
        numbers[name] = int(population.numbers[at])
        targets.append(
            Target(
                name=name,
                orbit=_orbit(population.orbits[at], anomaly),
                prize=float(prize),
                mass_kg=float(population.bodies.masses[at]),
                removal=first.removal,
                disposal=first.disposal,
            )
        )
    return Offer(_instance(template, tuple(targets), year, start_years), numbers, unit)


def _eligible(
    template: Instance, population: ObjectPopulation, taken: set[int], settings: ScenarioSettings
) -> np.ndarray[Any, np.dtype[np.bool_]]:
    transfer, altitudes = template.transfer, population.altitudes_m
    low, high = settings.altitude_km or (0.0, math.inf)
    least = max(transfer.min_altitude_m, 1e3 * low)
    if template.targets[0].removal == "tow":
        least = max(least, np.nextafter(template.circle_m(template.targets[0]), math.inf))
    fits = (altitudes >= least) & (altitudes <= min(transfer.max_altitude_m, 1e3 * high))
    fits &= population.orbits[:, 0] > EARTH_RADIUS_M
    first, last = settings.inclination_deg or (0.0, 180.0)
    tilts = np.degrees(population.orbits[:, TILT])
    fits &= (tilts >= first) & (tilts <= last)
    fits &= ~np.isin(population.numbers, sorted(taken))
    eligible: np.ndarray[Any, np.dtype[np.bool_]] = fits
    return eligible


def _orbit(row: np.ndarray[Any, np.dtype[np.float64]], true_anomaly: float) -> Orbit:
    perigee, apogee = float(row[0]), float(row[1])
    angles = np.degrees([row[NODE], row[NODE + 1], true_anomaly]) % 360.0
    return Orbit(
        semi_major_axis_m=0.5 * (perigee + apogee),
        eccentricity=(apogee - perigee) / (apogee + perigee),
        inclination_deg=math.degrees(row[TILT]),
        **dict(
            zip(
                ("raan_deg", "argument_of_perigee_deg", "true_anomaly_deg"),
                angles.tolist(),
                strict=True,
            )
        ),
    )


def _instance(
    template: Instance, targets: tuple[Target, ...], year: int, start_years: float
) -> Instance:
    """The template in a year, with planes of stations and starts drifted under J2."""
    since_s = YEAR_S * (start_years + year)
    epoch = template.epoch + timedelta(seconds=since_s)
    return template.replace(
        name=f"{template.name}-year-{year}",
        epoch=epoch,
        frame=None if template.frame is None else Frame(name="TEME", axes_epoch=epoch),
        stations=tuple(
            station.replace(
                orbit=None if station.orbit is None else drifted(station.orbit, since_s)
            )
            for station in template.stations
        ),
        targets=targets,
        chasers=tuple(
            chaser.replace(start=InOrbit(orbit=drifted(chaser.start.orbit, since_s)))
            if isinstance(chaser.start, InOrbit)
            else chaser
            for chaser in template.chasers
        ),
    )


def drifted(orbit: Orbit, since_s: float) -> Orbit:
    """An orbit after drift of its node and perigee under J2, with unchanged size and phase."""
    node, perigee, _ = secular_rates(
        orbit.semi_major_axis_m,
        orbit.eccentricity,
        math.radians(orbit.inclination_deg),
        OBLATENESS_M2,
    )
    return orbit.replace(
        raan_deg=(orbit.raan_deg + math.degrees(node) * since_s) % 360.0,
        argument_of_perigee_deg=(orbit.argument_of_perigee_deg + math.degrees(perigee) * since_s)
        % 360.0,
    )


LEAST_S = 1e-3


def fails(seed: int, year: int, chance: float) -> bool:
    """Whether the campaign of a year fails at launch."""
    drawn = keyed_draws(seed, year, CAMPAIGN_LOSSES, np.zeros(1, int))
    return chance > 0.0 and float(drawn[0]) < chance


Keep = Callable[[Instance, Plan], None]
"""Called with the instance of a campaign and its first plan."""


def campaign(
    offered: Offer,
    settings: ScenarioSettings,
    seed: int,
    year: int,
    keep: Keep = lambda instance, plan: None,
) -> FlownCampaign | None:
    """Plan and fly a campaign; None if nothing is offered to it.

    A capture that fails is found at the end of its service; the chaser goes on from there, and all
    that has not begun is planned anew, without that object.

    Parameters
    ----------
    offered : Offer
    settings : ScenarioSettings
    seed, year : int
    keep : callable
    """
    instance = offered.instance
    if instance is None:
        return None
    if fails(seed, year, settings.campaign_failure):
        return FlownCampaign(True, len(instance.targets), 0, 0, 0.0, ())
    numbers = np.array(list(offered.numbers.values()))
    drawn = keyed_draws(seed, year, CAPTURES, numbers)
    failing = {
        name
        for name, chance in zip(offered.numbers, drawn, strict=True)
        if chance < settings.capture_failure
    }
    prizes = {target.name: target.prize * offered.unit for target in instance.targets}

    def attempt(leg: Leg) -> Attempt:
        name, failed = leg.destination, leg.destination in failing
        time_s = leg.end_s if failed else leg.done_s
        return Attempt(time_s, offered.numbers[name], name, prizes[name], not failed)

    plan = solve(
        instance, settings.method, time_limit=settings.time_limit_s, seed=seed, stop=Proven()
    ).plan
    if plan is None:
        return FlownCampaign(False, len(instance.targets), 0, 0, 0.0, ())
    keep(instance, plan)
    planned, delta_v_m_s = len(_services(plan, offered)), sum(leg.spent_m_s for leg in plan.legs)
    attempts: list[Attempt] = []
    replanned = 0
    left: Instance = instance
    while plan is not None:
        services = _services(plan, offered)
        # A leg has begun only after its departure, also where a service takes no time.
        wrong = [
            max(leg.end_s, leg.leaves_s + LEAST_S) for leg in services if leg.destination in failing
        ]
        if not wrong:
            attempts += map(attempt, services)
            break
        at_s = min(min(wrong), left.mission.duration_s)
        begun = [leg for state in states_at(left, plan, at_s) for leg in state.legs]
        missed = [leg.destination for leg in begun if leg.destination in failing]
        made = replan(
            left,
            plan,
            at_s,
            missed=missed,
            method=settings.method,
            time_limit=settings.time_limit_s,
            seed=seed,
            stop=Proven(),
        )
        for state in made.states:
            done = state.legs[:-1] if state.is_put else state.legs
            attempts += [attempt(leg) for leg in done if leg.destination in offered.numbers]
        left, plan, replanned = made.instance, made.plan, replanned + 1
    attempts = sorted(attempts)
    return FlownCampaign(
        False, len(instance.targets), planned, replanned, delta_v_m_s, tuple(attempts)
    )


def _services(plan: Plan, offered: Offer) -> list[Leg]:
    return [leg for leg in plan.legs if leg.destination in offered.numbers]
