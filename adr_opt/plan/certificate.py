"""The certificate file ``adr-opt-certificate/1``: the evidence for a bound, for verification."""

from __future__ import annotations

import gzip
import hashlib
import os
import zlib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from ..common.card import Shown
from ..common.errors import InputError
from ..common.files import parse_model, read_text, to_text, write_bytes
from ..common.records import Name, NonNegative, Positive, Record, without_usual
from .plan import FORMER_MODEL, InstanceReference, Model, Plan, without_former_model

FORMAT: Literal["adr-opt-certificate/1"] = "adr-opt-certificate/1"

LARGEST_WORTH = 1e100
"""Largest sum of prizes, far beyond any prize and within float range; sums are exact."""

Worth = Annotated[float, Field(ge=0.0, le=LARGEST_WORTH)]
FINEST = 1e-8
"""Shortest step [s] and narrowest slot [m/s]: finer ones cost memory and prove no more."""

Fineness = Annotated[float, Field(ge=FINEST)]
Names = Annotated[tuple[Name, ...], Field(strict=False)]


class ProvenWalks(Record):
    """Evidence on the walks of interchangeable chasers.

    No walk of one of ``chasers`` collects ``most``, where each service counts what the target is
    worth less its multiplier, and each refuelling takes off that of the station. A walk may come
    back to a target that it has forgotten: when it comes to a body, it goes on remembering those of
    ``neighbourhoods`` there and the target that it comes from, and no others.

    Where ``worth_per_m_s`` is given it does not have to keep to its tanks: it pays that for ΔV,
    and collects the price of what is in the tank at the start and after each refuelling.
    """

    chasers: Names
    most: Annotated[float, Field(ge=-LARGEST_WORTH, le=LARGEST_WORTH)]
    neighbourhoods: dict[Name, Names] = Field(default_factory=dict)
    worth_per_m_s: Worth | None = None


class ProvenCut(Record):
    """A subset-row cut: one route of a plan at most services two or more of three ``targets``.

    A walk pays the ``multiplier`` at its second service of one of them, and at its fourth and every
    other one after that; at bodies that are not in ``memory`` it forgets an odd one.
    """

    targets: Annotated[tuple[Name, Name, Name], Field(strict=False)]
    memory: Names
    multiplier: Worth


