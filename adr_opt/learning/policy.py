"""The learned policy in NumPy: weights with a card in one file, and the scores of choices."""

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
from ..kernels.episodes.choices import (
    ANGLE_FROM_CHASER,
    CHOICE_FIELDS,
    COST,
    INCLINATION_FROM_HOME,
    IS_OPEN,
    IS_STATION,
    LEGAL,
    MISSION_FIELDS,
    PHASE,
    RAAN_FROM_HOME,
    RADIUS_FROM_HOME,
)
from ..mission.mission import Mission

FloatArray = npt.NDArray[np.float32]
BoolArray = npt.NDArray[np.bool_]

FORMAT = "adr-opt-policy/2"

SHIPPED = "policy"
"""Name of the policy that comes with the package."""

MOST_BYTES = 16 * 2**20
"""Largest size of all arrays of a file; those of the package have a hundredth."""

TOKENS = 17
"""Number of choices that the network looks at: stations, and the cheapest moves, legal first."""

HEADS = 4
"""Of attention."""

PLACE, PLACE_WIDTH = 6, 6
"""Numbers that say where the orbit of a token lies, and what a head makes of them: products for
two tokens hold their distance and their phase."""

PLACES = (RADIUS_FROM_HOME, INCLINATION_FROM_HOME, RAAN_FROM_HOME)
"""Fields that say where the orbit of a choice lies."""

CONTEXT = len(MISSION_FIELDS) + 2 * len(CHOICE_FIELDS)
"""Numbers of the whole: of the mission, and means and deviations over all open targets."""

LAST, EQUAL, FAR_AWAY = 100.0, 1e-3, 1e4
"""What puts illegal choices behind, orders those of equal cost by their planes, and hides from
attention those that are not there."""

UNSEEN = -30.0
"""Score of choices that are no tokens."""

ILLEGAL = -1e8
"""Score of an illegal move."""


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
        How they came about, and what they collect.

    Raises
    ------
    InputError
        They are no weights of the network.
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
            raise InputError("these are no weights of the policy's network")
        self._of = {
            name: np.ascontiguousarray(array.T) if array.ndim == 2 else array
            for name, array in arrays.items()
        }
        self._own, self._shared = np.split(self._of["head.weight"], 2)
        self._average = np.full((self._width, 1), 1.0 / self._width, dtype=np.float32)
        with np.errstate(over="ignore", invalid="ignore"):
            for layer in range(self._layers):
                self._fold(f"norm_{layer}", f"attend_{layer}")
                self._fold(f"then_{layer}", f"widen_{layer}")
                for part in ("weight", "bias"):
                    queries = self._of[f"attend_{layer}.{part}"][..., : self._width]
                    queries *= np.float32((HEADS / self._width) ** 0.5)

    def _fold(self, norm: str, linear: str) -> None:
        """Put the scale and shift of a norm into the layer after it, which spares two steps."""
        of, weight = self._of, self._of[f"{linear}.weight"]
        of[f"{linear}.bias"] = of[f"{linear}.bias"] + of[f"{norm}.bias"] @ weight
        of[f"{linear}.weight"] = weight * of[f"{norm}.weight"][:, None]

    @property
    def name(self) -> str:
        """What plans call it."""
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
        """Scores of choices, shape (states, choices), illegal ones at :data:`ILLEGAL`.

        Parameters
        ----------
        moves : (states, choices, len(CHOICE_FIELDS)) float32
        mission : (states, len(MISSION_FIELDS)) float32

        Raises
        ------
        InputError
            Scores without measure, by which an illegal move might seem best.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            scores = self._scores(moves, mission)
        if not (np.abs(scores) < -ILLEGAL).all():
            raise InputError(
                f"policy {self.name!r}: its scores are not finite, or beyond {-ILLEGAL:g}; the "
                "file is damaged"
            )
        scores[moves[..., LEGAL] == 0.0] = ILLEGAL
        return scores

    def _scores(self, moves: FloatArray, mission: FloatArray) -> FloatArray:
        legal, is_open, is_station = (moves[..., at] for at in (LEGAL, IS_OPEN, IS_STATION))
        key = (moves[..., COST] + EQUAL * moves[..., ANGLE_FROM_CHASER]) * (1.0 - is_station)
        key += LAST * (3.0 - legal - is_open - np.maximum(is_open, is_station))
        seen = min(TOKENS, key.shape[1])
        kept = np.argpartition(key, seen - 1, axis=1)[:, :seen]
        rows = np.arange(len(moves))[:, None]
        x = moves[rows, kept]
        open_targets = (is_open * (1.0 - is_station))[:, None]
        per_count = 1.0 / np.maximum(open_targets.sum(2), 1.0)
        mean = (open_targets @ moves)[:, 0] * per_count
        away = moves - mean[:, None]
        spread = np.sqrt((open_targets @ (away * away))[:, 0] * per_count)
        whole = self._linear("context", np.concatenate([mission, mean, spread], axis=1))
        h = self._linear("encode", _relu(self._linear("token", x) + whole[:, None]))
        present = np.maximum(x[..., IS_OPEN], x[..., IS_STATION])
        place = self._place(x)
        hidden = ((1.0 - present) * np.float32(FAR_AWAY))[:, None, None]
        for layer in range(self._layers):
            split = self._linear(f"attend_{layer}", self._normed(h))
            q, k, v = split.reshape(*x.shape[:2], 3, HEADS, -1).transpose(2, 0, 3, 1, 4)
            here = self._linear(f"place_{layer}", place)
            here, there = here.reshape(*x.shape[:2], 2, HEADS, -1).transpose(2, 0, 3, 1, 4)
            near = q @ k.transpose(0, 1, 3, 2) + here @ there.transpose(0, 1, 3, 2)
            near -= hidden
            near = np.exp(near - near.max(-1, keepdims=True))
            near /= near.sum(-1, keepdims=True)
            h = h + self._linear(
                f"merge_{layer}", (near @ v).transpose(0, 2, 1, 3).reshape(h.shape)
            )
            wide = _relu(self._linear(f"widen_{layer}", self._normed(h)))
            h = h + self._linear(f"narrow_{layer}", wide)
        pooled = (present[:, None] @ h)[:, 0] / np.maximum(present.sum(1, keepdims=True), 1.0)
        # What all tokens share of the head is worked out once.
        beside = (pooled + whole) @ self._shared + self._of["head.bias"]
        found = self._linear("score", _relu(h @ self._own + beside[:, None]))[..., 0]
        scores = np.full(key.shape, UNSEEN, dtype=np.float32)
        scores[rows, kept] = found
        return scores

    def _linear(self, name: str, x: FloatArray) -> FloatArray:
        found: FloatArray = x @ self._of[f"{name}.weight"] + self._of[f"{name}.bias"]
        return found

    def _normed(self, x: FloatArray) -> FloatArray:
        # A product takes a third of the time of a mean.
        away = x - x @ self._average
        found: FloatArray = away / np.sqrt((away * away) @ self._average + np.float32(1e-5))
        return found

    def _place(self, x: FloatArray) -> FloatArray:
        """Where orbits of tokens lie."""
        place, phase = x[..., list(PLACES)], x[..., PHASE : PHASE + 1] * np.float32(np.pi)
        square = (place * place).sum(-1, keepdims=True)
        return np.concatenate([place, square, np.sin(phase), np.cos(phase)], axis=-1)


def _relu(x: FloatArray) -> FloatArray:
    found: FloatArray = np.maximum(x, np.float32(0.0))
    return found


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
        It is no such file, or of a version that sees something else.
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
