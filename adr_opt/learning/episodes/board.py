"""Observations by name, in arrays that kernels fill."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...kernels.episodes import lookahead, world_view
from ...kernels.episodes import observation as kernels
from ...kernels.episodes.episodes import Episodes, StackedFields
from ...kernels.episodes.published import observe_published
from ...kernels.episodes.worlds import Worlds

Array = npt.NDArray[np.float32]
Observation = dict[str, Array] | Array

OBSERVATIONS = (
    "transfer",
    "lookahead",
    "published",
    "transfer-prizes",
    "lookahead-prizes",
    "transfer-worlds",
)
"""``transfer`` is the fastest, ``lookahead`` has more information and takes longer, ``published``
is for comparison with the study. These hide prizes; the next two show them, and are otherwise the
first two. ``transfer-worlds`` is ``transfer-prizes`` with what uncertain worlds may make of a
move."""

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


def move_fields(name: str) -> tuple[str, ...]:
    """Field names of a move in an observation by moves."""
    if not sees_prizes(name):
        return kernels.MOVE_FIELDS + (lookahead.CHAIN_FIELDS if follows_chains(name) else ())
    more = lookahead.CHAIN_PRIZE_FIELDS if follows_chains(name) else ()
    if sees_worlds(name):
        more = world_view.WORLD_FIELDS
    return (*kernels.MOVE_FIELDS, kernels.PRIZE_FIELD, *more)


def sees_prizes(name: str) -> bool:
    """Whether an observation shows the prize of each target."""
    return name.endswith(("-prizes", "-worlds"))


def sees_worlds(name: str) -> bool:
    """Whether an observation shows what uncertain worlds may make of each move."""
    return name.endswith("-worlds")


def follows_chains(name: str) -> bool:
    """Whether an observation looks ahead along chains of moves."""
    return name.startswith("lookahead")


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
    order : (count,) int32
        Order in which :meth:`observe` takes the episodes; that of their numbers at first.
    promises : Promises or None
        What chains promise, where the observation follows them; no part of it.
    """

    def __init__(self, name: str, count: int, targets: int) -> None:
        self.name = name
        self.mask = np.zeros((count, targets + 1), dtype=np.bool_)
        self.legal = np.zeros(count, dtype=np.int32)
        self.order = np.arange(count, dtype=np.int32)
        self.promises: lookahead.Promises | None = None
        if follows_chains(name):
            self.promises = lookahead.Promises(*np.zeros((3, count, targets + 1)))
        if name == "published":
            self._flat = np.zeros((count, published_size(targets)), dtype=np.float32)
        else:
            moves, mission = len(move_fields(name)), len(kernels.MISSION_FIELDS)
            self._moves = np.zeros((count, targets + 1, moves), dtype=np.float32)
            self._mission = np.zeros((count, mission), dtype=np.float32)
            self._into = kernels.ObservationArrays(
                self._moves, self._mission, self.mask, self.legal
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
        prized, into = sees_prizes(self.name), self._into
        if sees_worlds(self.name):
            world_view.observe_worlds(pool, episodes, order, first, last, into, worlds)
        elif self.promises is None:
            kernels.observe_transfer(pool, episodes, order, first, last, into, prized)
        else:
            lookahead.observe_lookahead(
                pool, episodes, order, first, last, into, prized, self.promises
            )

    @property
    def arrays(self) -> Observation:
        """The arrays themselves, in the structure of the space."""
        if self.name == "published":
            return self._flat
        return {MISSION: self._mission, MOVES: self._moves}

    def copy(self, index: int | npt.NDArray[np.int32] | None = None) -> Observation:
        """A copy of all observations, or of those of one or of some episodes."""
        arrays = self.arrays
        if isinstance(arrays, dict):
            return {
                name: array.copy() if index is None else np.array(array[index])
                for name, array in arrays.items()
            }
        return arrays.copy() if index is None else np.array(arrays[index])
