"""What is varied: limits of an instance, and the values that each takes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from ...errors import InputError
from ...instance import Instance
from ...kernels.constants import DAY_S

MOST_POINTS = 10_000
"""More points than this are a typing error."""

Limits = tuple[float, float]
"""ΔV of a full tank [m/s], duration [s]."""


@dataclass(frozen=True)
class Kind:
    """A limit that can be varied.

    Attributes
    ----------
    name, unit : str
        As a command line says them.
    scale : float
        What one unit is in SI.
    """

    name: str
    unit: str
    scale: float


KINDS = {kind.name: kind for kind in (Kind("delta-v", "m/s", 1.0), Kind("duration", "days", DAY_S))}


@dataclass(frozen=True)
class Axis:
    """A limit and the values that it takes, ascending, in SI.

    Attributes
    ----------
    kind : {"delta-v", "duration"}
    values : tuple of float
        [m/s] or [s].
    """

    kind: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"vary {self.kind!r}: unknown; use one of: {', '.join(KINDS)}")
        if not self.values or not all(0.0 < value < math.inf for value in self.values):
            raise InputError(f"vary {self.kind}: its values must be positive numbers")
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


def grid(instance: Instance, axes: Sequence[Axis]) -> list[Limits]:
    """All points: every value of each axis with every one of the others, ascending.

    Raises
    ------
    InputError
        No axis, one twice, too many points, or a tank that has no one ΔV is varied.
    """
    by_kind = {axis.kind: axis for axis in axes}
    if not axes:
        raise InputError("nothing is varied; say what with --vary, as delta-v=1000:6000:500")
    if len(by_kind) < len(axes):
        raise InputError("one limit is varied twice; give its values in one list")
    tanks = {chaser.tank.delta_v_m_s for chaser in instance.chasers}
    if "delta-v" not in by_kind and len(tanks) > 1:
        # Nothing is read off this number but how points compare, and all have the same.
        tanks = {max(tanks)}
    delta_vs = by_kind["delta-v"].values if "delta-v" in by_kind else tuple(tanks)
    durations = (
        by_kind["duration"].values if "duration" in by_kind else (instance.mission.duration_s,)
    )
    if len(delta_vs) * len(durations) > MOST_POINTS:
        raise InputError(f"{len(delta_vs) * len(durations)} points, more than {MOST_POINTS}")
    return list(product(delta_vs, durations))
