"""Given connections: costs from elsewhere in place of the model's.

See docs/model.md section 9.

Whatever answers (origin, destination, departure) can be planned on: rows, matrices at departures,
a function. All become rows, one for each connection, of which planners and ``check`` are told.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.errors import InputError
from ..common.records import LARGEST_DELTA_V_M_S, LARGEST_TIME_S
from ..kernels.legs.given import sifted
from .given_functions import LEAST_S, Functions

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]

COLUMNS = ("origin", "destination", "departure_s", "arrival_s", "delta_v_m_s")
"""Columns of a row."""

REMOVED = "exception"
"""Column of a removed rule: without it, connections that it limited must not be planned."""

Costs = Callable[[int, npt.NDArray[np.int64], float], tuple[npt.ArrayLike, npt.ArrayLike]]
"""Durations [s] and costs from an origin to some destinations at a departure [s]."""


class GivenPairs(NamedTuple):
    """The pairs of bodies that have given connections, in order.

    Attributes
    ----------
    pair : (pairs,) int64
        Origin times the number of bodies, and destination.
    first : (pairs + 1,) int64
        First row of each, and the number of all rows.
    departures : (pairs,) int64
        Number of different ones of each.
    least : (pairs,) float64
        Least cost of each.
    """

    pair: npt.NDArray[np.int64]
    first: npt.NDArray[np.int64]
    departures: npt.NDArray[np.int64]
    least: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Given(Shown):
    """Connections between bodies, by origin, destination, departure, arrival and cost.

    Made by :func:`of_rows`, :func:`of_matrices` and :func:`of_function`; two that hold the same
    have the same :attr:`sha256`.

    Attributes
    ----------
    names : tuple of str
        The bodies that have connections, in the order of their names.
    origin, destination : (connections,) int32
        Numbers of names.
    departure, arrival : (connections,) float64
        Times since the epoch; service begins after the arrival [s].
    cost : (connections,) float64
        What stands where others have a ΔV [m/s by convention].
    functions : Functions or None
        Of pairs whose arrivals are functions of time, and which have no connections.
    """

    names: tuple[str, ...]
    origin: IntArray
    destination: IntArray
    departure: FloatArray
    arrival: FloatArray
    cost: FloatArray
    functions: Functions | None = None
    _number: dict[str, int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for array in (self.origin, self.destination, self.departure, self.arrival, self.cost):
            array.setflags(write=False)
        object.__setattr__(self, "_number", {name: at for at, name in enumerate(self.names)})

    @cached_property
    def pairs(self) -> GivenPairs:
        """The pairs that have connections."""
        pair = self.origin.astype(np.int64) * len(self.names) + self.destination
        begins = np.append(True, np.diff(pair) != 0)[: pair.size]
        new = begins | np.append(True, np.diff(self.departure) != 0.0)[: pair.size]
        first = np.flatnonzero(begins)
        departures = np.add.reduceat(new, first, dtype=np.int64) if first.size else first
        least = np.minimum.reduceat(self.cost, first) if first.size else self.cost
        return GivenPairs(pair[first], np.append(first, pair.size), departures, least)

    @property
    def bodies(self) -> tuple[str, ...]:
        """All bodies with connections or functions, in the order of their names."""
        return tuple(sorted({*self.names, *(self.functions.names if self.functions else ())}))

    def with_functions(self, functions: Functions | None) -> Given:
        """The same connections, beside functions of time.

        Raises
        ------
        InputError
            A pair has both.
        """
        for origin, destination in functions.pairs if functions else ():
            if self.of_pair(origin, destination)[0].size:
                raise InputError(
                    f"{origin!r} to {destination!r}: has given connections and a function of "
                    "time; give one of the two"
                )
        return replace(self, functions=functions)

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of the connections, independent of the file that holds them.

        That of the names as a JSON list and a line feed, and of the columns one after the other,
        as little-endian numbers of 4 (origin, destination) and 8 bytes, in the order of the rows.
        """
        digest = hashlib.sha256(json.dumps(self.names, ensure_ascii=False).encode() + b"\n")
        for numbers in (self.origin, self.destination):
            digest.update(numbers.astype("<i4").tobytes())
        for values in (self.departure, self.arrival, self.cost):
            digest.update(values.astype("<f8").tobytes())
        return digest.hexdigest()

    def _rows(self, origin: str, destination: str) -> slice:
        """Rows of a pair; none for unknown pairs."""
        i, j = self._number.get(origin, -1), self._number.get(destination, -1)
        if min(i, j) < 0:
            return slice(0)
        pair, pairs = i * len(self.names) + j, self.pairs
        at = int(np.searchsorted(pairs.pair, pair))
        if at == pairs.pair.size or pairs.pair[at] != pair:
            return slice(0)
        return slice(pairs.first[at], pairs.first[at + 1])

    def of_pair(self, origin: str, destination: str) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Departures, arrivals [s] and costs of a pair, in order; empty for unknown pairs."""
        rows = self._rows(origin, destination)
        return self.departure[rows], self.arrival[rows], self.cost[rows]

    def sizes(self, names: Sequence[str]) -> tuple[int, int, int]:
        """Most departures of a pair, number of all connections, most destinations of a body."""
        wanted, pairs = set(names), self.pairs
        known = np.array([name in wanted for name in self.names], dtype=np.bool_)
        origin, destination = np.divmod(pairs.pair, max(len(self.names), 1))
        mine = known[origin] & known[destination]
        rows = np.diff(pairs.first)[mine].sum()
        near = np.bincount(origin[mine]).max(initial=0)
        return int(pairs.departures[mine].max(initial=0)), int(rows), int(near)


def among(
    given: Given, names: Collection[str], starts: Mapping[str, str] = MappingProxyType({})
) -> Given:
    """The connections between some of the bodies.

    Parameters
    ----------
    given : Given
    names : collection of str
        Bodies that stay.
    starts : mapping of str to str, optional
        Bodies that are left, and the start that takes over what leads from each: nothing leads to
        a start, and nothing else from it.
    """
    new = set(starts.values())
    known = [*given.names, *sorted(new.difference(given.names))]
    number = {name: at for at, name in enumerate(known)}
    stays = np.array([name in names and name not in new for name in given.names], dtype=np.bool_)
    left = np.array([name in starts for name in given.names], dtype=np.bool_)
    become = np.array([number[starts.get(name, name)] for name in given.names], dtype=np.int32)
    # A body that is left and stays leads on twice: from itself, and from the start.
    mine, taken = (
        np.flatnonzero(origins[given.origin] & stays[given.destination])
        for origins in (stays, left)
    )
    rows = np.concatenate([mine, taken])
    made = _made(
        np.concatenate([given.origin[mine], become[given.origin[taken]]]),
        given.destination[rows],
        given.departure[rows],
        given.arrival[rows],
        given.cost[rows],
        known,
        "row {}".format,
    )
    if given.functions is not None:
        made = made.with_functions(given.functions.among(names, starts))
    return made


def only(functions: Functions) -> Given:
    """Functions of time, and no connections."""
    none: FloatArray = np.empty(0)
    return of_rows(dict.fromkeys(COLUMNS, none.astype(np.int32)), ()).with_functions(functions)


def of_rows(columns: Any, names: Sequence[str]) -> Given:
    """Connections from rows in any order.

    Parameters
    ----------
    columns : mapping of str to array
        The :data:`COLUMNS`, as a dictionary of arrays or a table of another library: bodies by name
        or number, times since the epoch [s], costs. Others are not looked at. A row whose arrival
        and cost are both NaN is no connection.
    names : sequence of str
        The bodies, in the order of their numbers.

    Raises
    ------
    InputError
        A column is missing or of another length, a body is unknown, or a number is not finite,
        negative or too large, or an arrival not after its departure; or there are exceptions.
    """
    found: dict[str, npt.NDArray[Any]] = {}
    for name in COLUMNS:
        try:
            found[name] = np.asarray(columns[name])
        except (KeyError, ValueError, IndexError, TypeError):
            raise InputError(
                f"column {name} is missing; a row has the columns {', '.join(COLUMNS)}"
            ) from None
        if found[name].ndim != 1 or found[name].size != found["origin"].size:
            raise InputError(f"column {name} must have one value for each row")
    ends = [_numbers(found[name], name, names) for name in COLUMNS[:2]]
    times = [_floats(found[name], name, of_time=name in COLUMNS[2:4]) for name in COLUMNS[2:]]
    try:
        columns[REMOVED]
    except Exception:  # each library has its own for a column that is not there
        pass
    else:
        refuse_exceptions([REMOVED])
    lacks_arrival, lacks_cost = np.isnan(times[1]), np.isnan(times[2])
    alone = np.flatnonzero(lacks_arrival != lacks_cost)
    if alone.size:
        at = int(alone[0])
        missing, stated = COLUMNS[3:] if lacks_arrival[at] else COLUMNS[:2:-1]
        raise InputError(
            _half(
                f"row {at}, {names[int(ends[0][at])]!r} to {names[int(ends[1][at])]!r}",
                missing,
                stated,
            )
        )
    rows = np.flatnonzero(~lacks_arrival)
    origin, destination = (values[rows] for values in ends)
    departure, arrival, cost = (values[rows] for values in times)
    return _made(origin, destination, departure, arrival, cost, names, lambda at: f"row {rows[at]}")


def _half(where: str, missing: str, stated: str) -> str:
    """A sentence on a connection that has a duration or a cost but not both."""
    return (
        f"{where}: {missing} is missing and {stated} is not; give both, or neither where there is "
        "no connection"
    )


def refuse_exceptions(columns: Sequence[str]) -> None:
    """Refuse rows with the removed column of exceptions.

    Raises
    ------
    InputError
    """
    if REMOVED in columns:
        raise InputError(
            f"column {REMOVED}: limits of exceptions were removed in 1.1; leave out the column and "
            "the rows that must not be used"
        )


def of_matrices(
    departures: npt.ArrayLike, duration: npt.ArrayLike, cost: npt.ArrayLike, names: Sequence[str]
) -> Given:
    """Connections from matrices: at each departure from every body to every other one.

    Parameters
    ----------
    departures : (departures,) float
        Since the epoch, each later than the one before [s]. A chaser ready in between waits for the
        next one.
    duration : (departures, bodies, bodies) float
        By (departure, origin, destination); +inf, or NaN in both, for no connection [s]. The
        diagonal is not looked at.
    cost : (departures, bodies, bodies) float
        Likewise.
    names : sequence of str
        The bodies, in the order of their numbers.

    Raises
    ------
    InputError
        Departures are not in order, a shape is another one, or a number as for :func:`of_rows`.
    """
    times = _departures(departures)
    shape = (times.size, len(names), len(names))
    takes, costs = _floats(duration, "duration", of_time=True), _floats(cost, "cost")
    for array, what in ((takes, "duration"), (costs, "cost")):
        if array.shape != shape:
            raise InputError(
                f"{what} has the shape {array.shape}, not {shape}: (departures, origin, "
                "destination) of all bodies of the instance, in the order of its numbers"
            )
    both = (takes, "duration"), (costs, "cost")
    for (array, what), (other, its) in (both, both[::-1]):
        half = np.isnan(array) & np.isfinite(other)
        wrong = (half | np.isneginf(array)) & ~np.eye(len(names), dtype=np.bool_)
        if wrong.any():
            k, m, n = (int(axis[0]) for axis in np.nonzero(wrong))
            if half[k, m, n]:
                where = f"departure {times[k]:g} s, {names[m]!r} to {names[n]!r}"
                raise InputError(_half(where, f"{what}[{k}, {m}, {n}]", its))
            raise InputError(
                f"{what}[{k}, {m}, {n}] = -inf: must be a number ≥ 0, or +inf for no connection"
            )
    there = np.isfinite(takes) & np.isfinite(costs) & ~np.eye(len(names), dtype=np.bool_)
    leaves, i, j = np.nonzero(there)
    departure = times[leaves]
    return _made(
        i, j, departure, departure + takes[there], costs[there], names, "connection {}".format
    )


def of_function(
    f: Costs, departures: npt.ArrayLike, names: Sequence[str], resolution: float = 0.0
) -> Given:
    """Connections from a function, evaluated at each departure.

    Parameters
    ----------
    f : callable
        Called with the number of an origin, those of all other bodies as an array, and a departure
        [s]; it may be compiled by Numba. Gives durations [s] and costs, shape (destinations,), or
        (choices, destinations) where there are several connections for each; +inf for none.
    departures : (departures,) float
        As :func:`of_matrices` takes them.
    names : sequence of str
        The bodies, in the order of their numbers.
    resolution : float
        A connection is dropped if another one of its pair departs no earlier, arrives no later and
        costs no more than that above it.

    Raises
    ------
    InputError
        As for :func:`of_matrices`.
    """
    times, bodies = _departures(departures), np.arange(len(names))
    parts: list[tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray]] = []
    for i in range(len(names)):
        others = np.delete(bodies, i)
        if not others.size:
            continue
        answers = [_evaluated(f, i, others, at) for at in times]
        if len({answer[0].shape for answer in answers}) > 1:
            raise InputError(
                f"f({i}, destinations, departure) must give as many rows at each departure; fill "
                "them up with +inf"
            )
        shape = (times.size, -1, others.size)
        duration, cost = (np.array(values).reshape(shape) for values in zip(*answers, strict=True))
        departure = np.broadcast_to(times[:, None, None], duration.shape)
        for at, j in enumerate(others):
            there = np.isfinite(duration[:, :, at]) & np.isfinite(cost[:, :, at])
            leaves = departure[:, :, at][there]
            rows = _sorted(leaves, leaves + duration[:, :, at][there], cost[:, :, at][there])
            found = sifted(*rows, np.inf, resolution)
            ends = np.full((2, found.departure.size), [[i], [j]], dtype=np.int32)
            parts.append((ends[0], ends[1], found.departure, found.arrival, found.delta_v))
    if not parts:
        none, nobody = np.empty(0), np.empty(0, dtype=np.int32)
        parts = [(nobody, nobody, none, none, none)]
    origin, destination, leaves, lands, costs = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    return _made(origin, destination, leaves, lands, costs, names, "connection {}".format)


def _evaluated(f: Costs, i: int, others: npt.NDArray[np.int64], at: float) -> list[FloatArray]:
    """Durations and costs from one call, shape (choices, destinations)."""
    answer = f(i, others, float(at))
    try:
        duration, cost = (
            np.atleast_2d(_floats(values, "f", of_time=of_time))
            for values, of_time in zip(answer, (True, False), strict=True)
        )
    except (TypeError, ValueError):
        duration = cost = np.empty(0)
    if duration.shape != cost.shape or duration.shape[-1] != others.size or duration.ndim != 2:
        raise InputError(
            f"f({i}, destinations, {at:g}) must give durations and costs, an array of one for each "
            f"of the {others.size} destinations, or of several rows of them"
        )
    for values in (duration, cost):
        if (np.isnan(values) | np.isneginf(values)).any():
            raise InputError(
                f"f({i}, destinations, {at:g}) gives nan or -inf; +inf means no connection"
            )
    return [duration, cost]


def _departures(departures: npt.ArrayLike) -> FloatArray:
    times = np.atleast_1d(_floats(departures, "departures", of_time=True))
    if times.ndim != 1 or not np.all(np.isfinite(times) & (times >= 0.0)):
        raise InputError("departures must be a list of finite times ≥ 0 in seconds")
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if late.size:
        at = int(late[0])
        raise InputError(
            f"departures[{at + 1}] = {times[at + 1]:g} is not after departures[{at}] = "
            f"{times[at]:g}; give each later than the one before"
        )
    return times


NO_NUMBERS = {
    "b": "true and false",
    "U": "text",
    "S": "text",
    "M": "dates",
    "m": "times",
    "c": "complex numbers",
}
"""Kinds of arrays that NumPy would convert to numbers, against any likely intention."""


def _floats(values: Any, name: str, *, of_time: bool = False) -> FloatArray:
    """A copy of values as floats, with time differences in seconds.

    Raises
    ------
    InputError
        It is text, truth values, dates or anything else that is no number.
    """
    try:
        found = np.asarray(values)
        kind = found.dtype.kind
        if kind == "O" and any(isinstance(one, (str, bytes, bool)) for one in found.ravel()):
            kind = "U"
        if kind == "m" and of_time:
            found, kind = found / np.timedelta64(1, "s"), "f"
        if kind not in "iufO":
            raise InputError(
                f"{name} must be numbers, and is {NO_NUMBERS.get(kind, 'something else')}; give "
                "seconds and costs as numbers"
            )
        return np.array(found, dtype=np.float64)
    except InputError:
        raise
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} must be an array of numbers, of the documented shape") from None


def _numbers(values: npt.NDArray[Any], column: str, names: Sequence[str]) -> IntArray:
    """Bodies given by number or by name, as numbers."""
    if values.dtype.kind in "iu":
        wrong = np.flatnonzero((values < 0) | (values >= len(names)))
        if wrong.size:
            raise InputError(
                f"row {wrong[0]}: {column} = {values[wrong[0]]} is not the number of a body, "
                f"from 0 to {len(names) - 1}"
            )
        return values.astype(np.int32)
    known = {name: number for number, name in enumerate(names)}
    told = (known.get(name, -1) if isinstance(name, str) else -1 for name in values.tolist())
    found = np.fromiter(told, np.int32, values.size)
    wrong = np.flatnonzero(found < 0)
    if wrong.size:
        raise InputError(
            f"row {wrong[0]}: {column} = {str(values[wrong[0]])!r} is not a body of the instance"
        )
    return found


def _made(
    origin: npt.NDArray[Any],
    destination: npt.NDArray[Any],
    departure: FloatArray,
    arrival: FloatArray,
    cost: FloatArray,
    names: Sequence[str],
    where: Callable[[int], str],
) -> Given:
    """Validated connections in order; ``where`` locates a row in errors."""

    def refuse(wrong: npt.NDArray[np.bool_], told: Callable[[int], str]) -> None:
        if wrong.any():
            at = int(np.flatnonzero(wrong)[0])
            ends = f"{names[int(origin[at])]!r} to {names[int(destination[at])]!r}"
            raise InputError(f"{where(at)}, {ends}: {told(at)}")

    refuse(origin == destination, lambda at: "ends where it begins; leave it out")
    for values, name, most in (
        (departure, "departure_s", LARGEST_TIME_S),
        (arrival, "arrival_s", LARGEST_TIME_S),
        (cost, "delta_v_m_s", LARGEST_DELTA_V_M_S),
    ):
        refuse(
            ~(np.isfinite(values) & (values >= 0.0) & (values <= most)),
            lambda at, values=values, name=name, most=most: (  # type: ignore[misc]
                f"{name} = {float(values[at])!r}: must be a number from 0 to {most:g}"
            ),
        )
    refuse(
        arrival - departure < LEAST_S,
        lambda at: (
            f"takes {float(arrival[at] - departure[at])!r} s; must take at least {LEAST_S:g} s"
        ),
    )
    used = np.flatnonzero(
        np.bincount(origin, minlength=len(names)) + np.bincount(destination, minlength=len(names))
    )
    kept = sorted(names[int(number)] for number in used)
    number = np.zeros(max(len(names), 1), dtype=np.int32)
    number[used] = [kept.index(names[int(one)]) for one in used]
    i, j = number[origin], number[destination]
    departure, arrival, cost = departure + 0.0, arrival + 0.0, cost + 0.0  # no −0.0
    # Most often rows are in order but for that of the names, which takes far less time.
    pair = i.astype(np.int64) * len(kept) + j
    order = np.argsort(pair, kind="stable")
    columns = pair, departure, arrival, cost
    if not _are_in_order(*(column[order] for column in columns)):
        order = np.lexsort(columns[::-1])
    return Given(tuple(kept), i[order], j[order], departure[order], arrival[order], cost[order])


def _are_in_order(*columns: npt.NDArray[Any]) -> bool:
    """Whether rows are in lexicographic order of their columns."""
    same = np.ones(max(columns[0].size - 1, 0), dtype=np.bool_)
    for column in columns:
        before, after = column[:-1], column[1:]
        if np.any(same & (after < before)):
            return False
        same &= after == before
    return True


def _sorted(departure: FloatArray, arrival: FloatArray, cost: FloatArray) -> list[FloatArray]:
    order = np.lexsort((cost, arrival, departure))
    rows = [departure[order], arrival[order], cost[order]]
    for values in rows:
        values.setflags(write=False)  # as those of a Given, or kernels would be compiled twice
    return rows
