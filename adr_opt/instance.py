"""The instance: one chaser's mission over a field of debris, as data and as a file.

The pydantic models below are the format ``adr-opt-instance/1``: the published JSON Schema is made
from them (:func:`json_schema`). All are frozen; :meth:`Record.replace` makes variants.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Collection
from datetime import UTC, datetime
from typing import Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import (
    AfterValidator,
    AwareDatetime,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_serializer,
    model_validator,
)

from .errors import InputError
from .files import read_model, sentence, to_text
from .kernels.constants import EARTH_RADIUS_M, MU_M3_S2, SLACK_M, SLACK_S, STATION
from .kernels.transfer import TransferRule

FORMAT: Literal["adr-opt-instance/1"] = "adr-opt-instance/1"

# A name ends up in formats of other programs, which end texts at a NUL.
Name = Annotated[str, Field(min_length=1, pattern=r"^[^\x00]*$")]
NonNegative = Annotated[float, Field(ge=0.0)]
Positive = Annotated[float, Field(gt=0.0)]

# Far beyond any use, and near enough for arithmetic to hold: two-body motion about the Earth ends
# some 1.5 million km out, angles of many turns have lost their digits, prizes are summed and
# divided, and solvers count ΔV in whole steps.
LARGEST_LENGTH_M = 1e9
LARGEST_ANGLE_DEG = 1e6
LARGEST_DELTA_V_M_S = 1e9
LARGEST_PRIZE = 1e12
LEAST_PRIZE = 1e-12
LARGEST_DURATION_S = 100 * 365.25 * 86400.0

Length = Annotated[float, Field(gt=0.0, le=LARGEST_LENGTH_M)]
Angle = Annotated[float, Field(ge=-LARGEST_ANGLE_DEG, le=LARGEST_ANGLE_DEG)]


def _is_nothing_or_enough(prize: float) -> float:
    if 0.0 < prize < LEAST_PRIZE:
        raise ValueError(f"must be 0 or at least {LEAST_PRIZE:g}")
    return prize


Prize = Annotated[
    float,
    Field(
        ge=0.0,
        le=LARGEST_PRIZE,
        json_schema_extra={"anyOf": [{"const": 0.0}, {"minimum": LEAST_PRIZE}]},
    ),
    AfterValidator(_is_nothing_or_enough),
]


class Record(BaseModel):
    """Base of all data: frozen, strict about types, no unknown keys, no NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed.

        Raises
        ------
        InputError
            A change is not valid.
        """
        values = {name: getattr(self, name) for name in type(self).model_fields}
        try:
            return type(self)(**(values | changes))
        except ValidationError as error:
            raise InputError(sentence(error)) from None


class Orbit(Record):
    """Keplerian elements in the inertial frame at the epoch of the instance."""

    semi_major_axis_m: Length
    eccentricity: Annotated[float, Field(ge=0.0, lt=1.0)]
    inclination_deg: Annotated[float, Field(ge=0.0, le=180.0)]
    raan_deg: Angle
    argument_of_perigee_deg: Angle
    true_anomaly_deg: Angle

    @model_validator(mode="after")
    def _above_the_ground(self) -> Self:
        perigee = self.semi_major_axis_m * (1.0 - self.eccentricity)
        if perigee <= EARTH_RADIUS_M:
            raise ValueError(
                f"the perigee radius of {perigee:.0f} m is under the ground "
                f"({EARTH_RADIUS_M:.0f} m); raise semi_major_axis_m or lower eccentricity"
            )
        return self

    def circular_elements(self) -> tuple[float, float, float, float]:
        """The circle that is planned with: radius, inclination, RAAN, argument of latitude.

        r = a and u = argument of perigee + mean anomaly (MODEL section 1) [m, rad].
        """
        e = self.eccentricity
        true = math.radians(self.true_anomaly_deg)
        eccentric = true - 2.0 * math.atan2(
            # atan(β sin ν / (1 + β cos ν)) form of E: no loss of digits, no branch at ν = π
            (e / (1.0 + math.sqrt(1.0 - e * e))) * math.sin(true),
            1.0 + (e / (1.0 + math.sqrt(1.0 - e * e))) * math.cos(true),
        )
        mean = eccentric - e * math.sin(eccentric)
        latitude = math.radians(self.argument_of_perigee_deg) + mean
        return (
            self.semi_major_axis_m,
            math.radians(self.inclination_deg),
            math.radians(self.raan_deg),
            latitude,
        )

    def eccentricity_vector(self) -> npt.NDArray[np.float64]:
        """Inertial eccentricity vector, shape (3,)."""
        i, o, w = (
            math.radians(x)
            for x in (self.inclination_deg, self.raan_deg, self.argument_of_perigee_deg)
        )
        node = np.array([math.cos(o), math.sin(o), 0.0])
        ahead = np.array(
            [-math.sin(o) * math.cos(i), math.cos(o) * math.cos(i), math.sin(i)], dtype=float
        )
        return self.eccentricity * (math.cos(w) * node + math.sin(w) * ahead)


class Station(Record):
    """Where the chaser starts and refuels."""

    name: Name
    orbit: Orbit


class Target(Record):
    """A debris object that may be visited, and what servicing it is worth."""

    name: Name
    prize: Prize = 1.0
    orbit: Orbit


class MissionLimits(Record):
    """Duration, ΔV budget and the time spent at a body (in its periods)."""

    duration_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)]
    delta_v_m_s: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)]
    service_revolutions: NonNegative = 1.0
    refuel_revolutions: NonNegative = 1.0


class TransferSettings(Record):
    """Parameters of the co-elliptic sequence (MODEL section 2)."""

    first_leg_fraction: Annotated[float, Field(ge=0.0, le=1.0)] = 0.75
    standoff_m: NonNegative = 1000.0
    safety_ellipse_revolutions: Positive = 0.5
    max_phasing_revolutions: Annotated[int, Field(ge=0, le=100)] = 12
    min_altitude_m: Length = 300e3
    max_altitude_m: Length = 2000e3
    time_value_m_s_per_h: NonNegative = 75.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.max_altitude_m <= self.min_altitude_m:
            raise ValueError(
                f"max_altitude_m = {self.max_altitude_m!r} must be greater than "
                f"min_altitude_m = {self.min_altitude_m!r}"
            )
        if self.safety_ellipse_revolutions % 1.0 != 0.5:
            raise ValueError(
                f"safety_ellipse_revolutions = {self.safety_ellipse_revolutions!r} must be 0.5 "
                "plus whole inspection laps (0.5, 1.5, …)"
            )
        return self


class KeepOutZone(Record):
    """A closed altitude band that is forbidden during a closed time window (MODEL section 5)."""

    min_altitude_m: NonNegative
    max_altitude_m: NonNegative
    start_s: float
    end_s: float

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.max_altitude_m < self.min_altitude_m:
            raise ValueError(
                f"max_altitude_m = {self.max_altitude_m!r} must not be less than "
                f"min_altitude_m = {self.min_altitude_m!r}"
            )
        if self.end_s < self.start_s:
            raise ValueError(
                f"end_s = {self.end_s!r} must not be before start_s = {self.start_s!r}"
            )
        return self


def _is_calendar_time(value: Any) -> Any:
    """Refuse what pydantic would take for seconds since 1970."""
    if isinstance(value, datetime) or (isinstance(value, str) and value[4:5] == "-"):
        return value
    raise ValueError("must be a time like 2026-01-01T00:00:00Z")


def _has_utc(epoch: datetime) -> datetime:
    try:
        epoch.astimezone(UTC)
    except OverflowError:
        raise ValueError("must lie in the years 1 to 9999 in UTC") from None
    return epoch


class Instance(Record):
    """A mission to plan. Bodies are numbered with the station first, then the targets in order."""

    format: Literal["adr-opt-instance/1"] = FORMAT
    name: Name
    epoch: Annotated[
        AwareDatetime,
        Field(strict=False),
        BeforeValidator(_is_calendar_time),
        AfterValidator(_has_utc),
    ]
    station: Station
    targets: Annotated[tuple[Target, ...], Field(strict=False)]
    mission: MissionLimits
    transfer: TransferSettings = TransferSettings()
    keep_out_zones: Annotated[tuple[KeepOutZone, ...], Field(strict=False)] = ()

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        seen = {self.station.name}
        for number, target in enumerate(self.targets):
            if target.name in seen:
                raise ValueError(
                    f"field targets[{number}].name = {target.name!r}: another body has this name; "
                    "give each its own"
                )
            seen.add(target.name)
        return self

    @field_serializer("epoch")
    def _epoch_text(self, epoch: datetime) -> str:
        return epoch.astimezone(UTC).isoformat().replace("+00:00", "Z")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, the station first."""
        return (self.station.name, *(target.name for target in self.targets))

    @property
    def body_orbits(self) -> tuple[Orbit, ...]:
        """Orbits of the bodies, the station first."""
        return (self.station.orbit, *(target.orbit for target in self.targets))

    @property
    def is_approximate(self) -> bool:
        """Whether some orbit is not a circle, so that the model is an approximation of it."""
        return any(orbit.eccentricity > 0.0 for orbit in self.body_orbits)

    def part(self, bodies: Collection[int]) -> Instance:
        """The instance with only some of its bodies, in its own order; the station stays."""
        targets = [self.targets[body - 1] for body in sorted(bodies) if body != STATION]
        return self.replace(targets=targets)

    def to_json(self) -> str:
        """The instance file, the same bytes on every machine."""
        return to_text(self.model_dump(mode="json"))

    @property
    def sha256(self) -> str:
        """SHA-256 of the file that :meth:`to_json` gives; plans carry it."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    def orbits(self) -> npt.NDArray[np.float64]:
        """Circular orbits of the bodies, shape (bodies, 4), columns ``kernels.ORBIT_COLUMNS``."""
        return np.array([orbit.circular_elements() for orbit in self.body_orbits])

    def eccentricity_delta_v(self) -> npt.NDArray[np.float64]:
        """Cost of matching eccentricity vectors, v·|Δe|/2 with the destination's circular speed.

        Returns
        -------
        (origin, destination) float64
            [m/s]; zero between circles (MODEL section 1).
        """
        orbits = self.body_orbits
        vectors = np.array([orbit.eccentricity_vector() for orbit in orbits])
        speeds = np.sqrt(MU_M3_S2 / np.array([orbit.semi_major_axis_m for orbit in orbits]))
        difference = np.linalg.norm(vectors[:, None, :] - vectors[None, :, :], axis=2)
        cost: npt.NDArray[np.float64] = 0.5 * difference * speeds[None, :]
        return cost

    def transfer_rule(self) -> TransferRule:
        """The transfer settings and zones as the kernels take them (radii, m/s per s).

        Zones are closed, so the slack of the model is theirs: what touches one is in it.
        """
        settings = self.transfer
        zones = np.array(
            [
                (
                    EARTH_RADIUS_M + zone.min_altitude_m - SLACK_M,
                    EARTH_RADIUS_M + zone.max_altitude_m + SLACK_M,
                    zone.start_s - SLACK_S,
                    zone.end_s + SLACK_S,
                )
                for zone in self.keep_out_zones
            ],
            dtype=float,
        ).reshape(-1, 4)
        return TransferRule(
            settings.first_leg_fraction,
            settings.standoff_m,
            settings.safety_ellipse_revolutions,
            settings.max_phasing_revolutions,
            EARTH_RADIUS_M + settings.min_altitude_m,
            EARTH_RADIUS_M + settings.max_altitude_m,
            settings.time_value_m_s_per_h / 3600.0,
            zones,
        )


def load(path: str | os.PathLike[str]) -> Instance:
    """Read an instance file.

    Raises
    ------
    InputError
        No such file, not JSON, or not a valid instance.
    """
    return read_model(path, Instance)


def json_schema() -> dict[str, Any]:
    """The JSON Schema of the instance file."""
    schema = Instance.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
