"""One mission of a campaign flown by the contest's own equations, beside what the estimate says."""

from __future__ import annotations

from pathlib import Path

from adr_opt.errors import InputError
from adr_opt.refining.leg import NoWay

from ..reading import FloatArray
from .campaign import read_campaign
from .estimate import legs_m_s
from .expense import expense_meur, launched_kg, propellant_kg
from .flying import FlownLeg, flown_leg, read_ephemeris
from .retiming import retimed

LEAST_D = 1.0
"""Shorter transfers are none: the estimate has no phase, and theirs cost what it does not say."""

STEP_D = 0.1


def report_flight(debris: Path, campaign: Path, number: int, rows: FloatArray) -> str:
    """Legs of a mission by the estimate and as flown, in Markdown.

    Parameters
    ----------
    debris, campaign : Path
        The contest's file, and a campaign in the form of the winner's file.
    number : int
        Of the mission, from 0.
    rows : (debris, columns) float64
    """
    missions = read_campaign(campaign)
    if not 0 <= number < len(missions):
        raise InputError(f"--fly {number}: {campaign} has missions 0 to {len(missions) - 1}")
    mission = missions[number]
    if any(
        other.arrival_d - one.departure_d < LEAST_D
        for one, other in zip(mission.stops[:-1], mission.stops[1:], strict=True)
    ):
        mission = retimed(mission, rows, STEP_D, least_d=LEAST_D)
    ephemeris = read_ephemeris(debris)
    planned = legs_m_s(mission, rows)
    lines = [
        "| from | to | departure [MJD2000] | transfer [d] | estimate [m/s] | flown [m/s] "
        "| impulses | off [m] | off [m/s] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    flown: list[FlownLeg] = []
    for one, other, wanted in zip(mission.stops[:-1], mission.stops[1:], planned, strict=True):
        days = f"{one.departure_d:.1f} | {other.arrival_d - one.departure_d:.1f}"
        begin = f"| {one.debris} | {other.debris} | {days} | {wanted:.1f}"
        try:
            leg = flown_leg(
                ephemeris[one.debris], ephemeris[other.debris], one.departure_d, other.arrival_d
            )
        except NoWay:
            lines.append(f"{begin} | – | – | – | – |")
            continue
        flown.append(leg)
        lines.append(
            f"{begin} | {leg.delta_v_m_s:.1f} | {leg.impulses} | {leg.miss_m:.1e} "
            f"| {leg.miss_m_s:.1e} |"
        )
    lines += ["", f"{len(flown)} of {len(planned)} legs flown to their debris."]
    if len(flown) == len(planned):
        legs = [leg.delta_v_m_s for leg in flown]
        lines.append(
            f"{sum(planned):.1f} m/s and {expense_meur(launched_kg(planned)):.2f} M€ by the "
            f"estimate; {sum(legs):.1f} m/s, {propellant_kg(legs):.0f} kg of propellant and "
            f"{expense_meur(launched_kg(legs)):.2f} M€ flown."
        )
    return "\n".join(lines)
