"""Relaxed tours of any number of services, which are quick to evaluate: for multipliers."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.core.compile import kernel

from .memories import NearMemories
from .relaxation import NEVER, TimeSteps, level, lower


@kernel
def _fill(steps, memories, multipliers, values):
    """Fill the values of all places and steps, from the last step back; each leg takes a step."""
    places, size = values.shape[0], values.shape[2] - 1
    for step in range(steps.total, -1, -1):
        for place in range(places):
            row = values[place, step]
            for memory in range(size):
                row[memory] = steps.ends[place, step]
            row[size] = NEVER
            for j in range(multipliers.size):
                then = max(step + 1, np.int64(steps.after[place, j, step]))
                if j == place or then > steps.total:
                    continue
                source = values[j, then]
                onward, charge = memories.onward[place, j], np.int32(multipliers[j])
                lower(row, source, onward, charge)
            level(row)


@kernel
def _visits(steps, memories, multipliers, values):
    """How often the best one does each target."""
    count = np.zeros(multipliers.size, np.int64)
    place, step, memory = np.int64(multipliers.size), np.int64(0), np.int64(0)
    while True:
        value, found = values[place, step, memory], np.int64(-1)
        for j in range(multipliers.size):
            then = max(step + 1, np.int64(steps.after[place, j, step]))
            if j == place or then > steps.total:
                continue
            after = np.int64(memories.onward[place, j, memory])
            if values[j, then, after] + multipliers[j] == value:
                found = np.int64(j)
                step, memory = then, after
                break
        if found < 0:
            return count
        count[found] += 1
        place = found


def evaluated(
    steps: TimeSteps,
    memories: NearMemories,
    multipliers: npt.NDArray[np.int64],
    room: npt.NDArray[np.int32] | None = None,
) -> tuple[int, npt.NDArray[np.int64], npt.NDArray[np.int32]]:
    """Value [units] and services of the best relaxed tour, and the room, to be used again."""
    targets = multipliers.size
    shape = targets + 1, steps.total + 1, memories.onward.shape[2] + 1
    if room is None or room.shape != shape:
        room = np.empty(shape, dtype=np.int32)
    _fill(steps, memories, multipliers, room)
    least = int(room[targets, 0, 0])
    value = NEVER if least >= NEVER else least - int(multipliers.sum())
    return value, _visits(steps, memories, multipliers, room), room
