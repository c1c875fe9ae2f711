"""Specifications of environments that can be written as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from gymnasium.envs.registration import EnvSpec

from ...problem.instance import Instance
from ...problem.uncertainty import Uncertainty
from .fields import Fields


class SpecHolder:
    """An environment whose specification has the arguments in a form that JSON can hold.

    So ``EnvSpec.from_json(env.spec.to_json())`` makes the same environment. An instance with more
    than its file says stays an object, which JSON refuses: pass the path of its file instead.
    """

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The specification that Gymnasium made the environment of."""
        return self._spec

    @spec.setter
    def spec(self, given: EnvSpec | None) -> None:
        self._spec = given if given is None else replace_arguments(given)


def replace_arguments(spec: EnvSpec) -> EnvSpec:
    """A specification with its arguments in a form that JSON can hold."""
    plain = {name: in_json(value) for name, value in spec.kwargs.items()}
    return replace(spec, kwargs=plain)


def in_json(value: Any) -> Any:
    """An argument of an environment in a form that JSON can hold."""
    if isinstance(value, Instance):
        return json.loads(value.to_json()) if value.is_all_in_file else value
    if isinstance(value, Uncertainty):
        return value.model_dump(mode="json")
    if isinstance(value, Fields):
        return asdict(value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {name: in_json(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [in_json(each) for each in value]
    return value
