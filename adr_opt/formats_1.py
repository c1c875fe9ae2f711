"""The formats ``adr-opt-instance/1`` and ``adr-opt-plan/1``: read, as those of today, not written.

An instance of /1 has one station, where its one chaser starts, and says what an hour is worth.
Plans name their instance with the SHA-256 of its file: :func:`sha256_1` is that of its file in /1.
"""

from __future__ import annotations

import hashlib
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from .bodies import Prize, Station, Target
from .chasers import AtStation, Chaser, Tank, free_name
from .epoch import Epoch
from .files import to_text
from .instance import Instance
from .orbit import Orbit
from .plan import Burn, InstanceReference, Leg, Plan, Route, Status, Unvisited
from .records import (
    LARGEST_DELTA_V_M_S,
    LARGEST_DURATION_S,
    DeltaV,
    Name,
    NonNegative,
    Record,
    Time,
)
from .settings import KeepOutZone, MissionSettings, SequenceSettings, TransferSettings
from .time_value import TIME_VALUE_M_S_PER_H


class Station1(Record):
    """The station of /1."""

    name: Name
    orbit: Orbit


class Target1(Record):
    """A target of /1."""

    name: Name
    prize: Prize = 1.0
    orbit: Orbit


class MissionLimits1(Record):
    """Duration, ΔV budget and the time spent at a body (in its periods)."""

    duration_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)]
    delta_v_m_s: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)]
    service_revolutions: NonNegative = 1.0
    refuel_revolutions: NonNegative = 1.0


class TransferSettings1(SequenceSettings):
    """Parameters of the co-elliptic sequence, and what an hour is worth."""

    time_value_m_s_per_h: NonNegative = TIME_VALUE_M_S_PER_H


class Instance1(Record):
    """An instance of /1."""

    format: Literal["adr-opt-instance/1"] = "adr-opt-instance/1"
    name: Name
    epoch: Epoch
    station: Station1
    targets: Annotated[tuple[Target1, ...], Field(strict=False)]
    mission: MissionLimits1
    transfer: TransferSettings1 = TransferSettings1()
    keep_out_zones: Annotated[tuple[KeepOutZone, ...], Field(strict=False)] = ()

    def upgraded(self) -> Instance:
        """The same instance in the format of today."""
        limits = self.mission
        names = {self.station.name, *(target.name for target in self.targets)}
        chaser = Chaser(
            name=free_name(names),
            start=AtStation(station=self.station.name),
            tank=Tank(delta_v_m_s=limits.delta_v_m_s),
        )
        made = Instance(
            name=self.name,
            epoch=self.epoch,
            stations=(Station(name=self.station.name, orbit=self.station.orbit),),
            targets=tuple(
                Target(name=target.name, orbit=target.orbit, prize=target.prize)
                for target in self.targets
            ),
            chasers=(chaser,),
            mission=MissionSettings(**limits.model_dump(exclude={"delta_v_m_s"})),
            transfer=TransferSettings(**self.transfer.model_dump(exclude={"time_value_m_s_per_h"})),
            keep_out_zones=self.keep_out_zones,
        )
        return made.with_time_value(self.transfer.time_value_m_s_per_h)


class Leg1(Record):
    """A leg of /1, which is a short transfer."""

    origin: Name
    destination: Name
    ready_s: Time
    departure_s: Time
    arrival_s: Time
    end_s: Time
    delta_v_m_s: DeltaV
    delta_v_left_m_s: float
    phasing_revolutions: int
    eccentricity_delta_v_m_s: DeltaV = 0.0
    burns: Annotated[tuple[Burn, ...], Field(strict=False)]


