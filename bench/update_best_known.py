"""Keep `instances/best-known.csv`: the best plan and the best bound of each instance.

    python bench/update_best_known.py --time-limit 60 instances/nominal/*.json
    python bench/update_best_known.py --time-limit 10 --family cloud --family large --missing
    python bench/update_best_known.py --time-limit 60 --bound none --family campaign --missing
    python bench/update_best_known.py nominal-042 plan.json bound.json
    python bench/update_best_known.py --plan nominal-042 --out plan.json

An instance, given as a file, by its name in the library or with its family, is solved with a
planner and a bound side by side, or by a planner that proves by itself (`--method exact --bound
none`, as for several chasers); a plan file, or what `bound --json` printed, is taken as it is. A
row changes only for the better: a plan that collects more (or as much with less ΔV) and that
`check` finds nothing wrong with, a bound that is lower. Each row is written when it is found;
`--missing` leaves out the instances that have a plan and a bound already, so that an interrupted
run goes on where it was.

A row holds its plan as the order of the bodies, from which `--plan` makes the plan file again. The
plans of instances that are committed as files are also kept whole in `instances/best-known/`, each
with the best bound of its row.

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
from adr_opt import Instance, Plan
from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable, parse_model, read_text, write_text
from adr_opt.common.tolerance import COST_RELATIVE, meets, tolerance
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.problem import Routes, problem_of
from adr_opt.mission.result import versions
from adr_opt.plan.plan import InstanceReference, relative_gap
from adr_opt.run import front
from adr_opt.run.methods import PLANNERS
from adr_opt.run.side_by_side import BOUND_NOTE, InvalidBound
from adr_opt.sources.library import Library, load_library

FOLDER = Path(__file__).resolve().parents[1] / "instances"
WHO = "the adr-opt developers"
ALONE = "none"
"""Stands for no bound beside the planner, whose own one counts."""

PLAN_FORMATS = "adr-opt-plan/"
"""Begins the format of plan files, of this one and of former ones."""


class Refused(Exception):
    """A claim that contradicts the rules or what is known; the row stays as it was."""


@dataclass(frozen=True)
class Row:
    """A row of the table; the names are its columns, empty where nothing is known.

    `gap` is (upper bound − objective) / upper bound; `order` the bodies of the plan by number, the
    station 0, joined with hyphens (an empty route is a hyphen), of several chasers a route each,
    joined with slashes; `plan` the plan file, if there is one, relative to the table; `date` (UTC),
    `who` and `versions` are those of the last improvement.
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
    order: str = ""

    @property
    def routes(self) -> Routes:
        """The bodies of the plan in order for each chaser, the station 0."""
        return tuple(
            tuple(int(body) for body in route.split("-") if body) for route in self.order.split("/")
        )


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


def order_of(instance: Instance, plan: Plan) -> str:
    """The destinations of a plan as a row has them."""
    index = {name: number for number, name in enumerate(instance.names)}
    flown = {route.chaser: route.legs for route in plan.routes}
    routes = [flown.get(chaser.name, ()) for chaser in instance.chasers]
    return "/".join("-".join(str(index[leg.destination]) for leg in legs) or "-" for legs in routes)


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
        slack = tolerance(plan.objective)
        more = plan.objective > row.objective + slack
        cheaper = (
            abs(plan.objective - row.objective) <= slack
            and plan.delta_v_m_s < row.delta_v_m_s * (1.0 - COST_RELATIVE)
        )  # fmt: skip
        if more or cheaper:
            said.append(f"plan {plan.objective:g} with {plan.delta_v_m_s:.1f} m/s by {plan.method}")
            improved = replace(
                improved,
                objective=plan.objective,
                delta_v_m_s=plan.delta_v_m_s,
                plan=f"best-known/{name}.json" if file_of(folder, name) else "",
                planner_method=plan.method,
                order=order_of(claim.instance, plan),
            )
        else:
            plan = None
    if math.isnan(claim.upper_bound):
        raise Refused(f"{name}: the bound is not a number")
    _refuse_contradiction(name, claim, improved)
    if claim.upper_bound < row.upper_bound - tolerance(claim.upper_bound):
        said.append(f"bound {claim.upper_bound:g} by {claim.bound_method}")
        improved = replace(improved, upper_bound=claim.upper_bound, bound_method=claim.bound_method)
    if not said:
        return f"{name}: not better ({_known(row)})"

    if improved.order and math.isfinite(improved.upper_bound):
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
    plan = f"objective {row.objective:g}" if row.order else "no plan"
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
    """Refuse a bound below a legal plan: one of them is wrong, which needs a person to look."""
    bounds = ((claim.upper_bound, claim.bound_method), (row.upper_bound, row.bound_method))
    for bound, method in bounds:
        if bound < row.objective - tolerance(row.objective):
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
    met = meets(plan.objective, least)
    return plan.replace(
        upper_bound=row.upper_bound,
        gap=row.gap,
        status="optimal" if met else "feasible",
        notes=(*notes, f"{BOUND_NOTE}{row.bound_method}"),
    )


