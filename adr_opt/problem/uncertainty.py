"""The uncertainty file ``adr-opt-uncertainty/1``: what may differ from the plan.

Distributions by kind of event and by target, all independent. See docs/model.md section 13.
"""

from __future__ import annotations

import math
import os
from statistics import NormalDist
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from ..common.errors import InputError
from ..common.files import read_model, to_text, write_text
from ..common.records import LARGEST_DURATION_S, Name, Omitting, Record
from ..kernels.core import draws
from .instance import Instance
from .support import refuse_unknown

FORMAT: Literal["adr-opt-uncertainty/1"] = "adr-opt-uncertainty/1"

LARGEST_FACTOR = 100.0
LARGEST_SIGMA = 3.0
MOST_TRIES = 100

Share = Annotated[float, Field(ge=0.0, le=1.0)]
Factor = Annotated[float, Field(gt=0.0, le=LARGEST_FACTOR)]
Tries = Annotated[int, Field(ge=1, le=MOST_TRIES)]

_NORMAL = NormalDist()


class LognormalFactor(Record):
    """A lognormal factor of median 1 within bounds.

    What lies beyond a bound counts as the bound, so that the median stays 1.
    """

    lognormal_sigma: Annotated[float, Field(ge=0.0, le=LARGEST_SIGMA)]
    least: Factor = 0.5
    most: Factor = 2.0

    @model_validator(mode="after")
    def _has_one_between(self) -> Self:
        if not self.least <= 1.0 <= self.most:
            raise ValueError(
                f"least = {self.least!r}, most = {self.most!r}: the median is 1; give bounds on "
                "both sides of it"
            )
        return self

    def at(self, uniform: float) -> float:
        """The factor at a number drawn uniformly from (0, 1)."""
        return float(draws.lognormal_at(uniform, self.lognormal_sigma, self.least, self.most))

    @property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation."""
        sigma = self.lognormal_sigma
        if sigma == 0.0:
            return 1.0, 0.0
        low, high = math.log(self.least) / sigma, math.log(self.most) / sigma

        def power(n: int) -> float:
            """Mean of the n-th power, draws beyond a bound counted at that bound."""
            shift, cdf = n * sigma, _NORMAL.cdf
            within = math.exp(0.5 * shift * shift) * (cdf(high - shift) - cdf(low - shift))
            return within + self.least**n * cdf(low) + self.most**n * cdf(-high)

        mean = power(1)
        return mean, math.sqrt(max(power(2) - mean * mean, 0.0))


class Delay(Omitting):
    """A delay that occurs with a chance, exponential with a mean, up to a maximum."""

    chance: Share = 1.0
    mean_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)]
    most_s: Annotated[float, Field(ge=0.0, le=LARGEST_DURATION_S)] | None = None

    OMITTED: ClassVar = ("most_s",)

    def at(self, uniform: float) -> float:
        """The delay at a number drawn uniformly from (0, 1) [s]."""
        return float(draws.delay_at(uniform, self.chance, self.mean_s, self.at_most_s))

    @property
    def at_most_s(self) -> float:
        """The maximum, stated or not [s]."""
        return LARGEST_DURATION_S if self.most_s is None else self.most_s

    @property
    def average_s(self) -> float:
        """The mean of all, those that do not occur and those at the maximum included [s]."""
        if self.mean_s == 0.0:
            return 0.0
        return -self.chance * self.mean_s * math.expm1(-self.at_most_s / self.mean_s)


class LegUncertainty(Record):
    """Factors on the ΔV of legs, of all kinds or by kind of leg."""

    delta_v_factor: LognormalFactor | None = None
    kinds: dict[Name, LognormalFactor] = Field(default_factory=dict)

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _set(write(self))


class ServiceUncertainty(Record):
    """Times of services: a factor on the planned time, and a delay added to it."""

    factor: LognormalFactor | None = None
    added: Delay | None = None

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _set(write(self))


class CaptureUncertainty(Omitting):
    """Captures: the chance that a try succeeds, and the maximum number of tries."""

    success: Share | None = None
    tries: Tries = 1

    OMITTED: ClassVar = ("success",)


class LaunchUncertainty(Record):
    """Slips of launches, of all chasers that are launched or by name of the chaser."""

    slip_s: Delay | None = None
    chasers: dict[Name, Delay] = Field(default_factory=dict)

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return _set(write(self))


class TankUncertainty(Record):
    """Share of the ΔV of a full tank that can be used, uniform between two shares."""

    least: Annotated[float, Field(gt=0.0, le=1.0)]
    most: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.least > self.most:
            raise ValueError(
                f"least = {self.least!r} is more than most = {self.most!r}; give the smaller first"
            )
        return self

    def at(self, uniform: float) -> float:
        """The share at a number drawn uniformly from (0, 1)."""
        return self.least + (self.most - self.least) * uniform

    @property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation."""
        return 0.5 * (self.least + self.most), (self.most - self.least) / math.sqrt(12.0)


