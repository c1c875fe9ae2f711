"""Content of an instance file: fields, their consistency, and bytes.

The pydantic models of ``adr-opt-instance/3`` stand here and in :mod:`.frame`, :mod:`.orbit`,
:mod:`.bodies`, :mod:`.chasers` and :mod:`.settings`; :mod:`.format_2` reads and writes files of
``/2``.
"""

from __future__ import annotations

import hashlib
from itertools import chain
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from ..common.constants import DAY_S
from ..common.errors import InputError
from ..common.files import to_text
from ..common.records import Name, Omitting
from ..common.tolerance import check_prizes
from . import format_2
from .agreement import (
    check_approach,
    check_burns,
    check_decay,
    check_expense,
    check_falling_prizes,
    check_launches,
    check_names,
    check_orbits,
    check_removals,
    check_separation,
    check_stations,
    check_thrust,
    check_windows,
)
from .bodies import Station, Target
from .capture_windows import WindowFile
from .chasers import Chaser, TankByMass
from .disposal import Disposal, DisposalCircle
from .ephemerides import EphemeridesFile
from .frame import Epoch, Frame
from .settings import KeepOutZone, MissionSettings, Objective, TransferSettings
from .transfer_sizes import default_step_s


class InstanceFile(Omitting):
    """The fields of an instance; :class:`adr_opt.Instance` is the plannable object.

    Attributes
    ----------
    name : str
    epoch : datetime
        t = 0 of all times in seconds.
    frame : Frame or None
        Inertial frame of orbits and burns; None if unknown.
    dynamics : {"two-body", "j2"}
    stations : tuple of Station
    targets : tuple of Target
    chasers : tuple of Chaser
        At least one.
    mission : MissionSettings
    transfer : TransferSettings
    objective : Objective
        Cost that ranks plans of equal prize.
    keep_out_zones : tuple of KeepOutZone
    ephemerides : EphemeridesFile or None
        Files with the true states of bodies, to which orbits were fitted.
    windows : WindowFile or None
        File with the windows of all targets, in place of their own.
    """

    format: Literal["adr-opt-instance/3"] = format_2.FORMAT
    name: Name
    epoch: Epoch
    frame: Frame | None = None
    dynamics: Literal["two-body", "j2"] = "two-body"
    stations: Annotated[tuple[Station, ...], Field(strict=False)]
    targets: Annotated[tuple[Target, ...], Field(strict=False)]
    chasers: Annotated[tuple[Chaser, ...], Field(strict=False, min_length=1)]
    mission: MissionSettings
    transfer: TransferSettings = TransferSettings()
    objective: Objective = Objective()
    keep_out_zones: Annotated[tuple[KeepOutZone, ...], Field(strict=False)] = ()
    ephemerides: EphemeridesFile | None = None
    windows: WindowFile | None = None

    OMITTED: ClassVar = ("frame", "ephemerides", "windows")

    @model_validator(mode="after")
    def _something_drifts(self) -> Self:
        if self.dynamics == "two-body" and self.transfer.max_drift_s > 0.0:
            raise ValueError(
                f"field transfer.max_drift_s = {self.transfer.max_drift_s!r}: no plane drifts in "
                'two-body motion; write 0.0, or dynamics "j2"'
            )
        return self

    @model_validator(mode="after")
    def _grid_follows(self) -> Self:
        """Derive the grid of drift legs from the mission if it is not given."""
        transfer = self.transfer
        if transfer.max_drift_s > 0.0 and "drift_step_s" not in transfer.model_fields_set:
            known = [body.orbit for body in self.targets if body.orbit is not None]
            step = default_step_s(self.mission.duration_s, known)
            object.__setattr__(self, "transfer", transfer.replace(drift_step_s=step))
        return self

    @model_validator(mode="after")
    def _parts_agree(self) -> Self:
        check_names(self.stations, self.targets, self.chasers)
        check_decay(self.targets, self.chasers, drifts=self.dynamics == "j2")
        if self.ephemerides is not None and self.frame is None:
            raise ValueError("field ephemerides: in no frame; give the field frame")
        check_stations(self.stations, self.chasers)
        check_prizes(
            chain.from_iterable(target.prizes for target in self.targets),
            sum(target.required for target in self.targets),
        )
        check_falling_prizes(self.targets)
        check_windows(
            self.targets,
            self.mission,
            in_file=self.windows is not None,
            drifts=self.dynamics == "j2",
        )
        check_expense(self.chasers, self.objective)
        check_thrust(
            self.chasers,
            self.transfer,
            zones=bool(self.keep_out_zones),
            drifts=self.dynamics == "j2",
        )
        check_separation(self.chasers, self.mission)
        is_given = self.transfer.given is not None
        check_launches(self.chasers, self.mission, is_given=is_given, drifts=self.dynamics == "j2")
        check_orbits(self.stations, self.targets, self.mission, is_given=is_given)
        if is_given and self.keep_out_zones:
            raise ValueError(
                "field keep_out_zones: the paths of given connections are not known; leave zones "
                "out"
            )
        check_burns(self.transfer, zones=bool(self.keep_out_zones))
        check_removals(
            self.targets, self.chasers, self.mission, self.transfer, zones=bool(self.keep_out_zones)
        )
        check_approach(self.transfer, [*self.stations, *self.targets])
        return self

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read an instance from a JSON text; raises as :func:`.format_2.read`."""
        return format_2.read(cls, text)

    @classmethod
    def json_schema(cls) -> dict[str, Any]:
        """The JSON Schema of files of this format and of ``adr-opt-instance/2``."""
        return format_2.described(super().json_schema())

    def __eq__(self, other: object) -> bool:
        """Whether both describe the same mission; the value of an hour is not part of it."""
        if not isinstance(other, InstanceFile):
            return NotImplemented
        return all(
            getattr(self, field) == getattr(other, field) for field in type(self).model_fields
        )

    def __hash__(self) -> int:
        return hash(tuple(getattr(self, field) for field in type(self).model_fields))

    def with_limits(
        self,
        duration_s: float | None = None,
        delta_v_m_s: float | None = None,
        propellant_kg: float | None = None,
    ) -> Self:
        """The same field for a mission of another duration or with other tanks.

        With ``delta_v_m_s`` all tanks are counted in ΔV; with ``propellant_kg`` those by mass hold
        that mass, and the rest of their masses stays.

        Raises
        ------
        InputError
            A limit is not valid, or a tank given in ΔV is to hold propellant.
        """
        if delta_v_m_s is not None and propellant_kg is not None:
            raise InputError("a tank is given by its ΔV or by its propellant; give one of the two")
        changes: dict[str, Any] = {}
        if duration_s is not None:
            changes["mission"] = self.mission.replace(duration_s=duration_s)
        if delta_v_m_s is not None:
            changes["chasers"] = tuple(
                chaser.replace(tank=_tank_of(chaser, delta_v_m_s)) for chaser in self.chasers
            )
        if propellant_kg is not None:
            changes["chasers"] = tuple(
                chaser.replace(tank=_filled(chaser, propellant_kg)) for chaser in self.chasers
            )
        return self.replace(**changes)

    @property
    def chaser(self) -> Chaser:
        """The chaser of an instance that has only one.

        Raises
        ------
        InputError
            There are several chasers.
        """
        if len(self.chasers) > 1:
            raise InputError(
                f"{self.name!r} has {len(self.chasers)} chasers, but this works with one; keep "
                "only one in its field chasers"
            )
        return self.chasers[0]

    @property
    def time_m_s_per_s(self) -> float:
        """Price of each second of a used chaser, in a cost of ΔV [m/s per s].

        By default a mission of full length costs one ΔV resolution more than one of zero length, so
        that time decides between costs equal within the resolution. The default is zero for given
        costs, whose unit is unknown, and where the cost is not ΔV.
        """
        stated, duration_s = self.objective.time_m_s_per_day, self.mission.duration_s
        if stated is not None:
            return stated / DAY_S
        is_by_model = self.objective.cost == "delta-v" and self.transfer.given is None
        if not is_by_model or duration_s == 0.0:
            return 0.0
        return self.transfer.delta_v_resolution_m_s / duration_s

    def disposal_of(self, target: Target) -> Disposal | None:
        """Disposal orbit of a target if it is towed: its own, or the mission's."""
        return target.disposal or self.mission.disposal

    def circle_m(self, target: Target | str) -> float:
        """Altitude of the circle that a towed target, or one of a name, is released on [m]."""
        if isinstance(target, str):
            target = next(each for each in self.targets if each.name == target)
        disposal = self.disposal_of(target)
        assert isinstance(disposal, DisposalCircle)
        return disposal.circle_m

    @property
    def largest_tank_m_s(self) -> float:
        """Largest ΔV that a chaser has at once [m/s]."""
        return max(chaser.usable.delta_v_m_s for chaser in self.chasers)

    @property
    def station_names(self) -> tuple[str, ...]:
        """Names of the stations."""
        return tuple(station.name for station in self.stations)

    def to_json(self) -> str:
        """The instance file in the oldest format that can express it, the same bytes everywhere."""
        return to_text(format_2.written(self.model_dump(mode="json")))

    @property
    def sha256(self) -> str:
        """SHA-256 of the file written by :meth:`to_json`; plans carry it."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()


def _tank_of(chaser: Chaser, delta_v_m_s: float) -> dict[str, float]:
    """A resized tank of a chaser; its ΔV at the start stays if it fits."""
    spent, full = chaser.spent_m_s, chaser.tank.delta_v_m_s
    if spent == 0.0:
        return {"delta_v_m_s": delta_v_m_s}
    return {"delta_v_m_s": delta_v_m_s, "initial_delta_v_m_s": min(full - spent, delta_v_m_s)}


def _filled(chaser: Chaser, propellant_kg: float) -> TankByMass:
    """A tank by mass with other propellant; its propellant at the start stays if it fits."""
    tank = chaser.tank
    if not isinstance(tank, TankByMass):
        raise InputError(
            f"propellant: the tank of {chaser.name!r} is given in ΔV, without masses; give its "
            "ΔV, or give its dry_mass_kg, propellant_kg and isp_s"
        )
    initial = tank.initial_propellant_kg
    if initial is not None:
        initial = min(initial, propellant_kg)
    return TankByMass(
        dry_mass_kg=tank.dry_mass_kg,
        propellant_kg=propellant_kg,
        isp_s=tank.isp_s,
        initial_propellant_kg=initial,
    )
