"""What a vectorised environment tells of episodes that have ended."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...kernels.episodes.episodes import Episodes
from ...kernels.episodes.worlds import Worlds
from ..episodes import LOSS_WORDS, Observation


def last_words(
    episodes: Episodes,
    worlds: Worlds | None,
    ended: npt.NDArray[np.int32],
    seen: Observation,
    rewards: npt.NDArray[np.float32],
    targets: npt.NDArray[np.int32],
) -> list[dict[str, Any]]:
    """Information on ended episodes, as Stable-Baselines3 expects it.

    Parameters
    ----------
    episodes : Episodes
    worlds : Worlds or None
        None where everything goes as planned.
    ended : (ended,) int32
    seen : Observation
        What these saw last.
    rewards : (episodes,) float32
        Of the latest moves.
    targets : (ended,) int32
        Of their fields.
    """
    serviced = episodes.serviced[ended].tolist()
    collected = episodes.collected[ended].tolist()
    refuelled = episodes.refuelled[ended].tolist()
    illegal = (rewards[ended] < 0.0).tolist()
    delta_v = episodes.delta_v[ended].tolist()
    budget, duration = episodes.budget[ended].tolist(), episodes.duration[ended].tolist()
    fields, lost = targets.tolist(), _losses(worlds, ended)
    told = []
    for row in range(ended.size):
        last = (
            {name: part[row] for name, part in seen.items()}
            if isinstance(seen, dict)
            else seen[row]
        )
        said = {
            "terminal_observation": last,
            "TimeLimit.truncated": False,
            "episode": {
                "r": collected[row] - illegal[row],
                "l": serviced[row] + refuelled[row] + illegal[row] + sum(lost[row].values()),
                "t": 0.0,
            },
            "serviced": serviced[row],
            "collected": collected[row],
            "delta_v_m_s": delta_v[row],
            "budget_m_s": budget[row],
            "duration_s": duration[row],
            "targets": fields[row],
        }
        if worlds is not None:
            said["world"] = int(worlds.states.seed[ended[row]])
            said["model"] = int(worlds.states.model[ended[row]])
            said["losses"] = lost[row]
        told.append(said)
    return told


def _losses(worlds: Worlds | None, ended: npt.NDArray[np.int32]) -> list[dict[str, int]]:
    """Numbers of losses of episodes by reason."""
    if worlds is None:
        return [{} for _ in ended]
    return [
        {word: count for word, count in zip(LOSS_WORDS, lost, strict=True) if count}
        for lost in worlds.states.losses[ended].tolist()
    ]
