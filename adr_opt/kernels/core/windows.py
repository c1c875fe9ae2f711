"""When services may begin: the rule of windows, stated once.

A service begins at the first time from arrival on from which its capture fits into one interval, so
that a chaser that arrives too late for one waits for the next. Its end never falls as arrival
rises. :mod:`adr_opt.judge` states the rule again, on purpose.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .compile import inlined, kernel

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class Windows(NamedTuple):
    """Intervals in which services may begin, with the slack of the model.

    Every body has one at least; one where none may begin has one whose ``latest`` is −inf.

    Attributes
    ----------
    first : (bodies + 1,) int64
        Place of the first interval of each body, and of all that are there.
    opens, latest : (intervals,) float64
        First and last time at which a service may begin, ascending at each body [s].
    """

    first: IntArray
    opens: FloatArray
    latest: FloatArray

    @property
    def opening(self) -> FloatArray:
        """Start of the first interval of each body, shape (bodies,) [s]."""
        return self.opens[self.first[:-1]]

    @property
    def closing(self) -> FloatArray:
        """Last time at which a service of each body may begin, shape (bodies,) [s]."""
        return self.latest[self.first[1:] - 1]

    @property
    def bodies(self) -> IntArray:
        """Body of each interval, shape (intervals,)."""
        return np.repeat(np.arange(self.first.size - 1), np.diff(self.first))

    def of(self, bodies: IntArray) -> "Windows":
        """Those of some bodies, in their order."""
        counts = np.diff(self.first)[bodies]
        places = np.repeat(self.first[bodies] + counts - np.cumsum(counts), counts)
        places += np.arange(places.size)
        first = np.append(0, np.cumsum(counts))
        return Windows(first, self.opens[places], self.latest[places])

    def later(self, body: int, begin: float) -> "Windows":
        """The same with another end of the last interval of a body [s]."""
        latest = self.latest.copy()
        latest[self.first[body + 1] - 1] = begin
        latest.setflags(write=False)
        return self._replace(latest=latest)

    def only(self, body: int, opens: float, latest: float) -> "Windows":
        """The same with one interval of a body in place of all of its [s]."""
        low, high = self.first[body], self.first[body + 1]
        first = self.first - np.where(np.arange(self.first.size) > body, high - low - 1, 0)
        return Windows(
            first,
            np.concatenate([self.opens[:low], [opens], self.opens[high:]]),
            np.concatenate([self.latest[:low], [latest], self.latest[high:]]),
        )

    def until(self, latest: npt.ArrayLike) -> "Windows":
        """The same as far as services begin by a time, one for all or of each body [s]."""
        size = self.first.size - 1
        capped = np.minimum(self.latest, np.broadcast_to(latest, size)[self.bodies])
        return windows_of(self.bodies, self.opens, capped)


def windows_of(body: IntArray, opens: FloatArray, latest: FloatArray) -> Windows:
    """Windows from intervals, read-only; those that end before they begin are dropped.

    Parameters
    ----------
    body : (intervals,) int64
        Whose they are, ascending; every body has one.
    opens, latest : (intervals,) float64
        [s].
    """
    begins = np.flatnonzero(np.diff(body, prepend=-1))
    kept = opens <= latest
    none = begins[~np.logical_or.reduceat(kept, begins)]
    kept[none], latest = True, latest.copy()
    latest[none] = -np.inf
    first = np.append(np.cumsum(kept)[begins] - kept[begins], kept.sum())
    made = Windows(first.astype(np.int64), opens[kept], latest[kept])
    for array in made:
        array.setflags(write=False)
    return made


@kernel
def _begin_among(windows, low, high, arrival):
    """The same among the intervals from ``low`` up to ``high``."""
    end = high
    while low < high:
        middle = (low + high) // 2
        if windows.latest[middle] < arrival:
            low = middle + 1
        else:
            high = middle
    if low == end:
        return np.inf
    begin = max(arrival, windows.opens[low])
    return begin if begin <= windows.latest[low] else np.inf


@inlined
def service_begin(windows, body, arrival):
    """Earliest start of a service after an arrival; +inf if there is none [s]."""
    low, high = windows.first[body], windows.first[body + 1]
    if high - low > 1:
        return _begin_among(windows, low, high, arrival)
    begin = max(arrival, windows.opens[low])
    return begin if begin <= windows.latest[low] else np.inf


@inlined
def service_end(windows, body, arrival, service):
    """End of a service with a duration; +inf if it may not begin [s]."""
    return service_begin(windows, body, arrival) + service


@inlined
def opening(windows, body):
    """Start of the first interval of a body [s]."""
    return windows.opens[windows.first[body]]


@inlined
def last_begin(windows, body):
    """Last time at which a service may begin; −inf for none [s]."""
    return windows.latest[windows.first[body + 1] - 1]


@kernel
def latest_arrival(windows, body, begin):
    """Latest arrival whose service begins by a time; −inf for none [s]."""
    low, high = windows.first[body], windows.first[body + 1]
    start = low
    while low < high:
        middle = (low + high) // 2
        if windows.opens[middle] <= begin:
            low = middle + 1
        else:
            high = middle
    return min(begin, windows.latest[low - 1]) if low > start else -np.inf


@kernel
def _ends(windows, bodies, arrivals, services, ends):
    """Fill in :func:`service_end` of each."""
    for at in range(arrivals.size):
        ends[at] = service_end(windows, bodies[at], arrivals[at], services[at])


def service_ends(
    windows: Windows, bodies: npt.ArrayLike, arrivals: npt.ArrayLike, service: npt.ArrayLike = 0.0
) -> FloatArray:
    """Ends of services, by arrival.

    Parameters
    ----------
    windows : Windows
    bodies : int or (services,) int
    arrivals, service : float or (services,) float64
        Arrivals, and how long the services take [s].

    Returns
    -------
    (services,) float64
        +inf where a service may not begin [s].
    """
    arrays = np.broadcast_arrays(
        np.asarray(bodies, dtype=np.int64),
        np.asarray(arrivals, dtype=np.float64),
        np.asarray(service, dtype=np.float64),
    )
    ends = np.empty(arrays[0].size)
    _ends(windows, *(array.flatten() for array in arrays), ends)
    return ends.reshape(arrays[0].shape)
