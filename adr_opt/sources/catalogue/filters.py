"""Filters that select targets from a catalogue."""

from __future__ import annotations

import fnmatch
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M
from ...common.errors import InputError
from .records import ElementSet, shown

Range = tuple[float, float]

WILD = "*?["


@dataclass(frozen=True)
class Filters:
    """Limits on the mean orbit at the epoch of the instance; with None, everything passes.

    Attributes
    ----------
    altitude_km : (float, float) or None
        Of the mean semi-major axis, the radius that is planned with, above 6378.137 km.
    inclination_deg : (float, float) or None
    raan_deg : (float, float) or None
        Eastwards from the first to the second, through 360° if the second is smaller.
    names : tuple of str
        Patterns with ``*``, ``?`` and ``[…]``, or parts of names without them; upper and lower
        case are alike. An object passes that fits one of them.
    """

    altitude_km: Range | None = None
    inclination_deg: Range | None = None
    raan_deg: Range | None = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for what, limits in (
            ("altitude", self.altitude_km),
            ("inclination", self.inclination_deg),
            ("RAAN", self.raan_deg),
        ):
            if limits is None:
                continue
            if any(math.isnan(limit) for limit in limits):
                raise InputError(f"{what} {limits[0]:g}:{limits[1]:g}: must be two numbers LO:HI")
            if what != "RAAN" and limits[0] > limits[1]:
                raise InputError(
                    f"{what} {limits[0]:g}:{limits[1]:g}: the first must not exceed the second"
                )

    def match_name(self, record: ElementSet) -> bool:
        """Whether the name of an object passes."""
        name = record.name.casefold()
        for pattern in self.names:
            wanted = pattern.casefold()
            if any(sign in wanted for sign in WILD):
                if fnmatch.fnmatchcase(name, wanted):
                    return True
            elif wanted in name:
                return True
        return not self.names

    def outside(self, elements: npt.NDArray[np.float64]) -> dict[str, npt.NDArray[np.bool_]]:
        """Objects whose orbits each filter excludes.

        Parameters
        ----------
        elements : (object, element) float64
            Columns of :data:`~.propagation.ELEMENTS`.

        Returns
        -------
        dict
            Filter → (object,) bool.
        """
        found = {}
        if self.altitude_km is not None:
            altitude_km = (elements[:, 0] - EARTH_RADIUS_M) / 1e3
            found["altitude"] = _outside(altitude_km, self.altitude_km)
        if self.inclination_deg is not None:
            found["inclination"] = _outside(np.degrees(elements[:, 2]), self.inclination_deg)
        if self.raan_deg is not None:
            low, high = self.raan_deg
            if not high - low >= 360.0:
                width = (high - low) % 360.0
                beyond = np.remainder(np.degrees(elements[:, 3]) - low, 360.0)
                found["raan"] = beyond > width
            else:
                found["raan"] = np.zeros(len(elements), dtype=bool)
        return found

    def told_ranges(self, elements: npt.NDArray[np.float64]) -> str:
        """Ranges of the filtered quantities over all objects, in words; empty without filters.

        Parameters
        ----------
        elements : (object, element) float64
            As for :meth:`outside`; rows of NaN do not count.
        """
        known = elements[np.isfinite(elements[:, 0])]
        if not len(known):
            return ""
        told = [
            f"{what} are {low:.4g} to {high:.4g} {unit}"
            for what, limits, values, unit in (
                ("altitudes", self.altitude_km, (known[:, 0] - EARTH_RADIUS_M) / 1e3, "km"),
                ("inclinations", self.inclination_deg, np.degrees(known[:, 2]), "deg"),
                ("RAANs", self.raan_deg, np.degrees(known[:, 3]) % 360.0, "deg"),
            )
            if limits is not None
            for low, high in ((float(values.min()), float(values.max())),)
        ]
        return ", ".join(told)


def _outside(values: npt.NDArray[np.float64], limits: Range) -> npt.NDArray[np.bool_]:
    outside: npt.NDArray[np.bool_] = (values < limits[0]) | (values > limits[1])
    return outside


def parse_range(text: str, option: str, *, open_ended: bool = True) -> Range:
    """Two numbers given as ``LO:HI``; one may be omitted if ``open_ended``.

    Raises
    ------
    InputError
        They are not.
    """
    low, sign, high = (part.strip() for part in text.partition(":"))
    try:
        limits = (
            float(low) if low or not open_ended else -math.inf,
            float(high) if high or not open_ended else math.inf,
        )
        if not sign or not (low or high) or any(part in ("nan", "inf") for part in (low, high)):
            raise ValueError
        if not all(math.isfinite(x) for x, part in zip(limits, (low, high), strict=True) if part):
            raise ValueError
    except ValueError:
        raise InputError(f"{option} = {shown(text)!r}: give two numbers as LO:HI") from None
    return limits
