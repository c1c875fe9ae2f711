"""Given costs that are functions of time: piecewise linear arrivals that never overtake.

See docs/model.md section 9. Where a pair has a function, a chaser may leave at any time, and who
leaves later arrives no earlier. No list of connections says as much, however long it is. Their
files, ``adr-opt-functions/1``, are JSON beside the instance file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import Field

from ..common.card import Shown
from ..common.errors import InputError
from ..common.files import read_model, write_text
from ..common.records import LARGEST_DELTA_V_M_S, LARGEST_TIME_S, Name, Record
from .settings import GivenFile

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

LEAST_S = 1e-3
"""Least duration of a leg, as of given connections [s]."""


class Function(NamedTuple):
    """The function of a pair.

    Attributes
    ----------
    departure, arrival : (breakpoints,) float64
        Neither falls; linear in between, and at a jump the earlier arrival counts. Nothing leaves
        after the last one, and who is ready before the first waits for it [s].
    cost : float
        What each of its legs costs [m/s by convention].
    """

    departure: FloatArray
    arrival: FloatArray
    cost: float


@dataclass(frozen=True, eq=False, repr=False)
class Functions(Shown):
    """Arrivals as functions of departures, by origin and destination.

    Made by :func:`of_breakpoints`; two that hold the same have the same :attr:`sha256`.

    Attributes
    ----------
    names : tuple of str
        The bodies that have functions, in the order of their names.
    origin, destination : (pairs,) int32
        Numbers of names, in order.
    first : (pairs + 1,) int64
        First breakpoint of each pair.
    departure, arrival : (breakpoints,) float64
        Times since the epoch [s].
    cost : (pairs,) float64
        [m/s by convention].
    """

    names: tuple[str, ...]
    origin: IntArray
    destination: IntArray
    first: npt.NDArray[np.int64]
    departure: FloatArray
    arrival: FloatArray
    cost: FloatArray
    _place: dict[tuple[str, str], int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        columns = self.origin, self.destination, self.first, self.departure, self.arrival, self.cost
        for array in columns:
            array.setflags(write=False)
        object.__setattr__(self, "_place", {pair: at for at, pair in enumerate(self.pairs)})

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """The pairs, in order."""
        return [
            (self.names[i], self.names[j])
            for i, j in zip(self.origin.tolist(), self.destination.tolist(), strict=True)
        ]

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the functions, independent of the file that holds them.

        That of the names as a JSON list and a line feed, and of the columns one after the other,
        as little-endian numbers of 4 (origin, destination) and 8 bytes (the number of breakpoints
        of each pair, departures, arrivals, costs), in the order of the pairs.
        """
        digest = hashlib.sha256(json.dumps(self.names, ensure_ascii=False).encode() + b"\n")
        for numbers in (self.origin, self.destination):
            digest.update(numbers.astype("<i4").tobytes())
        digest.update(np.diff(self.first).astype("<i8").tobytes())
        for values in (self.departure, self.arrival, self.cost):
            digest.update(values.astype("<f8").tobytes())
        return digest.hexdigest()

    def of_pair(self, origin: str, destination: str) -> Function | None:
        """The function of a pair; None if it has none."""
        at = self._place.get((origin, destination))
        if at is None:
            return None
        rows = slice(int(self.first[at]), int(self.first[at + 1]))
        return Function(self.departure[rows], self.arrival[rows], float(self.cost[at]))

    def among(
        self, names: Collection[str], starts: Mapping[str, str] = MappingProxyType({})
    ) -> Functions | None:
        """The functions between some of the bodies, as :func:`.given.among`; None without any."""
        new = set(starts.values())
        found: list[tuple[str, str, Function]] = []
        for origin, destination in self.pairs:
            if destination not in names or destination in new:
                continue
            function = self.of_pair(origin, destination)
            assert function is not None
            if origin in names and origin not in new:
                found.append((origin, destination, function))
            if origin in starts:
                found.append((starts[origin], destination, function))
        return _made(found) if found else None


def of_breakpoints(
    rows: Iterable[tuple[str, str, npt.ArrayLike, float]], names: Sequence[str]
) -> Functions:
    """Functions from breakpoints, pair by pair in any order.

    Parameters
    ----------
    rows : iterable of (origin, destination, breakpoints, cost)
        Bodies by name; (breakpoints, 2) departures and arrivals [s]; the cost of each leg.
    names : sequence of str
        The bodies that may occur.

    Raises
    ------
    InputError
        A body is unknown or a pair occurs twice; a number is not finite, negative or too large;
        breakpoints are not in order, overtake, or take no time.
    """
    known, seen = set(names), set[tuple[str, str]]()
    found: list[tuple[str, str, Function]] = []
    for origin, destination, breakpoints, cost in rows:
        where = f"{origin!r} to {destination!r}"
        for name in (origin, destination):
            if name not in known:
                raise InputError(f"{where}: {name!r} is not a body of the instance")
        if origin == destination:
            raise InputError(f"{where}: ends where it begins; leave it out")
        if (origin, destination) in seen:
            raise InputError(f"{where}: has two functions; give one")
        seen.add((origin, destination))
        found.append((origin, destination, _checked(where, breakpoints, cost)))
    return _made(found)


