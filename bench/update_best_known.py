"""Keep `instances/best-known.csv`: the best plan and the best bound of each committed instance.

    python bench/update_best_known.py --time-limit 60 instances/nominal/*.json
    python bench/update_best_known.py plan.json bound.json

An instance file is solved with a planner and a bound side by side; a plan file, or what
`bound --json` printed, is taken as it is. A row changes only for the better: a plan that collects
more (or as much with less ΔV) and that `check` finds nothing wrong with, a bound that is lower.
The plans are kept in `instances/best-known/`, each with the best bound of its row.

Exit status 0: done, whether or not anything improved; 1: something was refused, an illegal plan
or a bound below a legal plan, and its row is as it was; else 2 if some input is wrong.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import adr_opt
from adr_opt import Instance, Plan, front
from adr_opt.errors import InputError
from adr_opt.files import parse_model, read_text, write_text
from adr_opt.plan import FORMAT as PLAN_FORMAT
from adr_opt.plan import relative_gap
from adr_opt.planner import PLANNERS
from adr_opt.result import versions
from adr_opt.together import BOUND_NOTE, InvalidBound

FOLDER = Path(__file__).resolve().parents[1] / "instances"
WHO = "the adr-opt developers"
TOLERANCE = 1e-6
"""Relative difference of objectives and bounds, and of ΔV, that is no improvement."""


class Refused(Exception):
    """A claim that contradicts the rules or what is known; the row stays as it was."""


@dataclass(frozen=True)
class Row:
    """A row of the table; the names are its columns, empty where nothing is known.

    `gap` is (upper bound − objective) / upper bound, `plan` the plan file relative to the table,
    `date` (UTC), `who` and `versions` are those of the last improvement.
    """

    instance: str
    sha256: str
    objective: float = -math.inf
    delta_v_m_s: float = math.inf
    upper_bound: float = math.inf
    gap: float = math.inf
    plan: str = ""
    planner_method: str = ""
    bound_method: str = ""
    who: str = ""
    date: str = ""
    versions: str = ""


COLUMNS = [field.name for field in fields(Row)]
NUMBERS = {
    "objective": -math.inf,
    "delta_v_m_s": math.inf,
    "upper_bound": math.inf,
    "gap": math.inf,
}


@dataclass(frozen=True)
class Claim:
    """A plan, a bound or both, that may be better than what is known."""

    instance: Instance
    plan: Plan | None
    upper_bound: float
    bound_method: str
    versions: Mapping[str, str]


# --- the table ----------------------------------------------------------------------------------


def read_table(folder: Path) -> dict[str, Row]:
    """The rows by instance; none if there is no table yet.

    Raises
    ------
    InputError
        The file is not such a table.
    """
    path = folder / "best-known.csv"
    if not path.exists():
        return {}
    reader = csv.DictReader(io.StringIO(read_text(path)))
    if reader.fieldnames != COLUMNS:
        raise InputError(f"{path}: the columns must be {', '.join(COLUMNS)}; correct the header")
    rows = {}
    for line in reader:
        if None in line or None in line.values():
            raise InputError(f"{path}: line {reader.line_num} has not {len(COLUMNS)} columns")
        values: dict[str, Any] = dict(line)
        for column, nothing in NUMBERS.items():
            try:
                values[column] = float(line[column]) if line[column] else nothing
            except ValueError:
                raise InputError(
                    f"{path}: line {reader.line_num}: {column} = {line[column]!r} is not a number"
                ) from None
        rows[line["instance"]] = Row(**values)
    return rows


def write_table(folder: Path, rows: Mapping[str, Row]) -> None:
    """Write the rows in the order of the instances' names, whole or not at all."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for name in sorted(rows):
        values: dict[str, Any] = asdict(rows[name])
        for column in NUMBERS:
            values[column] = repr(values[column]) if math.isfinite(values[column]) else ""
        writer.writerow(values)
    write_text(folder / "best-known.csv", text.getvalue())


