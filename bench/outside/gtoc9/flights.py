"""Missions of a campaign flown by the contest's own equations, and what became of them."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np

from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable
from adr_opt.fly.refine.leg import NoWay

from ..reading import FloatArray
from ..telling import Doing, silent
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


def fly(
    missions: Sequence[Removals], debris: Sequence[Debris], jobs: int = 2, doing: Doing = silent
) -> Iterator[FlownMission]:
    """Fly missions at their times, each leg in its turn; a mission comes when its legs are flown.

    Parameters
    ----------
    missions : sequence of Removals
    debris : sequence of Debris
    jobs : int
        Threads.
    doing : callable
        Hears of every leg.

    Raises
    ------
    NoWay
        For a leg no impulses were found, nor when it departs a little later.
    """
    places = [(one, other) for mission in missions for one, other in pairwise(mission.stops)]
    with ThreadPoolExecutor(jobs) as threads:
        results = threads.map(lambda place: _leg(debris, *place), places)
        done = 0
        for mission in missions:
            legs = []
            for one, other in pairwise(mission.stops):
                doing(f"from {one.debris} to {other.debris}", done, len(places))
                legs.append(next(results))
                done += 1
            departures = [departure for _, departure in legs] + [mission.end_d]
            stops = zip(mission.stops, departures, strict=True)
            removals = Removals(tuple(stop._replace(departure_d=then) for stop, then in stops))
            yield FlownMission(removals, tuple(flight for flight, _ in legs))


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
    debris_file: Path,
    campaign: Path,
    rows: FloatArray,
    number: int | None,
    write: Path | None,
    jobs: int = 2,
    doing: Doing = silent,
) -> Iterator[str]:
    """Fly a campaign, or one mission of it, and judge it; in Markdown, mission by mission.

    Parameters
    ----------
    debris_file, campaign : Path
        The contest's file, and a campaign in the form of the winner's file.
    rows : (debris, columns) float64
    number : int, optional
        Of the mission, from 0; all without.
    write : Path, optional
        Where a whole campaign is written with its impulses, as far as it is flown.
    jobs : int
    doing : callable
        Hears of every leg.
    """
    missions = read_campaign(campaign)
    if number is not None:
        if not 0 <= number < len(missions):
            raise InputError(f"--fly {number}: {campaign} has missions 0 to {len(missions) - 1}")
        missions = missions[number : number + 1]
    if write is not None:
        check_writable(write)
    debris, since = read_ephemeris(debris_file), time.process_time()

    def flown() -> Iterator[FlownMission]:
        known: list[FlownMission] = []
        doing("phasing", 0, 1)
        for mission in fly(in_phase(missions, rows, debris), debris, jobs, doing):
            known.append(mission)
            if write is not None and number is None:
                write_flown(write, known)
            yield mission

    try:
        if number is not None:
            (mission,) = flown()
            yield leg_table(mission, judged((mission,), debris), rows)
        else:
            yield from mission_table(flown(), debris, rows)
    except NoWay as error:
        raise InputError(f"{campaign}: {error}; give another campaign") from None
    yield f"\nFlown in {time.process_time() - since:.0f} s of processors."


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


def mission_table(
    missions: Iterable[FlownMission], debris: Sequence[Debris], rows: FloatArray
) -> Iterator[str]:
    """Missions judged, in Markdown, each as it comes, and all of them together.

    Parameters
    ----------
    missions : iterable of FlownMission
    debris : sequence of Debris
    rows : (debris, columns) float64
        Elements for the estimate.
    """
    yield (
        "| mission | begins [MJD2000] | debris | estimate [M€] | flown [M€] | propellant [kg] "
        "| off [m] | off [m/s] | lowest perigee [km] |\n|---|---|---|---|---|---|---|---|---|"
    )
    known, estimates = [], []
    for number, mission in enumerate(missions):
        known.append(mission)
        estimates.append(expense_meur(launched_kg(legs_m_s(mission.removals, rows))))
        alone = judged((mission,), debris)
        (legs,), found = alone.legs, alone.score
        yield (
            f"| {number} | {mission.removals.begin_d:.1f} | {len(mission.removals.stops)} "
            f"| {estimates[number]:.2f} | {found.missions_meur[0]:.2f} "
            f"| {found.propellant_kg[0]:.0f} "
            f"| {max((leg.miss_m for leg in legs), default=0.0):.1e} "
            f"| {max((leg.miss_m_s for leg in legs), default=0.0):.1e} "
            f"| {min((leg.perigee_m for leg in legs), default=float('nan')) / 1e3:.0f} |"
        )
    whole = judged(known, debris)
    count = sum(len(legs) for legs in whole.legs)
    yield (
        f"\n{count} legs. J is {sum(estimates):.2f} M€ by the estimate at these times and "
        f"{whole.score.total_meur:.2f} M€ flown; {len(whole.violations)} rules broken."
    )
    yield from whole.violations