def _checked(where: str, breakpoints: npt.ArrayLike, cost: float) -> Function:
    """A function, if it is one.

    Raises
    ------
    InputError
    """
    try:
        points = np.array(breakpoints, dtype=np.float64)
    except (TypeError, ValueError):
        points = np.empty(0)
    if points.ndim != 2 or points.shape[1:] != (2,) or not points.size:
        raise InputError(
            f"{where}: breakpoints are pairs [departure, arrival] in seconds, at least one"
        )
    wrong = ~(np.isfinite(points) & (points >= 0.0) & (points <= LARGEST_TIME_S))
    if wrong.any():
        value = float(points[wrong][0])
        raise InputError(f"{where}: {value!r} s: must be a number from 0 to {LARGEST_TIME_S:g}")
    if not 0.0 <= cost <= LARGEST_DELTA_V_M_S:
        raise InputError(
            f"{where}: delta_v_m_s = {cost!r}: must be a number from 0 to {LARGEST_DELTA_V_M_S:g}"
        )
    points += 0.0  # no −0.0
    departure, arrival = points[:, 0].copy(), points[:, 1].copy()
    early = np.flatnonzero(np.diff(departure) < 0.0)
    if early.size:
        at = int(early[0])
        raise InputError(
            f"{where}: breakpoint {at + 1} departs at {departure[at + 1]:g}, before "
            f"{departure[at]:g}; give breakpoints in order"
        )
    over = np.flatnonzero(np.diff(arrival) < 0.0)
    if over.size:
        at = int(over[0])
        raise InputError(
            f"{where}: departing at {departure[at + 1]:g} arrives at {arrival[at + 1]:g}, before "
            f"the earlier departure does at {arrival[at]:g}; arrivals must not fall"
        )
    if np.any(departure[2:] == departure[:-2]):
        at = int(np.flatnonzero(departure[2:] == departure[:-2])[0])
        raise InputError(f"{where}: three breakpoints depart at {departure[at]:g}; a jump has two")
    short = np.flatnonzero(arrival - departure < LEAST_S)
    if short.size:
        at = int(short[0])
        raise InputError(
            f"{where}: breakpoint {at} takes {float(arrival[at] - departure[at])!r} s; must take "
            f"at least {LEAST_S:g} s"
        )
    return Function(departure, arrival, float(cost) + 0.0)


def _made(found: Sequence[tuple[str, str, Function]]) -> Functions:
    """Functions in the order of their pairs."""
    ordered = sorted(found, key=lambda row: row[:2])
    names = tuple(sorted({name for row in ordered for name in row[:2]}))
    number = {name: at for at, name in enumerate(names)}
    sizes = [row[2].departure.size for row in ordered]
    empty: list[Any] = [np.empty(0)]
    return Functions(
        names,
        np.array([number[row[0]] for row in ordered], dtype=np.int32),
        np.array([number[row[1]] for row in ordered], dtype=np.int32),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.concatenate([*empty, *(row[2].departure for row in ordered)]),
        np.concatenate([*empty, *(row[2].arrival for row in ordered)]),
        np.array([row[2].cost for row in ordered], dtype=np.float64),
    )


FORMAT: Literal["adr-opt-functions/1"] = "adr-opt-functions/1"

Breakpoint = Annotated[tuple[float, float], Field(strict=False)]
"""Departure and arrival [s]."""


class PairFunction(Record):
    """The function of a pair."""

    origin: Name
    destination: Name
    delta_v_m_s: float = 0.0
    breakpoints_s: Annotated[tuple[Breakpoint, ...], Field(strict=False, min_length=1)]


class FunctionsFile(Record):
    """Functions of time of some pairs."""

    format: Literal["adr-opt-functions/1"]
    functions: Annotated[tuple[PairFunction, ...], Field(strict=False)]


def read_functions(
    instance_path: str | os.PathLike[str], reference: GivenFile, names: tuple[str, ...]
) -> Functions | None:
    """Read the functions that an instance file names, from a file beside it; None if it names none.

    Raises
    ------
    InputError
        No such file, not JSON, or no functions that can be planned on; or others than the instance
        says.
    """
    if reference.functions is None:
        return None
    path = Path(instance_path).parent / reference.functions
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the given functions there")
    content = read_model(path, FunctionsFile)
    rows = (
        (each.origin, each.destination, each.breakpoints_s, each.delta_v_m_s)
        for each in content.functions
    )
    try:
        made = of_breakpoints(rows, names)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if reference.functions_sha256 not in (None, made.sha256):
        raise InputError(
            f"{path}: not the functions that {instance_path} names in transfer.given: their "
            f"sha256 is {made.sha256}; put the right file there, or leave the field "
            "functions_sha256 out"
        )
    return made


def write_functions(path: str | os.PathLike[str], functions: Functions) -> None:
    """Write functions as JSON, completely or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    lines = []
    for origin, destination in functions.pairs:
        function = functions.of_pair(origin, destination)
        assert function is not None
        row = {
            "origin": origin,
            "destination": destination,
            "delta_v_m_s": function.cost,
            "breakpoints_s": list(
                zip(function.departure.tolist(), function.arrival.tolist(), strict=True)
            ),
        }
        lines.append("  " + json.dumps(row, ensure_ascii=False))
    body = ",\n".join(lines)
    text = f'{{\n "format": {json.dumps(FORMAT)},\n "functions": [\n{body}\n ]\n}}\n'
    write_text(path, text)
