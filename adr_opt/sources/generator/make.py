"""Instances from a family and a seed, or from a name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from ...common.errors import InputError
from ...problem.bodies import Target
from ...problem.chasers import AnyTank
from ...problem.instance import Instance
from ...problem.orbit import Orbit
from ...problem.settings import MissionSettings, TransferSettings
from ...problem.transfer_sizes import transfers_for
from .families import FAMILIES, Family, family
from .fitting import fitted
from .fleet import chasers_of, stations_of
from .stream import LARGEST_SEED, stream
from .zones import draw_zones

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
MOST = 10**6
"""Maximum number of targets and of zones."""

MOST_CHASERS = 100
"""Maximum number of chasers and of stations."""

NAME = re.compile(
    r"(?P<family>[a-z-]+)-(?P<seed>\d{3,})(?:-n(?P<targets>\d+))?(?:-c(?P<chasers>\d+))?"
    r"(?:-s(?P<stations>\d+))?(?:-z(?P<zones>\d+))?"
)


def generate(  # noqa: PLR0913
    name: str,
    seed: int,
    *,
    targets: int | None = None,
    zones: int = 0,
    chasers: int | None = None,
    stations: int | None = None,
    tank: AnyTank | None = None,
    kits: int | None = None,
    kit_mass_kg: float | None = None,
    towed_kg: float | None = None,
    disposal_altitude_m: float | None = None,
) -> Instance:
    """Draw an instance.

    Parameters
    ----------
    name : str
        A family of :data:`FAMILIES`.
    seed : int
        Not negative.
    targets : int, optional
        Number of targets, instead of the family's.
    zones : int
        Number of keep-out zones to draw; they do not change the field.
    chasers, stations : int, optional
        Numbers of chasers and of stations, instead of the family's. Further stations lie where
        targets might; all chasers are alike and start at the stations in turn, or each in an orbit
        of its own. They do not change the field.
    tank : Tank or TankByMass, optional
        Of each chaser, instead of the family's.
    kits : int, optional
        Each target takes a kit; this is the maximum number aboard each chaser.
    kit_mass_kg : float, optional
        Of each kit; needs a tank by mass [kg].
    towed_kg, disposal_altitude_m : float, optional
        Instead of kits: each target has this mass [kg] and is towed down to a circle there [m];
        needs a tank by mass.

    Raises
    ------
    InputError
        Unknown family, or a number out of range, or kits and tows that cannot be meant.
    """
    kind = family(name)
    for what, value, most in (("seed", seed, LARGEST_SEED), ("zones", zones, MOST)):
        if not 0 <= value <= most:
            raise InputError(f"{what} = {value}: must be between 0 and {most}")
    if targets is not None and not 0 <= targets <= MOST:
        raise InputError(f"targets = {targets}: must be between 0 and {MOST}")
    if chasers is not None and not 1 <= chasers <= MOST_CHASERS:
        raise InputError(f"chasers = {chasers}: must be between 1 and {MOST_CHASERS}")
    fewest = 0 if kind.station is None else 1
    most = 0 if kind.station is None else MOST_CHASERS
    if stations is not None and not fewest <= stations <= most:
        raise InputError(
            f"stations = {stations}: must be between {fewest} and {most} in the family {name}"
        )
    uniform = stream(seed, kind.purpose)
    low, high = kind.targets
    count = low
    if high > low:
        count = min(high, int(uniform(low, high + 1)))
    if targets is not None:
        count = targets
    width = max(3, len(str(count)))
    suffix = f"-n{count}" if targets is not None else ""
    suffix += "" if chasers in (None, kind.chasers) else f"-c{chasers}"
    suffix += "" if stations in (None, fewest) else f"-s{stations}"
    suffix += f"-z{zones}" if zones else ""
    start = None if kind.draw_start is None else kind.draw_start(uniform)
    there = stations_of(kind, seed, fewest if stations is None else stations)
    objects = tuple(
        _target(kind, f"debris-{number:0{width}d}", kind.draw_target(uniform))
        for number in range(1, count + 1)
    )
    drawn = Instance(
        name=f"{kind.name}-{seed:03d}{suffix}",
        epoch=EPOCH,
        dynamics="j2" if kind.drifts else "two-body",
        stations=there,
        targets=objects,
        chasers=chasers_of(kind, seed, chasers or kind.chasers, start, there),
        mission=_mission(kind),
        transfer=_transfers(kind, [each.orbit for each in objects if each.orbit is not None]),
        keep_out_zones=draw_zones(seed, zones, kind.duration_s),
    )
    return fitted(
        drawn,
        tank=tank,
        kits=kits,
        kit_mass_kg=kit_mass_kg,
        towed_kg=towed_kg,
        disposal_altitude_m=disposal_altitude_m,
    )


def _target(kind: Family, name: str, orbit: Orbit) -> Target:
    mass_kg = None if kind.mass_kg is None else kind.mass_kg(orbit)
    return Target(name=name, orbit=orbit, prize=1.0, mass_kg=mass_kg, removal=kind.removal)


def _transfers(kind: Family, orbits: Sequence[Orbit]) -> TransferSettings:
    if kind.transfer is not None:
        return kind.transfer
    return transfers_for(kind.duration_s, orbits=orbits) if kind.drifts else TransferSettings()


def _mission(kind: Family) -> MissionSettings:
    if kind.service_s is None:
        return MissionSettings(duration_s=kind.duration_s)
    return MissionSettings(
        duration_s=kind.duration_s,
        service_revolutions=None,
        service_s=kind.service_s,
        disposal_altitude_m=kind.disposal_altitude_m,
    )


def family_of(name: str) -> str:
    """The family at the beginning of an instance's name."""
    found = NAME.fullmatch(name)
    return "" if found is None else found["family"]


def by_name(name: str) -> Instance:
    """The instance from :func:`generate` by its name, such as ``nominal-042`` or ``cloud-003-z6``.

    Raises
    ------
    InputError
        It is no such name.
    """
    found = NAME.fullmatch(name)
    if found is None or found["family"] not in FAMILIES:
        raise InputError(
            f"instance {name!r} is not the name of a generated instance; use FAMILY-SEED such "
            f"as nominal-042, with one of the families {', '.join(FAMILIES)}"
        )
    counts: dict[str, Any] = {
        what: int(found[what])
        for what in ("targets", "zones", "chasers", "stations")
        if found[what] is not None
    }
    made = generate(found["family"], int(found["seed"]), **counts)
    if made.name != name:
        raise InputError(f"instance {name!r}: write it as {made.name!r}")
    return made
