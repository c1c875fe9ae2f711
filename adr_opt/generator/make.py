"""From a family and a seed, or from a name, to an instance."""

from __future__ import annotations

import re
from datetime import UTC, datetime

from ..bodies import Station, Target
from ..chasers import AtStation, Chaser, InOrbit, Tank
from ..errors import InputError
from ..instance import Instance
from ..settings import MissionSettings, TransferSettings
from ..sizes import transfers_for
from .families import FAMILIES, Family, family
from .stream import LARGEST_SEED, stream
from .zones import draw_zones

EPOCH = datetime(2026, 1, 1, tzinfo=UTC)
MOST = 10**6
"""Largest number of targets and of zones."""

NAME = re.compile(
    r"(?P<family>[a-z-]+)-(?P<seed>\d{3,})(?:-n(?P<targets>\d+))?(?:-z(?P<zones>\d+))?"
)


def generate(name: str, seed: int, *, targets: int | None = None, zones: int = 0) -> Instance:
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

    Raises
    ------
    InputError
        Unknown family, or a number out of range.
    """
    kind = family(name)
    for what, value, most in (("seed", seed, LARGEST_SEED), ("zones", zones, MOST)):
        if not 0 <= value <= most:
            raise InputError(f"{what} = {value}: must be between 0 and {most}")
    if targets is not None and not 0 <= targets <= MOST:
        raise InputError(f"targets = {targets}: must be between 0 and {MOST}")
    uniform = stream(seed, kind.purpose)
    low, high = kind.targets
    count = low
    if high > low:
        count = min(high, int(uniform(low, high + 1)))
    if targets is not None:
        count = targets
    width = max(3, len(str(count)))
    suffix = f"-n{count}" if targets is not None else ""
    suffix += f"-z{zones}" if zones else ""
    start = (
        AtStation(station="station")
        if kind.draw_start is None
        else InOrbit(orbit=kind.draw_start(uniform))
    )
    return Instance(
        name=f"{kind.name}-{seed:03d}{suffix}",
        epoch=EPOCH,
        dynamics="j2" if kind.drifts else "two-body",
        stations=() if kind.station is None else (Station(name="station", orbit=kind.station),),
        targets=tuple(
            Target(name=f"debris-{number:0{width}d}", prize=1.0, orbit=kind.draw_target(uniform))
            for number in range(1, count + 1)
        ),
        chasers=(Chaser(name="chaser", start=start, tank=Tank(delta_v_m_s=kind.delta_v_m_s)),),
        mission=_mission(kind),
        transfer=transfers_for(kind.duration_s) if kind.drifts else TransferSettings(),
        keep_out_zones=draw_zones(seed, zones, kind.duration_s),
    )


def _mission(kind: Family) -> MissionSettings:
    if kind.service_s is None:
        return MissionSettings(duration_s=kind.duration_s)
    return MissionSettings(
        duration_s=kind.duration_s, service_revolutions=None, service_s=kind.service_s
    )


def by_name(name: str) -> Instance:
    """The instance that :func:`generate` gives a name, such as ``nominal-042`` or ``cloud-003-z6``.

    Raises
    ------
    InputError
        It is no such name.
    """
    found = NAME.fullmatch(name)
    if found is None or found["family"] not in FAMILIES:
        raise InputError(
            f"instance {name!r} is no name of a generated instance; use FAMILY-SEED such as "
            f"nominal-042, with one of the families {', '.join(FAMILIES)}"
        )
    targets = None if found["targets"] is None else int(found["targets"])
    made = generate(
        found["family"], int(found["seed"]), targets=targets, zones=int(found["zones"] or 0)
    )
    if made.name != name:
        raise InputError(f"instance {name!r} is written {made.name!r}; write it so")
    return made
