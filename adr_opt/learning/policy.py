"""The learned policy: weights with a card in one file, and the scores of choices."""

from __future__ import annotations

import io
import json
import os
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.arrays import read_arrays
from ..common.errors import InputError
from ..common.files import write_bytes
from ..common.json_text import loaded
from ..kernels.episodes.choices import CHOICE_FIELDS, MISSION_FIELDS
from ..kernels.episodes.set_scores import (
    CONTEXT,
    HEADS,
    ILLEGAL,
    PLACE,
    PLACE_WIDTH,
    ScorerWeights,
    set_scores,
)
from ..mission.mission import Mission

FloatArray = npt.NDArray[np.float32]
BoolArray = npt.NDArray[np.bool_]

FORMAT = "adr-opt-policy/2"

SHIPPED = "policy"
"""Name of the policy that comes with the package."""

MOST_BYTES = 16 * 2**20
"""Largest size of all arrays of a file [bytes]; those of the package take a hundredth of it."""


def shapes(width: int, layers: int) -> dict[str, tuple[int, ...]]:
    """Shapes of all weights."""

    def linear(name: str, out: int, into: int) -> dict[str, tuple[int, ...]]:
        return {f"{name}.weight": (out, into), f"{name}.bias": (out,)}

    found = {
        **linear("token", width, len(CHOICE_FIELDS)),
        **linear("context", width, CONTEXT),
        **linear("encode", width, width),
        **linear("head", width, 2 * width),
        **linear("score", 1, width),
    }
    for layer in range(layers):
        for norm in ("norm", "then"):
            found |= {f"{norm}_{layer}.{part}": (width,) for part in ("weight", "bias")}
        found |= linear(f"attend_{layer}", 3 * width, width)
        found |= linear(f"place_{layer}", 2 * HEADS * PLACE_WIDTH, PLACE)
        found |= linear(f"merge_{layer}", width, width)
        found |= linear(f"widen_{layer}", 2 * width, width)
        found |= linear(f"narrow_{layer}", width, 2 * width)
    return found


