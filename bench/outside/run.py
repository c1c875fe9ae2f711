"""Known results of others' benchmarks, and those of our planners.

    python bench/outside/run.py gtoc9 --data DIR
    python bench/outside/run.py gtoc9-instance gtoc9.json --data DIR
    python bench/outside/run.py gtoc9-flown bench/outside/gtoc9/flown.json --data DIR
    python bench/outside/run.py optw --data DIR
    python bench/outside/run.py odrc --data DIR
    python bench/outside/run.py tdtsptw --data DIR --limit 900 --cells FILE

DIR is the folder of all data, or that of the benchmark; without --data, what ADR_OPT_EXTERNAL_DATA
names. Published solutions are scored again. Every row is printed as soon as it is known.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

# This script lies in the package that it runs.
sys.path.insert(0, str(Path(__file__).parents[1]))

from tables import experiment

from adr_opt.common.errors import InputError
from outside.gtoc9 import known as of_gtoc9
from outside.odrc import ours as of_odrc
from outside.optw import ours as of_optw
from outside.tdtsptw import ours as of_tdtsptw


def folder_of(name: str, data: Path | None) -> Path:
    """The folder of a benchmark: within that of all data, or itself.

    Raises
    ------
    InputError
        There is no such folder.
    """
    given = data or Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ""))
    if given == Path() or not given.is_dir():
        raise InputError(f"--data {given}: no such folder; name that of the data")
    return given / name if (given / name).is_dir() else given


def gtoc9(data: Path | None = None) -> None:
    """The winner's campaign of GTOC9 as flown and estimated, and ours."""
    of_gtoc9.report(folder_of("gtoc9", data))


def gtoc9_instance(file: Path, data: Path | None = None, step: float = 0.1) -> None:
    """Write the contest as an instance, connections on a grid of so many days."""
    of_gtoc9.write_instance(folder_of("gtoc9", data), file, step)


def gtoc9_flown(file: Path, data: Path | None = None) -> None:
    """A campaign with its impulses flown once more by the contest's equations, and scored."""
    of_gtoc9.judge(folder_of("gtoc9", data), file)


def optw(data: Path | None = None, limit: float = 120.0) -> None:
    """Orienteering with time windows: optima of CPLEX, and our plans and proofs."""
    of_optw.report(folder_of("optw", data), limit)


def odrc(data: Path | None = None, limit: float = 60.0) -> None:
    """Removal of 13 debris with low thrust: the published plan and ours on a grid."""
    of_odrc.report(folder_of("mcrdv", data), limit)


def tdtsptw(
    data: Path | None = None,
    limit: float = 300.0,
    cells: Path | None = None,
    draw: int | None = None,
) -> None:
    """Time-dependent tours with windows: known ends, our tours and bounds.

    Rows are kept in ``--cells``, and not worked out again. ``--draw N``: of the largest instances N
    with a known end and N without, instead of all.
    """
    of_tdtsptw.report(folder_of("tdtsptw", data), limit, cells, draw)


if __name__ == "__main__":
    sys.exit(experiment(__doc__, gtoc9, gtoc9_instance, gtoc9_flown, optw, odrc, tdtsptw))