def update(folder: Path, claim: Claim) -> str:
    """Improve a row by a claim, if the claim is better.

    Returns
    -------
    str
        What became of it, in words.

    Raises
    ------
    Refused
        The plan is illegal, or a bound is below a legal plan.
    """
    rows = read_table(folder)
    name, sha256 = claim.instance.name, claim.instance.sha256
    row = rows.get(name, Row(name, sha256))
    if row.sha256 != sha256:
        raise Refused(
            f"{name}: its row is for another version of the instance (sha256 {row.sha256[:12]}…); "
            "remove the row and its plan"
        )
    improved, said = row, []
    plan = claim.plan
    if plan is not None:
        _refuse_illegal(claim.instance, plan)
        slack = TOLERANCE * max(1.0, abs(plan.objective))
        more = plan.objective > row.objective + slack
        cheaper = (
            abs(plan.objective - row.objective) <= slack
            and plan.delta_v_m_s < row.delta_v_m_s * (1.0 - TOLERANCE)
        )  # fmt: skip
        if more or cheaper:
            said.append(f"plan {plan.objective:g} with {plan.delta_v_m_s:.1f} m/s by {plan.method}")
            improved = replace(
                improved,
                objective=plan.objective,
                delta_v_m_s=plan.delta_v_m_s,
                plan=f"best-known/{name}.json",
                planner_method=plan.method,
            )
        else:
            plan = None
    if math.isnan(claim.upper_bound):
        raise Refused(f"{name}: the bound is not a number")
    _refuse_contradiction(name, claim, improved)
    if claim.upper_bound < row.upper_bound - TOLERANCE * max(1.0, abs(claim.upper_bound)):
        said.append(f"bound {claim.upper_bound:g} by {claim.bound_method}")
        improved = replace(improved, upper_bound=claim.upper_bound, bound_method=claim.bound_method)
    if not said:
        return f"{name}: not better ({_known(row)})"

    if improved.plan and math.isfinite(improved.upper_bound):
        # Rounding may leave the bound a hair below the objective.
        upper_bound = float(max(improved.upper_bound, improved.objective))
        gap = relative_gap(improved.objective, upper_bound)
        improved = replace(improved, upper_bound=upper_bound, gap=gap)
    improved = replace(
        improved,
        who=WHO,
        date=datetime.now(UTC).date().isoformat(),
        versions="; ".join(f"{package} {number}" for package, number in claim.versions.items()),
    )
    if improved.plan:
        if plan is None:
            plan = adr_opt.load_plan(folder / improved.plan)
        # The plan first: an interruption in between leaves a table that claims too little.
        (folder / "best-known").mkdir(exist_ok=True)
        _with_bound(claim.instance, plan, improved).save(folder / improved.plan)
    write_table(folder, {**rows, name: improved})
    return f"{name}: {' and '.join(said)} ({_known(improved)})"


def _known(row: Row) -> str:
    plan = f"objective {row.objective:g}" if row.plan else "no plan"
    bound = f"bound {row.upper_bound:g}" if math.isfinite(row.upper_bound) else "no bound"
    gap = f", gap {row.gap:.2%}" if math.isfinite(row.gap) else ""
    return f"{plan}, {bound}{gap}"


def _refuse_illegal(instance: Instance, plan: Plan) -> None:
    try:
        violations = adr_opt.check(instance, plan)
    except InputError as error:
        raise Refused(str(error)) from None
    if violations:
        listed = "\n  ".join(str(violation) for violation in violations)
        raise Refused(f"{instance.name}: the plan by {plan.method} is illegal:\n  {listed}")


def _refuse_contradiction(name: str, claim: Claim, row: Row) -> None:
    """Refuse a bound below a legal plan: one of the two is wrong, and somebody has to look."""
    bounds = ((claim.upper_bound, claim.bound_method), (row.upper_bound, row.bound_method))
    for bound, method in bounds:
        if bound < row.objective - TOLERANCE * max(1.0, abs(row.objective)):
            raise Refused(
                f"{name}: ALARM: the bound {bound!r} by {method} is below the legal plan of "
                f"objective {row.objective!r} by {row.planner_method}; one of them is wrong"
            )


