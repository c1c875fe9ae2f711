"""Shell completion: values that arguments and options offer at a tab.

Nothing here may import numba: a shell waits for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

VARIABLE = "_ADR_OPT_COMPLETE"
"""Environment variable by which a shell requests completions, as click names it."""

Complete = Callable[[click.Context, click.Parameter, str], list[Any]]

_FAMILIES = """
tiny nominal reduced-time reduced-fuel campaign cloud large sso rocket-bodies removal electric
fragment-cloud
"""
FAMILIES = tuple(_FAMILIES.split())
"""Families of the generator, which takes a second to import."""


def _beginning(names: tuple[str, ...], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def files(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[Any]:
    """Let the shell list files."""
    return [CompletionItem(incomplete, type="file")]


def folders(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[Any]:
    """Let the shell list folders."""
    return [CompletionItem(incomplete, type="dir")]


def families(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Families of instances."""
    return _beginning(FAMILIES, incomplete)


def planners(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Installed planners."""
    from ...run.methods import names

    return _beginning(names(), incomplete)


def bounds(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Installed bounds."""
    from ...run.methods import BOUNDS, names

    return _beginning(names(BOUNDS), incomplete)


def methods(context: click.Context, parameter: click.Parameter, incomplete: str) -> list[str]:
    """Installed planners and bounds."""
    both = planners(context, parameter, incomplete) + bounds(context, parameter, incomplete)
    return sorted(set(both))


BY_METAVAR: dict[str, Complete] = {"FILE": files, "PLAN": files, "DIR": folders}
"""Completions of option values, by their name in the help."""
