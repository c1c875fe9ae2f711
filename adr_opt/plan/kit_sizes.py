"""Sizing of kits for the propellant that the disposal of their objects takes."""

from __future__ import annotations

import math

from ..common.constants import EARTH_RADIUS_M, MU_M3_S2, STANDARD_GRAVITY_M_S2
from ..common.errors import InputError
from ..kernels.legs.burns import half_ellipse_speeds
from ..problem.bodies import Target
from ..problem.disposal import Disposal, DisposalCircle
from ..problem.instance import Instance


def disposal_m_s(target: Target) -> float:
    """ΔV of a kit from its object's orbit to the disposal orbit, by burns at apsides [m/s].

    Raises
    ------
    InputError
        One of the orbits is not stated.
    """
    orbit, disposal = target.orbit, target.disposal
    if orbit is None or disposal is None:
        raise InputError(f"{target.name!r}: no disposal orbit for its kit; give its disposal")
    low_m = orbit.semi_major_axis_m * (1.0 - orbit.eccentricity)
    high_m = orbit.semi_major_axis_m * (1.0 + orbit.eccentricity)
    at_apogee = half_ellipse_speeds(high_m, low_m)[0]
    if not isinstance(disposal, DisposalCircle):
        lower_m = min(EARTH_RADIUS_M + disposal.perigee_m, low_m)
        return float(at_apogee - half_ellipse_speeds(high_m, lower_m)[0])
    circle_m = EARTH_RADIUS_M + disposal.circle_m
    leaves, arrives = half_ellipse_speeds(high_m, circle_m)
    return float(abs(at_apogee - leaves) + abs(arrives - math.sqrt(MU_M3_S2 / circle_m)))


def with_sized_kits(instance: Instance, isp_s: float, disposal: Disposal | None = None) -> Instance:
    """The same mission with kits that hold enough propellant to dispose of any of its objects.

    Parameters
    ----------
    instance : Instance
        ``kit_mass_kg`` of its chasers is the mass without propellant.
    isp_s : float
        Specific impulse of the kits [s].
    disposal : DisposalCircle or DisposalPerigee, optional
        Of objects that state none.

    Raises
    ------
    InputError
        An object that takes a kit has no mass, or no orbit of disposal.
    """
    exhaust_m_s = STANDARD_GRAVITY_M_S2 * isp_s
    targets = tuple(
        target.replace(disposal=target.disposal or disposal) if target.service.takes_kit else target
        for target in instance.targets
    )
    takers = [target for target in targets if target.service.takes_kit]
    for target in takers:
        if target.mass_kg is None:
            raise InputError(f"{target.name!r}: its mass_kg is unknown, but sizes its kit; give it")

    def sized(dry_kg: float) -> float:
        needs = (
            (target.mass_kg + dry_kg) * math.expm1(disposal_m_s(target) / exhaust_m_s)
            for target in takers
            if target.mass_kg is not None
        )
        return dry_kg + max(needs, default=0.0)

    chasers = (chaser.replace(kit_mass_kg=sized(chaser.kit_mass_kg)) for chaser in instance.chasers)
    return instance.replace(chasers=tuple(chasers), targets=targets)
