"""Pending labels, by the row at which they will be ready, sixteen to a block.

Where departures lie on a grid, hundreds of labels land in one row. A new one is compared with all
of them before it is made, so each row has a chain of blocks with the same integers side by side as
:mod:`.waiting` keeps. A block is given back as soon as its labels have arrived.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel

from ..networks.simd import LANES
from .waiting import NOBODY, dominates, fill_lane, lanes_that_may

FREE, USED = 0, 1


class Pending(NamedTuple):
    """The pending labels.

    Attributes
    ----------
    first : (rows,) int32
        First block of each row, −1 for none. Only this one has empty lanes.
    following : (blocks,) int32
        Next block of the row, or next one that is free; −1 for none.
    size : (blocks,) int32
        Labels in the block.
    label : (blocks·lanes,) int32
    keys : (blocks·(2 + 2·words)·lanes,) int32
        Of each block ΔV left, value, and two parts of each word of memory.
    cursor : (2,) int64
        The first free block that was given back, −1 for none, and how many were ever used.
    """

    first: np.ndarray
    following: np.ndarray
    size: np.ndarray
    label: np.ndarray
    keys: np.ndarray
    cursor: np.ndarray


def pending_room(rows: int, words: int, blocks: int) -> Pending:
    """Empty storage for pending labels."""
    return Pending(
        np.full(rows, -1, dtype=np.int32),
        np.empty(blocks, dtype=np.int32),
        np.zeros(blocks, dtype=np.int32),
        np.empty(blocks * LANES, dtype=np.int32),
        np.full(blocks * (2 + 2 * words) * LANES, NOBODY, dtype=np.int32),
        np.array([-1, 0], dtype=np.int64),
    )


def more_room(pending: Pending, words: int) -> Pending:
    """The same labels in twice the storage."""
    blocks = pending.size.size
    twice = pending_room(pending.first.size, words, 2 * blocks)
    for new, old in zip(twice, pending, strict=True):
        new[: old.size] = old
    return twice


@kernel
def is_preceded(pending, row, labels, candidate, memory, compared, terms):
    """Whether a pending label at a row dominates a candidate there."""
    left, value = candidate.resources.left, candidate.value
    block = pending.first[row]
    while block >= 0:
        base = block * (2 + 2 * memory.size) * LANES
        hits = lanes_that_may(pending.keys, base, LANES, left, value, memory, compared)
        lane = 0
        while hits >> lane:
            if hits >> lane & 1 and dominates(
                labels, pending.label[block * LANES + lane], candidate, memory, compared, terms
            ):
                return True
            lane += 1
        block = pending.following[block]
    return False


@kernel
def send(pending, row, labels, label):
    """Add a pending label at a row; False if storage is full."""
    block = pending.first[row]
    if block < 0 or pending.size[block] == LANES:
        if pending.cursor[FREE] >= 0:
            new = pending.cursor[FREE]
            pending.cursor[FREE] = pending.following[new]
        elif pending.cursor[USED] < pending.size.size:
            new = pending.cursor[USED]
            pending.cursor[USED] += 1
        else:
            return False
        pending.following[new] = block
        pending.first[row] = new
        block = new
    lane = pending.size[block]
    pending.label[block * LANES + lane] = label
    base = block * (2 + 2 * labels.memory.shape[1]) * LANES + lane
    fill_lane(pending.keys, base, LANES, labels, label)
    pending.size[block] = lane + 1
    return True


@inlined
def next_of(pending, row):
    """The next pending label at a row; −1 if there is none."""
    block = pending.first[row]
    return -1 if block < 0 else pending.label[block * LANES + pending.size[block] - 1]


@inlined
def take(pending, row, words):
    """Remove the next pending label at a row."""
    block = pending.first[row]
    lane = pending.size[block] - 1
    pending.size[block] = lane
    pending.keys[block * (2 + 2 * words) * LANES + lane] = NOBODY
    if lane == 0:
        pending.first[row] = pending.following[block]
        pending.following[block] = pending.cursor[FREE]
        pending.cursor[FREE] = block