# --- where claims come from ---------------------------------------------------------------------


def library_of(folder: Path) -> Library:
    """The library in a folder; an empty one if there is none."""
    path = folder / "library.json"
    return load_library(path) if path.exists() else Library(version="0.0", instances=())


def file_of(folder: Path, name: str) -> Path | None:
    """The committed file of an instance, if there is one."""
    # A name is text from a file: it may hold anything, and must not lead out of the folder.
    paths = [path for path in sorted(folder.glob("*/*.json")) if path.stem == name]
    return next((path for path in paths if path.parent.name != "best-known"), None)


def known_instance(folder: Path, name: str) -> Instance:
    """The instance of a name: its committed file, or generated as the library lists it.

    Raises
    ------
    InputError
        There is none, or the generator gives another.
    """
    path = file_of(folder, name)
    if path is not None:
        return adr_opt.load(path)
    entry = library_of(folder).find(name)
    if entry is None:
        raise InputError(
            f"instance {name!r}: not in a folder of {folder}, nor in its library; "
            "commit it there first"
        )
    return entry.generate()


def committed(folder: Path, name: str, sha256: str) -> Instance:
    """The instance of a name, if its content is the one expected.

    Raises
    ------
    InputError
        There is none, or its content is another.
    """
    instance = known_instance(folder, name)
    if not InstanceReference(name=name, sha256=sha256).is_of(instance):
        where = file_of(folder, name) or "the library"
        raise InputError(
            f"instance {name!r}: sha256 {sha256[:12]}… is not that of {where} "
            f"({instance.sha256[:12]}…); give what was made for the committed one"
        )
    return instance


def claim_of(given: str, arguments: argparse.Namespace) -> Claim:
    """The claim of a file; an instance, given as a file or by name, is solved.

    Raises
    ------
    InputError
        The file is none of the three kinds, or not for a committed instance.
    """
    path = Path(given)
    if not path.exists() and library_of(arguments.folder).find(given) is not None:
        return solved(known_instance(arguments.folder, given), arguments)
    text = read_text(path)
    try:
        content = json.loads(text)
        kind = str(content.get("format", ""))
    except (ValueError, AttributeError):
        raise InputError(f"{path}: not a JSON object; give a JSON file") from None
    if kind.startswith(PLAN_FORMATS):
        plan = parse_model(text, Plan, str(path))
        instance = committed(arguments.folder, plan.instance.name, plan.instance.sha256)
        by = [note.removeprefix(BOUND_NOTE) for note in plan.notes if note.startswith(BOUND_NOTE)]
        bound = math.inf if plan.upper_bound is None else plan.upper_bound
        # A plan of a former format names the file that its instance was then.
        plan = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
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
    return solved(instance, arguments)


