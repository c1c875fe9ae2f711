"""The refined plan file ``adr-opt-refined/1``: a plan that holds in true dynamics."""

from __future__ import annotations

import hashlib
import math
import os
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ..common.card import Shown
from ..common.files import read_model, read_text, to_text, write_text
from ..common.json_text import loaded
from ..common.records import DeltaV, Name, NonNegative, Record, Time
from ..problem.ephemerides import Digest, EphemerisKind
from .impulses import impulses_of
from .leg_kinds import OneOf, RefinedKindName, leg_kind
from .phases import refined_phases
from .plan import InstanceReference, Plan, Vector
from .refined_thrust import RefinedThrust

FORMAT: Literal["adr-opt-refined/1"] = "adr-opt-refined/1"

ADDS_UP_M_S = 1e-6
"""Tolerance between the ΔV of a leg and the sum of its burns [m/s]."""

Gravity = Literal["two-body", "j2", "j3", "j4"]
Freedom = Literal["free", "planned"]
Status = Literal["complete", "incomplete"]
Position = Annotated[
    tuple[
        Annotated[float, Field(ge=-1e9, le=1e9)],
        Annotated[float, Field(ge=-1e9, le=1e9)],
        Annotated[float, Field(ge=-1e9, le=1e9)],
    ],
    Field(strict=False),
]
Velocity = Annotated[Vector, Field(strict=False)]


class PlanReference(Record):
    """Reference to the plan that was refined: its planner, and the SHA-256 of its file."""

    method: Name
    seed: Annotated[int, Field(ge=0)]
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class EphemeridesReference(Record):
    """Reference to the ephemerides that legs were refined onto, copied from the instance."""

    kind: EphemerisKind
    sha256: Digest


class BodyState(Record):
    """Osculating state of a body at the epoch, in the inertial frame of the elements.

    Where a plan is refined onto ephemerides, the state that is reported then.
    """

    name: Name
    position_m: Position
    velocity_m_s: Velocity


class RefinedBurn(Record):
    """An impulse; ``phase`` is that of the plan's burn, or ``transfer`` for free burns.

    Those of tows have ``tow``.
    """

    time_s: Time
    delta_v_m_s: Velocity
    phase: Annotated[str, OneOf(refined_phases)]

    @property
    def size_m_s(self) -> float:
        """Its ΔV [m/s]."""
        return math.hypot(*self.delta_v_m_s)


class RefinedState(Record):
    """Osculating state of the chaser at an event, after its burn if there is one."""

    event: Literal["departure", "burn", "stand-off", "arrival", "release"]
    time_s: Time
    position_m: Position
    velocity_m_s: Velocity


