"""The instance: a mission over a field of debris, as data and as a file.

The pydantic models of the format ``adr-opt-instance/2`` stand here and in :mod:`.orbit`,
:mod:`.bodies`, :mod:`.chasers` and :mod:`.settings`: the published JSON Schema is made from them
(:func:`json_schema`). All are frozen; :meth:`Record.replace` makes variants.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Collection
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import (
    AfterValidator,
    AwareDatetime,
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationError,
    field_serializer,
    model_validator,
)

from .agreement import check_names, check_orbits, check_stations
from .bodies import Station, Target
from .chasers import AtStation, Chaser, InOrbit
from .errors import InputError
from .files import check_writable, read_model, sentence, to_text, write_text
from .given import Given
from .given_files import read_named, write_given
from .kernels.constants import (
    EARTH_RADIUS_M,
    HOUR_S,
    OBLATENESS_M2,
    SLACK_M,
    SLACK_S,
)
from .kernels.eccentricity import matchings
from .kernels.orbits import ORBIT_COLUMNS
from .kernels.transfer import TransferRule
from .orbit import Orbit
from .records import Name, Record
from .settings import GivenFile, KeepOutZone, MissionSettings, Objective, TransferSettings

FORMAT: Literal["adr-opt-instance/2"] = "adr-opt-instance/2"

LEO = Orbit(
    semi_major_axis_m=EARTH_RADIUS_M + 700e3, eccentricity=0.0, inclination_deg=98.0,
    raan_deg=0.0, argument_of_perigee_deg=0.0, true_anomaly_deg=0.0,
)  # fmt: skip
"""Some orbit."""

SPENT_BY_DRIFTING, REFUELLED = 0.8, 3.0
"""What an hour is worth where planes drift, as a multiple of a tank over the mission; and so many
times as much where there are stations."""

TIME_VALUE_M_S_PER_H = 75.0
"""What an hour is worth to whoever chooses one transfer without looking ahead, if nobody says."""


def is_calendar_time(value: Any) -> Any:
    """Refuse what pydantic would take for seconds since 1970."""
    if isinstance(value, datetime) or (isinstance(value, str) and value[4:5] == "-"):
        return value
    raise ValueError("must be a time like 2026-01-01T00:00:00Z")


def has_utc(epoch: datetime) -> datetime:
    """Refuse what is out of the calendar in UTC."""
    try:
        epoch.astimezone(UTC)
    except OverflowError:
        raise ValueError("must lie in the years 1 to 9999 in UTC") from None
    return epoch


class Instance(Record):
    """A mission to plan.

    Bodies are numbered: the stations in order, then the orbits of their own where chasers start,
    then the targets in order.
    """

    format: Literal["adr-opt-instance/2"] = FORMAT
    name: Name
    epoch: Annotated[
        AwareDatetime,
        Field(strict=False),
        BeforeValidator(is_calendar_time),
        AfterValidator(has_utc),
    ]
    dynamics: Literal["two-body", "j2"] = "two-body"
    stations: Annotated[tuple[Station, ...], Field(strict=False)]
    targets: Annotated[tuple[Target, ...], Field(strict=False)]
    chasers: Annotated[tuple[Chaser, ...], Field(strict=False, min_length=1)]
    mission: MissionSettings
    transfer: TransferSettings = TransferSettings()
    objective: Objective = Objective()
    keep_out_zones: Annotated[tuple[KeepOutZone, ...], Field(strict=False)] = ()

    _time_value_m_s_per_h: float | None = PrivateAttr(default=None)
    _given: Given | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _something_drifts(self) -> Self:
        if self.dynamics == "two-body" and self.transfer.max_drift_s > 0.0:
            raise ValueError(
                f"field transfer.max_drift_s = {self.transfer.max_drift_s!r}: nothing drifts in "
                'two-body motion; write 0.0, or dynamics "j2"'
            )
        return self

    @model_validator(mode="after")
    def _parts_agree(self) -> Self:
        check_names(self.stations, self.targets, self.chasers)
        check_stations(self.stations, self.chasers)
        is_given = self.transfer.given is not None
        check_orbits(self.stations, self.targets, self.mission, is_given=is_given)
        if is_given and self.keep_out_zones:
            raise ValueError(
                "field keep_out_zones: connections are given, and nobody knows where they lead; "
                "leave zones out"
            )
        return self

    def __eq__(self, other: object) -> bool:
        """Whether it is the same mission; what an hour is worth is no part of it."""
        if not isinstance(other, Instance):
            return NotImplemented
        return all(
            getattr(self, field) == getattr(other, field) for field in type(self).model_fields
        )

    def __hash__(self) -> int:
        return hash(tuple(getattr(self, field) for field in type(self).model_fields))

    @classmethod
    def from_json(cls, text: str) -> Instance:
        """The instance that a JSON text holds, in this format or in a former one."""
        from . import formats_1

        former = formats_1.instance_of(text)
        return super().from_json(text) if former is None else former

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed.

        Raises
        ------
        InputError
            A change is not valid.
        """
        made = super().replace(**changes)
        made._time_value_m_s_per_h = self._time_value_m_s_per_h
        if made.transfer.given == self.transfer.given:
            made._given = self._given
        return made

    def with_given(self, given: Given, file: str | None = None) -> Self:
        """The same instance whose connections are given, in place of the model's.

        Parameters
        ----------
        given : Given
        file : str, optional
            What the file is called that :meth:`save` writes them to, beside that of the instance;
            by default as the instance says, or "connections.parquet".

        Raises
        ------
        InputError
            A connection is from or to a body that the instance does not have, or a field makes no
            sense with it.
        """
        strange = sorted(set(given.names) - set(self.names))
        if strange:
            raise InputError(f"given connections: {strange[0]!r} is not a body of {self.name!r}")
        if file is None:
            file = self.transfer.given.file if self.transfer.given else "connections.parquet"
        try:
            reference = GivenFile(file=file, sha256=given.sha256)
        except ValidationError as error:
            raise InputError(sentence(error)) from None
        made = self.replace(transfer=self.transfer.replace(given=reference))
        made._given = given
        return made

    @property
    def given(self) -> Given | None:
        """The connections that are given; None where they are the model's.

        Raises
        ------
        InputError
            They are in a file that was not read.
        """
        reference = self.transfer.given
        if reference is not None and self._given is None:
            raise InputError(
                f"the connections of {self.name!r} are in {reference.file!r}, which was not read; "
                "read the instance with adr_opt.load from a file beside it"
            )
        return self._given

    @property
    def nodes_drift(self) -> bool:
        """Whether planes drift as chasers fly: under J2, where connections are the model's."""
        return self.dynamics == "j2" and self.transfer.given is None

    @property
    def has_orbits(self) -> bool:
        """Whether all bodies have an orbit."""
        return all(orbit is not None for orbit in self.known_orbits)

    def with_time_value(self, time_value_m_s_per_h: float) -> Self:
        """The same instance for those who value an hour so, see :attr:`time_value_m_s_per_h`.

        Raises
        ------
        InputError
            It is negative or not finite.
        """
        if not (math.isfinite(time_value_m_s_per_h) and time_value_m_s_per_h >= 0.0):
            raise InputError(
                f"time_value_m_s_per_h = {time_value_m_s_per_h!r}: must be a finite number ≥ 0"
            )
        made = self.model_copy()
        made._time_value_m_s_per_h = time_value_m_s_per_h
        return made

    def same(self, other: Instance) -> bool:
        """Whether it is equal to another one, and an hour is worth as much to both."""
        return self == other and self.time_value_m_s_per_h == other.time_value_m_s_per_h

    @property
    def time_value_m_s_per_h(self) -> float:
        """What an hour is worth to whoever chooses one transfer without looking ahead [m/s per h].

        No part of the file, of equality and of :attr:`sha256`: a default for methods, and that of
        a file of the format ``adr-opt-instance/1`` is what the file says.
        """
        if self._time_value_m_s_per_h is None:
            return TIME_VALUE_M_S_PER_H * self.hurry
        return self._time_value_m_s_per_h

    @property
    def hurry(self) -> float:
        """How dear time is here, against a mission of days: 1, and less where planes drift.

        There time buys ΔV, and is worth what the mission spends on the average; a chaser that can
        refuel spends more than one tank. So it is where connections are given.
        """
        duration_s, is_given = self.mission.duration_s, self.transfer.given is not None
        if (self.transfer.max_drift_s == 0.0 and not is_given) or duration_s == 0.0:
            return 1.0
        share = SPENT_BY_DRIFTING * (REFUELLED if self.stations else 1.0)
        spent = share * self.largest_tank_m_s * HOUR_S / duration_s / TIME_VALUE_M_S_PER_H
        # Of given costs nobody knows the unit, so no usual value is a limit.
        return spent if is_given else min(1.0, spent)

    def with_limits(
        self, duration_s: float | None = None, delta_v_m_s: float | None = None
    ) -> Self:
        """The same field for a mission of another duration or with other tanks.

        Raises
        ------
        InputError
            A limit is not valid.
        """
        changes: dict[str, Any] = {}
        if duration_s is not None:
            changes["mission"] = self.mission.replace(duration_s=duration_s)
        if delta_v_m_s is not None:
            changes["chasers"] = tuple(
                chaser.replace(tank={"delta_v_m_s": delta_v_m_s}) for chaser in self.chasers
            )
        return self.replace(**changes)

    @field_serializer("epoch")
    def _epoch_text(self, epoch: datetime) -> str:
        return epoch.astimezone(UTC).isoformat().replace("+00:00", "Z")

    @property
    def chaser(self) -> Chaser:
        """The chaser, where there is one.

        Raises
        ------
        InputError
            There are several: whoever asks works with one.
        """
        if len(self.chasers) > 1:
            raise InputError(
                f"{self.name!r} has {len(self.chasers)} chasers, and this works with one; leave "
                "one in its field chasers"
            )
        return self.chasers[0]

    @property
    def largest_tank_m_s(self) -> float:
        """The most ΔV that a chaser has at once [m/s]."""
        return max(chaser.tank.delta_v_m_s for chaser in self.chasers)

    @property
    def station_names(self) -> tuple[str, ...]:
        """Names of the stations."""
        return tuple(station.name for station in self.stations)

    @property
    def start_bodies(self) -> dict[str, Orbit]:
        """Orbits of their own where chasers start, by the name of the chaser.

        A chaser that is launched anywhere has none: an orbit stands there so that each body has
        one, and no transfer leads to it or from it (:attr:`launches`).
        """
        some = (self.targets[0].orbit if self.targets else None) or LEO
        return {
            chaser.name: chaser.start.orbit if isinstance(chaser.start, InOrbit) else some
            for chaser in self.chasers
            if not isinstance(chaser.start, AtStation)
        }

    @property
    def launches(self) -> dict[int, float]:
        """When each chaser may be launched that starts anywhere, by the body of its start [s]."""
        return {
            self.names.index(chaser.name): chaser.available_s[0]
            for chaser in self.chasers
            if chaser.is_launched
        }

    @property
    def start(self) -> int:
        """Number of the body where the chaser starts, where there is one."""
        return self.names.index(self.chaser.start_name)

    @property
    def starts(self) -> tuple[int, ...]:
        """Number of the body where each chaser starts."""
        return tuple(self.names.index(chaser.start_name) for chaser in self.chasers)

    @property
    def first_target(self) -> int:
        """Number of the first target; those before it are stations and where chasers start."""
        return len(self.stations) + len(self.start_bodies)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of their numbers."""
        return (
            *self.station_names,
            *self.start_bodies,
            *(target.name for target in self.targets),
        )

    @property
    def known_orbits(self) -> tuple[Orbit | None, ...]:
        """Orbits of the bodies, in the order of their numbers; None for those that have none."""
        return (
            *(station.orbit for station in self.stations),
            *self.start_bodies.values(),
            *(target.orbit for target in self.targets),
        )

    @property
    def body_orbits(self) -> tuple[Orbit, ...]:
        """The same where all bodies have one.

        Raises
        ------
        InputError
            One has none.
        """
        found = []
        for name, orbit in zip(self.names, self.known_orbits, strict=True):
            if orbit is None:
                raise InputError(f"{name!r} has no orbit, which this needs; give it one")
            found.append(orbit)
        return tuple(found)

    @property
    def is_approximate(self) -> bool:
        """Whether some orbit is not a circle, so that the model is an approximation of it.

        Given connections are what they are.
        """
        if self.transfer.given is not None:
            return False
        return any(orbit.eccentricity > 0.0 for orbit in self.body_orbits)

    def part(self, bodies: Collection[int]) -> Self:
        """The instance with only some of its targets, in its own order; other bodies stay."""
        first = self.first_target
        return self.replace(
            targets=tuple(self.targets[body - first] for body in sorted(bodies) if body >= first)
        )

    def to_json(self) -> str:
        """The instance file, the same bytes on every machine."""
        return to_text(self.model_dump(mode="json"))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the instance file, and beside it that of its connections where they are given.

        Raises
        ------
        InputError
            One of them cannot be written.
        """
        check_writable(path)
        if self.transfer.given is not None and self.given is not None:
            write_given(Path(path).parent / self.transfer.given.file, self.given)
        write_text(path, self.to_json())

    @property
    def sha256(self) -> str:
        """SHA-256 of the file that :meth:`to_json` gives; plans carry it."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    @property
    def oblateness_m2(self) -> float:
        """J2 R² of the dynamics: 0 for two bodies [m²]."""
        return OBLATENESS_M2 if self.dynamics == "j2" else 0.0

    def orbits(self) -> npt.NDArray[np.float64]:
        """The bodies as kernels take them, shape (bodies, columns); NaN for those without an orbit.

        Columns are :data:`adr_opt.kernels.orbits.ORBIT_COLUMNS`.
        """
        oblateness, nothing = self.oblateness_m2, (math.nan,) * len(ORBIT_COLUMNS)
        return np.array(
            [nothing if orbit is None else orbit.row(oblateness) for orbit in self.known_orbits]
        )

    def eccentricity_delta_v(self) -> npt.NDArray[np.float64]:
        """What matching eccentricity vectors alone would cost, v·|Δe|/2.

        Returns
        -------
        (origin, destination) float64
            [m/s]; zero between circles (MODEL section 1), and where perigees drift: then it is
            worked out for each departure. Given connections have none.
        """
        if self.dynamics == "j2" or self.transfer.given is not None:
            return np.zeros((len(self.names), len(self.names)))
        return np.asarray(matchings(self.orbits()))

    def transfer_rule(self, time_value_m_s_per_h: float | None = None) -> TransferRule:
        """The transfer settings and zones as the kernels take them (radii, m/s per s).

        Parameters
        ----------
        time_value_m_s_per_h : float, optional
            What an hour is worth when one of several sequences is chosen; by default
            :attr:`time_value_m_s_per_h`.

        Notes
        -----
        Zones are closed, so the slack of the model is theirs: what touches one is in it.
        """
        settings = self.transfer
        worth = self.time_value_m_s_per_h if time_value_m_s_per_h is None else time_value_m_s_per_h
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
            worth / HOUR_S,
            zones,
            self.oblateness_m2,
        )


def load(path: str | os.PathLike[str]) -> Instance:
    """Read an instance file, and beside it that of its connections where they are given.

    Raises
    ------
    InputError
        No such file, not JSON, or not a valid instance; or the connections are missing, others than
        the instance says, or cannot be planned on.
    MissingExtra
        What reads the connections is not installed.
    """
    instance = read_model(path, Instance)
    reference = instance.transfer.given
    if reference is None:
        return instance
    return instance.with_given(read_named(path, reference, instance.names), reference.file)


def json_schema() -> dict[str, Any]:
    """The JSON Schema of the instance file."""
    schema = Instance.model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
