"""Tests over many seeds or examples: some at the gate, all in a test marked ``slow``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import pytest
from hypothesis import given, settings

Decorator = Callable[[Callable[..., None]], Callable[..., None]]


def over_kinds(names: str, **kinds: tuple[Any, ...]) -> pytest.MarkDecorator:
    """Parametrise a test that counts over seeds, of instances of some kinds.

    Parameters
    ----------
    names : str
        Arguments of the test, as ``"draw, seeds"``: the last one is a sequence of seeds.
    **kinds : tuple
        For each kind, by its name, the values of the other arguments, all seeds, and the number
        of those at the gate.
    """
    cases = []
    for name, (*values, seeds, gate) in kinds.items():
        cases.append(pytest.param(*values, seeds[:gate], id=name))
        if others := seeds[gate:]:
            cases.append(pytest.param(*values, others, id=f"{name}-slow", marks=pytest.mark.slow))
    return pytest.mark.parametrize(names, cases)


def first_of(values: Sequence[Any], *, gate: int) -> list[Any]:
    """Values of one argument of a test: the first ones at the gate, the others with ``slow``.

    Parameters
    ----------
    values : sequence
    gate : int
        Number of values at the gate.
    """
    return [*values[:gate], *(pytest.param(each, marks=pytest.mark.slow) for each in values[gate:])]


def over_seeds(seeds: Sequence[Any], *, gate: int) -> Decorator:
    """Loop over seeds inside a test of one ``seed``.

    A failure names its seed. A seed that is skipped is passed over, unless all of them are.

    Parameters
    ----------
    seeds : sequence
    gate : int
        Number of seeds at the gate.
    """

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @wraps(test)
        def loop(*, seeds: Sequence[Any], **arguments: Any) -> None:
            skipped = []
            for seed in seeds:
                try:
                    test(seed=seed, **arguments)
                except pytest.skip.Exception as skip:
                    skipped.append(skip)
                except BaseException as error:
                    error.add_note(f"seed {seed!r}")
                    raise
            if len(skipped) == len(seeds):
                raise skipped[0]

        signature = inspect.signature(test)
        own = list(signature.parameters.values())
        own = [each.replace(name="seeds") if each.name == "seed" else each for each in own]
        vars(loop)["__signature__"] = signature.replace(parameters=own)
        return over_kinds("seeds", seeds=(seeds, gate))(loop)

    return decorate


def over_examples(*strategies: Any, gate: int, full: int, **more: Any) -> Decorator:
    """Let Hypothesis draw the arguments of a test.

    Parameters
    ----------
    *strategies : SearchStrategy
        Of the arguments.
    gate, full : int
        Number of examples at the gate, and in the test marked ``slow``.
    **more
        Other settings.
    """

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        def drawn(examples: int) -> None:
            limited = settings(max_examples=examples, deadline=None, **more)
            limited(given(*strategies)(test))()

        drawn.__doc__ = test.__doc__
        all_ = pytest.param(full, marks=pytest.mark.slow)
        return pytest.mark.parametrize("examples", [gate, all_])(drawn)

    return decorate
