"""Scripts of tables: the command line, Markdown, times and kept rows, once for all experiments.

An experiment is a script whose tables are functions, and their arguments are its words::

    python bench/EXPERIMENT.py TABLE [WORD ...] [--option VALUE]

An argument without a default is a word; one with a default is the option of its name: a flag if it
is ``False``, with several values if it is a tuple. A script with a single table needs no name.
"""

from __future__ import annotations

import argparse
import inspect
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin

from machine import heading

from adr_opt.common.errors import InputError
from adr_opt.study import Run, Study

Made = TypeVar("Made")


def experiment(
    text: str | None, *tables: Callable[..., object], argv: Sequence[str] | None = None
) -> int:
    """Print the table that the command line names, below the command and the machine.

    Parameters
    ----------
    text : str, optional
        What the script says of itself.
    *tables : callable
        Each prints a table, and may return an exit status.
    argv : sequence of str, optional

    Returns
    -------
    int
        Exit status: 0, that of the table, or 2 with a sentence where the input is wrong.
    """
    parser = argparse.ArgumentParser(
        description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    if len(tables) == 1:
        add_words(parser, tables[0])
        parser.set_defaults(_table=tables[0])
    else:
        names = parser.add_subparsers(required=True, metavar="TABLE")
        for table in tables:
            said = inspect.getdoc(table) or ""
            one = names.add_parser(
                table.__name__.replace("_", "-"),
                help=_unformatted(said.partition("\n")[0]),
                description=said,
                formatter_class=argparse.RawDescriptionHelpFormatter,
            )
            add_words(one, table)
            one.set_defaults(_table=table)
    asked = vars(parser.parse_args(argv))
    table = asked.pop("_table")
    words: list[Any] = []
    for name, each in inspect.signature(table).parameters.items():
        if each.kind is each.VAR_POSITIONAL:
            words += asked.pop(name)
        elif each.default is each.empty:
            words.append(asked.pop(name))
    print(heading(), flush=True)
    try:
        return int(table(*words, **asked) or 0)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2


def add_words(parser: argparse.ArgumentParser, table: Callable[..., object]) -> None:
    """Add the arguments of a table to a parser, by its signature."""
    for name, each in inspect.signature(table, eval_str=True).parameters.items():
        kind, several = _kind(each.annotation)
        how: dict[str, Any] = {"type": kind}
        if get_origin(kind) is Literal:
            how = {"choices": get_args(kind)}
        if each.kind is each.VAR_POSITIONAL:
            parser.add_argument(name, nargs="*", **how)
        elif each.default is each.empty:
            parser.add_argument(name, **how)
        elif kind is bool:
            parser.add_argument(f"--{name.replace('_', '-')}", action="store_true")
        else:
            given = each.default
            shown = " ".join(map(str, given)) if isinstance(given, tuple) else given
            parser.add_argument(
                f"--{name.replace('_', '-')}",
                default=given,
                nargs="+" if several else None,
                help="" if given is None else _unformatted(f"[{shown}]"),
                **how,
            )


def _unformatted(text: str) -> str:
    """A text for argparse, which formats its lines of help, and not its descriptions."""
    return text.replace("%", "%%")


def _kind(annotation: Any) -> tuple[Any, bool]:
    """Type of a value, and whether there may be several."""
    parts = [each for each in get_args(annotation) if each is not NoneType]
    if NoneType in get_args(annotation):
        return _kind(parts[0])
    return (parts[0], True) if get_origin(annotation) is tuple else (annotation, False)


def head(*cells: str) -> None:
    """Print the head of a table."""
    print(f"\n| {' | '.join(cells)} |\n|{'---|' * len(cells)}", flush=True)


def row(*cells: object) -> None:
    """Print a row of a table."""
    print(f"| {' | '.join(map(str, cells))} |", flush=True)


def timed(call: Callable[[], Made]) -> tuple[Made, float, float]:
    """What a call gives, its time by the clock, and that of processors in this process [s]."""
    began, spent = time.perf_counter(), time.process_time()
    made = call()
    return made, time.perf_counter() - began, time.process_time() - spent


def times_s(call: Callable[[], object], runs: int) -> list[float]:
    """Times by the clock of some runs after one that warms up, sorted [s]."""
    call()
    return sorted(timed(call)[1] for _ in range(runs))


def alone(function: Callable[..., Made], *given: Any) -> Made:
    """What a function gives in a process of its own, which ends with it."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *given).result()


def kept(
    file: Path | None, key: dict[str, Any], make: Callable[[], dict[str, Any]]
) -> dict[str, Any]:
    """A row by its key: as the file of a study has it, or made, and added to it."""
    study = Study("bench", 1, row=lambda key, place: make())
    with Run(study, file) as running:
        ((_, made),) = running.rows([(key,)])
    return {**key, **made}
