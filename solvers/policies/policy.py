"""A trained policy in a file, run by ONNX Runtime: no PyTorch, and no code in the file."""

from __future__ import annotations

import os
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.common.json_text import loaded
from adr_opt.kernels.episodes.observation import MISSION_FIELDS
from adr_opt.kernels.episodes.published import PUBLISHED_ELEMENTS
from adr_opt.learning.episodes import OBSERVATIONS, Observation
from adr_opt.learning.episodes.board import MISSION, MOVES, move_fields, published_size
from adr_opt.mission.mission import Mission

from .screening import ACTIONS, BATCH, check_graph, parsed

FORMAT = "adr-opt-policy/1"

SHIPPED = "set"
"""Default policy, shipped with the package."""

MOST_BYTES = 4 * 2**20
"""Maximum size of a policy file, checked before reading."""

LONGEST_NAME = 60
"""Maximum length of a name in the metadata."""

ILLEGAL = -1e8
"""Score of an illegal move."""

FloatArray = npt.NDArray[np.float32]


class Policy:
    """Network that gives scores of moves and values of states.

    Parameters
    ----------
    path : Path
        An ONNX file that ``train`` wrote.
    threads : int
        Threads of ONNX Runtime.

    Attributes
    ----------
    name : str
        Configuration that it was trained by.
    observation : str
        What it sees, one of :data:`adr_opt.learning.episodes.OBSERVATIONS`.
    targets : int or None
        Number of targets that it was made for; None for any.
    facts : dict
        Training steps, seed and versions, as the file states them.

    Raises
    ------
    InputError
        No policy file, or one of another format or observation.
    MissingExtra
        ONNX Runtime is not installed.
    """

    def __init__(self, path: Path, threads: int = 1) -> None:
        try:
            import onnxruntime
        except ImportError:
            raise MissingExtra("method 'ppo'", "onnxruntime", "ppo") from None
        self._path = path
        model = parsed(_read(path), path)
        known = {entry.key: entry.value for entry in model.metadata_props}
        if known.get("format") != FORMAT:
            raise InputError(
                f"{path}: format {repr(known.get('format'))[:LONGEST_NAME]} is not {FORMAT!r}; "
                "give a file that train wrote"
            )
        try:
            self.facts: dict[str, Any] = loaded(known["facts"])
            self.name, self.observation = known["name"], known["observation"]
            self.targets = int(known["targets"]) or None
            longest = max(len(self.name), len(self.observation))
            if (self.targets or 1) < 1 or longest > LONGEST_NAME or type(self.facts) is not dict:
                raise ValueError
        except (KeyError, ValueError, RecursionError):
            raise InputError(f"{path}: its metadata is not that of a policy") from None
        if self.observation not in OBSERVATIONS:
            raise InputError(
                f"{path}: made for the observation {self.observation!r}, which is unknown; use "
                f"one of: {', '.join(OBSERVATIONS)}"
            )
        if known.get("fields") != field_names(self.observation):
            raise InputError(
                f"{path}: made for another version of the observation {self.observation!r}; "
                "train it again"
            )
        check_graph(model, path, self._inputs(BATCH, ACTIONS))
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = threads
        options.log_severity_level = 4  # errors come as exceptions; nothing goes to stderr
        try:
            self._session = onnxruntime.InferenceSession(
                model.SerializeToString(), options, providers=["CPUExecutionProvider"]
            )
        except Exception as error:  # ONNX Runtime has no common class of its own for these
            raise InputError(
                f"{path}: ONNX Runtime refuses it ({type(error).__name__}); give a file that "
                "train wrote"
            ) from None
        self._check_outputs()

    def _inputs(self, states: int, actions: int) -> dict[str, tuple[int, ...]]:
        """Shapes of the network's inputs for a number of states."""
        if self.observation == "published":
            return {"observation": (states, published_size(self.targets or 0))}
        return {
            MOVES: (states, actions, len(move_fields(self.observation))),
            MISSION: (states, len(MISSION_FIELDS)),
        }

    def _check_outputs(self) -> None:
        """Evaluate two artificial states, so that invalid files are rejected at once."""
        actions = 4 if self.observation != "published" else (self.targets or 0) + 1
        states: Any = {
            name: np.zeros(shape, np.float32) for name, shape in self._inputs(2, actions).items()
        }
        try:
            scores, value = self._session.run(None, states)
            fits = scores.shape == (2, actions) and value.shape == (2,)
        except Exception:  # ONNX Runtime has no common class of its own for these
            fits = False
        if not fits:
            raise InputError(
                f"{self._path}: does not take the observation {self.observation!r} and give a "
                "score for every move and a value; train it again"
            )

    def judge(self, observation: Observation, mask: npt.NDArray[np.bool_]) -> tuple[Any, Any]:
        """Scores (batch, actions), with illegal moves at :data:`ILLEGAL`, and values (batch,)."""
        seen = observation if isinstance(observation, dict) else {"observation": observation}
        scores, value = self._session.run(None, seen)
        # A NaN would win every argmax, and so would an illegal move among legal ones that score
        # even less; no weights that train wrote give such scores.
        if not (np.abs(scores) < -ILLEGAL).all():
            raise InputError(
                f"{self._path}: its scores are not finite, or beyond {-ILLEGAL:g}; the file is "
                "damaged"
            )
        return np.where(mask, scores, np.float32(ILLEGAL)), value

    def notes(self, mission: Mission) -> tuple[str, ...]:
        """Notes for a plan made with the policy: whether it was trained on such missions."""
        known = "j2" if self.facts.get("dynamics") == "j2" else "two-body"
        if mission.instance.dynamics == known:
            return ()
        return (
            f"policy {self.name!r} was trained on fields with dynamics {known!r}, and this mission "
            f"has {mission.instance.dynamics!r}: other methods may plan it better",
        )

    def check_size(self, targets: int) -> None:
        """Refuse an instance of a size that the policy does not support.

        Raises
        ------
        InputError
            The sentence says which policy to use instead.
        """
        if self.targets is not None and targets > self.targets:
            raise InputError(
                f"{self._path}: policy {self.name!r} was made for {self.targets} targets, the "
                f"instance has {targets}; use the package's own ({SHIPPED!r}), which takes any "
                "number"
            )


