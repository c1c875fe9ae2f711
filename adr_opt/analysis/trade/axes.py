"""Axes of a trade-off: limits of an instance, and the values of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.chasers import TankByMass
from ...problem.instance import Instance

YEAR_S = 365.25 * DAY_S

MOST_POINTS = 10_000
"""Maximum number of points; more must be a typing error."""


class PointLimits(NamedTuple):
    """Position of a point in the grid.

    Attributes
    ----------
    delta_v_m_s, duration_s : float
        Of a full tank, and of the mission.
    thrust_n, isp_s : float or None
        Of chasers with low thrust; None where that is not varied.
    """

    delta_v_m_s: float
    duration_s: float
    thrust_n: float | None = None
    isp_s: float | None = None


@dataclass(frozen=True)
class AxisKind:
    """A limit that can be varied.

    Attributes
    ----------
    name, unit : str
        As a command line says them.
    scale : float
        What one unit is in SI.
    title : str
        As charts say it.
    of_designs : bool
        Whether it makes another design, of which :func:`..design.study.design_study` makes plans.
    whole, may_be_zero : bool
        Which values it takes.
    """

    name: str
    unit: str
    scale: float
    title: str
    of_designs: bool = False
    whole: bool = False
    may_be_zero: bool = False


KINDS = {
    kind.name: kind
    for kind in (
        AxisKind("delta-v", "m/s", 1.0, "ΔV of a full tank [m/s]"),
        AxisKind("propellant", "kg", 1.0, "propellant of a full tank [kg]"),
        AxisKind("duration", "days", DAY_S, "duration [days]"),
        AxisKind("thrust", "N", 1.0, "thrust [N]"),
        AxisKind("isp", "s", 1.0, "specific impulse [s]"),
        AxisKind("launches", "", 1.0, "launches", of_designs=True, whole=True),
        AxisKind("separation", "years", YEAR_S, "years between launches", True, may_be_zero=True),
        AxisKind("kits", "", 1.0, "kits aboard", of_designs=True, whole=True),
        AxisKind("dry-mass", "kg", 1.0, "dry mass [kg]", of_designs=True),
        AxisKind("start", "days", DAY_S, "first launch [days]", True, may_be_zero=True),
        AxisKind("launch", "years", YEAR_S, "launch date [years]", True, may_be_zero=True),
        AxisKind("altitude", "km", 1e3, "altitude launched into [km]", of_designs=True),
        AxisKind("budget", "euros", 1.0, "budget [euros]", of_designs=True),
    )
}
"""Limits that can be varied, by name."""


@dataclass(frozen=True)
class Tanks:
    """The varied limit of tanks, with its values.

    Attributes
    ----------
    limit : {"", "delta_v_m_s", "propellant_kg"}
        Nothing where tanks stay as they are.
    values : tuple of (float, float)
        The ΔV by which points are told apart [m/s], and what the limit is there: that ΔV itself
        where nothing else is said.
    """

    limit: str = ""
    values: tuple[tuple[float, float], ...] = ()

    def changes(self, delta_v_m_s: float) -> dict[str, float]:
        """Keyword arguments of ``with_limits`` for the tanks at a point."""
        return {self.limit: dict(self.values).get(delta_v_m_s, delta_v_m_s)} if self.limit else {}


@dataclass(frozen=True)
class Axis:
    """A limit with its values, ascending, in SI units.

    Attributes
    ----------
    kind : str
        One of :data:`KINDS`.
    values : tuple of float
        [m/s], [kg], [s], [N], euros, or numbers.
    """

    kind: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"vary {self.kind!r}: unknown; use one of: {', '.join(KINDS)}")
        kind = KINDS[self.kind]
        least = -math.ulp(0.0) if kind.may_be_zero else 0.0
        if not self.values or not all(least < value < math.inf for value in self.values):
            wanted = "numbers of at least 0" if kind.may_be_zero else "positive numbers"
            raise InputError(f"vary {self.kind}: its values must be {wanted}")
        if kind.whole and any(value != round(value) for value in self.values):
            raise InputError(f"vary {self.kind}: its values must be whole numbers")
        if sorted(set(self.values)) != list(self.values):
            raise InputError(f"vary {self.kind}: its values must ascend, each given once")


def parse_axis(text: str) -> Axis:
    """An axis as ``NAME=LO:HI:STEP`` or ``NAME=VALUE,VALUE…``; durations are in days.

    Raises
    ------
    InputError
        It is not of that form, or a number makes no sense.
    """
    name, sign, said = (part.strip() for part in text.partition("="))
    if not (sign and name and said):
        raise InputError(f"--vary {text!r}: give it as NAME=LO:HI:STEP or NAME=VALUE,VALUE…")
    if name not in KINDS:
        raise InputError(f"--vary {text!r}: {name!r} is unknown; use one of: {', '.join(KINDS)}")
    is_range = ":" in said
    try:
        numbers = [float(part) for part in said.split(":" if is_range else ",")]
        if is_range and len(numbers) != 3:
            raise ValueError
    except ValueError:
        raise InputError(f"--vary {text!r}: give numbers, as LO:HI:STEP or VALUE,VALUE…") from None
    values = _range(text, *numbers) if is_range else sorted(numbers)
    return Axis(name, tuple(KINDS[name].scale * value for value in values))


def _range(text: str, low: float, high: float, step: float) -> list[float]:
    if not all(map(math.isfinite, (low, high, step))) or step <= 0.0 or high < low:
        raise InputError(f"--vary {text!r}: LO must not exceed HI, and STEP must be positive")
    count = math.floor((high - low) / step + 1e-9) + 1
    if count > MOST_POINTS:
        raise InputError(f"--vary {text!r}: {count} values, more than the {MOST_POINTS} allowed")
    return [round(low + number * step, 9) for number in range(count)]


def grid(instance: Instance, axes: Sequence[Axis]) -> list[PointLimits]:
    """All combinations of the axes' values, ascending.

    Raises
    ------
    InputError
        No axis, one twice, too many points, or what is varied is not there: a tank that has one ΔV,
        or low thrust.
    """
    by_kind = {axis.kind: axis for axis in axes}
    if not axes:
        raise InputError("nothing is varied; say what with --vary, as delta-v=1000:6000:500")
    if len(by_kind) < len(axes):
        raise InputError("one limit is varied twice; give its values in one list")
    for axis in axes:
        if KINDS[axis.kind].of_designs:
            raise InputError(
                f"vary {axis.kind}: each value is another design, with plans and bounds of its "
                "own; use adr_opt.analysis.design_study"
            )
    tanks = tanks_of(instance, axes)
    durations = (
        by_kind["duration"].values if "duration" in by_kind else (instance.mission.duration_s,)
    )
    found = []
    for thrust_n, isp_s in _drives(instance, by_kind):
        # Where tanks stay, points are not told apart by this number.
        largest_m_s = with_drive(instance, thrust_n, isp_s).largest_tank_m_s
        delta_vs = tuple(value for value, _ in tanks.values) or (largest_m_s,)
        found += [PointLimits(*each, thrust_n, isp_s) for each in product(delta_vs, durations)]
    if len(found) > MOST_POINTS:
        raise InputError(f"{len(found)} points, more than {MOST_POINTS}")
    return sorted(found)


def own_limits(
    instance: Instance, axes: Sequence[Axis], limits: Sequence[PointLimits]
) -> tuple[list[Axis], list[PointLimits]]:
    """Axes and points with the limits that the instance itself has, where no drive is varied."""
    by_mass = [c.tank.propellant_kg for c in instance.chasers if isinstance(c.tank, TankByMass)]
    own = {
        "delta-v": instance.largest_tank_m_s,
        "duration": instance.mission.duration_s,
        "propellant": max(by_mass, default=0.0),
    }
    if not all(axis.kind in own for axis in axes):
        return list(axes), list(limits)
    wider, at = [], []
    for axis in axes:
        value = own[axis.kind]
        value = next((each for each in axis.values if math.isclose(each, value)), value)
        wider.append(Axis(axis.kind, tuple(sorted({*axis.values, value}))))
        at.append(Axis(axis.kind, (value,)))
    return wider, sorted({*limits, *grid(instance, at)})


def _drives(
    instance: Instance, by_kind: dict[str, Axis]
) -> Iterator[tuple[float | None, float | None]]:
    """All combinations of thrust and specific impulse; None if unchanged."""
    varied = [kind for kind in ("thrust", "isp") if kind in by_kind]
    if varied and not instance.has_low_thrust:
        raise InputError(
            f"vary {varied[0]}: no chaser of {instance.name!r} has low thrust; give one a thrust_n"
        )
    if "isp" in by_kind and "propellant" in by_kind:
        raise InputError(
            "vary isp or propellant: both change the ΔV of a tank, which identifies points"
        )
    thrusts, impulses = (
        by_kind[kind].values if kind in by_kind else (None,) for kind in ("thrust", "isp")
    )
    return product(thrusts, impulses)


def with_drive(instance: Instance, thrust_n: float | None, isp_s: float | None) -> Instance:
    """The instance with another thrust and specific impulse of all chasers with low thrust.

    Raises
    ------
    InputError
        One of them is not valid.
    """
    if thrust_n is None and isp_s is None:
        return instance
    chasers = []
    for chaser in instance.chasers:
        if chaser.thrust_n is not None:
            if thrust_n is not None:
                chaser = chaser.replace(thrust_n=thrust_n)
            if isp_s is not None:
                chaser = chaser.replace(tank=chaser.tank.replace(isp_s=isp_s))
        chasers.append(chaser)
    return instance.replace(chasers=tuple(chasers))


def tanks_of(instance: Instance, axes: Sequence[Axis]) -> Tanks:
    """The varied limit of tanks.

    Raises
    ------
    InputError
        It cannot be: masses count and ΔV is varied, or there are none and propellant is.
    """
    by_kind = {axis.kind: axis for axis in axes}
    if "delta-v" in by_kind and "propellant" in by_kind:
        raise InputError("vary delta-v or propellant, not both: each states the content of a tank")
    if "delta-v" in by_kind:
        for chaser in instance.chasers:
            if counts_masses(instance) and isinstance(chaser.tank, TankByMass):
                raise InputError(
                    f"vary delta-v: the tank of {chaser.name!r} is one by mass, and masses count "
                    "(kit_mass_kg, tows, expense or low thrust); vary propellant, in kg"
                )
        values = by_kind["delta-v"].values
        return Tanks("delta_v_m_s", tuple(zip(values, values, strict=True)))
    if "propellant" in by_kind:
        if any(station.max_propellant_kg is not None for station in instance.stations):
            raise InputError(
                "vary propellant: a station has a max_propellant_kg, of which larger tanks take "
                "more, so that points cannot be compared; leave the limit out"
            )
        values = by_kind["propellant"].values
        largest_m_s = [
            instance.with_limits(propellant_kg=value).largest_tank_m_s for value in values
        ]
        return Tanks("propellant_kg", tuple(zip(largest_m_s, values, strict=True)))
    return Tanks()


def counts_masses(instance: Instance) -> bool:
    """Whether a chaser's mass matters beyond the ΔV of its tank without cargo."""
    return (
        instance.has_low_thrust
        or any(target.service.is_flown for target in instance.targets)
        or any(chaser.kit_mass_kg > 0.0 or chaser.priced.counts_mass for chaser in instance.chasers)
    )
