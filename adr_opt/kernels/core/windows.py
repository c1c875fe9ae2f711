"""The window rule: when services may begin.

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

    Every body has one at least; one where none may begin has one whose ``latest`` is −inf. The
    first of each body come first, so that most need to look no further.

    Attributes
    ----------
    first : (bodies + 1,) int64
        Place of the second interval of each body, and the number of all.
    opens, latest : (intervals,) float64
        First and last time at which a service may begin, ascending at each body [s].
    """

    first: IntArray
    opens: FloatArray
    latest: FloatArray

    @property
    def _last(self) -> IntArray:
        """Place of the last interval of each body."""
        bodies = np.arange(self.first.size - 1)
        return np.where(self.first[1:] > self.first[:-1], self.first[1:] - 1, bodies)

    @property
    def opening(self) -> FloatArray:
        """Start of the first interval of each body, shape (bodies,) [s]."""
        return self.opens[: self.first.size - 1]

    @property
    def closing(self) -> FloatArray:
        """Last time at which a service of each body may begin, shape (bodies,) [s]."""
        return self.latest[self._last]

    @property
    def _by_body(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Body of each interval, and the intervals, in order of these."""
        bodies = np.arange(self.first.size - 1)
        body = np.append(bodies, np.repeat(bodies, np.diff(self.first)))
        order = np.argsort(body, kind="stable")
        return body[order], self.opens[order], self.latest[order]

    def of(self, bodies: IntArray) -> "Windows":
        """Windows of some bodies, in the given order."""
        counts = np.diff(self.first)[bodies]
        ends = np.cumsum(counts)
        rest = np.arange(int(counts.sum())) + np.repeat(self.first[bodies] - ends + counts, counts)
        places = np.append(bodies, rest)
        first = bodies.size + np.append(0, ends)
        return _read_only(first, self.opens[places], self.latest[places])

    def later(self, body: int, begin: float) -> "Windows":
        """A copy with another end of a body's last interval [s]."""
        latest = self.latest.copy()
        latest[self._last[body]] = begin
        return _read_only(self.first, self.opens, latest)

    def only(self, body: int, opens: float, latest: float) -> "Windows":
        """A copy with one interval of a body in place of all its intervals [s]."""
        found, starts, ends = self._by_body
        kept = (found != body) | np.append(True, found[1:] != found[:-1])
        starts, ends = starts.copy(), ends.copy()
        starts[found == body], ends[found == body] = opens, latest
        return windows_of(found[kept], starts[kept], ends[kept])

    def until(self, latest: npt.ArrayLike) -> "Windows":
        """A copy cut off at a latest start of services, one for all or one per body [s]."""
        body, opens, ends = self._by_body
        capped = np.broadcast_to(latest, self.first.size - 1)[body]
        return windows_of(body, opens, np.minimum(ends, capped))


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
    body, opens, latest = body[kept], opens[kept], latest[kept]
    is_first = np.diff(body, prepend=-1) > 0
    order = np.argsort(~is_first, kind="stable")
    rest = np.bincount(body[~is_first], minlength=begins.size)
    first = begins.size + np.append(0, np.cumsum(rest))
    return _read_only(first, opens[order], latest[order])


def _read_only(first: IntArray, opens: FloatArray, latest: FloatArray) -> Windows:
    made = Windows(first.astype(np.int64), opens, latest)
    for array in made:
        array.setflags(write=False)
    return made


@kernel
def _begin_among(windows, low, high, arrival):
    """Earliest start of a service within the intervals from ``low`` up to ``high``."""
    end = high
    while low < high:
        middle = (low + high) // 2
        if windows.latest[middle] < arrival:
            low = middle + 1
        else:
            high = middle
    return max(arrival, windows.opens[low]) if low < end else np.inf


@inlined
def service_begin(windows, body, arrival):
    """Earliest start of a service after an arrival; +inf if there is none [s]."""
    begin = max(arrival, windows.opens[body])
    if begin <= windows.latest[body]:
        return begin
    return _begin_among(windows, windows.first[body], windows.first[body + 1], arrival)


@inlined
def service_end(windows, body, arrival, service):
    """End of a service with a duration; +inf if it may not begin [s]."""
    return service_begin(windows, body, arrival) + service


@inlined
def opening(windows, body):
    """Start of the first interval of a body [s]."""
    return windows.opens[body]


@inlined
def last_begin(windows, body):
    """Last time at which a service may begin; −inf for none [s]."""
    after = windows.first[body + 1]
    return windows.latest[after - 1 if after > windows.first[body] else body]


@kernel
def _latest_among(windows, low, high, body, begin):
    """Latest arrival where a body has intervals from ``low`` up to ``high`` beside its first."""
    start = low
    while low < high:
        middle = (low + high) // 2
        if windows.opens[middle] <= begin:
            low = middle + 1
        else:
            high = middle
    at = low - 1 if low > start else body
    return min(begin, windows.latest[at]) if windows.opens[at] <= begin else -np.inf


@inlined
def latest_arrival(windows, body, begin):
    """Latest arrival whose service begins by a time; −inf for none [s]."""
    low, high = windows.first[body], windows.first[body + 1]
    if high > low:
        return _latest_among(windows, low, high, body, begin)
    return min(begin, windows.latest[body]) if windows.opens[body] <= begin else -np.inf


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
