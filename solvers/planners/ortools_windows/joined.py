"""Windows of several chasers joined into one network, with a path through each.

A path that leaves the window of one chaser begins that of the next, so what is said of one path
through one network, its price, its tanks and that it visits no target twice, is said of all
chasers together.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from adr_opt.kernels.rules.rules import Rules

from .window_network import Window, WindowNetwork


class Joined(NamedTuple):
    """A network of several windows, with its constraints.

    Attributes
    ----------
    net : WindowNetwork
        Its tanks are numbered through all windows.
    roots : (windows,) int64
        Where the path of each window begins.
    tanks : (tanks,) float64
        ΔV that each holds [m/s].
    full : float
        The largest tank of a chaser, or 1 if that is less [m/s].
    open_targets : (targets,) int64
        Targets that some window may visit, ascending.
    most_targets : (windows,) int64
        Most of them in each window.
    prize : (bodies,) float64
        What each body is worth.
    first_target : int
    """

    net: WindowNetwork
    roots: npt.NDArray[np.int64]
    tanks: npt.NDArray[np.float64]
    full: float
    open_targets: npt.NDArray[np.int64]
    most_targets: npt.NDArray[np.int64]
    prize: npt.NDArray[np.float64]
    first_target: int


def joined(parts: Sequence[tuple[Rules, Window, WindowNetwork]]) -> Joined:
    """One network from those of several windows.

    Parameters
    ----------
    parts : sequence of (Rules, Window, WindowNetwork)
        What a target is worth, and which bodies are targets, is the same in all of them.
    """
    rules = [each for each, _, _ in parts]
    windows = [window for _, window, _ in parts]
    nets = [net for _, _, net in parts]
    roots = np.cumsum([0, *(net.body.size for net in nets)], dtype=np.int64)
    tanks = [
        np.concatenate(([window.left], np.full(window.refuels, each.budget)))
        for each, window in zip(rules, windows, strict=True)
    ]
    first_tanks = np.cumsum([0, *(each.size for each in tanks)], dtype=np.int64)
    edges = np.cumsum([0, *(net.tail.size for net in nets)], dtype=np.int64)
    last = len(nets) - 1
    net = WindowNetwork(
        body=np.concatenate([net.body for net in nets]),
        end=np.concatenate([net.end for net in nets]),
        delta_v=np.concatenate([net.delta_v for net in nets]),
        tank=np.concatenate([net.tank + first_tanks[at] for at, net in enumerate(nets)]),
        rest_worth=np.concatenate([net.rest_worth for net in nets]),
        rest_need=np.concatenate([net.rest_need for net in nets]),
        onward=np.concatenate(
            [
                np.full(net.body.size, roots[at + 1] if at < last else -1, dtype=np.int64)
                for at, net in enumerate(nets)
            ]
        ),
        head=np.concatenate(
            [net.head[:-1] + edges[at] for at, net in enumerate(nets)] + [edges[-1:]]
        ),
        tail=np.concatenate([net.tail + roots[at] for at, net in enumerate(nets)]),
    )
    return Joined(
        net,
        roots[:-1],
        np.concatenate(tanks),
        max(1.0, *(each.budget for each in rules)),
        reduce(np.union1d, [window.open_targets for window in windows]),
        np.array([window.most_targets for window in windows], dtype=np.int64),
        rules[0].prize,
        int(rules[0].first_target),
    )
