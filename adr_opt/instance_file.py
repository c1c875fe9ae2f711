"""What an instance file says: its fields, what they must agree on, and its bytes.

The pydantic models of ``adr-opt-instance/2`` stand here and in :mod:`.epoch`, :mod:`.orbit`,
:mod:`.bodies`, :mod:`.chasers` and :mod:`.settings`.
"""

from __future__ import annotations

import hashlib
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from .agreement import check_expense, check_names, check_orbits, check_stations, check_tows
from .bodies import Station, Target
from .chasers import Chaser
from .epoch import Epoch
from .errors import InputError
from .files import to_text
from .records import Name, Record
from .settings import KeepOutZone, MissionSettings, Objective, TransferSettings
from .tolerance import check_prizes

FORMAT: Literal["adr-opt-instance/2"] = "adr-opt-instance/2"


class InstanceFile(Record):
    """The fields of an instance; :class:`adr_opt.Instance` is what can be planned."""

    format: Literal["adr-opt-instance/2"] = FORMAT
    name: Name
    epoch: Epoch
    dynamics: Literal["two-body", "j2"] = "two-body"
    stations: Annotated[tuple[Station, ...], Field(strict=False)]
    targets: Annotated[tuple[Target, ...], Field(strict=False)]
    chasers: Annotated[tuple[Chaser, ...], Field(strict=False, min_length=1)]
    mission: MissionSettings
    transfer: TransferSettings = TransferSettings()
    objective: Objective = Objective()
    keep_out_zones: Annotated[tuple[KeepOutZone, ...], Field(strict=False)] = ()

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
        check_prizes(
            (target.prize for target in self.targets),
            sum(target.required for target in self.targets),
        )
        check_expense(self.chasers, self.objective)
        is_given = self.transfer.given is not None
        check_orbits(self.stations, self.targets, self.mission, is_given=is_given)
        if is_given and self.keep_out_zones:
            raise ValueError(
                "field keep_out_zones: connections are given, and nobody knows where they lead; "
                "leave zones out"
            )
        check_tows(
            self.targets, self.chasers, self.mission, self.transfer,
            zones=bool(self.keep_out_zones),
        )  # fmt: skip
        return self

    def __eq__(self, other: object) -> bool:
        """Whether it is the same mission; what an hour is worth is no part of it."""
        if not isinstance(other, InstanceFile):
            return NotImplemented
        return all(
            getattr(self, field) == getattr(other, field) for field in type(self).model_fields
        )

    def __hash__(self) -> int:
        return hash(tuple(getattr(self, field) for field in type(self).model_fields))

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
                chaser.replace(tank=_tank_of(chaser, delta_v_m_s)) for chaser in self.chasers
            )
        return self.replace(**changes)

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

    def to_json(self) -> str:
        """The instance file, the same bytes on every machine."""
        return to_text(self.model_dump(mode="json"))

    @property
    def sha256(self) -> str:
        """SHA-256 of the file that :meth:`to_json` gives; plans carry it."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()


def _tank_of(chaser: Chaser, delta_v_m_s: float) -> dict[str, float]:
    """Another tank of a chaser; what is left at the start stays, if it holds that."""
    spent, full = chaser.tank.spent_m_s, chaser.tank.delta_v_m_s
    if spent == 0.0:
        return {"delta_v_m_s": delta_v_m_s}
    return {"delta_v_m_s": delta_v_m_s, "initial_delta_v_m_s": min(full - spent, delta_v_m_s)}
