"""What is known of a benchmark that others made, and what our planners make of it.

    python bench/outside/run.py gtoc9 --data DIR
    python bench/outside/run.py optw --data DIR
    python bench/outside/run.py kttsp --data DIR --solution FILE
    python bench/outside/run.py odrc --data DIR

DIR is the folder of all data, or that of the benchmark; without --data, what ADR_OPT_EXTERNAL_DATA
names. Published solutions are scored again. Exit status 0: done; 2: the call or a file is wrong, in
one sentence.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

# This script lies in the package that it runs.
sys.path.insert(0, str(Path(__file__).parents[1]))

from machine import heading

from adr_opt.errors import InputError
from outside.gtoc9 import known as of_gtoc9
from outside.kttsp import known as of_kttsp
from outside.odrc import known as of_odrc
from outside.optw import known as of_optw

FOLDERS = {"gtoc9": "gtoc9", "optw": "optw", "kttsp": "kttsp", "odrc": "mcrdv"}
"""Where the data of each lie in the folder of all."""


def folder_of(name: str, data: Path) -> Path:
    """The folder of a benchmark."""
    if not data.is_dir():
        raise InputError(f"--data {data}: no such folder; name that of the data")
    inner = data / FOLDERS[name]
    return inner if inner.is_dir() else data


def report(name: str, folder: Path, solution: Path | None) -> str:
    """What is known of a benchmark, in Markdown."""
    if name == "kttsp":
        return of_kttsp.report(folder, solution)
    if solution is not None:
        raise InputError(f"--solution {solution}: only solutions of kttsp can be scored so far")
    return {"gtoc9": of_gtoc9, "optw": of_optw, "odrc": of_odrc}[name].report(folder)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", choices=list(FOLDERS))
    given = os.environ.get("ADR_OPT_EXTERNAL_DATA")
    parser.add_argument("--data", type=Path, default=Path(given) if given else None)
    parser.add_argument("--solution", type=Path, help="of kttsp, as it is submitted")
    parsed = parser.parse_args(arguments)
    try:
        if parsed.data is None:
            raise InputError("--data: no folder given; name that of the data")
        text = report(parsed.name, folder_of(parsed.name, parsed.data), parsed.solution)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(heading())
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
