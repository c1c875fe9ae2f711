"""Start and end of a service: the rule of windows, stated once.

A chaser that arrives early waits until the window opens. Whether the service ends in time is left
to the caller. :mod:`adr_opt.judge` states the rule again, on purpose.
"""

import numpy as np
import numpy.typing as npt

from .compile import inlined


@inlined
def service_begin(arrival, opens):
    """Start of a service that only its window delays [s]."""
    return max(arrival, opens)


@inlined
def service_end(arrival, opens, service):
    """End of a service with a duration [s]."""
    return max(arrival, opens) + service


def service_ends(
    arrivals: npt.ArrayLike, opens: npt.ArrayLike, service: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Ends of services, by arrival.

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
