"""Studies over worlds: one row for each of consecutive seeds."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from functools import cached_property
from hashlib import sha256
from typing import Any, Generic, Protocol, TypeVar

from pydantic import ConfigDict, TypeAdapter

from ...common.errors import InputError
from ...common.json_text import validated
from ...problem.instance import Instance
from ...study import Place, Study, check_jobs
from ...study.workers import Row
from .mission_facts import MissionFacts

EXACT = ConfigDict(strict=True, allow_inf_nan=False, extra="forbid")
"""Strict reading of the data classes of rows: stated types, finite numbers."""

MOST_SAMPLES = 1_000_000

R = TypeVar("R")


class OfInstance(Protocol):
    """Data on which rows of worlds depend, an instance included."""

    @property
    def instance(self) -> Instance:
        """The instance."""
        ...


S = TypeVar("S", bound=OfInstance)


class InProcess(Generic[S]):
    """Data shared by the rows of one process.

    Parameters
    ----------
    setting : S
    """

    def __init__(self, setting: S) -> None:
        self.setting = setting

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.setting,)

    @cached_property
    def alone(self) -> MissionFacts:
        """Facts for rows computed alone, on all cores."""
        return MissionFacts(self.setting.instance)

    @cached_property
    def _beside(self) -> MissionFacts:
        return MissionFacts(self.setting.instance, cores=1)

    def facts(self, place: Place) -> MissionFacts:
        """Facts for a row computed at a place."""
        return self.alone if place.alone else self._beside


def worlds_study(protocol: str, row: Row, of: Mapping[str, str], kind: type[R]) -> Study[int, R]:
    """A study of worlds by their seeds.

    Parameters
    ----------
    protocol : str
    row : callable
        Makes what comes of a seed.
    of : mapping of str to str
        What it depends on besides.
    kind : type
        Data class of the rows, with :data:`EXACT` and a field ``seed``.
    """
    adapter = TypeAdapter(kind)

    def from_json(seed: int, value: Any) -> R:
        found = validated(adapter, json.dumps(value))
        if found.seed != seed:  # type: ignore[attr-defined]
            raise ValueError("of a different seed")
        return found

    digests = {word: sha256(text.encode()).hexdigest() for word, text in of.items()}
    return Study(protocol, 1, row, digests, to_json=asdict, from_json=from_json)


def check_worlds(samples: int, seed: int, jobs: int, cluster: str | None) -> None:
    """Refuse numbers of worlds or processes out of range.

    Raises
    ------
    InputError
        One of them is out of range, or jobs are given for a cluster.
    """
    if not 1 <= samples <= MOST_SAMPLES:
        raise InputError(f"samples = {samples}: give 1 to {MOST_SAMPLES}")
    if seed < 0:
        raise InputError(f"seed = {seed}: must not be negative")
    check_jobs(jobs, cluster)
