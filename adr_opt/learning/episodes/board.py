"""Observations by name, in arrays that kernels fill."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...kernels.episodes.choices import CHOICE_FIELDS, MISSION_FIELDS, new_choices
from ...kernels.episodes.episodes import Episodes, StackedFields
from ...kernels.episodes.observation import ObservationArrays, observe_choices
from ...kernels.episodes.published import observe_published
from ...kernels.episodes.worlds import Worlds

Array = npt.NDArray[np.float32]
Observation = dict[str, Array] | Array

OBSERVATIONS = ("choices", "published")
"""``choices`` has a row for every move, in known and in uncertain worlds; ``published`` is that of
the study, for comparison."""

MOVES, MISSION = "moves", "mission"


def check_observation(name: str) -> None:
    """Refuse an unknown observation.

    Raises
    ------
    InputError
        The sentence lists the known ones.
    """
    if name not in OBSERVATIONS:
        raise InputError(f"observation {name!r} is unknown; use one of: {', '.join(OBSERVATIONS)}")


def published_size(targets: int) -> int:
    """Size of the observation ``published``: visited, 2 globals, 6 elements of each body."""
    return 7 * targets + 8


def allowed(legal: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """A copy of masks for drawing actions, shape (…, actions): where none is legal, the last one.

    It is the station's. Environments that reset at the next step ignore the action of that step,
    but it is drawn, and there must be something to draw.
    """
    mask = legal.copy()
    mask[..., -1] |= ~mask.any(axis=-1)
    return mask


class Board:
    """The arrays of one observation of many episodes.

    Parameters
    ----------
    name : str
        Observation.
    count : int
        Episodes.
    targets : int

    Attributes
    ----------
    mask : (count, targets + 1) bool
        Legal actions.
    legal : (count,) int32
        Their numbers.
    choices : ObservationArrays
        Rows of all moves, of the observation ``choices``.
    order : (count,) int32
        Order in which :meth:`observe` takes the episodes; that of their numbers at first.
    """

    def __init__(self, name: str, count: int, targets: int) -> None:
        self.name = name
        self.mask = np.zeros((count, targets + 1), dtype=np.bool_)
        self.legal = np.zeros(count, dtype=np.int32)
        self.order = np.arange(count, dtype=np.int32)
        if name == "published":
            self._flat = np.zeros((count, published_size(targets)), dtype=np.float32)
        else:
            moves, mission = len(CHOICE_FIELDS), len(MISSION_FIELDS)
            self.choices = ObservationArrays(
                np.zeros((count, targets + 1, moves), dtype=np.float32),
                np.zeros((count, mission), dtype=np.float32),
                self.mask,
                self.legal,
            )

    def observe(
        self,
        pool: StackedFields,
        episodes: Episodes,
        first: int,
        last: int,
        worlds: Worlds | None = None,
    ) -> None:
        """Write mask and observation of the episodes ``order[first:last]``.

        ``worlds`` are theirs where they are uncertain.
        """
        self._observe(pool, episodes, self.order, (first, last), worlds)

    def observe_these(
        self,
        pool: StackedFields,
        episodes: Episodes,
        which: npt.NDArray[np.int32],
        worlds: Worlds | None = None,
    ) -> None:
        """Write mask and observation of some episodes."""
        self._observe(pool, episodes, which, (0, which.size), worlds)

    def _observe(
        self,
        pool: StackedFields,
        episodes: Episodes,
        order: npt.NDArray[np.int32],
        part: tuple[int, int],
        worlds: Worlds | None,
    ) -> None:
        first, last = part
        if self.name == "published":
            observe_published(pool, episodes, order, first, last, self._flat, self.mask, self.legal)
            return
        scratch = new_choices(self.mask.shape[1])
        observe_choices(pool, episodes, order, first, last, self.choices, worlds, scratch)

    @property
    def arrays(self) -> Observation:
        """The arrays themselves, in the structure of the space."""
        if self.name == "published":
            return self._flat
        return {MISSION: self.choices.mission, MOVES: self.choices.moves}

    def copy(self, index: int | npt.NDArray[np.int32] | None = None) -> Observation:
        """A copy of all observations, or of those of one or of some episodes."""
        arrays = self.arrays
        if isinstance(arrays, dict):
            return {
                name: array.copy() if index is None else np.array(array[index])
                for name, array in arrays.items()
            }
        return arrays.copy() if index is None else np.array(arrays[index])
