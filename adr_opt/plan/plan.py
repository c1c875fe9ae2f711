"""The plan file ``adr-opt-plan/2``: legs with their times and costs, and a quality certificate."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer

from ..common.card import Shown
from ..common.errors import InputError
from ..common.files import read_model, to_text, write_text
from ..common.records import DeltaV, Name, NonNegative, Omitting, Positive, Record, Time, without
from ..problem.instance import Instance
from ..problem.settings import Objective
from .impulses import impulses_of
from .leg_kinds import DRIFT, SHORT, KindName, LegKind, OneOf, leg_kind
from .phases import burn_phases
from .plan_flight import PlanFlight

FORMAT: Literal["adr-opt-plan/2"] = "adr-opt-plan/2"

MODEL: Literal[3] = 3
"""Version of docs/model.md by which costs are computed."""

FORMER_MODEL: Literal[2] = 2
"""Version of plans and certificates that state none: phasing was free in drift legs."""

Model = Literal[2, 3]

Status = Literal["optimal", "feasible", "infeasible", "unknown"]
Reason = Literal[
    "no-transfer",
    "several",
    "duration",
    "delta-v",
    "kits",
    "capacity",
    "not-worth-it",
    "not-considered",
]

Vector = tuple[DeltaV, DeltaV, DeltaV]


class InstanceReference(Record):
    """Reference to the instance of a plan: its name and the SHA-256 of its file."""

    name: Name
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]

    def is_of(self, instance: Instance) -> bool:
        """Whether an instance has this name and SHA-256."""
        return (self.name, self.sha256) == (instance.name, instance.sha256)

    def refuse_other(self, instance: Instance, what: str = "plan") -> None:
        """Raise :class:`InputError` for another instance."""
        if not self.is_of(instance):
            raise InputError(
                f"the {what} belongs to the instance {self.name!r} (sha256 {self.sha256[:12]}…), "
                f"not to {instance.name!r} (sha256 {instance.sha256[:12]}…); give the instance it "
                "was made for"
            )


class Burn(Record):
    """An impulse in the inertial frame of the elements."""

    time_s: Time
    delta_v_m_s: Annotated[Vector, Field(strict=False)]
    phase: Annotated[str, OneOf(burn_phases)]

    @property
    def size_m_s(self) -> float:
        """ΔV of the burn [m/s]."""
        return math.hypot(*self.delta_v_m_s)


def burns_of(
    times_s: Iterable[float], vectors_m_s: Iterable[npt.NDArray[np.float64]], phases: Iterable[str]
) -> tuple[Burn, ...]:
    """Impulses as stated in plans, from times, 3-vectors and names of phases."""
    return tuple(
        Burn(
            time_s=float(time),
            delta_v_m_s=(float(vector[0]), float(vector[1]), float(vector[2])),
            phase=phase,
        )
        for time, vector, phase in zip(times_s, vectors_m_s, phases, strict=True)
    )


class LowThrustArc(Record):
    """An arc of low thrust, about two opposite places of each revolution.

    It changes the circular speed by ``size_m_s`` (before less after), the inclination and the node.
    """

    kind: Literal["arc"] = "arc"
    start_s: Time
    end_s: Time
    delta_v_m_s: DeltaV
    window_deg: float
    argument_of_latitude_deg: float
    size_m_s: float
    inclination_deg: float
    raan_deg: float


class Tow(Record):
    """Tow of a serviced object to its orbit of disposal.

    See docs/model.md section 5.

    Between circles from the first of its two burns at ``start_s`` to the second one at ``end_s``,
    when the object is released; before that the chaser waits with it, as long as the next transfer
    allows. Of a tow that begins at an apogee the first burn is within a revolution of ``start_s``,
    and the chaser waits from the last one to ``end_s`` without the object; a burn of the phase
    ``return`` it makes alone. Of a spiral from its beginning to its end, without burns.
    """

    start_s: Time
    end_s: Time
    delta_v_m_s: DeltaV
    burns: Annotated[tuple[Burn, ...], Field(strict=False)]

    @property
    def first_burn_s(self) -> float:
        """Time at which the tow first moves the object, by a burn or a spiral [s]."""
        return self.burns[0].time_s if self.burns else self.start_s

    @property
    def back_m_s(self) -> float:
        """ΔV of the chaser alone, after the release [m/s]."""
        return math.fsum(burn.size_m_s for burn in self.burns if burn.phase == "return")


class Leg(Shown, Omitting):
    """A transfer with the service that follows it.

    ``ready_s`` is when the chaser is free at the origin, ``departure_s`` the node crossing (of a
    leg that drifts, when the time begins within which the phase is met), ``arrival_s`` the end of
    the approach, ``end_s`` the end of service (refuelling, at the
    station); ``delta_v_left_m_s`` is what is left then: the full budget after refuelling.
    ``eccentricity_delta_v_m_s`` is the part of ``delta_v_m_s`` that matches eccentricity vectors;
    it has no burn, because the burns fly between circles (docs/model.md section 1). ``kind`` is
    that of the transfer: ``short`` is the co-elliptic sequence, ``drift`` waits on an orbit whose
    node moves otherwise; its ``delta_v_m_s`` is that of the closed form, near the sum of its burns;
    ``launch`` puts a chaser that starts anywhere onto its first target, at once and for nothing;
    ``given`` is a given connection, which has no burns; other kinds are those of
    families that were registered. ``mass_kg``, that of the
    chaser at ``end_s`` with propellant and kits, is there for tanks by mass only. ``tow`` is there
    where the destination is towed. It is no part of ``delta_v_m_s``, but what is left, and the
    mass, are those after it; the next leg is ready as long after ``end_s`` as it takes.
    ``manoeuvres`` are the arcs of a leg of low thrust, which has no burns; None of any other.
    ``mass_class_kg`` is the largest mass at departure with which such a leg can be flown, its arcs
    being those of a chaser of that mass; None for any mass. ``vented_kg`` is the propellant that is
    vented before the departure, or not loaded before the first leg; None for nothing.
    """

    kind: KindName = SHORT.name
    origin: Name
    destination: Name
    ready_s: Time
    departure_s: Time
    arrival_s: Time
    end_s: Time
    delta_v_m_s: DeltaV
    delta_v_left_m_s: float
    mass_kg: float | None = None
    tow: Tow | None = None
    phasing_revolutions: int
    eccentricity_delta_v_m_s: DeltaV = 0.0
    burns: Annotated[tuple[Burn, ...], Field(strict=False)]
    manoeuvres: Annotated[tuple[LowThrustArc, ...], Field(strict=False)] | None = None
    mass_class_kg: Positive | None = None
    vented_kg: NonNegative | None = None

    OMITTED: ClassVar = ("mass_kg", "tow", "manoeuvres", "mass_class_kg", "vented_kg")

    @property
    def traits(self) -> LegKind:
        """The kind of the leg."""
        return leg_kind(self.kind)

    @property
    def done_s(self) -> float:
        """End of the service, or of the tow that follows [s]."""
        return self.end_s if self.tow is None else self.tow.end_s

    @property
    def free_s(self) -> float:
        """Time from which the chaser may leave its destination: after service and tow [s]."""
        return self.end_s + (0.0 if self.tow is None else self.tow.end_s - self.tow.start_s)

    @property
    def removal_m_s(self) -> float:
        """ΔV flown after the service, with the object [m/s]."""
        return 0.0 if self.tow is None else self.tow.delta_v_m_s

    @property
    def removal_burns(self) -> tuple[Burn, ...]:
        """Burns after the service, with the object; none if it stays."""
        return () if self.tow is None else self.tow.burns

    @property
    def spent_m_s(self) -> float:
        """ΔV of the transfer and of the removal after it [m/s]."""
        return self.delta_v_m_s + self.removal_m_s

    @property
    def leaves_s(self) -> float:
        """Departure of the chaser from its origin: the first burn, if there is one [s]."""
        return self.burns[0].time_s if self.burns else self.departure_s

    @property
    def impulses(self) -> tuple[Burn, ...]:
        """Burns of the transfer as made: the stop and the first burn of the approach are one."""
        return impulses_of(self.burns)

    @property
    def all_impulses(self) -> tuple[Burn, ...]:
        """Impulses of the transfer and of the removal after it."""
        return (*self.impulses, *self.removal_burns)

    @property
    def standoff_s(self) -> float | None:
        """When the approach begins; None without one [s]."""
        return next((burn.time_s for burn in self.burns if burn.phase == "approach"), None)

    @property
    def docked_s(self) -> float:
        """End of docking: the last burn, if there is one [s]."""
        return self.burns[-1].time_s if self.burns else self.arrival_s

    @property
    def burns_delta_v_m_s(self) -> float:
        """Sum of the impulses [m/s].

        With ``at_once_m_s``, that of a short leg is ``delta_v_m_s`` less the part without burns.
        """
        return math.fsum(burn.size_m_s for burn in self.impulses)

    @property
    def at_once_m_s(self) -> float:
        """ΔV that simultaneous burns save as one vector; the price counts each burn [m/s]."""
        return math.fsum(burn.size_m_s for burn in self.burns) - self.burns_delta_v_m_s


class Route(Shown, Record):
    """The legs of one chaser, in order."""

    chaser: Name
    legs: Annotated[tuple[Leg, ...], Field(strict=False)]


class Unvisited(Record):
    """A target left out of the plan, with the reason.

    The reason says what keeps the chaser from one more leg at the end of the plan, and is tried: a
    larger tank alone would do (``delta-v``), a longer mission and window alone (``duration``),
    another kit (``kits``), or more targets than its limits allow (``capacity``); more than one of
    these (``several``); or none, up to four tanks and twice the time (``no-transfer``).
    ``not-worth-it``: one more leg fits, and the plan does not fly it. ``not-considered`` is one
    without a search for a way from where the plan ends, because the time or the memory did not
    allow it; a note of the plan says more.
    """

    target: Name
    reason: Reason


class ExpectedPrize(Record):
    """Prize that following a plan collects on average (docs/model.md section 13.5).

    ``prize`` is the mean of ``worlds`` rehearsals, with its ``standard_error``, in worlds of the
    uncertainty file whose digest is ``uncertainty_sha256``.
    """

    prize: float
    standard_error: Annotated[float, Field(ge=0.0)]
    worlds: Annotated[int, Field(ge=2)]
    uncertainty_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


def _in_order(course: tuple[CoursePoint, ...]) -> tuple[CoursePoint, ...]:
    if any(after < before for (before, *_), (after, *_) in pairwise(course)):
        raise ValueError("times must not decrease")
    return course


CoursePoint = Annotated[tuple[NonNegative, float | None, float | None], Field(strict=False)]
"""Time since the run began [s], value of the best plan and upper bound; null for none yet."""

Course = Annotated[tuple[CoursePoint, ...], Field(strict=False), AfterValidator(_in_order)]


class Plan(Shown, Record):
    """A mission plan with its bounds.

    Attributes
    ----------
    model : int
        Version of docs/model.md by which costs are computed.
    instance : InstanceReference
    method : str
    seed : int
    status : {"optimal", "feasible", "infeasible", "unknown"}
        Of ``objective``: "optimal" if no plan collects more.
    objective : float
        Sum of the prizes of the visited targets.
    upper_bound, gap : float or None
        Proven: no plan collects more; and (bound − objective) / bound. None if not proven.
    cost : float
        By the objective of the instance: [m/s], [s], or the unit of expenses.
    cost_bound, cost_gap : float or None
        Proven: no plan that collects as much costs less; and (cost − bound) / cost.
    cost_status : str or None
        As ``status``, of the cost; None if not proven.
    runtime_s : float
        Of the method [s].
    versions : dict of str to str
        Versions of packages.
    notes : tuple of str
    routes : tuple of Route
        Legs of each chaser.
    unvisited : tuple of Unvisited
        Targets left out, each with its reason.
    expected : ExpectedPrize or None
        Mean prize of following the plan, if it was chosen for that.
    flown : PlanFlight or None
        Outcome of its flight, if it was flown.
    course : Course or None
        Best plan and bound over the time of the run, if its method reported any.
    """

    format: Literal["adr-opt-plan/2"] = FORMAT
    model: Model = FORMER_MODEL
    instance: InstanceReference
    method: Name
    seed: Annotated[int, Field(ge=0)]
    status: Status
    objective: float
    upper_bound: float | None = None
    gap: float | None = None
    cost: float
    cost_bound: float | None = None
    cost_gap: float | None = None
    cost_status: Status | None = None
    runtime_s: Annotated[float, Field(ge=0.0)]
    versions: dict[str, str] = Field(default_factory=dict)
    notes: Annotated[tuple[str, ...], Field(strict=False)] = ()
    routes: Annotated[tuple[Route, ...], Field(strict=False)] = ()
    unvisited: Annotated[tuple[Unvisited, ...], Field(strict=False)] = ()
    expected: ExpectedPrize | None = None
    flown: PlanFlight | None = None
    course: Course | None = None

    @model_serializer(mode="wrap")
    def _without_former_model(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without(without_former_model(write(self)), "expected", "flown", "course")

    @property
    def has_former_drifts(self) -> bool:
        """Whether the plan has drift legs of the former model, in which phasing cost nothing."""
        return self.model < MODEL and any(leg.kind == DRIFT.name for leg in self.legs)

    @property
    def legs(self) -> tuple[Leg, ...]:
        """Legs of all routes, one route after another."""
        return tuple(leg for route in self.routes for leg in route.legs)

    @property
    def legs_sha256(self) -> str:
        """Digest of all routes, which identifies the legs."""
        routes = [route.model_dump(mode="json") for route in self.routes]
        return hashlib.sha256(json.dumps(routes).encode()).hexdigest()

    @property
    def own_flight(self) -> PlanFlight | None:
        """The stated flight of exactly these legs; None if there is none."""
        flown = self.flown
        return flown if flown is not None and flown.legs_sha256 == self.legs_sha256 else None

    @property
    def lead_ins(self) -> dict[int, tuple[Burn, ...]]:
        """Burns that lead from the orbit of a body to the start of a leg, by leg number from 1.

        They are those of the preceding tow: only legs that leave a disposal orbit have any. The
        last of them is made as the leg departs.
        """
        found, number = {}, 0
        for route in self.routes:
            before: tuple[Burn, ...] = ()
            for leg in route.legs:
                number += 1
                if before:
                    found[number] = before
                before = leg.removal_burns
        return found

    @property
    def destinations(self) -> tuple[str, ...]:
        """Names of the destinations in order."""
        return tuple(leg.destination for leg in self.legs)

    @property
    def orders(self) -> dict[str, tuple[str, ...]]:
        """Names of the destinations in order, by name of the chaser."""
        return {route.chaser: tuple(leg.destination for leg in route.legs) for route in self.routes}

    @property
    def delta_v_m_s(self) -> float:
        """Total ΔV of all legs and tows [m/s]."""
        return sum(leg.spent_m_s for leg in self.legs)

    def to_json(self) -> str:
        """The plan file."""
        return to_text(self.to_dict())

    def to_dict(self) -> dict[str, Any]:
        """The plan file as plain data."""
        return self.model_dump(mode="json")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a plan file.

        Raises
        ------
        InputError
            No such file, not JSON, or not a valid plan file. Whether the plan is legal is not
            checked here; see :func:`adr_opt.check`.
        """
        return read_model(path, cls)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the plan file, completely or not at all."""
        write_text(path, self.to_json())


def without_former_model(content: dict[str, Any]) -> dict[str, Any]:
    """The content of a file without a mention of the former model, so that digests stay valid."""
    return {k: v for k, v in content.items() if k != "model" or v != FORMER_MODEL}


load_plan = Plan.load


def cost_of(objective: Objective, legs: Iterable[Leg]) -> float:
    """Cost of legs as an instance counts it: total ΔV [m/s], or the end of the last one [s].

    Tows count.
    What chasers take, and their days cost, is for :func:`.expense.cost_of_routes` to say.
    """
    if objective.cost == "duration":
        return max((leg.done_s for leg in legs), default=0.0)
    return float(sum(leg.spent_m_s for leg in legs))


def relative_gap(objective: float, upper_bound: float) -> float:
    """(upper bound − objective) / upper bound; 0 if both are 0."""
    return (upper_bound - objective) / upper_bound if upper_bound > 0.0 else 0.0
