"""Integer weights: the replacement of m/s and seconds in formats of combinatorial problems."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...legs.matrices import FloatArray, Matrices
from ...problem.instance import Instance
from ...problem.support import binding

UNITS = {"delta_v": "m/s", "duration": "s"}

LARGEST = 2**31 - 1
"""Largest weight written: many readers of these formats keep weights in 32-bit integers."""

FINEST_SCALE = 1000.0


@dataclass(frozen=True)
class WeightMatrix:
    """One quantity at one departure, as integers.

    Attributes
    ----------
    values : (bodies, bodies) int64
        ``round(scale · quantity)``, so that each is within 0.5/scale of the truth; 0 on the
        diagonal.
    quantity : {"delta_v", "duration"}
    scale : float
        Weight of one m/s or of one second.
    no_transfer : int
        Weight where there is no transfer: more than any tour of the other weights.
    departure : float
        Ready time since the epoch [s].
    choice : str
        Which transfers they are of, in words of ASCII.
    has_service : bool
        Whether durations contain the service at the destination.
    """

    values: npt.NDArray[np.int64]
    quantity: str
    scale: float
    no_transfer: int
    departure: float
    choice: str
    has_service: bool = False


def check_quantity(quantity: str) -> None:
    """Raise :class:`InputError` for an unknown quantity."""
    if quantity not in UNITS:
        raise InputError(f"quantity = {quantity!r}: use one of {', '.join(UNITS)}")


def check_scale(scale: float | None) -> None:
    """Raise :class:`InputError` for a scale that is not positive."""
    if scale is not None and not (math.isfinite(scale) and scale > 0.0):
        raise InputError(f"scale = {scale!r}: must be a positive number")


def whole_weights(
    matrices: Matrices,
    quantity: str,
    scale: float | None,
    limit: float = 0.0,
    service: FloatArray | None = None,
) -> WeightMatrix:
    """Scale and round the first departure of the matrices.

    Parameters
    ----------
    matrices : Matrices
    quantity : {"delta_v", "duration"}
    scale : float, optional
        By default the largest power of ten up to 1000 that fits.
    limit : float
        Budget that the weight for "no transfer" has to exceed as well [m/s or s].
    service : (bodies,) float64, optional
        Added to the way to each body [s]; the diagonal stays 0.

    Raises
    ------
    InputError
        The weights do not fit into 31 bits.
    """
    exact = matrices.delta_v[0] if quantity == "delta_v" else matrices.duration[0]
    if service is not None:
        exact = exact + service
        np.fill_diagonal(exact, 0.0)
    finite = np.isfinite(exact)
    largest = float(exact[finite].max(initial=0.0))

    def no_transfer(at: float) -> int:
        return max(len(exact) * math.ceil(at * largest), math.ceil(at * limit)) + 1

    if scale is None:
        scale = FINEST_SCALE
        while no_transfer(scale) > LARGEST:
            scale /= 10.0
    elif not scale * max(len(exact) * largest, limit) < LARGEST - len(exact):
        raise InputError(
            f"scale = {scale!r}: the weights would not fit into 31 bits; give less, or none"
        )
    values = np.full(exact.shape, no_transfer(scale), dtype=np.int64)
    values[finite] = np.rint(scale * exact[finite]).astype(np.int64)
    return WeightMatrix(
        values,
        quantity,
        scale,
        no_transfer(scale),
        float(matrices.departures[0]),
        matrices.choice.replace("ΔV", "delta-v"),
        service is not None,
    )


def slug(instance: Instance) -> str:
    """A valid name in the formats, from the name of an instance.

    Readers look for their keywords, all upper case, anywhere in a line.
    """
    return re.sub(r"[^a-z0-9._-]+", "-", instance.name.lower()).strip("-") or "instance"


def comment(instance: Instance, weights: WeightMatrix) -> str:
    """A line that explains the integers."""
    contents = ""
    if weights.quantity == "duration":
        contents = "from ready to arrival, without service; "
        if weights.has_service:
            contents = "from ready to the end of service, at the station to arrival; "
    return (
        f"{weights.quantity} in {UNITS[weights.quantity]} times {weights.scale:g}, rounded, "
        f"transfers {weights.choice}, ready at {weights.departure!r} s after "
        f"{instance.model_dump(mode='json')['epoch']}; "
        f"{weights.no_transfer} = no transfer; {contents}"
        f"{_nodes(instance)}; instance sha256 {instance.sha256}{_left_out(instance)}"
    )


NOT_HELD = (
    "windows",
    "required targets",
    "late availability",
    "end of availability",
    "ends",
    "most targets",
    "limited refuellings",
    "cost",
    "refuelling",
)
"""Rules that files for other solvers have no place for, and say so."""


def _left_out(instance: Instance) -> str:
    """The rules of an instance that are not in the file."""
    words = [word for word, _ in binding(instance, NOT_HELD)]
    return f"; not in this file: {', '.join(words)}" if words else ""


def _nodes(instance: Instance) -> str:
    """Assignment of bodies to nodes."""
    stations, first = len(instance.stations), instance.first_target
    if first == 1:
        before = "the station" if stations else "the start"
        return f"node 1 is {before}, then the targets in order"
    start = ", the last of these the start" if first > stations else ""
    return f"nodes 1 to {first} are the stations in order{start}, then the targets in order"


def edges(weights: WeightMatrix) -> list[str]:
    """Lines of the matrix, as in all these formats."""
    return [
        "EDGE_WEIGHT_TYPE : EXPLICIT",
        "EDGE_WEIGHT_FORMAT : FULL_MATRIX",
        "EDGE_WEIGHT_SECTION",
        *(" ".join(map(str, row)) for row in weights.values.tolist()),
    ]
