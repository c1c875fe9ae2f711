"""The timetable of an instance: exact ΔV and duration of every transfer at every time."""

from __future__ import annotations

import math
import operator
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from copy import copy
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.card import Shown
from ..common.errors import InputError
from ..common.processors import usable_cores
from ..kernels.tables import timetable as kernels
from ..kernels.tables import timetable_making as making
from ..kernels.tables.on_demand import Source
from ..kernels.tables.timetable_making import Pairs
from ..problem.given import Costs, of_function, of_matrices, of_rows
from ..problem.instance import AnyInstance, Instance
from ..problem.rules import JUDGED, Follower
from ..problem.support import followed
from .connection_finder import ConnectionFinder, estimate
from .connections import CHOICES, AllConnections, Choice, Connections, Pairwise, weights_of
from .corrections import NO_CORRECTIONS
from .matrices import FloatArray, Matrices
from .nearest_pairs import Neighbours, begun, connected_pairs
from .service_limits import limits_of
from .timetable_size import too_large

SLICE_ENTRIES = 20_000
"""Number of entries computed at once: about 20 ms, after which a build can be interrupted."""

SLICE_SAMPLES = 1_000_000
"""Number of matrix entries looked up at once, after which an interrupt is noticed."""


FOLLOWS = Follower("a timetable", JUDGED)


