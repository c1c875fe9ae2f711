"""Methods as they are typed: NAME[:OPTION=VALUE,…][@SECONDS]."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from adr_opt.common.errors import InputError
from adr_opt.common.options import parsed, read
from adr_opt.run.front import method_of, spec_of
from adr_opt.run.methods import options_of

DEFAULT_METHODS = "greedy,greedy-guarded,mcts,beam,auto,ortools,ppo"
"""The planners of the published study and those of this project that answer it."""


@dataclass(frozen=True)
class Method:
    """A planner, its options as text (sorted by name) and its time limit [s]."""

    name: str
    options: tuple[tuple[str, str], ...]
    limit_s: float

    @property
    def key(self) -> str:
        """The one way to write the method: what rows are stored under."""
        options = ",".join(f"{name}={text}" for name, text in self.options)
        return f"{self.name}{':' if options else ''}{options}@{self.limit_s:g}"

    @property
    def plans_campaigns(self) -> bool:
        """Whether it plans for several chasers."""
        return spec_of(self.name).several

    def values(self) -> dict[str, Any]:
        """The options as :func:`adr_opt.solve` takes them, on one core unless typed otherwise.

        Missions are planned side by side, so a planner must not take the cores of the next.

        Raises
        ------
        InputError
            Unknown method or option, or a value that is not of its type or out of range.
        """
        planner = method_of(self.name)
        kind = options_of(planner)
        values = {name: parsed(kind, name, text) for name, text in self.options}
        read(kind, values)
        if spec_of(self.name).uses_cores:
            values.setdefault("jobs", 1)
        return values


def parse_methods(texts: Iterable[str], limit_s: float) -> tuple[Method, ...]:
    """The methods of comma-separated lists, each once.

    Parameters
    ----------
    texts : iterable of str
    limit_s : float
        Time limit of those that have none of their own [s].

    Raises
    ------
    InputError
        Something is not a method, or not installed; the sentence names it.
    """
    found: dict[str, Method] = {}
    for text in texts:
        # A comma before OPTION= belongs to the options of the method before it.
        for spec in re.split(r",(?!\s*[A-Za-z_][A-Za-z_0-9]*=)", text):
            if spec.strip():
                method = _parse(spec.strip(), limit_s)
                found[method.key] = method
    if not found:
        raise InputError("--methods: names no method; give for example --methods greedy,beam")
    return tuple(found.values())


def _parse(spec: str, limit_s: float) -> Method:
    rest, at, limit_text = spec.partition("@")
    name, _, listed = rest.partition(":")
    limit = limit_s
    if at:
        try:
            limit = float(limit_text)
        except ValueError:
            raise InputError(
                f"--methods: {spec!r}: the time limit {limit_text!r} is not a number of seconds"
            ) from None
    if not (math.isfinite(limit) and limit > 0.0):
        raise InputError(f"--methods: {spec!r}: the time limit must be positive, in seconds")
    options = {}
    for pair in filter(None, (part.strip() for part in listed.split(","))):
        option, equals, text = pair.partition("=")
        if not equals:
            raise InputError(f"--methods: {spec!r}: write {pair!r} as OPTION=VALUE")
        options[option.strip()] = text.strip()
    method = Method(name, tuple(sorted(options.items())), limit)
    method.values()
    return method


def labels(keys: Iterable[str]) -> dict[str, str]:
    """Short names of stored methods: without the time limit where nothing else tells it apart."""
    keys = tuple(keys)
    stems = [key.rpartition("@")[0] for key in keys]
    return {
        key: stem if stems.count(stem) == 1 else key for key, stem in zip(keys, stems, strict=True)
    }
