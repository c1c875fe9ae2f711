"""The table `instances/best-known.csv`: the best plan and the best bound of each instance."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import adr_opt
from adr_opt import Certificate, Instance, Plan
from adr_opt.common.errors import InputError
from adr_opt.common.files import read_text, write_text
from adr_opt.common.tolerance import COST_RELATIVE, meets, tolerance
from adr_opt.mission.problem import Routes
from adr_opt.plan.plan import InstanceReference, relative_gap
from adr_opt.run.side_by_side import BOUND_NOTE
from adr_opt.sources.library import Library, load_library

FOLDER = Path(__file__).resolve().parents[2] / "instances"
WHO = "the adr-opt developers"


class Refused(Exception):
    """A claim that contradicts the rules or what is known; the row stays as it was."""


@dataclass(frozen=True)
class Row:
    """A row of the table; the names are its columns, empty where nothing is known.

    `gap` is (upper bound − objective) / upper bound; `order` the bodies of the plan by number, the
    station 0, joined with hyphens (an empty route is a hyphen), of several chasers a route each,
    joined with slashes; `plan` and `certificate` the files of the plan and of the proof, if there
    are such files, relative to the table; `date` (UTC), `who` and `versions` are those of the last
    improvement.
    """

    instance: str
    sha256: str
    objective: float = -math.inf
    delta_v_m_s: float = math.inf
    upper_bound: float = math.inf
    gap: float = math.inf
    plan: str = ""
    certificate: str = ""
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
    """A plan, a bound or both, that may be better than what is known.

    A `certificate` proves the bound: it has been verified.
    """

    instance: Instance
    plan: Plan | None
    upper_bound: float
    bound_method: str
    versions: Mapping[str, str]
    certificate: Certificate | None = None
    who: str = WHO


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
        cheaper = abs(
            plan.objective - row.objective
        ) <= slack and plan.delta_v_m_s < row.delta_v_m_s * (1.0 - COST_RELATIVE)
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
        improved = replace(
            improved,
            upper_bound=claim.upper_bound,
            bound_method=claim.bound_method,
            certificate="",  # the one that there was proves a weaker bound
        )
    slack = tolerance(claim.upper_bound)
    proves = claim.certificate is not None and claim.upper_bound <= improved.upper_bound + slack
    if proves and not improved.certificate:
        said.append("certificate")
        improved = replace(improved, certificate=f"certificates/{name}.json.gz")
    if not said:
        return f"{name}: not better ({_known(row)})"

    if improved.order and math.isfinite(improved.upper_bound):
        # Rounding may leave the bound a hair below the objective.
        upper_bound = float(max(improved.upper_bound, improved.objective))
        gap = relative_gap(improved.objective, upper_bound)
        improved = replace(improved, upper_bound=upper_bound, gap=gap)
    improved = replace(
        improved,
        who=claim.who,
        date=datetime.now(UTC).date().isoformat(),
        versions="; ".join(f"{package} {number}" for package, number in claim.versions.items()),
    )
    if improved.plan:
        if plan is None:
            plan = adr_opt.load_plan(folder / improved.plan)
        # The plan first: an interruption in between leaves a table that claims too little.
        (folder / "best-known").mkdir(exist_ok=True)
        with_bound(claim.instance, plan, improved).save(folder / improved.plan)
    if claim.certificate is not None and improved.certificate != row.certificate:
        (folder / "certificates").mkdir(exist_ok=True)
        # Which plan it was written beside does not matter: it proves a bound of all.
        claim.certificate.replace(plan_sha256=None).save(folder / improved.certificate)
    write_table(folder, {**rows, name: improved})
    if row.certificate and not improved.certificate:
        (folder / row.certificate).unlink(missing_ok=True)
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


def with_bound(instance: Instance, plan: Plan, row: Row) -> Plan:
    """The plan with the bound of its row."""
    notes = [note for note in plan.notes if not note.startswith(BOUND_NOTE)]
    if not math.isfinite(row.upper_bound):
        return plan.replace(notes=tuple(notes), upper_bound=None, gap=None, status="feasible")
    least = min(row.upper_bound, sum(target.prize for target in instance.targets))
    met = meets(plan.objective, least)
    return plan.replace(
        upper_bound=row.upper_bound,
        gap=row.gap,
        status="optimal" if met else "feasible",
        notes=(*notes, f"{BOUND_NOTE}{row.bound_method}"),
    )


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