class Plan1(Record):
    """A plan of /1."""

    format: Literal["adr-opt-plan/1"] = "adr-opt-plan/1"
    instance: InstanceReference
    method: Name
    seed: Annotated[int, Field(ge=0)]
    status: Status
    objective: float
    upper_bound: float | None = None
    gap: float | None = None
    runtime_s: Annotated[float, Field(ge=0.0)]
    versions: dict[str, str] = Field(default_factory=dict)
    notes: Annotated[tuple[str, ...], Field(strict=False)] = ()
    legs: Annotated[tuple[Leg1, ...], Field(strict=False)] = ()
    unvisited: Annotated[tuple[Unvisited, ...], Field(strict=False)] = ()

    def upgraded(self) -> Plan:
        """The same plan in the format of today; the chaser is called as :class:`Instance1` does.

        A plan names all bodies: it starts at the station, and visits or lists every target.
        """
        names = {name for leg in self.legs for name in (leg.origin, leg.destination)}
        names |= {entry.target for entry in self.unvisited}
        legs = tuple(Leg(kind="short", **dict(leg)) for leg in self.legs)
        kept = {name: value for name, value in dict(self).items() if name not in ("format", "legs")}
        return Plan(
            **kept,
            cost=float(sum(leg.delta_v_m_s for leg in legs)),
            routes=(Route(chaser=free_name(names), legs=legs),) if legs else (),
        )


class _Kind(BaseModel):
    """What tells which format a file has; files may leave out their format."""

    format: Any = None
    station: Any = None
    legs: Any = None


def _kind(text: str) -> _Kind:
    try:
        return _Kind.model_validate_json(text)
    except ValidationError:  # no JSON object; whoever reads it as a file of today will say so
        return _Kind()


def instance_of(text: str) -> Instance | None:
    """The instance that a text of the format /1 holds; None if it is of another format.

    Raises
    ------
    pydantic.ValidationError
        The text breaks the format.
    """
    kind = _kind(text)
    is_former = kind.format is None and kind.station is not None
    if not is_former and kind.format != "adr-opt-instance/1":
        return None
    return Instance1.model_validate_json(text).upgraded()


def plan_of(text: str) -> Plan | None:
    """The plan that a text of the format /1 holds; None if it is of another format.

    Raises
    ------
    pydantic.ValidationError
        The text breaks the format.
    """
    kind = _kind(text)
    is_former = kind.format is None and kind.legs is not None
    if not is_former and kind.format != "adr-opt-plan/1":
        return None
    return Plan1.model_validate_json(text).upgraded()


def sha256_1(instance: Instance) -> str | None:
    """SHA-256 of an instance's file in the format /1; None if /1 cannot express it."""
    written = _downgraded(instance)
    if written is None:
        return None
    return hashlib.sha256(to_text(written.model_dump(mode="json")).encode()).hexdigest()


def is_of(reference: InstanceReference, instance: Instance) -> bool:
    """Whether what a plan names is this instance, by the SHA-256 of its file of today or of /1."""
    return reference.name == instance.name and (
        reference.sha256 == instance.sha256 or reference.sha256 == sha256_1(instance)
    )


def _downgraded(instance: Instance) -> Instance1 | None:
    """The instance in /1, if reading that gives the instance again."""
    if len(instance.stations) != 1 or instance.transfer.given is not None:
        return None
    limits = instance.mission
    if limits.service_revolutions is None:
        return None
    settings = instance.transfer.model_dump(include=set(TransferSettings1.model_fields))
    made = Instance1(
        name=instance.name,
        epoch=instance.epoch,
        station=Station1(
            **{name: getattr(instance.stations[0], name) for name in Station1.model_fields}
        ),
        targets=tuple(
            Target1(**{name: getattr(target, name) for name in Target1.model_fields})
            for target in instance.targets
        ),
        mission=MissionLimits1(
            duration_s=limits.duration_s,
            delta_v_m_s=instance.chasers[0].tank.delta_v_m_s,
            service_revolutions=limits.service_revolutions,
            refuel_revolutions=limits.refuel_revolutions,
        ),
        transfer=TransferSettings1(**settings, time_value_m_s_per_h=instance.time_value_m_s_per_h),
        keep_out_zones=instance.keep_out_zones,
    )
    return made if made.upgraded() == instance else None