def _with_bound(instance: Instance, plan: Plan, row: Row) -> Plan:
    """The plan with the bound of its row."""
    notes = [note for note in plan.notes if not note.startswith(BOUND_NOTE)]
    if not math.isfinite(row.upper_bound):
        return plan.replace(notes=tuple(notes), upper_bound=None, gap=None)
    least = min(row.upper_bound, sum(target.prize for target in instance.targets))
    met = plan.objective >= least - TOLERANCE * max(1.0, abs(least))
    return plan.replace(
        upper_bound=row.upper_bound,
        gap=row.gap,
        status="optimal" if met else "feasible",
        notes=(*notes, f"{BOUND_NOTE}{row.bound_method}"),
    )


# --- where claims come from ---------------------------------------------------------------------


def committed(folder: Path, name: str, sha256: str) -> Instance:
    """The committed instance of a name.

    Raises
    ------
    InputError
        There is none, or its content is another.
    """
    for path in sorted(folder.glob(f"*/{name}.json")):
        if path.parent.name == "best-known":
            continue
        instance = adr_opt.load(path)
        if instance.sha256 != sha256:
            raise InputError(
                f"instance {name!r}: sha256 {sha256[:12]}… is not that of {path} "
                f"({instance.sha256[:12]}…); give what was made for the committed file"
            )
        return instance
    raise InputError(f"instance {name!r}: not in a folder of {folder}; commit it there first")


def claim_of(path: Path, arguments: argparse.Namespace) -> Claim:
    """What a file claims; an instance is solved.

    Raises
    ------
    InputError
        The file is none of the three kinds, or not for a committed instance.
    """
    text = read_text(path)
    try:
        content = json.loads(text)
        kind = str(content.get("format", ""))
    except (ValueError, AttributeError):
        raise InputError(f"{path}: not a JSON object; give a JSON file") from None
    if kind == PLAN_FORMAT:
        plan = parse_model(text, Plan, str(path))
        instance = committed(arguments.folder, plan.instance.name, plan.instance.sha256)
        by = [note.removeprefix(BOUND_NOTE) for note in plan.notes if note.startswith(BOUND_NOTE)]
        bound = math.inf if plan.upper_bound is None else plan.upper_bound
        return Claim(instance, plan, bound, by[0] if by else plan.method, plan.versions)
    if not kind and {"upper_bound", "instance", "method"} <= set(content):
        try:
            reference = content["instance"]
            instance = committed(arguments.folder, str(reference["name"]), str(reference["sha256"]))
            bound = math.inf if content["upper_bound"] is None else float(content["upper_bound"])
            made = {str(k): str(v) for k, v in dict(content.get("versions", {})).items()}
        except (TypeError, KeyError, ValueError):
            raise InputError(f"{path}: not what 'bound --json' prints; print it anew") from None
        return Claim(instance, None, bound, str(content["method"]), made)

    instance = parse_model(text, Instance, str(path))
    committed(arguments.folder, instance.name, instance.sha256)
    result = front.run(
        PLANNERS,
        instance,
        arguments.method,
        bound=arguments.bound,
        time_limit=arguments.time_limit,
        seed=arguments.seed,
    )
    return Claim(instance, result.plan, result.upper_bound, arguments.bound, versions())


def main(argv: Sequence[str] | None = None) -> int:
    """Go through the files and return the exit status: a refusal counts more than a wrong file."""
    parser = argparse.ArgumentParser(
        description="Update instances/best-known.csv, only for the better."
    )
    parser.add_argument(
        "paths", nargs="+", type=Path, metavar="FILE",
        help="instance (it is solved), plan, or what 'bound --json' printed",
    )  # fmt: skip
    parser.add_argument("--time-limit", type=float, default=60.0, metavar="S", help="per instance")
    parser.add_argument("--method", default="auto", help="planner for instances")
    parser.add_argument("--bound", default="lagrangian", help="bound for instances")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="folder of the table")
    arguments = parser.parse_args(argv)
    seen = set()
    for path in arguments.paths:
        # A file that fails does not keep the others back.
        try:
            print(update(arguments.folder, claim_of(path, arguments)), flush=True)
        except InputError as error:
            print(f"wrong: {error}", file=sys.stderr)
            seen.add(2)
        except (Refused, InvalidBound) as error:
            print(f"refused: {path}: {error}", file=sys.stderr)
            seen.add(1)
    return min(seen, default=0)


if __name__ == "__main__":
    sys.exit(main())
