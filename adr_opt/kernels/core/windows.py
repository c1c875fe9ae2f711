"""When a service begins and ends: the rule of windows, stated once.

A chaser that arrives early waits until the window opens. Whether the service ends in time is for
who asks to say. :mod:`adr_opt.judge` states the rule again, on purpose.
"""

import numpy as np
import numpy.typing as npt

from .compile import inlined


@inlined
def service_begin(arrival, opens):
    """When a service begins that nothing delays but its window [s]."""
    return max(arrival, opens)


@inlined
def service_end(arrival, opens, service):
    """When a service ends that takes some time [s]."""
    return max(arrival, opens) + service


def service_ends(
    arrivals: npt.ArrayLike, opens: npt.ArrayLike, service: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """When services end, by arrival.

    Parameters
    ----------
    arrivals : float or (services,) float64
        [s].
    opens, service : float or (services,) float64
        When the windows open, and how long the services take [s].

    Returns
    -------
    (services,) float64
        [s].
    """
    return np.asarray(np.add(np.maximum(arrivals, opens), service), dtype=np.float64)
