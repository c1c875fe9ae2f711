"""Departure events that are counted, and which of them a chaser takes who is ready at a time."""

import math

from ...common.constants import SLACK_S
from .compile import inlined


@inlined
def earliest_taken(ready):
    """The earliest departure that a chaser takes who is ready at a time: a slack before it."""
    return ready - SLACK_S


@inlined
def first_counted(first, spacing, earliest):
    """The number of the first of events a fixed time apart that is no earlier than a time."""
    m = max(0, math.ceil((earliest - first) / spacing))
    # The quotient may be rounded across an integer; the event's own time decides.
    if m > 0 and first + (m - 1) * spacing >= earliest:
        m -= 1
    elif first + m * spacing < earliest:
        m += 1
    return m


@inlined
def counted_event(first, spacing, total, earliest):
    """The same where there are so many; ``total`` if it is none of them."""
    return min(first_counted(first, spacing, earliest), total)
