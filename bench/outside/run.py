"""Known results of others' benchmarks, and those of our planners.

    python bench/outside/run.py gtoc9 --data DIR
    python bench/outside/run.py gtoc9 --data DIR --write-instance FILE [--step DAYS]
    python bench/outside/run.py gtoc9 --data DIR --fly MISSION [--plan FILE]
    python bench/outside/run.py gtoc9 --data DIR --fly-all FILE [--plan FILE]
    python bench/outside/run.py gtoc9 --data DIR --flown FILE
    python bench/outside/run.py optw --data DIR
    python bench/outside/run.py odrc --data DIR
    python bench/outside/run.py tdtsptw --data DIR [--time-limit S --cells FILE]

DIR is the folder of all data, or that of the benchmark; without --data, what ADR_OPT_EXTERNAL_DATA
names. Published solutions are scored again. The time limit of tdtsptw is that of each instance; its
results are kept in --cells, and gone on with.
Every row is printed as soon as it is known, and with --out FILE it is there, too.
Exit status 0: done; 2: the call or a file is wrong, in one sentence, before any work starts; 130:
interrupted, what is printed is kept.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

# This script lies in the package that it runs.
sys.path.insert(0, str(Path(__file__).parents[1]))

from machine import heading

from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable
from outside.gtoc9 import known as of_gtoc9
from outside.odrc import known as of_odrc
from outside.optw import known as of_optw
from outside.tdtsptw import known as of_tdtsptw
from outside.telling import Doing, silent, tell

DONE, WRONG, INTERRUPTED = 0, 2, 130

FOLDERS = {"gtoc9": "gtoc9", "optw": "optw", "odrc": "mcrdv", "tdtsptw": "tdtsptw"}
"""Folders of the data within the common folder."""


def folder_of(name: str, data: Path) -> Path:
    """The folder of a benchmark."""
    if not data.is_dir():
        raise InputError(f"--data {data}: no such folder; name that of the data")
    inner = data / FOLDERS[name]
    return inner if inner.is_dir() else data


def of_gtoc9_report(folder: Path, parsed: argparse.Namespace, doing: Doing) -> Iterator[str]:
    """What is known of GTOC9 and made of it, or a flown mission, in Markdown."""
    if parsed.time_limit is not None:
        raise InputError("--time-limit: gtoc9 is planned by adr-opt solve; see --write-instance")
    if parsed.write_instance is not None:
        return of_gtoc9.written(folder, parsed.write_instance, parsed.step)
    if parsed.flown is not None:
        return of_gtoc9.judged_again(folder, parsed.flown, doing)
    if parsed.fly is not None or parsed.fly_all is not None:
        plan = parsed.plan or folder / of_gtoc9.campaign.FILE
        return of_gtoc9.flights(folder, plan, parsed.fly, parsed.fly_all, doing)
    return of_gtoc9.report(folder, doing=doing)


def report(
    name: str,
    folder: Path,
    time_limit_s: float | None = None,
    cells: Path | None = None,
    doing: Doing = silent,
    count: int | None = None,
) -> Iterator[str]:
    """What is known of a benchmark, in Markdown, line by line."""
    if time_limit_s is not None and not (name == "tdtsptw" and time_limit_s >= 0.0):
        raise InputError(f"--time-limit {time_limit_s:g}: only tdtsptw takes one, of 0 or more")
    if count is not None and not (name == "tdtsptw" and count > 0):
        raise InputError(f"--draw {count}: only instances of tdtsptw are drawn, one or more")
    if name == "tdtsptw":
        limit_s = of_tdtsptw.TIME_LIMIT_S if time_limit_s is None else time_limit_s
        return of_tdtsptw.report(folder, limit_s, cells, doing, count)
    if cells is not None:
        raise InputError(f"--cells {cells}: only tdtsptw keeps any")
    return {"gtoc9": of_gtoc9, "optw": of_optw, "odrc": of_odrc}[name].report(folder, doing=doing)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("name", choices=list(FOLDERS))
    given = os.environ.get("ADR_OPT_EXTERNAL_DATA")
    parser.add_argument("--data", type=Path, default=Path(given) if given else None)
    parser.add_argument(
        "--time-limit", type=float, metavar="SECONDS", help="of each instance of tdtsptw"
    )
    parser.add_argument("--cells", type=Path, metavar="FILE", help="of the results of tdtsptw")
    parser.add_argument(
        "--draw",
        type=int,
        metavar="N",
        help="of tdtsptw: N of the largest with a known end and N without, instead of all",
    )
    parser.add_argument("--fly", type=int, help="of gtoc9: fly this mission of a campaign, from 0")
    parser.add_argument(
        "--fly-all", type=Path, metavar="FILE", help="of gtoc9: fly a campaign, and write it there"
    )
    parser.add_argument(
        "--flown", type=Path, metavar="FILE", help="of gtoc9: score a campaign that was flown"
    )
    parser.add_argument(
        "--plan", type=Path, help="of gtoc9: a campaign, or a plan of solve; without, the winner's"
    )
    parser.add_argument(
        "--write-instance", type=Path, metavar="FILE", help="of gtoc9: write it as an instance"
    )
    parser.add_argument(
        "--step",
        type=float,
        default=0.1,
        metavar="DAYS",
        help="of gtoc9: grid of the connections of that instance [%(default)g d]",
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="keep there what is printed")
    parsed = parser.parse_args(arguments)
    try:
        if parsed.data is None:
            raise InputError("--data: no folder given; name that of the data")
        folder = folder_of(parsed.name, parsed.data)
        if parsed.out is not None:
            check_writable(parsed.out)

        def lines(doing: Doing) -> Iterator[str]:
            if parsed.name == "gtoc9" and parsed.cells is None:
                return of_gtoc9_report(folder, parsed, doing)
            return report(parsed.name, folder, parsed.time_limit, parsed.cells, doing, parsed.draw)

        tell(lines, heading(), parsed.out)
    except InputError as error:
        print(error, file=sys.stderr)
        return WRONG
    except KeyboardInterrupt:
        kept = "" if parsed.out is None else f" and kept in {parsed.out}"
        print(f"interrupted: what was done is printed{kept}", file=sys.stderr, flush=True)
        os._exit(INTERRUPTED)  # what was being done goes on in its threads
    return DONE


if __name__ == "__main__":
    sys.exit(main())