class TargetUncertainty(Record):
    """Distributions of one target; unset fields take those of the whole file."""

    delta_v_factor: LognormalFactor | None = None
    service_s: ServiceUncertainty | None = None
    success: Share | None = None
    tries: Tries | None = None
    gone: Share | None = None

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # An empty record stays: it says that the target is certain where the file is not.
        return {name: value for name, value in write(self).items() if value is not None}


def _set(content: dict[str, Any]) -> dict[str, Any]:
    """The written form of a record without what is unset."""
    return {name: value for name, value in content.items() if value not in (None, {})}


class Uncertainty(Record):
    """Distributions of what may differ from the plan; by default nothing does.

    ``legs`` are factors on ΔV, ``service_s`` times of services, ``capture`` chances of captures,
    ``gone`` the chance that a target turns out to be gone, ``launches`` slips, ``tanks`` shares of
    tanks that can be used; ``targets`` has what differs by name of the target.
    """

    format: Literal["adr-opt-uncertainty/1"] = FORMAT
    legs: LegUncertainty = LegUncertainty()
    service_s: ServiceUncertainty = ServiceUncertainty()
    capture: CaptureUncertainty = CaptureUncertainty()
    gone: Share | None = None
    launches: LaunchUncertainty = LaunchUncertainty()
    tanks: TankUncertainty | None = None
    targets: dict[Name, TargetUncertainty] = Field(default_factory=dict)

    @model_serializer(mode="wrap")
    def _without_unset(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        content = _set(write(self))
        if content.get("capture") == {"tries": 1}:
            del content["capture"]
        return content

    def to_json(self) -> str:
        """The uncertainty file."""
        return to_text(self.model_dump(mode="json"))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read an uncertainty file.

        Raises
        ------
        InputError
            No such file, not JSON, or not a valid uncertainty file.
        """
        return read_model(path, cls)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the uncertainty file, completely or not at all."""
        write_text(path, self.to_json())

    def of(self, instance: Instance) -> Self:
        """The uncertainty of an instance, with chances of captures that its targets state.

        What the file says of captures, or of a target, goes before.

        Raises
        ------
        InputError
            A target is none of the instance's, a chaser is none that is launched, or a field is set
        that nobody knows.
        """
        refuse_unknown(self)
        targets = {target.name for target in instance.targets}
        for name in self.targets:
            if name not in targets:
                raise InputError(f"targets: {name!r} is not a target of {instance.name!r}")
        launched = {chaser.name for chaser in instance.chasers if chaser.is_launched}
        for name in self.launches.chasers:
            if name not in launched:
                raise InputError(
                    f"launches.chasers: {name!r} is not a chaser of {instance.name!r} that is "
                    "launched"
                )
        if self.capture.success is not None:
            return self
        own = dict(self.targets)
        for target in instance.targets:
            stated = own.get(target.name, TargetUncertainty())
            if target.success is not None and stated.success is None:
                own[target.name] = stated.replace(success=target.success)
        return self if own == self.targets else self.replace(targets=own)

    def factor_of(self, kind: str, destination: str | None) -> LognormalFactor | None:
        """Distribution of the factor on a leg's ΔV; None where it is 1.

        Parameters
        ----------
        kind : str
            Of the leg.
        destination : str or None
            Name of the target it leads to; None for a station.
        """
        own = self.targets.get(destination) if destination is not None else None
        if own is not None and own.delta_v_factor is not None:
            return own.delta_v_factor
        return self.legs.kinds.get(kind, self.legs.delta_v_factor)

    def service_of(self, target: str) -> ServiceUncertainty:
        """Distribution of the time of a service."""
        own = self.targets.get(target)
        return self.service_s if own is None or own.service_s is None else own.service_s

    def success_of(self, target: str) -> float:
        """Chance that a try at a target succeeds."""
        own = self.targets.get(target)
        known = self.capture.success if own is None or own.success is None else own.success
        return 1.0 if known is None else known

    def tries_of(self, target: str) -> int:
        """Maximum number of tries at a target."""
        own = self.targets.get(target)
        return self.capture.tries if own is None or own.tries is None else own.tries

    def gone_of(self, target: str) -> float:
        """Chance that a target is gone."""
        own = self.targets.get(target)
        known = self.gone if own is None or own.gone is None else own.gone
        return known or 0.0

    def slip_of(self, chaser: str) -> Delay | None:
        """Distribution of the slip of a chaser's launch; None where there is none."""
        return self.launches.chasers.get(chaser, self.launches.slip_s)