def solved(instance: Instance, arguments: argparse.Namespace) -> Claim:
    """Result of planner and bound side by side, or of a planner that proves by itself."""
    alone = arguments.bound == ALONE
    result = front.run(
        PLANNERS,
        instance,
        arguments.method,
        front.RunOptions(
            arguments.time_limit, arguments.seed, bound=None if alone else arguments.bound
        ),
    )
    by = arguments.method if alone else arguments.bound
    return Claim(instance, result.plan, result.upper_bound, by, versions())


def write_plan(folder: Path, name: str, out: Path) -> None:
    """Make the plan file of a row again, with its bound.

    Raises
    ------
    InputError
        The table has no plan of that name, or the file cannot be written.
    """
    check_writable(out)
    row = read_table(folder).get(name)
    if row is None or not row.order:
        raise InputError(f"instance {name!r}: the table has no plan of it; solve it first")
    instance = committed(folder, name, row.sha256)
    problem = problem_of(instance)
    plan = certify_routes(problem, row.planner_method, row.routes, seed=0, runtime_s=0.0).plan
    assert plan is not None
    _with_bound(instance, plan, row).save(out)


def is_known(row: Row | None) -> bool:
    """Whether a row has a plan and a bound."""
    return row is not None and bool(row.order) and math.isfinite(row.upper_bound)


def inputs(arguments: argparse.Namespace) -> list[str]:
    """Files and names to go through: those given, then the families.

    Raises
    ------
    InputError
        A family is not in the library, or the table cannot be read.
    """
    given = list(arguments.inputs)
    if arguments.family:
        library = library_of(arguments.folder)
        for name in arguments.family:
            entries = library.of_family(name)
            if not entries:
                known = ", ".join(dict.fromkeys(entry.family for entry in library.instances))
                raise InputError(
                    f"family {name!r} is not in the library; use one of {known or '(none)'}"
                )
            given += [entry.name for entry in entries]
    if arguments.missing:
        rows = read_table(arguments.folder)
        given = [each for each in given if not is_known(rows.get(Path(each).stem))]
    return given


def main(argv: Sequence[str] | None = None) -> int:
    """Go through the inputs and return the exit status: a refusal counts more than a wrong file."""
    parser = argparse.ArgumentParser(
        description="Update instances/best-known.csv, only for the better."
    )
    parser.add_argument(
        "inputs", nargs="*", metavar="FILE|NAME",
        help="instance (it is solved), plan, or what 'bound --json' printed; or a library name",
    )  # fmt: skip
    parser.add_argument("--family", action="append", metavar="NAME", help="all of it, repeatable")
    parser.add_argument("--missing", action="store_true", help="skip what has plan and bound")
    parser.add_argument("--time-limit", type=float, default=60.0, metavar="S", help="per instance")
    parser.add_argument("--method", default="auto", help="planner for instances")
    parser.add_argument(
        "--bound", default="lagrangian", help="bound beside it; none: the planner's own"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=FOLDER, help="folder of the table")
    parser.add_argument("--plan", metavar="NAME", help="write the best-known plan to --out instead")
    parser.add_argument("--out", type=Path, metavar="FILE", help="plan file for --plan")
    arguments = parser.parse_args(argv)
    if (arguments.plan is None) != (arguments.out is None):
        parser.error("--plan and --out go together; give both")
    if not (arguments.inputs or arguments.family or arguments.plan):
        parser.error("nothing to do; name files, instances or a --family")
    try:
        if arguments.plan is not None:
            write_plan(arguments.folder, arguments.plan, arguments.out)
        given = inputs(arguments)
    except InputError as error:
        print(f"wrong: {error}", file=sys.stderr)
        return 2
    seen = set()
    for number, each in enumerate(given, start=1):
        # A file that fails does not keep the others back.
        try:
            said = update(arguments.folder, claim_of(each, arguments))
            print(f"[{number}/{len(given)}] {said}", flush=True)
        except InputError as error:
            print(f"wrong: {error}", file=sys.stderr)
            seen.add(2)
        except (Refused, InvalidBound) as error:
            print(f"refused: {each}: {error}", file=sys.stderr)
            seen.add(1)
    return min(seen, default=0)


if __name__ == "__main__":
    sys.exit(main())
