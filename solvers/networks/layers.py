"""Layers of walks of a chaser with cargo: transitions between numbers of kits.

The values of walks have a layer for each number of kits, so that kits are counted as exactly as
bodies are. What a service does to what the tank is worth becomes an image of slots, rounded so
that no walk is the poorer for it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.rules import loads as load_kernels
from adr_opt.kernels.rules.loads import Loads

SLACK = 1e-9
"""Guard for rounding to slots, always in the optimistic direction [slots]."""


class Layers(NamedTuple):
    """Transitions of walks between numbers of kits.

    Attributes
    ----------
    takes : (bodies,) int64
        Kits that a service takes.
    image : (bodies, layers, width) int32
        Slot after the service of a body, by kits aboard and slot before; −1 for none.
    tops : (layers,) int64
        Slot of a full tank.
    """

    takes: np.ndarray
    image: np.ndarray
    tops: np.ndarray


@kernel
def _change(loads, slot, top, image):
    """Write the slots after services that change the remaining ΔV, by slot before."""
    bodies, layers, width = image.shape
    for body in range(bodies):
        for kits in range(layers):
            if loads.loss[body, kits] > 0.0:
                for before in range(width):
                    most = slot * (before + 1.0)
                    left, _ = load_kernels.after_service(loads, body, kits, most)
                    after = -1 if left < 0.0 else int(left / slot + SLACK)
                    image[body, kits, before] = min(after, top)


def layers_of(loads: Loads | None, slot: float, top: int, width: int) -> Layers | None:
    """Transitions between numbers of kits; None if loads do not matter.

    A slot holds all that is left up to the next one, so it is that one's image that counts.
    """
    if loads is None:
        return None
    bodies, layers = loads.scale.shape
    image = np.tile(np.arange(width, dtype=np.int32), (bodies, layers, 1))
    _change(loads, slot, top, image)
    tops = np.floor(loads.full / slot + SLACK).astype(np.int64)
    return Layers(loads.takes, image, tops)


@inlined
def top_of(layers, top, kits):
    """Slot of a full tank with a number of kits aboard."""
    if layers is None:
        return top
    return layers.tops[kits]


@inlined
def after_service(layers, j, kits, slot):
    """Kits aboard and slot after a service."""
    if layers is None:
        return kits, slot
    return kits - layers.takes[j], np.int64(layers.image[j, kits, slot])