class Policy:
    """Scores of choices; the largest is the move to make.

    Parameters
    ----------
    arrays : dict
        Weights by name (:func:`shapes`).
    card : dict
        How they were trained, and how many visits they collect.

    Raises
    ------
    InputError
        The weights do not fit the network.
    """

    def __init__(self, arrays: dict[str, npt.NDArray[Any]], card: dict[str, Any]) -> None:
        self.arrays, self.card = arrays, card
        encode = arrays.get("encode.bias", np.zeros(0))
        self._width = encode.size
        self._layers = sum(name.startswith("attend_") for name in arrays) // 2
        wanted = shapes(self._width, self._layers)
        good = arrays.keys() == wanted.keys() and self._width > 0 and self._width % HEADS == 0
        for name, array in arrays.items():
            good = good and array.shape == wanted[name] and array.dtype == np.float32
            good = good and bool(np.isfinite(array).all())
        if not good:
            raise InputError("its weights do not fit the policy's network")
        with np.errstate(over="ignore", invalid="ignore"):
            self._weights = self._folded()

    def _folded(self) -> ScorerWeights:
        """The layers, with scales and shifts of norms in the layers after them."""
        of = {name: array.T for name, array in self.arrays.items()}
        width = self._width
        for layer in range(self._layers):
            for norm, linear in (("norm", "attend"), ("then", "widen")):
                scale, shift = of[f"{norm}_{layer}.weight"], of[f"{norm}_{layer}.bias"]
                weight, bias = f"{linear}_{layer}.weight", f"{linear}_{layer}.bias"
                of[bias] = of[bias] + shift @ of[weight]
                of[weight] = of[weight] * scale[:, None]
            for part in ("weight", "bias"):
                queries = np.ones(3 * width, dtype=np.float32)
                queries[:width] = (HEADS / width) ** 0.5
                of[f"attend_{layer}.{part}"] = of[f"attend_{layer}.{part}"] * queries
        for linear in ("attend", "place", "merge", "widen", "narrow"):
            for part in ("weight", "bias"):
                of[f"{linear}.{part}"] = np.array(
                    [of[f"{linear}_{layer}.{part}"] for layer in range(self._layers)]
                )
        parts = {
            field: of[f"{field.removesuffix('_bias')}.{'bias' if '_' in field else 'weight'}"]
            for field in ScorerWeights._fields
        }
        parts["score"] = parts["score"][:, 0]
        return ScorerWeights(**{name: np.ascontiguousarray(of) for name, of in parts.items()})

    @property
    def name(self) -> str:
        """Name of the policy in plans."""
        return str(self.card.get("name", "own"))

    def notes(self, mission: Mission) -> tuple[str, ...]:
        """Notes for a plan made with the policy: whether it was trained on such missions."""
        known, dynamics = str(self.card.get("dynamics", "two-body")), mission.instance.dynamics
        if dynamics == known:
            return ()
        return (
            f"policy {self.name!r} was trained on fields with dynamics {known!r}, and this mission "
            f"has {dynamics!r}: other methods may plan it better",
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write weights and card, completely or not at all."""
        archive = io.BytesIO()
        told = {"format": FORMAT, "fields": _fields(), **self.card}
        card = np.frombuffer(json.dumps(told).encode(), dtype=np.uint8)
        np.savez(archive, allow_pickle=False, card=card, **self.arrays)
        write_bytes(Path(path), archive.getvalue())

    def scores(self, moves: FloatArray, mission: FloatArray) -> FloatArray:
        """Scores of choices, shape (states, choices): see :func:`.set_scores.set_scores`.

        Parameters
        ----------
        moves : (states, choices, len(CHOICE_FIELDS)) float32
        mission : (states, len(MISSION_FIELDS)) float32

        Raises
        ------
        InputError
            A score is not finite, or so large that an illegal move might seem best.
        """
        scores = np.empty(moves.shape[:2], dtype=np.float32)
        if not set_scores(self._weights, moves, mission, scores):
            raise InputError(
                f"policy {self.name!r}: its scores are not finite, or beyond {-ILLEGAL:g}; the "
                "file is damaged"
            )
        return scores


def _fields() -> str:
    """Names of all that the network sees: another version of them is another network."""
    return "; ".join((*CHOICE_FIELDS, *MISSION_FIELDS))


def log_probabilities(scores: FloatArray, temperature: float = 1.0) -> FloatArray:
    """Logarithms of the softmax of scores over the last axis."""
    shifted = (scores - scores.max(axis=-1, keepdims=True)) / np.float32(temperature)
    logs: FloatArray = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return logs


def load_policy(name: str | os.PathLike[str] = SHIPPED) -> Policy:
    """The policy of the package, or one in a file. Nothing in the file is executed.

    Parameters
    ----------
    name : str or path
        :data:`SHIPPED`, or the path of a file that ``train`` wrote.

    Raises
    ------
    InputError
        It is not such a file, or one for another version of the observation.
    """
    if str(name) in ("", SHIPPED):
        return _shipped()
    if not Path(name).is_file():
        raise InputError(
            f"policy {str(name)!r}: no such file; give one that train wrote, or {SHIPPED!r} for "
            "the policy of the package"
        )
    return _read(Path(name))


@cache
def _shipped() -> Policy:
    return _read(Path(str(files(__package__))) / "weights" / "policy.npz")


def _read(path: Path) -> Policy:
    try:
        found = read_arrays(path, MOST_BYTES)
        card = loaded(found.pop("card").tobytes().decode())
        known, fields = card.pop("format"), card.pop("fields")
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: is not a file of a policy ({FORMAT})") from error
    if known != FORMAT or fields != _fields():
        raise InputError(f"{path}: a policy of another version ({str(known)[:60]}); train it again")
    try:
        return Policy(found, card)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
