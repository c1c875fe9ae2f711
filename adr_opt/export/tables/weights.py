"""Formats of combinatorial problems, in which integer weights replace m/s and seconds.

``.tsp`` is an asymmetric travelling-salesman problem in TSPLIB 95 (TYPE ATSP, FULL_MATRIX; G.
Reinelt, TSPLIB 95, Universität Heidelberg).

``.oplib`` is an orienteering problem in OPLib's format (https://github.com/bcamath-ds/OPLib), which
extends TSPLIB 95 by COST_LIMIT, the most that a cycle through the depot may cost, and
NODE_SCORE_SECTION. All its numbers are integers. Its own instances are symmetric, and explicit ones
are written as a triangle; transfers are not symmetric, so the weights here are a FULL_MATRIX.

``.vrp`` is a prize-collecting vehicle-routing problem in VRPLIB, as PyVRP and vrplib read it. PyVRP
takes the weights both for distances and for durations, so a file is about one of the two. One unit
of prize is worth more than all routes together, so PyVRP, which minimises distance plus prizes
forgone, collects prizes first and saves ΔV or time second. PyVRP takes a prize of zero for a duty;
it is written as 1, which no detour is worth. The demand of every target is 1 and CAPACITY never
binds: readers of plain CVRP files ask for both.

What of a mission the last two can say, at one departure, whatever the time:

- ΔV: a cycle is one fuel load, from the station and back; there is no clock. In a ``.vrp`` there
  are as many routes as targets (VEHICLES_MAX_DISTANCE is the budget).
- duration: there is one route, the mission, and no fuel; unlike a plan it has to return. Service is
  in the weight of the way to each target (``.oplib``, which has no other place for it), or in
  SERVICE_TIME_SECTION beside VEHICLES_MAX_DURATION (``.vrp``).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...common.constants import STATION
from ...common.errors import InputError
from ...legs.matrices import FloatArray, Matrices
from ...mission.mission import Mission
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
"""Rules that files for other solvers cannot hold; the files state which are left out."""


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


def write_tsp(
    path: Path, instance: Instance, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure; COMMENT states the scale and the mark of no transfer."""
    weights = whole_weights(matrices, quantity, scale)
    lines = [
        f"NAME : {slug(instance)}",
        "TYPE : ATSP",
        f"COMMENT : {comment(instance, weights)}",
        f"DIMENSION : {len(matrices.names)}",
        *edges(weights),
        "EOF",
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


FINEST_SCORES = 1000.0


def scores(prizes: list[float]) -> tuple[list[int], float]:
    """Integer scores of prizes, and the score of a unit prize.

    Whole prizes are written as they are; others times the largest power of ten up to 1000 that
    fits, rounded.

    Raises
    ------
    InputError
        The prizes do not fit into 31 bits.
    """
    scale = 1.0 if all(prize.is_integer() for prize in prizes) else FINEST_SCORES
    while scale * sum(prizes) > LARGEST and scale > 1.0:
        scale /= 10.0
    if scale * sum(prizes) > LARGEST:
        raise InputError(f"prizes up to {max(prizes)!r} do not fit the 31 bits of a .oplib file")
    return [round(scale * prize) for prize in prizes], scale


def write_oplib(
    path: Path, mission: Mission, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure.

    Raises
    ------
    InputError
        The prizes or the weights do not fit into 31 bits.
    """
    instance = mission.instance
    is_duration = quantity == "duration"
    limit = instance.mission.duration_s if is_duration else instance.chaser.usable.delta_v_m_s
    service = np.array(mission.rules.service) if is_duration else None
    if service is not None:
        service[STATION] = 0.0  # the cycle ends there
    weights = whole_weights(matrices, quantity, scale, limit, service)
    values, unit = scores([target.prize for target in instance.targets])
    lines = [
        f"NAME : {slug(instance)}",
        f"COMMENT : {comment(instance, weights)}; {unit:g} = a prize of one",
        "TYPE : OP",
        f"DIMENSION : {len(matrices.names)}",
        f"COST_LIMIT : {math.floor(weights.scale * limit)}",
        *edges(weights),
        "NODE_SCORE_SECTION",
        *(f"{node} {score}" for node, score in enumerate([0, *values], start=1)),
        "DEPOT_SECTION",
        "1",
        "-1",
        "EOF",
    ]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")


LARGEST_PRIZES = 2**44
"""Largest sum of prizes and of distances in PyVRP; beyond it, sums may overflow."""


def write_vrp(
    path: Path, mission: Mission, matrices: Matrices, quantity: str, scale: float | None
) -> None:
    """Write one quantity at one departure.

    Raises
    ------
    InputError
        There is no target, or the prizes differ by too many orders of magnitude.
    """
    instance = mission.instance
    targets = len(instance.targets)
    if targets == 0:
        raise InputError(f"{instance.name!r} has no target: a .vrp file needs at least one")
    is_duration = quantity == "duration"
    limit = instance.mission.duration_s if is_duration else instance.chaser.usable.delta_v_m_s
    weights = whole_weights(matrices, quantity, scale, limit)
    budget = math.floor(weights.scale * limit)
    vehicles = 1 if is_duration else targets

    given = [target.prize for target in instance.targets]
    least = min([1.0, *(prize for prize in given if prize > 0.0)])
    prize_unit = (vehicles * budget + 1) / least
    if not prize_unit * sum(given) <= LARGEST_PRIZES:
        raise InputError(
            f"prizes from {least!r} to {max(given)!r} do not fit the integers of a .vrp file "
            f"with scale = {weights.scale:g}; give less"
        )
    prizes = [0, *(max(1, round(prize * prize_unit)) for prize in given)]

    def section(name: str, values: list[int]) -> list[str]:
        numbered = [f"{node} {value}" for node, value in enumerate(values, start=1)]
        return [f"{name}_SECTION", *numbered]

    lines = [
        f"NAME : {slug(instance)}",
        f"COMMENT : {comment(instance, weights)}; {prize_unit:.17g} = a prize of one",
        "TYPE : ACVRP",
        f"DIMENSION : {targets + 1}",
        f"VEHICLES : {vehicles}",
        f"CAPACITY : {targets}",
        f"VEHICLES_MAX_{'DURATION' if is_duration else 'DISTANCE'} : {budget}",
        *edges(weights),
        *section("DEMAND", [0] + [1] * targets),
        *section("PRIZE", prizes),
    ]
    if is_duration:
        service = [0, *(math.ceil(weights.scale * time) for time in mission.rules.service[1:])]
        lines += section("SERVICE_TIME", service)
    lines += ["DEPOT_SECTION", "1", "-1", "EOF"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
