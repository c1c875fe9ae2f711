"""Settings of a whole instance: limits, transfers, objective, value of time, keep-out zones."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ..common.constants import DAY_S, HOUR_S
from ..common.errors import InputError
from ..common.records import (
    LARGEST_DELTA_V_M_S,
    LARGEST_DURATION_S,
    LARGEST_MASS_KG,
    Length,
    Name,
    NonNegative,
    Omitting,
    Positive,
    Record,
    without,
    without_usual,
)
from .disposal import Disposal

SPENT_BY_DRIFTING, REFUELLED = 0.8, 3.0
"""Value of an hour where planes drift, as a multiple of a tank over the mission; the second
number multiplies it where there are stations."""

TIME_VALUE_M_S_PER_H = 75.0
"""Default value of an hour for missions of days."""


def hurry_of(
    duration_s: float,
    tank_m_s: float,
    *,
    time_buys_delta_v: bool,
    refuels: bool,
    usual_is_a_limit: bool,
) -> float:
    """Value of time relative to a mission of days (:attr:`adr_opt.Instance.hurry`).

    Parameters
    ----------
    duration_s : float
        How long the mission lasts [s].
    tank_m_s : float
        The most ΔV that a chaser has at once [m/s].
    time_buys_delta_v : bool
        Whether waiting saves ΔV: where planes drift, and where connections are given.
    refuels : bool
        Whether there are stations; a chaser that can refuel spends more than one tank.
    usual_is_a_limit : bool
        Whether the usual value of an hour is an upper limit.
    """
    if not time_buys_delta_v or duration_s == 0.0:
        return 1.0
    share = SPENT_BY_DRIFTING * (REFUELLED if refuels else 1.0)
    spent = share * tank_m_s * HOUR_S / duration_s / TIME_VALUE_M_S_PER_H
    return min(1.0, spent) if usual_is_a_limit else spent


def check_time_value(time_value_m_s_per_h: float) -> None:
    """Check that the value of an hour is finite and not negative.

    Raises
    ------
    InputError
        It is not.
    """
    if not (math.isfinite(time_value_m_s_per_h) and time_value_m_s_per_h >= 0.0):
        raise InputError(
            f"time_value_m_s_per_h = {time_value_m_s_per_h!r}: must be a finite number ≥ 0"
        )


LARGEST_MASS_CLASS = 1e6
"""Largest width of classes of mass: one class for any tank."""


class MissionSettings(Omitting):
    """Duration of the mission, and time spent at bodies.

    Attributes
    ----------
    duration_s : float
        Latest end of all stays [s].
    service_revolutions, service_s : float or None
        Time at a target, in periods of its orbit or in seconds; exactly one of the two is set.
    refuel_revolutions : float
        Time at a station, in periods of its orbit.
    disposal : DisposalCircle, DisposalPerigee or None
        Orbit to which objects are towed that name none of their own.
    launch_separation_s : float or None
        Least time between launches, which then follow the order of the file, with 0 as well; None
        for launches that do not depend on each other [s].
    mission_separation_s : float or None
        Least time from the last service of any chaser launched before to the next launch, whose
        time is then the plan's choice, in any order of the chasers [s].
    max_lifetime_years : float or None
        Longest time that released objects stay in orbit [years].
    max_uncontrolled_kg : float or None
        Mass above which released objects re-enter under control [kg].
    """

    duration_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)]
    service_revolutions: NonNegative | None = 1.0
    service_s: NonNegative | None = None
    refuel_revolutions: NonNegative = 1.0
    disposal: Disposal | None = None
    launch_separation_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)] | None = None
    mission_separation_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)] | None = None
    max_lifetime_years: Annotated[float, Field(gt=0.0, lt=1000.0)] | None = None
    max_uncontrolled_kg: Annotated[float, Field(ge=0.0, le=LARGEST_MASS_KG)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _one_service(cls, given: Any) -> Any:
        """The default of one field gives way to a value of the other."""
        if isinstance(given, dict) and given.get("service_s") is not None:
            return {"service_revolutions": None, **given}
        return given

    @model_validator(mode="after")
    def _exactly_one(self) -> Self:
        if (self.service_revolutions is None) == (self.service_s is None):
            stated = "none of them" if self.service_s is None else "both"
            raise ValueError(
                "must give service_revolutions or service_s, but gives "
                f"{stated}; write exactly one of the two"
            )
        return self

    @model_validator(mode="after")
    def _one_separation(self) -> Self:
        if self.launch_separation_s is not None and self.mission_separation_s is not None:
            raise ValueError(
                "gives launch_separation_s, for launches in the order of the file, and "
                "mission_separation_s, for launches in any order; write one of the two"
            )
        return self

    OMITTED: ClassVar = (
        "service_revolutions",
        "service_s",
        "disposal",
        "launch_separation_s",
        "mission_separation_s",
        "max_lifetime_years",
        "max_uncontrolled_kg",
    )


ApproachName = Literal["half-lap", "safety-ellipse"]

BurnsName = Literal["sequence", "free"]

OF_THE_ELLIPSE = ("keep_out_m", "approach_revolutions", "inspection_revolutions")
"""Parameters of a safety ellipse alone."""


class SequenceSettings(Record):
    """Parameters of the co-elliptic sequence and of the approach (docs/model.md section 2).

    Attributes
    ----------
    first_leg_fraction : float
        Share of the way from the phasing to the target radius that the co-elliptic orbit closes.
    standoff_m : float
        Distance behind the target at which the approach begins [m].
    max_phasing_revolutions : int
    min_altitude_m, max_altitude_m : float
        Limits of the phasing radius, as altitudes [m].
    approach : {"half-lap", "safety-ellipse"}
        "half-lap" ends in the target. "safety-ellipse" passes round it, whichever burn is missed no
        nearer than ``keep_out_m``.
    keep_out_m : float
        [m].
    approach_revolutions, inspection_revolutions : int
        Revolutions of the drift to the target, and on the ellipse around it.
    """

    first_leg_fraction: Annotated[float, Field(ge=0.0, le=1.0)] = 0.75
    standoff_m: NonNegative = 1000.0
    max_phasing_revolutions: Annotated[int, Field(ge=0, le=100)] = 12
    min_altitude_m: Length = 300e3
    max_altitude_m: Length = 2000e3
    approach: ApproachName = "half-lap"
    keep_out_m: Positive = 200.0
    approach_revolutions: Annotated[int, Field(ge=1, le=100)] = 2
    inspection_revolutions: Annotated[int, Field(ge=0, le=100)] = 0

    @property
    def kept_out_m(self) -> float | None:
        """Radius that the approach keeps out of, whichever burn is missed; None for half a lap."""
        return None if self.approach == "half-lap" else self.keep_out_m

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.max_altitude_m <= self.min_altitude_m:
            raise ValueError(
                f"max_altitude_m = {self.max_altitude_m!r} must be greater than "
                f"min_altitude_m = {self.min_altitude_m!r}"
            )
        if self.approach == "half-lap":
            for name in OF_THE_ELLIPSE:
                if (value := getattr(self, name)) != type(self).model_fields[name].default:
                    raise ValueError(
                        f"field {name} = {value!r}: half laps have none; leave it out, or write "
                        'approach "safety-ellipse"'
                    )
        return self


Digest = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class GivenFile(Record):
    """Files of given costs beside the instance, and their digests.

    Attributes
    ----------
    file : str or None
        File of connections, ``.parquet`` or ``.nc``.
    sha256 : str or None
        :attr:`.given.Given.sha256`; None for whatever the file holds.
    functions : str or None
        File of functions of time, ``.json``; it may stand beside ``file`` or alone.
    functions_sha256 : str or None
        :attr:`.given_functions.Functions.sha256`; None for whatever the file holds.
    """

    file: Annotated[Name, Field(pattern=r"^[^/\\\x00]+\.(parquet|nc)$")] | None = None
    sha256: Digest | None = None
    functions: Annotated[Name, Field(pattern=r"^[^/\\\x00]+\.json$")] | None = None
    functions_sha256: Digest | None = None

    @model_validator(mode="after")
    def _names_a_file(self) -> Self:
        if self.file is None and self.functions is None:
            raise ValueError("names no file; give file, functions or both")
        for name, file in (("sha256", self.file), ("functions_sha256", self.functions)):
            if file is None and getattr(self, name) is not None:
                raise ValueError(f"field {name} is that of no file; leave it out")
        return self

    @model_serializer(mode="wrap")
    def _without_absent_files(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content: dict[str, Any] = write(self)
        absent = ["functions", "functions_sha256"] if self.functions is None else []
        absent += ["file", "sha256"] if self.file is None else []
        return {name: value for name, value in content.items() if name not in absent}


class TransferSettings(SequenceSettings):
    """Parameters of the transfers (docs/model.md sections 2 to 4).

    Attributes
    ----------
    first_leg_fraction … inspection_revolutions
        As in :class:`SequenceSettings`.
    delta_v_resolution_m_s : float
        A connection that saves no more than this against another one is left out [m/s].
    departure_spacing_s : float
        Least spacing of the short departures of a pair [s].
    drift_step_s : float
        Grid of times of transfers that drift [s].
    max_drift_s : float
        Longest time that one of these may take; 0 for none [s].
    mass_class : float or None
        Largest width, as a share, of classes of the mass of chasers with low thrust;
        :data:`.drives.CLASS_WIDTH` if None.
    max_leg_s : float or None
        Longest time from an arrival to the next, waiting and service included [s].
    burns : {"sequence", "free"}
        Burns by which legs are priced: those of the sequence, or those that refinement finds
        (docs/model.md section 2.7).
    given : GivenFile or None
        Files of connections in place of these.
    """

    delta_v_resolution_m_s: NonNegative = 0.1
    departure_spacing_s: NonNegative = 0.0
    drift_step_s: Positive = DAY_S
    max_drift_s: NonNegative = 0.0
    mass_class: Annotated[float, Field(gt=0.0, le=LARGEST_MASS_CLASS)] | None = None
    max_leg_s: Annotated[float, Field(gt=0.0, le=LARGEST_DURATION_S)] | None = None
    burns: BurnsName = "sequence"
    given: GivenFile | None = None

    @property
    def may_drift(self) -> bool:
        """Whether legs may use drift orbits.

        So they may where costs are given, whose variation with time is unknown.
        """
        return self.max_drift_s > 0.0 or self.given is not None

    @model_serializer(mode="wrap")
    def _without_what_is_none(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content = without(write(self), "mass_class", "max_leg_s", "given")
        return without_usual(self, content, "approach", *OF_THE_ELLIPSE, "burns")


class Objective(Omitting):
    """Tie-breaker between plans that collect equal prizes: the least cost.

    Attributes
    ----------
    cost : {"delta-v", "duration", "expense"}
        ΔV of all legs and tows, with the price of time [m/s]; end of the last service or tow [s];
        or sum of the expenses of the chasers that are used (:class:`.chasers.Expense`).
    time_m_s_per_day : float or None
        Price of each day of a chaser that is used, for the first [m/s per day]; None for
        :attr:`.instance_file.InstanceFile.time_m_s_per_s`.
    """

    cost: Literal["delta-v", "duration", "expense"] = "delta-v"
    time_m_s_per_day: Annotated[float, Field(ge=0.0, le=LARGEST_DELTA_V_M_S)] | None = None

    @model_validator(mode="after")
    def _days_are_paid_in_delta_v(self) -> Self:
        if self.cost != "delta-v" and self.time_m_s_per_day is not None:
            raise ValueError(
                f"time_m_s_per_day = {self.time_m_s_per_day!r}: days are paid for where cost is "
                f'"delta-v", not "{self.cost}"; leave one of the two out'
            )
        return self

    OMITTED: ClassVar = ("time_m_s_per_day",)

    @property
    def asks_for_more(self) -> bool:
        """Whether the cost differs from the usual one, ΔV at the default price of time."""
        return self.cost != "delta-v" or bool(self.time_m_s_per_day)

    def together(self, costs: Iterable[float]) -> float:
        """Total cost of routes with given costs."""
        if self.cost == "duration":
            return max(costs, default=0.0)
        return math.fsum(costs)


class KeepOutZone(Record):
    """An altitude band that is closed during a time window (docs/model.md section 6).

    Attributes
    ----------
    min_altitude_m, max_altitude_m : float
        [m].
    start_s, end_s : float
        [s].
    """

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
