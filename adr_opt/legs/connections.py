"""Connections: every transfer of a pair that may be worth waiting for."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from threading import Lock
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.constants import HOUR_S, SLACK_S
from ..common.errors import InputError
from ..kernels.legs.found import ConnectionArrays

FloatArray = npt.NDArray[np.float64]

CHOICES = {"earliest": (0.0, 1.0), "cheapest": (1.0, 0.0)}
"""Weights of ΔV and of arrival time by the name of a choice."""

Choice = float | str
"""Rule for choosing among connections: a name, or the value of an hour [m/s]."""


@dataclass(frozen=True, repr=False)
class Connections(Shown):
    """The connections of a pair in order of departure, then of arrival.

    Attributes
    ----------
    departure, arrival : (connections,) float64
        Times since the epoch; the arrival is the end of the approach [s].
    delta_v : (connections,) float64
        [m/s].
    revolutions : (connections,) int8
        Phasing revolutions; −1 for a transfer that drifts, 0 for one that is given.
    family : (connections,) int8
        Number of the family of legs that each is of, in the order of :func:`.leg_kinds`.
    mass_kg : (connections,) float64 or None
        Largest mass of the chaser at departure, +inf for any; None where none of them depends on
        it [kg].
    """

    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    revolutions: npt.NDArray[np.int8]
    family: npt.NDArray[np.int8]
    mass_kg: FloatArray | None = None

    def at(self, rows: slice | npt.NDArray[Any]) -> Connections:
        """The connections at some rows."""
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(
            self, **{name: each[rows] for name, each in columns.items() if each is not None}
        )

    def after(self, ready: float) -> Connections:
        """The connections available to a chaser that is ready at a time [s]."""
        return self.at(slice(int(np.searchsorted(self.departure, ready - SLACK_S)), None))


@dataclass(frozen=True, repr=False)
class AllConnections(Shown):
    """Connections of all pairs in arrays, pair by pair by origin, then by destination.

    Within a pair in order of departure, then of arrival, as :class:`Connections`.

    Attributes
    ----------
    names : tuple of str
        Bodies, in the order of their numbers.
    origin, destination : (connections,) int32
        Numbers of bodies.
    departure, arrival : (connections,) float64
        Times since the epoch; the arrival is the end of the approach [s].
    delta_v : (connections,) float64
        [m/s].
    revolutions : (connections,) int8
        Phasing revolutions; −1 for a transfer that drifts, 0 for one that is given.
    family : (connections,) int8
        Number of the family of legs that each is of, in the order of :func:`.leg_kinds`.
    """

    names: tuple[str, ...]
    origin: npt.NDArray[np.int32]
    destination: npt.NDArray[np.int32]
    departure: FloatArray
    arrival: FloatArray
    delta_v: FloatArray
    revolutions: npt.NDArray[np.int8]
    family: npt.NDArray[np.int8]

    def __len__(self) -> int:
        """Number of connections."""
        return int(self.departure.size)

    def columns(self) -> dict[str, npt.NDArray[Any]]:
        """The arrays under the names used by :meth:`.Timetable.from_connections`.

        Returns
        -------
        dict of str to array
            ``origin``, ``destination``, ``departure_s``, ``arrival_s``, ``delta_v_m_s``,
            ``revolutions``.
        """
        return {
            "origin": self.origin,
            "destination": self.destination,
            "departure_s": self.departure,
            "arrival_s": self.arrival,
            "delta_v_m_s": self.delta_v,
            "revolutions": self.revolutions,
        }

    @classmethod
    def joined(cls, names: tuple[str, ...], pairs: Iterable[Pairwise]) -> AllConnections:
        """Connections of pairs, from triples (origin, destination, connections)."""
        listed = list(pairs)
        counts = [found.departure.size for _, _, found in listed]

        def column(name: str, kind: type[np.generic]) -> npt.NDArray[Any]:
            parts = [getattr(found, name) for _, _, found in listed]
            array = np.concatenate(parts) if parts else np.empty(0)
            return array.astype(kind, copy=False)

        def bodies(numbers: list[int]) -> npt.NDArray[np.int32]:
            return np.repeat(np.array(numbers, dtype=np.int32), counts)

        return cls(
            names,
            bodies([i for i, _, _ in listed]),
            bodies([j for _, j, _ in listed]),
            column("departure", np.float64),
            column("arrival", np.float64),
            column("delta_v", np.float64),
            column("revolutions", np.int8),
            column("family", np.int8),
        )


Pairwise = tuple[int, int, Connections]
"""Origin, destination, and the connections between them."""


def weights_of(choose: Choice) -> tuple[float, float]:
    """Weights of ΔV [per m/s] and of time [per s] of a choice.

    Raises
    ------
    InputError
        There is no such choice.
    """
    if choose in CHOICES:
        return CHOICES[str(choose)]
    try:
        value = float(choose)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        raise InputError(
            f"choose = {choose!r}: must be 'earliest', 'cheapest' or the value of an hour, "
            "a number of m/s ≥ 0"
        )
    return 1.0, value / HOUR_S


Pair = tuple[int, int]
"""Numbers of origin and destination."""


class ConnectionCache:
    """Least-recently-used cache of the connections of pairs, bounded in bytes.

    Beyond the bound, the least recently used connections are dropped, and computed again when
    next needed. Threads may share it.

    Parameters
    ----------
    room_bytes : float
        Memory that they may take.

    Attributes
    ----------
    room_bytes : float
    bytes : int
        Memory that they take.
    """

    def __init__(self, room_bytes: float = math.inf) -> None:
        self.room_bytes = room_bytes
        self.bytes = 0
        self._found: OrderedDict[Pair, ConnectionArrays] = OrderedDict()
        self._lock = Lock()

    def __len__(self) -> int:
        return len(self._found)

    def limit(self, room_bytes: float) -> None:
        """Change the bound on memory, and keep to it from now on; with 0, nothing is cached."""
        with self._lock:
            self.room_bytes = room_bytes
            self._shrink()

    def get(self, pair: Pair, find: Callable[[], ConnectionArrays]) -> ConnectionArrays:
        """The connections of a pair, computed by ``find`` if not cached."""
        with self._lock:
            known = self._found.get(pair)
            if known is not None:
                self._found.move_to_end(pair)
                return known
        made = find()
        with self._lock:
            if pair not in self._found:
                self._found[pair] = made
                self.bytes += _bytes_of(made)
                self._shrink()
        return made

    def _shrink(self) -> None:
        while self._found and self.bytes > self.room_bytes:
            self.bytes -= _bytes_of(self._found.popitem(last=False)[1])


def _bytes_of(found: ConnectionArrays) -> int:
    return sum(column.nbytes for column in found)
