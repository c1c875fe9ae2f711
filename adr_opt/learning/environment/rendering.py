"""Pictures of a running mission."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import HOUR_S
from ...common.wording import counted
from ...kernels.episodes.episodes import HOME
from ...kernels.orbits import elements
from ...mission.mission import Mission

SIZE = 400
MARGIN = 30
BACKGROUND = (250, 250, 248)
OPEN, VISITED = (30, 110, 180), (190, 190, 190)
STATION_COLOUR, CHASER = (40, 140, 70), (215, 80, 40)


def sentence(mission: Mission, state: dict[str, Any], visited: npt.NDArray[np.bool_]) -> str:
    """The state in one line.

    Parameters
    ----------
    mission : Mission
    state : dict
        ``body``, ``time_s``, ``delta_v_left_m_s``, ``serviced`` and ``refuelled``.
    visited : (bodies,) bool
        Not looked at here.
    """
    instance = mission.instance
    return (
        f"{state['time_s'] / HOUR_S:.1f} of {instance.mission.duration_s / HOUR_S:.1f} h, "
        f"{state['delta_v_left_m_s']:.0f} of {instance.chaser.tank.delta_v_m_s:.0f} m/s left, "
        f"at {mission.names[state['body']]}: "
        f"{state['serviced']} of {counted(len(instance.targets), 'target')} serviced, "
        f"refuelled {counted(state['refuelled'], 'time')}"
    )


def picture(
    mission: Mission, state: dict[str, Any], visited: npt.NDArray[np.bool_]
) -> npt.NDArray[np.uint8]:
    """Current orbital planes as points, with RAAN to the right and inclination upwards.

    ΔV is spent on the distance in this picture. Open targets are blue, serviced ones grey, the
    station green, the chaser has a red ring; bars below show time and ΔV left.

    Returns
    -------
    (400, 400, 3) uint8
    """
    image = np.full((SIZE, SIZE, 3), BACKGROUND, dtype=np.uint8)
    orbits = mission.transfer_inputs[1]
    nodes = elements.nodes(orbits, state["time_s"])
    inclinations = elements.inclinations(orbits, state["time_s"])
    raan = (nodes - nodes[HOME] + np.pi) % (2.0 * np.pi) - np.pi
    across = raan * np.sin(inclinations[HOME])
    up = inclinations - inclinations[HOME]
    reach = max(np.abs(across).max(), np.abs(up).max(), 1e-9)
    half = SIZE / 2 - MARGIN
    columns = (SIZE / 2 + half * across / reach).astype(int)
    rows = (SIZE / 2 - half * up / reach).astype(int)
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    for body in range(len(mission.names)):
        distance = np.hypot(x - columns[body], y - rows[body])
        colour = VISITED if visited[body] else OPEN
        if body == HOME:
            colour = STATION_COLOUR
        image[distance <= (6 if body == HOME else 4)] = colour
        if body == state["body"]:
            image[(distance > 7) & (distance <= 10)] = CHASER
    duration_s = mission.instance.mission.duration_s
    delta_v_m_s = mission.instance.chaser.tank.delta_v_m_s
    for row, share, colour in (
        (SIZE - 18, 1.0 - state["time_s"] / max(duration_s, 1.0), OPEN),
        (SIZE - 10, state["delta_v_left_m_s"] / max(delta_v_m_s, 1.0), CHASER),
    ):
        length = int((SIZE - 2 * MARGIN) * min(max(share, 0.0), 1.0))
        image[row : row + 5, MARGIN : MARGIN + length] = colour
    return image
