"""Hash table of labels by their set of targets and their place: open addressing, linear probing.

The table holds numbers of labels, −1 where it is empty, and has a power of two of slots, some of
them empty. Sets are multiplied by odd constants (Knuth, The Art of Computer Programming 3, 6.4).
"""

from __future__ import annotations

import numpy as np

from adr_opt.kernels.core.compile import inlined


@inlined
def slot_of(table, sets, places, done, place):
    """Slot of the label with a set and a place, or where it should be entered.

    Parameters
    ----------
    table : (slots,) int
    sets, places : (labels,) int64
        Of all labels.
    done, place : int
    """
    mask = table.size - 1
    mixed = (done + np.int64(place + 1) * 0x1E3779B97F4A7C15) * 0x5851F42D4C957F2D
    slot = (mixed ^ (mixed >> 29)) & mask
    while table[slot] >= 0 and (sets[table[slot]] != done or places[table[slot]] != place):
        slot = (slot + 1) & mask
    return slot
