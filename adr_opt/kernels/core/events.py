"""Departure events by number, and the one taken by a chaser that is ready at a time."""

import math

from ...common.constants import SLACK_S
from .compile import inlined


@inlined
def earliest_taken(ready):
    """Earliest departure taken by a chaser that is ready at a time: a slack before it."""
    return ready - SLACK_S


@inlined
def first_counted(first, spacing, earliest):
    """Number of the first of equidistant events that is no earlier than a time."""
    m = max(0, math.ceil((earliest - first) / spacing))
    # The quotient may be rounded across an integer; the event's own time decides.
    if m > 0 and first + (m - 1) * spacing >= earliest:
        m -= 1
    elif first + m * spacing < earliest:
        m += 1
    return m


@inlined
def counted_event(first, spacing, total, earliest):
    """Number of the first of a finite series of events; ``total`` if none is left."""
    return min(first_counted(first, spacing, earliest), total)
