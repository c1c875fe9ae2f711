"""The arguments that the comparisons have in common."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.mission.problem import Problem, problem_of
from adr_opt.sources.generator import FAMILIES


def _instances(arguments: argparse.Namespace) -> list[adr_opt.Instance]:
    """The instances asked for: files, or the first fields of a family."""
    if arguments.instances:
        return [adr_opt.load(path) for path in arguments.instances]
    return [adr_opt.generate(arguments.family, field) for field in range(arguments.count)]


def missions(arguments: argparse.Namespace) -> list[adr_opt.Mission]:
    """The missions asked for."""
    return [adr_opt.Mission(instance) for instance in _instances(arguments)]


def problems(arguments: argparse.Namespace) -> list[Problem]:
    """The same, with several chasers as campaigns."""
    return [problem_of(instance) for instance in _instances(arguments)]


def parser_of(text: str | None, time_limit_s: float) -> argparse.ArgumentParser:
    """The arguments that both comparisons have."""
    parser = argparse.ArgumentParser(
        description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--instances", nargs="+", type=Path, help="files, instead of a family")
    parser.add_argument("--family", default="nominal", choices=list(FAMILIES))
    parser.add_argument("--count", type=int, default=4, help="fields of the family, from 0")
    parser.add_argument("--time-limit", type=float, default=time_limit_s, help="[s] each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1, help="cores of methods that use several")
    parser.add_argument("--slot", type=float, default=240.0, help="DIDPPy's slot of time [s]")
    return parser


def require_positive(arguments: argparse.Namespace) -> None:
    """Raise :class:`InputError` if a number is out of range."""
    for name in ("count", "time_limit", "jobs", "slot"):
        value = getattr(arguments, name)
        if not value > 0 or not math.isfinite(value):
            raise InputError(f"--{name.replace('_', '-')} {value!r}: must be > 0")
