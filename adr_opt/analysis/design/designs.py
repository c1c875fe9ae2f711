"""Designs of a campaign: the varied limits of an instance, and the instance of each design."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product

from ...common.errors import InputError
from ...problem.chasers import Chaser, LaunchedInto, TankByMass
from ...problem.instance import Instance
from ...problem.rules import CAMPAIGNS, FIRST, MODELLED, Follower
from ...problem.support import refuse
from ..trade.axes import KINDS, MOST_POINTS, Axis, with_drive

MOST_LAUNCHES = 200
"""Maximum number of launches; more must be a typing error."""


@dataclass(frozen=True)
class Design:
    """A design: one value for each varied limit.

    Attributes
    ----------
    values : tuple of (str, float)
        Kinds of axes, in the order given, and values in SI units, euros or numbers.
    """

    values: tuple[tuple[str, float], ...]

    def value(self, kind: str) -> float | None:
        """Value of a varied limit; None if the limit is not varied."""
        return dict(self.values).get(kind)

    @property
    def budget(self) -> float:
        """Budget for plans; +inf if it is not varied [euros]."""
        value = self.value("budget")
        return math.inf if value is None else value

    @property
    def title(self) -> str:
        """The design in words."""
        return ", ".join(
            f"{kind} {shown(kind, value)} {KINDS[kind].unit}".rstrip()
            for kind, value in self.values
        )

    def to_dict(self) -> dict[str, float]:
        """Values by kind, in the units of a command line."""
        return {kind: round(value / KINDS[kind].scale, 9) for kind, value in self.values}


def shown(kind: str, value: float) -> str:
    """A value in the unit of a command line."""
    return f"{value / KINDS[kind].scale:,.10g}"


def designs_of(axes: Sequence[Axis]) -> list[Design]:
    """All combinations of the values of some axes, the last axis varying fastest.

    Raises
    ------
    InputError
        No axis, one twice, two for one tank, or too many combinations.
    """
    kinds = [axis.kind for axis in axes]
    if not kinds:
        raise InputError("nothing is varied; say what with --vary, as launches=1:5:1")
    if len(set(kinds)) < len(kinds):
        raise InputError("one limit is varied twice; give its values in one list")
    if {"delta-v", "propellant"} <= set(kinds):
        raise InputError("vary delta-v or propellant, not both: each states the content of a tank")
    count = 1
    for axis in axes:
        count *= len(axis.values)
    if count > MOST_POINTS:
        raise InputError(f"{count} points, more than {MOST_POINTS}")
    every = product(*(axis.values for axis in axes))
    return [Design(tuple(zip(kinds, values, strict=True))) for values in every]


def designed(instance: Instance, design: Design) -> Instance:
    """The instance of a design, apart from its budget.

    Raises
    ------
    InputError
        A value is not valid, or there is nothing in the instance that it could change.
    """
    values = dict(design.values)
    made = instance
    if "launches" in values:
        made = made.replace(chasers=launched(made, round(values["launches"])))
    if "dry-mass" in values or "isp" in values:
        made = _with_masses(made, values.get("dry-mass"), values.get("isp"))
    if "thrust" in values:
        if not made.has_low_thrust:
            raise InputError(
                f"vary thrust: no chaser of {made.name!r} has low thrust; give one a thrust_n"
            )
        made = with_drive(made, values["thrust"], None)
    if "kits" in values:
        if not any(target.service.takes_kit for target in made.targets):
            raise InputError(
                f'vary kits: no target of {made.name!r} takes a kit; give some removal "kit"'
            )
        kits = round(values["kits"])
        made = _each(made, [chaser.replace(kits=kits) for chaser in made.chasers])
    if "separation" in values:
        made = _separated(made, values["separation"])
    if "start" in values:
        made = _shifted(made, values["start"])
    if "altitude" in values:
        made = _lifted(made, values["altitude"])
    if "launch" in values:
        later_s = values["launch"] - min(chaser.available_s[0] for chaser in made.chasers)
        made = _shifted(made, values["launch"])
        made = made.with_limits(made.mission.duration_s + later_s)
    return made.with_limits(values.get("duration"), values.get("delta-v"), values.get("propellant"))


def launched(instance: Instance, count: int) -> tuple[Chaser, ...]:
    """The first chasers of an instance, with copies of its last one if there are too few.

    Copies are launched, or available, as long after each other as the last two chasers are.

    Raises
    ------
    InputError
        There are too many.
    """
    if count > MOST_LAUNCHES:
        raise InputError(f"vary launches: {count}, more than {MOST_LAUNCHES}")
    chasers = list(instance.chasers[:count])
    *before, last = instance.chasers
    later_s = last.available_s[0] - before[-1].available_s[0] if before else 0.0
    taken = {*instance.names, *(chaser.name for chaser in instance.chasers)}
    stem = re.sub(r"-?\d+$", "", last.name) or last.name
    number = len(chasers)
    while len(chasers) < count:
        number += 1
        name = f"{stem}-{number}"
        if name in taken:
            continue
        taken.add(name)
        since, until = chasers[-1].available_s
        chasers.append(last.replace(name=name, available_s=(since + max(later_s, 0.0), until)))
    return tuple(chasers)


def _with_masses(instance: Instance, dry_mass_kg: float | None, isp_s: float | None) -> Instance:
    changes = {"dry_mass_kg": dry_mass_kg, "isp_s": isp_s}
    changes = {name: value for name, value in changes.items() if value is not None}
    chasers = []
    for chaser in instance.chasers:
        if not isinstance(chaser.tank, TankByMass):
            raise InputError(
                f"vary {'isp' if dry_mass_kg is None else 'dry-mass'}: the tank of "
                f"{chaser.name!r} is given in ΔV, without masses; give its dry_mass_kg, "
                "propellant_kg and isp_s"
            )
        chasers.append(chaser.replace(tank=chaser.tank.replace(**changes)))
    return _each(instance, chasers)


SEPARATED = Follower(
    "vary separation",
    FIRST | CAMPAIGNS | MODELLED | {"functions of time", "capture windows"},
    "vary launches instead",
)
"""Varied launches are at fixed intervals, not at times that the plan chooses."""


def _separated(instance: Instance, separation_s: float) -> Instance:
    """The instance with each chaser launched or available a fixed time after the previous one."""
    refuse(instance, SEPARATED)
    first_s = instance.chasers[0].available_s[0]
    made = _each(
        instance,
        [
            chaser.replace(available_s=(first_s + number * separation_s, chaser.available_s[1]))
            for number, chaser in enumerate(instance.chasers)
        ],
    )
    # What the file says of launches would push them further apart.
    return made.replace(mission=made.mission.replace(launch_separation_s=None))


def _lifted(instance: Instance, altitude_m: float) -> Instance:
    """The instance with another altitude of launches into orbits."""
    if all(chaser.launch is None for chaser in instance.chasers):
        raise InputError(
            f"vary altitude: no chaser of {instance.name!r} is launched into an orbit; give one a "
            'start {"launch": …}'
        )
    starts = [
        LaunchedInto(launch=chaser.launch.replace(altitude_m=altitude_m))
        if chaser.launch
        else chaser.start
        for chaser in instance.chasers
    ]
    every = zip(instance.chasers, starts, strict=True)
    return _each(instance, [chaser.replace(start=start) for chaser, start in every])


def _shifted(instance: Instance, start_s: float) -> Instance:
    """The instance with availability shifted so that the first chaser starts at a time."""
    later_s = start_s - min(chaser.available_s[0] for chaser in instance.chasers)
    return _each(
        instance,
        [
            chaser.replace(available_s=(chaser.available_s[0] + later_s, chaser.available_s[1]))
            for chaser in instance.chasers
        ],
    )


def _each(instance: Instance, chasers: Iterable[Chaser]) -> Instance:
    return instance.replace(chasers=tuple(chasers))
