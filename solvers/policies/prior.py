"""Preferences of a learned policy among the moves of one state."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.episodes import episodes as kernels
from adr_opt.mission.mission import Mission

from .decoding import Field
from .policy import load_policy


class Prior:
    """A policy queried for single states of one mission.

    Parameters
    ----------
    mission : Mission
    policy : str
        Name or file, see :func:`.load_policy`.

    Attributes
    ----------
    notes : tuple of str
        What to say of plans that it had a part in.
    """

    def __init__(self, mission: Mission, policy: str) -> None:
        learned = load_policy(policy)
        self._field = Field(mission, learned)
        self.notes = learned.notes(mission)
        self._episode = self._field.begin(1)

    def moves(
        self, body: int, time: float, left: float, since_refuel: int, visited: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.int64]:
        """Legal moves of a state as bodies, in the policy's order of preference.

        Parameters
        ----------
        body : int
            Where the chaser is.
        time, left : float
            Since when it is free [s]; ΔV left [m/s].
        since_refuel : int
            Targets serviced since it last refuelled.
        visited : (bodies,) bool
        """
        episode, targets = self._episode, self._field.targets
        episode.body[0], episode.time[0], episode.left[0] = body, time, left
        episode.since[0] = since_refuel
        episode.visited[0, : visited.size] = visited
        board = self._field.board(episode)
        if not board.legal[0]:
            return np.empty(0, dtype=np.int64)
        scores, _ = self._field.policy.judge(board.arrays, board.mask)
        actions = np.argsort(-scores[0], kind="stable")[: board.legal[0]]
        return np.array([kernels.body_of(a, targets) for a in actions], dtype=np.int64)
