"""The network that scores legs, in NumPy: an encoder for each leg, pooled over all of them."""

from __future__ import annotations

import io
import json
import os
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...common.arrays import read_arrays
from ...common.errors import InputError
from ...common.files import write_bytes
from ...common.json_text import loaded
from .features import LEG_FEATURES, MISSION_FEATURES

FloatArray = npt.NDArray[np.float64]

FORMAT = "adr-opt-next-leg/1"

MOST_BYTES = 16 * 2**20
"""Largest size of all arrays of a file; those of the package have a thousandth."""

SHIPPED = "next-leg.npz"
"""File of the weights that come with the package."""


class ScorerLayers(NamedTuple):
    """Weights of the network; `width` hidden units.

    Attributes
    ----------
    leg : (width, LEG_FEATURES), mission : (width, MISSION_FEATURES), bias : (width,) float32
        The encoder of a leg.
    inner : (width, width), inner_bias : (width,) float32
        Its second layer.
    own : (width, width), mean, most : (width, width), head_bias : (width,) float32
        The head: the code of the leg, and mean and maximum of the codes of all legal ones.
    out : (width,) float32
    """

    leg: npt.NDArray[np.float32]
    mission: npt.NDArray[np.float32]
    bias: npt.NDArray[np.float32]
    inner: npt.NDArray[np.float32]
    inner_bias: npt.NDArray[np.float32]
    own: npt.NDArray[np.float32]
    mean: npt.NDArray[np.float32]
    most: npt.NDArray[np.float32]
    head_bias: npt.NDArray[np.float32]
    out: npt.NDArray[np.float32]


def shapes(width: int) -> dict[str, tuple[int, ...]]:
    """Shapes of all layers."""
    square = (width, width)
    return {
        "leg": (width, LEG_FEATURES),
        "mission": (width, MISSION_FEATURES),
        "bias": (width,),
        "inner": square,
        "inner_bias": (width,),
        "own": square,
        "mean": square,
        "most": square,
        "head_bias": (width,),
        "out": (width,),
    }


class LegScorer:
    """Scores of legs; the largest is the leg to fly.

    Parameters
    ----------
    layers : ScorerLayers
    facts : dict
        How they were trained.
    """

    def __init__(self, layers: ScorerLayers, facts: dict[str, Any]) -> None:
        self.layers, self.facts = layers, facts

    def scores(
        self, legs: FloatArray, mission: FloatArray, legal: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.float32]:
        """Scores of legs, −inf of those that are not legal, shape (legs,).

        Parameters
        ----------
        legs : (legs, LEG_FEATURES) float64
        mission : (MISSION_FEATURES,) float64
        legal : (legs,) bool
        """
        of = self.layers
        found = np.full(legal.size, -np.inf, dtype=np.float32)
        at = np.flatnonzero(legal)
        if at.size == 0:
            return found
        seen = legs[at].astype(np.float32)
        hidden = seen @ of.leg.T + (of.mission @ mission.astype(np.float32) + of.bias)
        np.maximum(hidden, 0.0, out=hidden)
        codes = hidden @ of.inner.T + of.inner_bias
        np.maximum(codes, 0.0, out=codes)
        pooled = of.mean @ codes.mean(axis=0) + of.most @ codes.max(axis=0) + of.head_bias
        head = codes @ of.own.T + pooled
        np.maximum(head, 0.0, out=head)
        found[at] = head @ of.out
        return found

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the weights, completely or not at all."""
        archive = io.BytesIO()
        told = np.frombuffer(json.dumps({"format": FORMAT, **self.facts}).encode(), dtype=np.uint8)
        np.savez(archive, allow_pickle=False, facts=told, **self.layers._asdict())
        write_bytes(Path(path), archive.getvalue())


def load_scorer(path: str | os.PathLike[str]) -> LegScorer:
    """Read weights. Nothing in the file is executed.

    Raises
    ------
    InputError
        It is no such file.
    """
    wrong = f"{os.fspath(path)}: is not a file of weights for choosing legs ({FORMAT})"
    try:
        found = read_arrays(path, MOST_BYTES)
    except ValueError as error:
        raise InputError(wrong) from error
    try:
        facts = loaded(found.pop("facts").tobytes().decode())
        layers = ScorerLayers(**found)
        good = facts.pop("format") == FORMAT
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(wrong) from error
    wanted = shapes(layers.bias.size)
    for name, array in layers._asdict().items():
        good = good and array.shape == wanted[name] and bool(np.isfinite(array).all())
    if not good:
        raise InputError(wrong)
    return LegScorer(
        ScorerLayers(*(np.ascontiguousarray(each, np.float32) for each in layers)), facts
    )


@cache
def shipped() -> LegScorer:
    """The scorer that comes with the package."""
    return load_scorer(str(files(__package__) / "weights" / SHIPPED))