class ProvenFloors(Record):
    """Prices of time and of ΔV.

    With the least time t and the least ΔV c that a service takes from wherever it may be, no plan
    is worth more than its time and its tank at these prices and, of each target, what it is worth
    beyond t and c at them; where a refuelling takes no less than a tank is worth. Of tanks by mass
    ΔV counts as with a ballast of ``ballast_kg``. With ``alone`` that holds of each chaser, and no
    plan is worth more than the sum of what is left of that in whole steps of the prizes.
    """

    worth_per_s: Worth
    worth_per_m_s: Worth
    ballast_kg: Worth = 0.0
    alone: bool = False

    @model_serializer(mode="wrap")
    def _without_defaults(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_usual(self, write(self), "ballast_kg", "alone")


class ProvenCost(Record):
    """A lower bound on the ΔV of plans that collect ``prize`` or more.

    Each service of a walk counts ``per_prize`` times what the target is worth, required ones with
    ``required_worth``, and its legs and tows take off their ΔV.

    Without ``walks``, of a single chaser, no walk that is worth as much as such a plan counts more
    than that worth times ``per_prize``, less ``bound``; ``neighbourhoods`` are what walks remember,
    as in :class:`ProvenWalks`. With ``walks``, which may be worth any amount and also pay
    ``multipliers`` and ``cuts``, all in m/s: the ``most`` of all chasers, the multipliers and those
    of the cuts add up to no more.
    """

    prize: NonNegative
    bound: NonNegative
    per_prize: Worth
    neighbourhoods: dict[Name, Names] = Field(default_factory=dict)
    multipliers: dict[Name, Worth] = Field(default_factory=dict)
    walks: Annotated[tuple[ProvenWalks, ...], Field(strict=False)] = ()
    cuts: Annotated[tuple[ProvenCut, ...], Field(strict=False)] = ()

    @model_serializer(mode="wrap")
    def _without_defaults(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        written: dict[str, Any] = write(self)
        for name in ("multipliers", "walks", "cuts"):
            if not getattr(self, name):
                written.pop(name, None)
        return written


class Certificate(Shown, Record):
    """Evidence for an upper bound (docs/certificates.md).

    Attributes
    ----------
    model : int
        Version of docs/model.md by which connections are computed.
    instance : InstanceReference
    plan_sha256 : str or None
        SHA-256 of the plan file that was written beside it.
    method : str
    upper_bound : float or None
        No plan collects more; None: no plan keeps all rules.
    required_worth : float
        Worth of a required target beyond its prize.
    prize_step : float or None
        All prizes are multiples of it.
    delta_v_slot_m_s : float
        Slot of ΔV of completion bounds. The claim does not depend on it, but the time to verify it
        does [m/s].
    time_step_s : float or None
        Step of time of walks that are counted and not followed one by one [s].
    multipliers : dict of str to float
        Of "each target at most once" and "each station at most ``max_refuellings`` times", by name;
        0 for those not in it.
    walks : tuple of ProvenWalks
        Each chaser once; empty where the prizes alone or the ``floors`` are the proof.
    floors : ProvenFloors or None
        Prices of time and of ΔV.
    cuts : tuple of ProvenCut
        Further constraints that walks pay for; the routes of a plan pay each at most once.
    cost : ProvenCost or None
        Proof of the least ΔV of plans that collect enough.
    """

    format: Literal["adr-opt-certificate/1"] = FORMAT
    model: Model = FORMER_MODEL
    instance: InstanceReference
    plan_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    method: Name
    upper_bound: NonNegative | None
    required_worth: Worth = 0.0
    prize_step: Positive | None = None
    delta_v_slot_m_s: Fineness = 20.0
    time_step_s: Fineness | None = None
    multipliers: dict[Name, Worth] = Field(default_factory=dict)
    walks: Annotated[tuple[ProvenWalks, ...], Field(strict=False)] = ()
    floors: ProvenFloors | None = None
    cuts: Annotated[tuple[ProvenCut, ...], Field(strict=False)] = ()
    cost: ProvenCost | None = None

    @model_serializer(mode="wrap")
    def _without_defaults(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        written = without_former_model(write(self))
        if not self.cuts:
            written.pop("cuts", None)
        if self.cost is None:
            written.pop("cost", None)
        return written

    def to_json(self) -> str:
        """The certificate file."""
        return to_text(self.model_dump(mode="json"))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a certificate file.

        Raises
        ------
        InputError
            No such file, not JSON, or not a valid certificate. Its claims are not verified here;
            see :func:`adr_opt.verify`.
        """
        if not _is_packed(path):
            return parse_model(read_text(path), cls, str(path))
        try:
            text = gzip.decompress(Path(path).read_bytes()).decode()
        except FileNotFoundError:
            raise InputError(f"{path}: no such file; check the path") from None
        except (OSError, EOFError, zlib.error, UnicodeDecodeError):
            raise InputError(f"{path}: not a complete gzip file; write it again") from None
        return parse_model(text, cls, str(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the certificate file completely or not at all; gzipped if named ``.gz``."""
        content = self.to_json().encode()
        write_bytes(path, gzip.compress(content, mtime=0) if _is_packed(path) else content)


load_certificate = Certificate.load


def _is_packed(path: str | os.PathLike[str]) -> bool:
    return os.fspath(path).endswith(".gz")


def sha256_of(plan: Plan) -> str:
    """SHA-256 of the plan file written by :meth:`Plan.to_json`, without the outcome of its flight.

    A plan may be flown after the certificate is written.
    """
    planned = plan if plan.flown is None else plan.replace(flown=None)
    return hashlib.sha256(planned.to_json().encode()).hexdigest()