def _read(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise InputError(f"{path}: {size} bytes are too many for a policy")
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def field_names(observation: str) -> str:
    """Names of all fields of an observation, as seen in training."""
    if observation == "published":
        return "; ".join(PUBLISHED_ELEMENTS)
    return "; ".join((*move_fields(observation), *MISSION_FIELDS))


def load_policy(name: str | os.PathLike[str] = SHIPPED, threads: int = 1) -> Policy:
    """The policy with a name or in a file.

    Parameters
    ----------
    name : str or path
        A policy that comes with the package, or the path of an ONNX file.
    threads : int

    Raises
    ------
    InputError
        No such policy, or not a policy file.
    MissingExtra
        ONNX Runtime is not installed.
    """
    shipped = Path(str(files(__package__))) / "weights"
    here = shipped / f"{name}.onnx"
    if os.sep not in str(name) and here.is_file():
        return Policy(here, threads)
    if not Path(name).is_file():
        known = ", ".join(sorted(path.stem for path in shipped.glob("*.onnx")))
        raise InputError(
            f"policy {str(name)!r}: no such file, and no policy of the package ({known})"
        )
    return Policy(Path(name), threads)


def log_probabilities(scores: FloatArray, temperature: float = 1.0) -> FloatArray:
    """Logarithms of the softmax of scores over the last axis."""
    shifted = (scores - scores.max(axis=-1, keepdims=True)) / np.float32(temperature)
    logs: FloatArray = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return logs
