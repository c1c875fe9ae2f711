"""Changed equipment of a family's chasers: tanks, kits, and tows of targets."""

from __future__ import annotations

from typing import Any

from ...common.errors import InputError
from ...problem.chasers import AnyTank
from ...problem.instance import Instance

SUFFIX = "-fitted"
"""Suffix of the names of such instances, which state no numbers and are in no library."""


def fitted(
    instance: Instance,
    *,
    tank: AnyTank | None = None,
    kits: int | None = None,
    kit_mass_kg: float | None = None,
    towed_kg: float | None = None,
    disposal_altitude_m: float | None = None,
) -> Instance:
    """The instance with other tanks, with kits or with tows; unchanged without arguments.

    Parameters
    ----------
    instance : Instance
    tank, kits, kit_mass_kg, towed_kg, disposal_altitude_m
        As :func:`adr_opt.generate` takes them.

    Raises
    ------
    InputError
        Kits and tows together, one of them said by half, or masses in a tank that is counted in ΔV.
    """
    if kits is not None and towed_kg is not None:
        raise InputError("a target takes a kit or is towed; give kits or a mass to tow")
    if (towed_kg is None) != (disposal_altitude_m is None):
        raise InputError("a tow needs a mass and a disposal altitude; give both or none")
    carried = instance.chasers[0].kits is not None
    if kit_mass_kg is not None and kits is None and (not carried or towed_kg is not None):
        raise InputError(f"kit mass = {kit_mass_kg:g} kg: there are no kits; say how many")
    of_chasers: dict[str, Any] = {}
    of_targets: dict[str, Any] = {}
    if tank is not None:
        of_chasers["tank"] = tank
    if kits is not None:
        of_chasers["kits"], of_targets["removal"] = kits, "kit"
    if kit_mass_kg is not None:
        of_chasers["kit_mass_kg"] = kit_mass_kg
    if towed_kg is not None:
        of_chasers |= {"kits": None, "kit_mass_kg": 0.0}
        of_targets |= {"removal": "tow", "mass_kg": towed_kg}
    if not of_chasers and not of_targets:
        return instance
    mission = instance.mission
    if disposal_altitude_m is not None:
        mission = mission.replace(disposal_altitude_m=disposal_altitude_m)
    return instance.replace(
        name=f"{instance.name}{SUFFIX}",
        chasers=tuple(chaser.replace(**of_chasers) for chaser in instance.chasers),
        targets=tuple(target.replace(**of_targets) for target in instance.targets),
        mission=mission,
    )