class Timetable(Shown):
    """The transfers of an instance: the one chosen at each time, and all connections of a pair.

    A chaser that is ready at a time and does not look ahead chooses among all connections that
    depart then or later (docs/model.md section 4); the table holds the choice for one value of
    time, exactly.

    Parameters
    ----------
    instance : Instance, path or dict
    threads : int, optional
        Threads to build with; all cores by default. The table does not depend on it.
    pairs : Pairs, optional
        Pairs to build, in this order; all by default.
    most : int, optional
        Maximum number of these pairs, from the first on.
    enough : callable, optional
        Called every few tens of milliseconds with the share of all pairs that is built. Once it
        returns True, the table keeps the pairs built so far.
    time_value_m_s_per_h : float, optional
        Value of an hour: of all connections that depart at a time or later, the table holds the one
        with the least ΔV + value · (arrival − ready); by default the instance's [m/s per h].
    connecting : ConnectionFinder, optional
        Finder of the instance's connections, if one exists already; its cached connections are
        reused.
    chaser : int, optional
        Number of the chaser whose availability limits the choice of transfers. By default the
        availability of any chaser does.
    examined : Neighbours, optional
        Nothing is built: chosen connections are computed on demand (:attr:`is_on_demand`), and
        these are the pairs that searches examine. Only if
        :attr:`~.connection_finder.ConnectionFinder.may_be_on_demand` says so.

    Attributes
    ----------
    instance : Instance
    pairs : Pairs
    built : int
        Number of pairs built, from the first on.
    table : adr_opt.kernels.tables.timetable.Table
        The read-only arrays, for kernels.
    limits : adr_opt.kernels.tables.timetable_making.ServiceLimits
        Times at the bodies.
    names : tuple of str
        Bodies, the stations first.

    Raises
    ------
    InputError
        There is not enough memory, or the time value is not a number ≥ 0.
    """

    def __init__(  # noqa: PLR0913
        self,
        instance: AnyInstance,
        threads: int | None = None,
        *,
        pairs: Pairs | None = None,
        most: int | None = None,
        enough: Callable[[float], bool] = lambda share: False,
        time_value_m_s_per_h: float | None = None,
        connecting: ConnectionFinder | None = None,
        chaser: int | None = None,
        examined: Neighbours | None = None,
    ) -> None:
        instance = followed(instance, FOLLOWS)
        if time_value_m_s_per_h is None:
            time_value_m_s_per_h = instance.time_value_m_s_per_h
        if not (math.isfinite(time_value_m_s_per_h) and time_value_m_s_per_h >= 0.0):
            raise InputError(
                f"time_value_m_s_per_h = {time_value_m_s_per_h!r}: must be a finite number ≥ 0"
            )
        corrections = NO_CORRECTIONS if connecting is None else connecting.corrections
        size = estimate(instance)
        if examined is not None:
            pairs = Pairs(np.arange(size.bodies), np.empty((size.bodies, 0), dtype=np.int32))
        if pairs is None:
            if not size.fits:
                raise InputError(too_large(instance, size))
            pairs = connected_pairs(instance, size.near)
        chosen, wanted = pairs, size.pairs
        limits = limits_of(instance, chaser, corrections)
        most = chosen.near.size if most is None else min(most, chosen.near.size)
        threads = threads or usable_cores()

        def so_far(filled: int) -> bool:
            return enough(filled / max(1, wanted))

        if connecting is None or connecting.instance is not instance:
            connecting = ConnectionFinder(instance, corrections, chaser or 0)
        if examined is not None:
            assert connecting.may_be_on_demand
            built = 0
            rule = instance.transfer_rule(time_value_m_s_per_h)
            interval = instance.transfer.departure_spacing_s
            # Searches alone look at it: when bodies are left, lists say.
            in_sight = limits.windows.until(connecting.ends.altitudes.arrive_by)
            source = Source(
                *connecting.inputs[:3],
                rule,
                limits._replace(windows=in_sight),
                *examined,
                connecting.is_listed,
                interval,
                math.inf if connecting.times is None else connecting.times.most,
            )
            table = making.without_entries(size.bodies, source)
            making.space(source.arriving, table)
        elif not connecting.is_listed:
            table = making.allocate(size.bodies, size.events, making.slots_of(chosen))
            given = (*connecting.inputs[:3], instance.transfer_rule(time_value_m_s_per_h))
            making.space(given[0], table)
            built = _in_slices(
                lambda first, last: making.fill(first, last, chosen, given, limits, table),
                most,
                max(1, SLICE_ENTRIES // size.events),
                threads,
                so_far,
            )
        else:
            chooser = connecting
            if not len(chooser.kept):  # else there was room, and it is taken by now
                chooser.kept.limit(min(size.room_bytes, chooser.kept.room_bytes))
            built = _in_slices(
                lambda first, last: chooser.choose_pairs(
                    chosen, first, last, limits, time_value_m_s_per_h
                ),
                most,
                max(1, int(SLICE_ENTRIES / max(size.listed, size.events))),
                threads,
                so_far,
            )
            pairs = chosen = begun(chosen, built)
            table = chooser.table(making.slots_of(chosen))
        for array in table[:-1]:
            array.setflags(write=False)
        self.connecting = connecting
        self.instance = instance
        self.pairs = pairs
        self.built = built
        self._wanted = wanted
        self.names = instance.names
        self.table = table
        self.limits = limits
        self.time_value_m_s_per_h = time_value_m_s_per_h

    def of_variant(self, instance: Instance, connecting: ConnectionFinder) -> Timetable:
        """The same timetable for a variant of its instance, without recomputation.

        Parameters
        ----------
        instance : Instance
            With other prizes, other tanks or fewer targets, if that changes no connection: see
            :func:`adr_opt.run.reused_timetable.serves`.
        connecting : ConnectionFinder
            Of that instance.

        Raises
        ------
        ValueError
            This is the timetable of some pairs only.
        """
        if not self.is_whole:
            raise ValueError("a timetable of some pairs cannot serve a variant; build all pairs")
        made = copy(self)
        bodies = np.array(self.connecting.numbers_of(instance), dtype=np.int64)
        connecting.counted_as(self.connecting)
        made.connecting = connecting
        made.table, made.limits = making.part_of(self.table, self.limits, bodies)
        for array in (*made.table[:-1], made.limits.service):
            array.setflags(write=False)
        made.instance, made.names = instance, instance.names
        size = estimate(instance)
        made.pairs, made.built, made._wanted = (
            connected_pairs(instance, size.near),
            size.pairs,
            size.pairs,
        )
        return made

    @classmethod
    def from_connections(
        cls, instance: Instance, connections: Any, *, file: str | None = None
    ) -> Timetable:
        """A timetable from given connections in rows.

        Its :attr:`instance` holds them, and can be planned, checked and saved.

        Parameters
        ----------
        instance : Instance
            Bodies, chasers and limits; connections are given in place of the model's.
        connections : mapping of str to array
            A dictionary of arrays, or a table of another library, with the columns ``origin`` and
            ``destination`` (names or numbers of bodies), ``departure_s`` and ``arrival_s`` (since
            the epoch) and ``delta_v_m_s`` (the cost, in m/s by convention); a row for each.
        file : str, optional
            Name of their file, which ``instance.save`` writes beside its own; by default as the
            instance says, or "connections.parquet".

        Raises
        ------
        InputError
            An unknown body, a column that is missing, or a number that is not finite, is negative,
            or leads back in time.
        """
        return cls(instance.with_given(of_rows(connections, instance.names), file))

    @classmethod
    def from_matrices(
        cls,
        instance: Instance,
        departures: Sequence[float] | FloatArray,
        duration: npt.ArrayLike,
        cost: npt.ArrayLike,
        *,
        file: str | None = None,
    ) -> Timetable:
        """A timetable from given connections as matrices by departure.

        A chaser ready between two departures waits for the next one.

        Parameters
        ----------
        instance, file
            As :meth:`from_connections` takes them.
        departures : (departures,) float
            Times since the epoch, each later than the previous one [s].
        duration, cost : (departures, bodies, bodies) float
            Durations [s] and costs [m/s by convention] by departure, origin and destination; +inf,
            or NaN in both, where there is no connection.

        Raises
        ------
        InputError
            As for :meth:`from_connections`, or departures that are not in order.
        """
        given = of_matrices(departures, duration, cost, instance.names)
        return cls(instance.with_given(given, file))

    @classmethod
    def from_function(
        cls,
        instance: Instance,
        f: Costs,
        departures: Sequence[float] | FloatArray,
        *,
        resolution_m_s: float = 0.0,
        file: str | None = None,
    ) -> Timetable:
        """A timetable from given connections as a function.

        Parameters
        ----------
        instance, file
            As :meth:`from_connections` takes them.
        f : callable
            ``f(origin, destinations, departure)`` gives how long it takes [s] from a body to each
            of some others, numbers of bodies in an array, and what it costs [m/s by convention]:
            two arrays, (destinations,) or (choices, destinations); +inf for no connection. Python,
            or compiled by Numba.
        departures : (departures,) float
            Times at which it is evaluated, each later than the previous one [s].
        resolution_m_s : float
            Connections are dropped that save no more than this against another one that departs no
            earlier and arrives no later.

        Raises
        ------
        InputError
            As for :meth:`from_matrices`.
        """
        given = of_function(f, departures, instance.names, resolution_m_s)
        return cls(instance.with_given(given, file))

    @property
    def is_whole(self) -> bool:
        """Whether the table holds all pairs that may have connections."""
        return self.built == self._wanted

    @property
    def is_on_demand(self) -> bool:
        """Whether the table is empty and chosen connections are computed on demand."""
        return kernels.source_of(self.table) is not None

    def holds(self, origin: int, destination: int) -> bool:
        """Whether the table holds a pair."""
        source = kernels.source_of(self.table)
        if source is not None:
            return bool((source.near[:, origin] == destination).any())
        return self.is_whole or bool(kernels.events(self.table, origin, destination) > 0)

    @property
    def entries(self) -> int:
        """Number of (pair, departure event) entries."""
        return kernels.count_entries(self.table)

    @property
    def most_events(self) -> int:
        """Maximum number of departure events per pair in the table."""
        return kernels.most_events(self.table)

    def index(self, body: int | str) -> int:
        """Index of a body given by index or name.

        Raises
        ------
        InputError
            There is no such body.
        """
        if isinstance(body, str):
            try:
                return self.names.index(body)
            except ValueError:
                raise InputError(f"body {body!r} is not in {self.instance.name!r}") from None
        try:
            index = operator.index(body)
        except TypeError:
            index = -1
        if not 0 <= index < len(self.names):
            raise InputError(
                f"body {body!r} is not in {self.instance.name!r}; give a name, or a whole number "
                f"from 0 to {len(self.names) - 1}"
            )
        return index

    def lookup(
        self, origin: int | str, destination: int | str, time_s: float
    ) -> tuple[float, float]:
        """The transfer chosen for a chaser that is ready at ``origin`` at ``time_s``.

        Among all connections that depart then or later, while a chaser is available, and leave time
        for service within the window of the destination, it has the least ΔV + time value · (time
        until service may begin).

        Returns
        -------
        delta_v, arrival : float
            [m/s], [s]; both +inf where there is no transfer, or the table does not hold the pair.

        Raises
        ------
        InputError
            An unknown body, or a time that is negative or not finite.
        """
        _check_number("time_s", time_s)
        i, j = self.index(origin), self.index(destination)
        self.connecting.refuse_function(i, j)
        delta_v, arrival = kernels.lookup(self.table, i, j, float(time_s))
        return float(delta_v) - self.connecting.spent_m_s(i), float(arrival)

    def connections(
        self,
        origin: int | str,
        destination: int | str,
        after: float = 0.0,
        *,
        resolution_m_s: float | None = None,
    ) -> Connections:
        """Every transfer of a pair that may be worth waiting for.

        Unlike :meth:`lookup`, which returns the one chosen by a time value, these are *all*
        sequences of all departure events, except dominated ones: another departs no earlier,
        arrives no later and costs no more (:mod:`adr_opt.kernels.legs.connections`). They arrive
        before the end of the mission; windows are ignored. Computed for this pair on every call.

        Parameters
        ----------
        origin, destination : int or str
            Bodies by index or name.
        after : float
            Only departures at or after this time since the epoch [s].
        resolution_m_s : float, optional
            A connection that saves no more than this counts as dominated; the instance's
            ``delta_v_resolution_m_s`` by default, 0 for all that save anything [m/s].

        Raises
        ------
        InputError
            An unknown body, or a number that is negative or not finite.
        """
        if resolution_m_s is None:
            resolution_m_s = self.instance.transfer.delta_v_resolution_m_s
        for name, value in (("after", after), ("resolution_m_s", resolution_m_s)):
            _check_number(name, value)
        i, j = self.index(origin), self.index(destination)
        found = self.connecting.of_pair(i, j, float(resolution_m_s)).after(after)
        spent = self.connecting.spent_m_s(i)
        return replace(found, delta_v=found.delta_v - spent) if spent else found

    def all_connections(
        self, after: float = 0.0, *, resolution_m_s: float | None = None
    ) -> AllConnections:
        """The :meth:`connections` of all pairs of bodies, in arrays.

        Computed on every call, in threads. For 50 targets over a week there are five million, of 34
        bytes each.

        Parameters
        ----------
        after, resolution_m_s
            As :meth:`connections` takes them.

        Returns
        -------
        AllConnections
            ``origin``, ``destination``, ``departure``, ``arrival``, ``delta_v``, ``revolutions``,
            ``family``: shape (connections,) each.

        Raises
        ------
        InputError
            A number is negative or not finite.
        """
        bodies = range(len(self.names))

        def of_origin(i: int) -> list[Pairwise]:
            return [
                (i, j, self.connections(i, j, after, resolution_m_s=resolution_m_s))
                for j in bodies
                if j != i
            ]

        self.connections(0, 0, after, resolution_m_s=resolution_m_s)  # refuses what is wrong
        with ThreadPoolExecutor(usable_cores()) as pool:
            return AllConnections.joined(
                self.names, chain.from_iterable(pool.map(of_origin, bodies))
            )

    def matrices(
        self, departures: Sequence[float] | FloatArray, choose: Choice | None = None
    ) -> Matrices:
        """Sample ΔV and duration at ready times.

        Parameters
        ----------
        departures : sequence of float
            Times since the epoch at which the chaser is ready [s].
        choose : {"earliest", "cheapest"} or float, optional
            Choose one of all :meth:`connections` that depart at the ready time or later: the one
            that arrives first, the one that costs least, or the one with the least ΔV plus this m/s
            per hour until arrival. Windows are ignored. By default the choice of :meth:`lookup`,
            which respects them. Waiting is part of the duration.

        Raises
        ------
        InputError
            A time is negative or not finite, or there is no such choice.
        """
        times = np.atleast_1d(np.asarray(departures, dtype=float))
        if times.ndim != 1 or not np.all(np.isfinite(times) & (times >= 0.0)):
            raise InputError("departures must be a list of finite times ≥ 0 in seconds")
        size = len(self.names)
        delta_v = np.empty((times.size, size, size))
        duration = np.empty_like(delta_v)
        for i in range(size if self.connecting.has_functions else 0):
            for j in range(size):
                self.connecting.refuse_function(i, j)
        if choose is None:
            step = max(1, SLICE_SAMPLES // size**2)
            for begin in range(0, times.size, step):
                part = slice(begin, begin + step)
                kernels.sample(self.table, times[part], delta_v[part], duration[part])
            self._without_spent(delta_v)
            words = f"{_words(self.time_value_m_s_per_h)}, service in time"
            return Matrices(times, self.names, delta_v, duration, words)
        weights = weights_of(choose)
        self.connecting.choose(times, *weights, delta_v, duration)
        self._without_spent(delta_v)
        return Matrices(times, self.names, delta_v, duration, _words(choose))

    def _without_spent(self, delta_v: FloatArray) -> None:
        """Subtract ΔV spent before the start from costs, by origin."""
        for i in range(len(self.names)):
            others = np.arange(len(self.names)) != i
            delta_v[:, i, others] -= self.connecting.spent_m_s(i)


def _words(choose: Choice) -> str:
    """The choice of transfers in words, as stated in files."""
    words = choose if choose in CHOICES else f"least ΔV + {float(choose):g} m/s per hour"
    return f"{words}, waiting allowed"


def _in_slices(
    fill: Callable[[int, int], None],
    pairs: int,
    step: int,
    threads: int,
    enough: Callable[[int], bool],
) -> int:
    """Fill pairs in slices, in threads; returns the number filled, from the first on."""
    if pairs == 0:
        return 0
    fill(0, 1)  # compiles once, before the threads
    if 1 < pairs <= 1 + step and not enough(1):
        fill(1, pairs)  # one slice, not worth a thread
        return pairs
    begun = done = 1
    running: deque[tuple[int, Future[None]]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        while not enough(done):
            while begun < pairs and len(running) <= threads:
                last = min(begun + step, pairs)
                running.append((last, pool.submit(fill, begun, last)))
                begun = last
            if not running:
                break
            last, slice_ = running.popleft()
            slice_.result()
            done = last
        for last, slice_ in running:
            slice_.result()
            done = last
    return done


def _check_number(name: str, value: float) -> None:
    try:
        good = math.isfinite(value) and value >= 0.0
    except TypeError:
        good = False
    if not good:
        raise InputError(f"{name} = {value!r}: must be a finite number ≥ 0")
