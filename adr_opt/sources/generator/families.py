"""Families of instances: everything but the seed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from ...common.constants import DAY_S, HOUR_S
from ...common.errors import InputError
from ...problem.bodies import DisposalCircle
from ...problem.chasers import Chaser
from ...problem.orbit import Orbit
from ...problem.settings import TransferSettings
from . import belt, clouds, rocket_bodies
from .stream import Uniform


@dataclass(frozen=True)
class Family:
    """A family of instances.

    Attributes
    ----------
    name, summary : str
    targets : (int, int)
        Least and largest number of targets; the seed draws it.
    duration_s, delta_v_m_s : float
    station : Orbit or None
        None without refuelling.
    draw_target : callable
        From a source of uniform numbers to the orbit of a target.
    purpose : int
        Number of the stream that the field is drawn from. Families of one purpose and one
        ``draw_target`` share the field of one seed.
    draw_start : callable, optional
        Draws the orbit where the chaser starts, before all targets, if that is not the station.
    drifts : bool
        Whether nodes drift: under J2, with the transfers of
        :func:`adr_opt.problem.transfer_sizes.transfers_for`.
    transfer : TransferSettings, optional
        How transfers are laid out, where that does not follow from the duration.
    service_s : float, optional
        Time spent at a target, instead of a revolution [s].
    chasers : int
        How many; all alike.
    draw_chaser : callable, optional
        From a number, counted from 0, to the chaser, where they are not alike.
    removal : {"visit", "kit", "tow"}
        Of all targets.
    disposal : DisposalCircle, optional
        The circle that targets are towed to.
    mass_kg : callable, optional
        From the orbit of a target to its mass [kg].
    """

    name: str
    summary: str
    targets: tuple[int, int]
    duration_s: float
    delta_v_m_s: float
    station: Orbit | None = belt.STATION
    draw_target: Callable[[Uniform], Orbit] = belt.draw_circle
    purpose: int = 0
    draw_start: Callable[[Uniform], Orbit] | None = None
    drifts: bool = False
    transfer: TransferSettings | None = None
    service_s: float | None = None
    chasers: int = 1
    draw_chaser: Callable[[int], Chaser] | None = None
    removal: Literal["visit", "kit", "tow"] = "visit"
    disposal: DisposalCircle | None = None
    mass_kg: Callable[[Orbit], float] | None = None


FAMILIES = {
    family.name: family
    for family in (
        Family("tiny", "6-8 targets, 1.5 days, 1 km/s", (6, 8), 1.5 * DAY_S, 1000.0),
        Family("nominal", "50 targets, 7 days, 3 km/s", (50, 50), 7.0 * DAY_S, 3000.0),
        Family("reduced-time", "50 targets, 3 days, 3 km/s", (50, 50), 3.0 * DAY_S, 3000.0),
        Family("reduced-fuel", "50 targets, 7 days, 1 km/s", (50, 50), 7.0 * DAY_S, 1000.0),
        Family(
            "cloud",
            "50 fragments, 10 days, 4 km/s",
            (clouds.CLOUD_TARGETS, clouds.CLOUD_TARGETS),
            10.0 * DAY_S,
            4000.0,
            clouds.CLOUD_STATION,
            clouds.draw_fragment,
            purpose=2,
        ),
        Family(
            "campaign",
            "50 targets, 3 chasers, 7 days, 1 km/s, 8 h at each target",
            (50, 50),
            7.0 * DAY_S,
            1000.0,
            service_s=8.0 * HOUR_S,
            chasers=3,
        ),
        Family("large", "200 targets, 30 days, 3 km/s", (200, 200), 30.0 * DAY_S, 3000.0),
        Family(
            "rocket-bodies",
            "20 rocket bodies, 730 days, 3 km/s",
            (rocket_bodies.TARGETS, rocket_bodies.TARGETS),
            730.0 * DAY_S,
            3000.0,
            None,
            rocket_bodies.draw_rocket_body,
            purpose=3,
            draw_start=rocket_bodies.draw_start,
            drifts=True,
            service_s=DAY_S,
        ),
        Family(
            "sso",
            "60 targets, 365 days, 3 km/s",
            (belt.SSO_TARGETS, belt.SSO_TARGETS),
            365.0 * DAY_S,
            3000.0,
            belt.SSO_STATION,
            belt.draw_debris,
            purpose=4,
            drifts=True,
            service_s=DAY_S,
        ),
        Family(
            "removal",
            "60 rocket bodies, 4 launches, 1,826 days, kits",
            (rocket_bodies.REMOVAL_TARGETS, rocket_bodies.REMOVAL_TARGETS),
            rocket_bodies.DURATION_S,
            rocket_bodies.REMOVAL_TANK.delta_v_m_s,
            None,
            rocket_bodies.draw_removal_target,
            purpose=5,
            drifts=True,
            service_s=10.0 * DAY_S,
            chasers=rocket_bodies.REMOVAL_CHASERS,
            draw_chaser=rocket_bodies.removal_chaser,
            removal="kit",
            mass_kg=rocket_bodies.mass_kg,
        ),
        Family(
            "electric",
            "60 rocket bodies, 3 electric chasers, 1,826 days, tows",
            (rocket_bodies.REMOVAL_TARGETS, rocket_bodies.REMOVAL_TARGETS),
            rocket_bodies.DURATION_S,
            rocket_bodies.ELECTRIC_TANK.delta_v_m_s,
            None,
            rocket_bodies.draw_removal_target,
            purpose=5,
            drifts=True,
            transfer=rocket_bodies.ELECTRIC_TRANSFER,
            service_s=rocket_bodies.ELECTRIC_SERVICE_S,
            chasers=rocket_bodies.ELECTRIC_CHASERS,
            draw_chaser=rocket_bodies.electric_chaser,
            removal="tow",
            disposal=DisposalCircle(circle_m=rocket_bodies.DISPOSAL_ALTITUDE_M),
            mass_kg=rocket_bodies.mass_kg,
        ),
        Family(
            "fragment-cloud",
            "1900 fragments, 60 days, 4 km/s",
            (clouds.FRAGMENTS_TARGETS, clouds.FRAGMENTS_TARGETS),
            60.0 * DAY_S,
            4000.0,
            clouds.FRAGMENTS_STATION,
            clouds.draw_piece,
            purpose=6,
            drifts=True,
            transfer=clouds.FRAGMENTS_TRANSFER,
        ),
    )
}
"""The families by name."""


def family(name: str) -> Family:
    """The family with a name.

    Raises
    ------
    InputError
        There is none; the sentence lists them.
    """
    if name not in FAMILIES:
        raise InputError(f"family {name!r} is unknown; use one of {', '.join(FAMILIES)}")
    return FAMILIES[name]
