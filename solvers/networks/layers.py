"""Walks of a chaser that carries something: from one number of kits aboard to another.

The values of walks have a layer for each number of kits, so that kits are counted as exactly as
bodies are. What a service does to what the tank is worth becomes an image of slots, rounded so
that no walk is the poorer for it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import SLACK_M_S
from adr_opt.kernels.core.compile import inlined
from adr_opt.kernels.rules.loads import Loads

SLACK = 1e-9
"""Guard of roundings to slots, always in the optimistic direction [slots]."""


class Layers(NamedTuple):
    """How walks go from one number of kits aboard to another.

    Attributes
    ----------
    takes : (bodies,) int64
        Kits that a service takes.
    image : (bodies, layers, width) int32
        Slot after the service of a body with so many kits aboard, of each slot before; −1 for none.
    tops : (layers,) int64
        Slot of a full tank.
    """

    takes: np.ndarray
    image: np.ndarray
    tops: np.ndarray


def layers_of(loads: Loads | None, slot: float, top: int, width: int) -> Layers | None:
    """How walks go from one number of kits to another; None where loads do not count.

    A slot holds all that is left up to the next one, so it is that one's image that counts.
    """
    if loads is None:
        return None
    bodies, layers = loads.scale.shape
    most_left = slot * (np.arange(width) + 1.0) - SLACK_M_S
    image = np.tile(np.arange(width, dtype=np.int32), (bodies, layers, 1))
    for body, kits in np.argwhere(loads.loss > 0.0):
        ratio = loads.scale[body, kits] * np.exp(most_left / loads.exhaust) - loads.loss[body, kits]
        left = loads.exhaust * np.log(np.maximum(ratio, 1e-300)) + SLACK_M_S
        slots = np.clip(np.floor(left / slot + SLACK), -1, top)
        image[body, kits] = slots
    tops = np.floor(loads.full / slot + SLACK).astype(np.int64)
    return Layers(loads.takes, image, tops)


@inlined
def top_of(layers, top, kits):
    """Slot of a full tank with so many kits aboard."""
    if layers is None:
        return top
    return layers.tops[kits]


@inlined
def after_service(layers, j, kits, slot):
    """Kits aboard and slot after a service."""
    if layers is None:
        return kits, slot
    return kits - layers.takes[j], np.int64(layers.image[j, kits, slot])