class RefinedTow(Record):
    """Tow of an object in true dynamics: from its own orbit, by burns or by a spiral.

    Burns are made at the plan's times and as large, along the motion that there is; those that
    lower a perigee are aimed at it, with ``planned_delta_v_m_s`` for what the plan has, and one of
    the phase ``return`` the chaser makes alone. A spiral has none: its ``thrust`` is that of the
    chaser, with ``mass_kg`` of chaser and object together, and ``planned_delta_v_m_s`` as well.
    ``released`` is where both are at the release.
    """

    burns: Annotated[tuple[RefinedBurn, ...], Field(strict=False, max_length=2)]
    released: RefinedState
    thrust: RefinedThrust | None = None
    planned_delta_v_m_s: DeltaV | None = None

    @model_serializer(mode="wrap")
    def _without_none(self, plainly: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content: dict[str, Any] = plainly(self)
        for name in ("thrust", "planned_delta_v_m_s"):
            if getattr(self, name) is None:
                content.pop(name, None)
        return content

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.thrust is not None and self.planned_delta_v_m_s is None:
            raise ValueError("field planned_delta_v_m_s: missing, but a spiral needs it; add it")
        if self.thrust is not None:
            windows = self.thrust.windows_s
            if self.burns or not windows:
                raise ValueError("field thrust: a spiral has windows of thrust and no burns")
            if windows[-1][1] > self.released.time_s:
                raise ValueError("field thrust: a window ends after the release; correct its times")
            return self
        phases = [burn.phase for burn in self.burns]
        if phases not in (["tow"], ["tow", "tow"], ["tow", "return"]):
            raise ValueError(
                'field burns: must be one or two of phase "tow", or one and a "return", where '
                "there is no thrust"
            )
        begin, end = self.burns[0], self.burns[-1]
        if not begin.time_s <= end.time_s:
            raise ValueError("field burns: must be in time order")
        if self.released.time_s != end.time_s:
            raise ValueError(
                f"field released: time_s = {self.released.time_s!r} is not that of the last "
                f"burn; write {end.time_s!r}"
            )
        return self

    @property
    def onward(self) -> RefinedState:
        """State from which the chaser continues: the release, or the burn back after it."""
        back = [burn.delta_v_m_s for burn in self.burns if burn.phase == "return"]
        velocity = [math.fsum(part) for part in zip(self.released.velocity_m_s, *back, strict=True)]
        return self.released.replace(velocity_m_s=tuple(velocity)) if back else self.released

    @property
    def back_m_s(self) -> float:
        """ΔV of the chaser alone, after the release [m/s]."""
        return math.fsum(burn.size_m_s for burn in self.burns if burn.phase == "return")

    @property
    def start_s(self) -> float:
        """Time of the first burn, or beginning of the first window of thrust [s]."""
        return self.burns[0].time_s if self.thrust is None else self.thrust.windows_s[0][0]

    @property
    def delta_v_m_s(self) -> float:
        """ΔV of both burns, or of the spiral [m/s]."""
        if self.thrust is not None:
            return self.thrust.delta_v_m_s
        return math.fsum(burn.size_m_s for burn in self.burns)

    @property
    def planned_m_s(self) -> float:
        """ΔV of the tow in the plan [m/s], which burns have as well."""
        planned = self.planned_delta_v_m_s
        return self.delta_v_m_s if planned is None else planned


class RefinedLeg(Record):
    """One leg in true dynamics.

    It begins docked with the origin, before the first burn; at ``standoff_s`` it is where the plan
    wants it behind the destination, and after the burn of that instant moves relative to that point
    by ``approach_m_s``, with which the approach begins, or rests where that is None; at
    ``arrival_s`` it has docked.
    The residuals are the larger ones of those two. ``planned_delta_v_m_s`` is that of the plan,
    ``retargeted_delta_v_m_s`` that of the plan's own burns, kept near what they were, and
    ``flown_delta_v_m_s`` the sum of ``burns``. ``chaser`` is its chaser, where there are several;
    where there is one, files say nothing of it. ``tow`` is that of the destination after its
    service, ``tow_before`` that of the origin, from whose end the leg begins; their burns count
    in neither sum. Where there are none, files say nothing of them. ``after_launch`` says that the
    chaser was launched onto the origin and towed it: a launch is no refined leg, so that this one
    counts what ``tow_before`` takes. ``thrust`` is that of a leg of low thrust before the
    stand-off; its ΔV counts in ``flown_delta_v_m_s``, and its ``burns`` are those of the approach
    alone. ``holding_delta_v_m_s`` is an estimate of what holding beside bodies takes that move by
    their ephemerides, while the leg waits and during its service; it counts in no sum of a leg,
    but in tanks. ``vented_kg`` is the propellant vented before it, or not loaded at the launch
    before it, as in the plan.
    """

    leg: Annotated[int, Field(ge=1)]
    chaser: Name | None = None
    kind: RefinedKindName
    origin: Name
    destination: Name
    ready_s: Time
    standoff_s: Time
    arrival_s: Time
    end_s: Time
    planned_delta_v_m_s: DeltaV
    retargeted_delta_v_m_s: DeltaV
    flown_delta_v_m_s: DeltaV
    lowest_altitude_m: float
    residual_m: NonNegative
    residual_m_s: NonNegative
    burns: Annotated[tuple[RefinedBurn, ...], Field(strict=False, min_length=1)]
    states: Annotated[tuple[RefinedState, ...], Field(strict=False, min_length=1)]
    tow_before: RefinedTow | None = None
    after_launch: Literal[True] | None = None
    tow: RefinedTow | None = None
    thrust: RefinedThrust | None = None
    approach_m_s: Velocity | None = None
    holding_delta_v_m_s: DeltaV | None = None
    vented_kg: NonNegative | None = None

    @property
    def spent_m_s(self) -> float:
        """ΔV of burns and arcs, as recomputed from them [m/s]."""
        arcs = 0.0 if self.thrust is None else self.thrust.delta_v_m_s
        return math.fsum((arcs, *(burn.size_m_s for burn in self.burns)))

    @property
    def impulses(self) -> tuple[RefinedBurn, ...]:
        """Burns as made, one vector at the stand-off: files from before 2.0 state two there."""
        return impulses_of(self.burns)

    @property
    def holding_m_s(self) -> float:
        """Estimated ΔV of holding; 0 where there is no estimate [m/s]."""
        return self.holding_delta_v_m_s or 0.0

    @property
    def removals(self) -> tuple[RefinedTow, ...]:
        """Tows that count with the leg: of the destination, and of the origin after a launch."""
        before = self.tow_before if self.after_launch else None
        return tuple(tow for tow in (before, self.tow) if tow is not None)

    @property
    def removal_m_s(self) -> float:
        """ΔV of the tow of the destination, and after a launch of the tow before it [m/s]."""
        return math.fsum(tow.delta_v_m_s for tow in self.removals)

    @property
    def planned_removal_m_s(self) -> float:
        """Planned ΔV of the tow of the destination, and after a launch of that before it [m/s]."""
        return math.fsum(tow.planned_m_s for tow in self.removals)

    @property
    def removal_burns(self) -> tuple[RefinedBurn, ...]:
        """Burns after the service, with the object; none if it stays."""
        return () if self.tow is None else self.tow.burns

    @property
    def is_led(self) -> bool:
        """Whether the leg begins where a removal ended, and not at a body."""
        return self.tow_before is not None

    @property
    def removal_s(self) -> float:
        """Duration of the tow of the destination [s]."""
        return 0.0 if self.tow is None else self.tow.released.time_s - self.tow.start_s

    @property
    def done_s(self) -> float:
        """End of the service, or of the tow that follows [s]."""
        return self.end_s if self.tow is None else self.tow.released.time_s

    @model_serializer(mode="wrap")
    def _without_none(self, plainly: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content: dict[str, Any] = plainly(self)
        for name in (
            "chaser",
            "tow_before",
            "after_launch",
            "tow",
            "thrust",
            "approach_m_s",
            "holding_delta_v_m_s",
            "vented_kg",
        ):
            if getattr(self, name) is None:
                content.pop(name, None)
        return content

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        times = [burn.time_s for burn in self.burns]
        if times != sorted(times):
            raise ValueError("field burns: not in time order; sort them by time_s")
        if not times[0] <= self.standoff_s <= self.arrival_s or times[-1] > self.arrival_s:
            raise ValueError(
                f"field standoff_s = {self.standoff_s!r}: must lie between the first burn and "
                "arrival_s, and no burn after that"
            )
        if leg_kind(self.kind).has_arcs != (self.thrust is not None):
            wrong = "needs it" if self.thrust is None else "has none"
            raise ValueError(f"field thrust: a leg of kind {self.kind!r} {wrong}")
        if self.thrust is not None and any(
            not self.states[0].time_s <= start <= end <= self.standoff_s
            for start, end in self.thrust.windows_s
        ):
            raise ValueError("field thrust: a window is not between the departure and standoff_s")
        total = self.spent_m_s
        if abs(total - self.flown_delta_v_m_s) > ADDS_UP_M_S:
            raise ValueError(
                f"field flown_delta_v_m_s = {self.flown_delta_v_m_s!r}: burns and arcs add up to "
                f"{total!r}; write that"
            )
        if self.tow_before is not None and self.tow_before.released.time_s > times[0]:
            raise ValueError("field tow_before: ends after the first burn; correct its times")
        if self.tow is not None and self.tow.start_s < self.arrival_s:
            raise ValueError("field tow: begins before arrival_s; correct its times")
        return self


class Missing(Record):
    """A leg that was not refined, and the reason: ``interrupted``, or an error.

    ``tow`` is the object before or after the leg for whose tow no spiral was found; where it was
    not that, files say nothing of it.
    """

    leg: Annotated[int, Field(ge=1)]
    reason: Name
    tow: Name | None = None

    @model_serializer(mode="wrap")
    def _without_none(self, plainly: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content: dict[str, Any] = plainly(self)
        if self.tow is None:
            content.pop("tow", None)
        return content


class RefinedPlan(Shown, Record):
    """A plan in true dynamics: burns that meet every stand-off, with states at every event.

    Attributes
    ----------
    instance : InstanceReference
    plan : PlanReference
        The plan that was refined.
    planned : Plan or None
        That plan itself, by which the file is judged; None in files of version 1.0.
    ephemerides : EphemeridesReference or None
        Those of the instance, if legs begin and end at their states; otherwise bodies move freely
        from ``bodies``.
    gravity : {"two-body", "j2", "j3", "j4"}
        Highest zonal harmonic of the field.
    freedom : {"free", "planned"}
        Burns of least ΔV, or those of the plan.
    status : {"complete", "incomplete"}
        "incomplete" if legs are missing. Each of the others begins docked with its origin, so they
        remain valid.
    runtime_s : float
        [s].
    versions : dict of str to str
    notes : tuple of str
    bodies : tuple of BodyState
        Osculating states at the epoch [m, m/s].
    legs : tuple of RefinedLeg
    missing : tuple of Missing
        Legs that were not refined, with the reason.
    """

    format: Literal["adr-opt-refined/1"] = FORMAT
    instance: InstanceReference
    plan: PlanReference
    planned: Plan | None = None
    ephemerides: EphemeridesReference | None = None
    gravity: Gravity
    freedom: Freedom
    status: Status
    runtime_s: NonNegative
    versions: dict[str, str] = Field(default_factory=dict)
    notes: Annotated[tuple[str, ...], Field(strict=False)] = ()
    bodies: Annotated[tuple[BodyState, ...], Field(strict=False)] = ()
    legs: Annotated[tuple[RefinedLeg, ...], Field(strict=False)] = ()
    missing: Annotated[tuple[Missing, ...], Field(strict=False)] = ()

    @model_serializer(mode="wrap")
    def _without_none(self, plainly: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content: dict[str, Any] = plainly(self)
        for name in ("planned", "ephemerides"):
            if getattr(self, name) is None:
                content.pop(name, None)
        return content

    @model_validator(mode="after")
    def _whole(self) -> Self:
        numbers = [leg.leg for leg in self.legs]
        if numbers != sorted(set(numbers)):
            raise ValueError("field legs: not in the order of their numbers; sort them by leg")
        known = {body.name for body in self.bodies}
        for leg in self.legs:
            for name in (leg.origin, leg.destination):
                if name not in known:
                    raise ValueError(f"field bodies: {name!r}, of leg {leg.leg}, is not among them")
        if (self.status == "incomplete") != bool(self.missing):
            raise ValueError(
                f'field status = "{self.status}": must be "incomplete" exactly where legs are '
                "missing"
            )
        for leg in self.legs:
            if (leg.holding_delta_v_m_s is None) != (self.ephemerides is None):
                raise ValueError(
                    f"field holding_delta_v_m_s of leg {leg.leg}: must be given exactly if the "
                    "plan has ephemerides"
                )
        return self

    @property
    def planned_delta_v_m_s(self) -> float:
        """Planned ΔV of the refined legs and their tows [m/s]."""
        return math.fsum(leg.planned_delta_v_m_s + leg.planned_removal_m_s for leg in self.legs)

    @property
    def retargeted_delta_v_m_s(self) -> float:
        """ΔV with the plan's own burns, kept close to the plan [m/s]."""
        return math.fsum(leg.retargeted_delta_v_m_s + leg.removal_m_s for leg in self.legs)

    @property
    def flown_delta_v_m_s(self) -> float:
        """ΔV of the refined legs and their tows [m/s]."""
        return math.fsum(leg.flown_delta_v_m_s + leg.removal_m_s for leg in self.legs)

    @property
    def holding_m_s(self) -> float:
        """Estimated ΔV of holding beside bodies; 0 without ephemerides [m/s]."""
        return math.fsum(leg.holding_m_s for leg in self.legs)

    @property
    def has_thrust(self) -> bool:
        """Whether some leg has low thrust."""
        return any(leg.thrust is not None for leg in self.legs)

    def made_of(self, plan: Plan) -> Self:
        """A copy that refers to a plan as the one that was refined."""
        return self.replace(plan=reference(plan), planned=plan)

    def to_json(self) -> str:
        """The refined plan file."""
        return to_text(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """The refined plan file as plain data."""
        return self.model_dump(mode="json")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a refined plan file.

        Raises
        ------
        InputError
            No such file, not JSON, or not a valid refined plan file.
        """
        return read_model(path, cls)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the refined plan file, completely or not at all."""
        write_text(path, self.to_json())


load_refined = RefinedPlan.load


def is_refined(path: str | os.PathLike[str]) -> bool:
    """Whether a file claims to be a refined plan; its errors are reported by others."""
    try:
        content = loaded(read_text(path))
    except (ValueError, RecursionError):  # InputError among them
        return False
    said = content.get("format") if isinstance(content, dict) else None
    return isinstance(said, str) and said.startswith("adr-opt-refined/")


def reference(plan: Plan) -> PlanReference:
    """Reference to a plan."""
    digest = hashlib.sha256(plan.to_json().encode()).hexdigest()
    return PlanReference(method=plan.method, seed=plan.seed, sha256=digest)
