"""Missions of a campaign flown by the contest's own equations, and what became of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.fly.refine.leg import NoWay

from ..reading import FloatArray
from .campaign import Removals, Stop, read_campaign
from .campaigns import better_times
from .ephemeris import Debris, read_ephemeris
from .estimate import legs_m_s
from .expense import expense_meur, launched_kg, propellant_kg
from .flown import Flight, FlownMission, write_flown
from .flying import flown_leg
from .judging import Judged, judged
from .phases import latitude_of

STEP_D, ROUNDS = 0.1, 1
"""Step of the grid on which legs are timed to meet debris in phase [d], and number of rounds."""

LATER_D = 0.0, 0.02, 0.05, 0.1, 0.2, 0.4
"""Delays of a departure for which no impulses were found: a longer stay breaks no rule."""

Tell = Callable[[str], None]


def fly(
    missions: Sequence[Removals], debris: Sequence[Debris], jobs: int = 2, tell: Tell | None = None
) -> tuple[FlownMission, ...]:
    """Fly missions at their times, each leg in its turn.

    Parameters
    ----------
    missions : sequence of Removals
    debris : sequence of Debris
    jobs : int
        Threads.
    tell : callable, optional
        Is told of every leg.

    Raises
    ------
    NoWay
        For a leg no impulses were found, nor when it departs a little later.
    """
    places = [(m, k) for m, mission in enumerate(missions) for k in range(len(mission.stops) - 1)]

    def flown(place: tuple[int, int]) -> tuple[Flight, float]:
        number, k = place
        one, other = missions[number].stops[k : k + 2]
        found = _leg(debris, one, other)
        if tell is not None:
            size = sum(float((impulse @ impulse) ** 0.5) for impulse in found[0].impulses_m_s)
            tell(f"mission {number}, from {one.debris} to {other.debris}: {size:.1f} m/s")
        return found

    with ThreadPoolExecutor(jobs) as threads:
        results = dict(zip(places, threads.map(flown, places), strict=True))
    whole = []
    for number, mission in enumerate(missions):
        legs = [results[number, k] for k in range(len(mission.stops) - 1)]
        departures = [departure for _, departure in legs] + [mission.end_d]
        stops = zip(mission.stops, departures, strict=True)
        removals = Removals(tuple(stop._replace(departure_d=then) for stop, then in stops))
        whole.append(FlownMission(removals, tuple(flight for flight, _ in legs)))
    return tuple(whole)


def _leg(debris: Sequence[Debris], one: Stop, other: Stop) -> tuple[Flight, float]:
    """The impulses of a leg, and its departure [d]."""
    for later in LATER_D:
        departure = one.departure_d + later
        if departure >= other.arrival_d:
            break
        try:
            leg = flown_leg(debris[one.debris], debris[other.debris], departure, other.arrival_d)
        except NoWay:
            continue
        # Differences of times since 2000 are good to a ten-millionth of a second only.
        times = np.clip(leg.times_s - departure * DAY_S, 0.0, (other.arrival_d - departure) * DAY_S)
        return Flight(times, leg.impulses_m_s), departure
    raise NoWay(
        f"no impulses from debris {one.debris} to {other.debris}, "
        f"{one.departure_d:.3f} to {other.arrival_d:.3f}"
    )


def in_phase(
    missions: Sequence[Removals], rows: FloatArray, debris: Sequence[Debris]
) -> tuple[Removals, ...]:
    """Missions at times at which legs meet their debris on their orbits."""
    latitudes = [latitude_of(one) for one in debris]
    return better_times(missions, rows, STEP_D, ROUNDS, latitudes)


def report_flights(
    debris_file: Path, campaign: Path, rows: FloatArray, number: int | None, write: Path | None,
    jobs: int = 2, tell: Tell | None = None,
) -> str:  # fmt: skip
    """Fly a campaign, or one mission of it, and judge it; in Markdown.

    Parameters
    ----------
    debris_file, campaign : Path
        The contest's file, and a campaign in the form of the winner's file.
    rows : (debris, columns) float64
    number : int, optional
        Of the mission, from 0; all without.
    write : Path, optional
        Where a whole campaign is written with its impulses.
    jobs : int
    tell : callable, optional
    """
    missions = read_campaign(campaign)
    if number is not None:
        if not 0 <= number < len(missions):
            raise InputError(f"--fly {number}: {campaign} has missions 0 to {len(missions) - 1}")
        missions = missions[number : number + 1]
    debris, since = read_ephemeris(debris_file), time.process_time()
    try:
        flown = fly(in_phase(missions, rows, debris), debris, jobs, tell)
    except NoWay as error:
        raise InputError(f"{campaign}: {error}; give another campaign") from None
    spent = f"\n\nFlown in {time.process_time() - since:.0f} s of processors."
    found = judged(flown, debris)
    if number is not None:
        return leg_table(flown[0], found, rows) + spent
    if write is not None:
        write_flown(write, flown)
    return mission_table(flown, found, rows) + spent


def leg_table(mission: FlownMission, found: Judged, rows: FloatArray) -> str:
    """The legs of a mission that was judged alone, in Markdown."""
    stops = mission.removals.stops
    planned = legs_m_s(mission.removals, rows)
    lines = [
        "| from | to | departure [MJD2000] | transfer [d] | estimate [m/s] | flown [m/s] "
        "| impulses | off [m] | off [m/s] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    ways = zip(stops[:-1], stops[1:], planned, mission.flights, found.legs[0], strict=True)
    for one, other, wanted, flight, leg in ways:
        days = f"{one.departure_d:.2f} | {other.arrival_d - one.departure_d:.2f}"
        lines.append(
            f"| {one.debris} | {other.debris} | {days} | {wanted:.1f} | {leg.delta_v_m_s:.1f} "
            f"| {len(flight.times_s)} | {leg.miss_m:.1e} | {leg.miss_m_s:.1e} |"
        )
    legs = [leg.delta_v_m_s for leg in found.legs[0]]
    lines += [
        "",
        f"{sum(planned):.1f} m/s and {expense_meur(launched_kg(planned)):.2f} M€ by the estimate; "
        f"{sum(legs):.1f} m/s, {propellant_kg(legs):.0f} kg of propellant and "
        f"{expense_meur(launched_kg(legs)):.2f} M€ flown.",
    ]
    # A mission by itself leaves other debris where they are.
    return "\n".join([*lines, *(said for said in found.violations if "removed 0" not in said)])


def mission_table(missions: Sequence[FlownMission], found: Judged, rows: FloatArray) -> str:
    """The missions of a campaign that was judged, in Markdown."""
    lines = [
        "| mission | begins [MJD2000] | debris | estimate [M€] | flown [M€] | propellant [kg] "
        "| off [m] | off [m/s] | lowest perigee [km] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    estimates = [
        expense_meur(launched_kg(legs_m_s(mission.removals, rows))) for mission in missions
    ]
    for number, (mission, legs) in enumerate(zip(missions, found.legs, strict=True)):
        lines.append(
            f"| {number} | {mission.removals.begin_d:.1f} | {len(mission.removals.stops)} "
            f"| {estimates[number]:.2f} | {found.score.missions_meur[number]:.2f} "
            f"| {found.score.propellant_kg[number]:.0f} "
            f"| {max((leg.miss_m for leg in legs), default=0.0):.1e} "
            f"| {max((leg.miss_m_s for leg in legs), default=0.0):.1e} "
            f"| {min((leg.perigee_m for leg in legs), default=float('nan')) / 1e3:.0f} |"
        )
    count = sum(len(legs) for legs in found.legs)
    lines += [
        "",
        f"{count} legs. J is {sum(estimates):.2f} M€ by the estimate at these times and "
        f"{found.score.total_meur:.2f} M€ flown; {len(found.violations)} rules broken.",
    ]
    return "\n".join([*lines, *found.violations])
