"""Settings of a flight with all forces: objects and solar activity."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple

from ...common.errors import InputError

Activity = Literal["low", "mean", "high"]

DEGREE = 20
"""Degree and order of the gravity field."""

MOST_AREA_MASS, MOST_DRAG, MOST_REFLECTION = 100.0, 10.0, 2.0
"""Largest accepted values; a foil has 100 m²/kg, and a mirror reflects everything."""


class SpaceWeather(NamedTuple):
    """Indices of an atmosphere model: radio flux F10.7 [sfu], and geomagnetic Ap and Kp."""

    f107: float
    ap: float
    kp: float


WEATHER: dict[Activity, SpaceWeather] = {
    "low": SpaceWeather(65.0, 0.0, 0.0),
    "mean": SpaceWeather(140.0, 15.0, 3.0),
    "high": SpaceWeather(250.0, 45.0, 5.0),
}
"""Long-term reference levels of ISO 14222:2013 (and ECSS-E-ST-10-04C), with the Kp of each Ap."""


@dataclass(frozen=True)
class Forces:
    """Objects that forces act on, and the activity of the Sun.

    Attributes
    ----------
    area_mass_m2_kg : float
        Cross-section of a chaser over its mass [m²/kg].
    target_area_mass_m2_kg : float or None
        The same of all other bodies; None for that of the chaser.
    drag : float
        Drag coefficient Cd of both.
    reflection : float
        Coefficient of radiation pressure Cr of both: 1 absorbs, 2 reflects straight back.
    activity : {"low", "mean", "high"}

    Raises
    ------
    InputError
        One is negative, not a number, or too large to be meant.
    """

    area_mass_m2_kg: float = 0.01
    target_area_mass_m2_kg: float | None = None
    drag: float = 2.2
    reflection: float = 1.3
    activity: Activity = "mean"

    def __post_init__(self) -> None:
        for name, value, most in (
            ("area-mass", self.area_mass_m2_kg, MOST_AREA_MASS),
            ("target-area-mass", self.of_targets_m2_kg, MOST_AREA_MASS),
            ("cd", self.drag, MOST_DRAG),
            ("cr", self.reflection, MOST_REFLECTION),
        ):
            if not 0.0 <= value <= most:
                raise InputError(f"{name} = {value:g}: must lie between 0 and {most:g}")
        if self.activity not in WEATHER:
            raise InputError(f"activity = {self.activity!r}: use one of {', '.join(WEATHER)}")

    @property
    def of_targets_m2_kg(self) -> float:
        """Cross-section over mass of bodies [m²/kg]."""
        own = self.target_area_mass_m2_kg
        return self.area_mass_m2_kg if own is None else own

    @property
    def weather(self) -> SpaceWeather:
        """Indices of the activity."""
        return WEATHER[self.activity]

    def to_dict(self) -> dict[str, Any]:
        """The settings as plain data, with all that they mean."""
        return asdict(self) | {
            "target_area_mass_m2_kg": self.of_targets_m2_kg,
            "f107": self.weather.f107,
            "ap": self.weather.ap,
            "gravity_degree": DEGREE,
        }
