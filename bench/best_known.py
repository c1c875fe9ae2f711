"""Keep and verify `instances/best-known.csv`: the best plan and the best bound of each instance.

    python bench/best_known.py verify                      # every row
    python bench/best_known.py verify tiny nominal-042     # a family, an instance
    python bench/best_known.py summary electric            # means of a family
    python bench/best_known.py add plan.json proof.json --who "Ada Lovelace"
    python bench/best_known.py plan nominal-042 --out plan.json
    python bench/best_known.py certify tiny reduced-fuel-000 --time-limit 60
    python bench/best_known.py solve --time-limit 60 instances/nominal/*.json
    python bench/best_known.py solve --time-limit 60 --bound none --family campaign --missing

`verify` makes each instance, makes the plan of its row again, passes it through `check`, compares
objective and ΔV, and has `adr_opt.verify` recompute the bound where its certificate is kept.
`summary` prints means of each family, and how many rows are proven.

`add` takes plans, certificates, and what `bound --json` printed. `solve` takes instances, given as
files, by their names in the library or with their family, and runs a planner and a bound side by
side on each, or a planner that proves by itself (`--method exact --bound none`, as for several
chasers). `certify` proves the bounds of rows again and keeps their certificates.

A row changes only for the better: a plan that collects more (or as much with less ΔV) and that
`check` finds nothing wrong with, a bound that is lower, a certificate where there was none. What
others bring (`--who`) counts as a bound with a certificate only. Each row is written when it is
found; `--missing` leaves out the instances that have a plan and a bound already, so that an
interrupted run goes on where it was.

A row holds its plan as the order of the bodies, from which `plan` makes the plan file again. The
plans of instances that are committed as files are also kept whole in `instances/best-known/`, each
with the best bound of its row, and certificates in `instances/certificates/`.

Exit status 0: done, whether or not anything improved; 1: something was refused, an illegal plan
or a bound below a legal plan, and its row is as it was, or a row is wrong; else 2 if some input is
wrong.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from harness.best_known_table import (
    COLUMNS,
    FOLDER,
    WHO,
    Claim,
    Refused,
    Row,
    committed,
    file_of,
    known_instance,
    library_of,
    order_of,
    read_table,
    update,
    with_bound,
    write_table,
)

import adr_opt
from adr_opt import Certificate, Instance, Plan
from adr_opt.common.errors import InputError
from adr_opt.common.files import check_writable, parse_model, read_text
from adr_opt.common.tolerance import tolerance
from adr_opt.legs.nearest_pairs import neighbours
from adr_opt.mission.certified import certify_routes
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.problem import problem_of
from adr_opt.mission.result import versions
from adr_opt.plan.plan import relative_gap
from adr_opt.run import front
from adr_opt.run.methods import BOUNDS, PLANNERS, names, spec
from adr_opt.run.side_by_side import BOUND_NOTE, InvalidBound
from adr_opt.sources.generator import family_of

__all__ = ["COLUMNS", "file_of", "main", "order_of", "read_table", "write_table"]

ALONE = "none"
"""Stands for no bound beside the planner, whose own one counts."""

PLAN_FORMATS = "adr-opt-plan/"
"""Begins the format of plan files, of this one and of former ones."""

CERTIFICATE_FORMATS = "adr-opt-certificate/"

ROUNDING = 1e-9
"""Share of its ΔV by which a plan may differ that was made on another machine."""


# --- claims -------------------------------------------------------------------------------------


def claimed(arguments: argparse.Namespace) -> Iterator[tuple[str, Callable[[], Claim]]]:
    """What the files of `add` claim, each with its name."""
    for given in arguments.inputs:
        yield given, lambda given=given: claim_of(Path(given), arguments.folder, arguments.who)


def claim_of(path: Path, folder: Path, who: str) -> Claim:
    """What a file claims.

    Raises
    ------
    InputError
        The file is none of the three kinds, or not for a committed instance.
    Refused
        It is a certificate that is not verified.
    """
    if path.suffix == ".gz":
        return proven(adr_opt.load_certificate(path), folder, who)
    text = read_text(path)
    try:
        content = json.loads(text)
        kind = str(content.get("format", ""))
    except (ValueError, AttributeError):
        raise InputError(f"{path}: not a JSON object; give a JSON file") from None
    if kind.startswith(CERTIFICATE_FORMATS):
        return proven(parse_model(text, Certificate, str(path)), folder, who)
    if kind.startswith(PLAN_FORMATS):
        plan = parse_model(text, Plan, str(path))
        instance = committed(folder, plan.instance.name, plan.instance.sha256)
        by = [note.removeprefix(BOUND_NOTE) for note in plan.notes if note.startswith(BOUND_NOTE)]
        stated = plan.upper_bound if who == WHO else None
        bound = math.inf if stated is None else stated
        # A plan of a former format names the file that its instance was then.
        plan = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
        return Claim(instance, plan, bound, by[0] if by else plan.method, plan.versions, who=who)
    if kind or not {"upper_bound", "instance", "method"} <= set(content):
        raise InputError(
            f"{path}: neither a plan, nor a certificate, nor what 'bound --json' prints; instances "
            "are for 'solve'"
        )
    if who != WHO:
        raise InputError(f"{path}: a bound of others counts with its certificate; give that")
    try:
        reference = content["instance"]
        instance = committed(folder, str(reference["name"]), str(reference["sha256"]))
        bound = math.inf if content["upper_bound"] is None else float(content["upper_bound"])
        made = {str(k): str(v) for k, v in dict(content.get("versions", {})).items()}
    except (TypeError, KeyError, ValueError):
        raise InputError(f"{path}: not what 'bound --json' prints; print it anew") from None
    return Claim(instance, None, bound, str(content["method"]), made)


def proven(certificate: Certificate, folder: Path, who: str) -> Claim:
    """What a certificate proves, recomputed.

    Raises
    ------
    InputError
        It is not for a committed instance.
    Refused
        It is not verified, or proves that there is no plan.
    """
    reference = certificate.instance
    instance = committed(folder, reference.name, reference.sha256)
    verdict = adr_opt.verify(instance, None, certificate)
    if not verdict.verified:
        raise Refused(f"{instance.name}: the certificate is refused: {verdict.reasons[0]}")
    if not math.isfinite(verdict.upper_bound):
        raise Refused(f"{instance.name}: the certificate says that there is no plan")
    bound, method = verdict.upper_bound, certificate.method
    return Claim(instance, None, bound, method, versions(), certificate, who)


def solvable(arguments: argparse.Namespace) -> Iterator[tuple[str, Callable[[], Claim]]]:
    """What planner and bound find of the instances of `solve`, each with its name."""
    for given in instances(arguments):
        yield given, lambda given=given: solved(given, arguments)


def instances(arguments: argparse.Namespace) -> list[str]:
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


def is_known(row: Row | None) -> bool:
    """Whether a row has a plan and a bound."""
    return row is not None and bool(row.order) and math.isfinite(row.upper_bound)


def solved(given: str, arguments: argparse.Namespace) -> Claim:
    """What planner and bound find side by side, or a planner that proves by itself.

    Raises
    ------
    InputError
        There is no such instance, or it is not a committed one.
    """
    if not Path(given).exists() and library_of(arguments.folder).find(given) is not None:
        instance = known_instance(arguments.folder, given)
    else:
        instance = adr_opt.load(given)
        committed(arguments.folder, instance.name, instance.sha256)
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


def provable(arguments: argparse.Namespace) -> Iterator[tuple[str, Callable[[], Claim]]]:
    """Certificates for the rows that state a bound and have none, each with its name."""
    for row in chosen(arguments):
        if math.isfinite(row.upper_bound) and not row.certificate:
            yield row.instance, lambda row=row: proven_again(row, arguments)


def proven_again(row: Row, arguments: argparse.Namespace) -> Claim:
    """The bound of a row, proven from its plan, with a certificate that has been verified.

    Raises
    ------
    Refused
        The certificate proves less than the row states.
    """
    began = time.perf_counter()
    instance = committed(arguments.folder, row.instance, row.sha256)
    can = [name for name in names(BOUNDS) if spec(name, BOUNDS).shows_evidence]
    method = row.bound_method if row.bound_method in can else front.DEFAULT_BOUND
    start = plan_of(arguments.folder, row) if row.order else None
    result = adr_opt.bound(instance, method, time_limit=arguments.time_limit, start=start)
    certificate = certificate_of(instance, replace(result, plan=None))
    made = time.perf_counter()
    claim = proven(certificate, arguments.folder, row.who)
    print(f"{row.instance}: proven in {made - began:.0f} s", end=", ")
    print(f"verified in {time.perf_counter() - made:.0f} s", flush=True)
    if claim.upper_bound > row.upper_bound + tolerance(row.upper_bound):
        raise Refused(f"{row.instance}: the certificate proves {claim.upper_bound:g} only")
    return claim


# --- rows ---------------------------------------------------------------------------------------


def chosen(arguments: argparse.Namespace) -> list[Row]:
    """The rows of some instances and families, or all.

    Raises
    ------
    InputError
        The table has none of a name.
    """
    rows = read_table(arguments.folder)
    if not arguments.inputs:
        return list(rows.values())
    found: dict[str, Row] = {}
    for given in arguments.inputs:
        its = {name: row for name, row in rows.items() if given in (name, family_of(name))}
        if not its:
            raise InputError(f"{given!r}: the table has no such instance or family")
        found |= its
    return list(found.values())


def plan_of(folder: Path, row: Row) -> Plan:
    """The plan of a row, from its order, with its bound."""
    instance = committed(folder, row.instance, row.sha256)
    problem = problem_of(instance)
    if problem.connecting.may_be_on_demand:  # an order needs few pairs, and many fields are large
        problem.ask(neighbours(instance, 1))
    plan = certify_routes(problem, row.planner_method, row.routes, seed=0, runtime_s=0.0).plan
    if plan is None:
        raise InputError(f"instance {row.instance!r}: the order of its row cannot be flown")
    return with_bound(instance, plan, row)


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
    plan_of(folder, row).save(out)


def verify_rows(arguments: argparse.Namespace) -> int:
    """Verify rows one by one, and tell of each as it is done; returns how many are wrong."""
    rows = chosen(arguments)
    counts = {"plans": 0, "bounds": 0, "unproven": 0, "wrong": 0}
    for number, row in enumerate(rows, start=1):
        began = time.perf_counter()
        said, wrong = verified(arguments.folder, row, counts)
        counts["wrong"] += bool(wrong)
        took = f"{time.perf_counter() - began:.1f} s"
        told = "; ".join([f"WRONG: {reason}" for reason in wrong] or said)
        print(f"[{number}/{len(rows)}] {row.instance}: {told} ({took})", flush=True)
    print(
        f"{len(rows)} rows, {counts['wrong']} wrong: {counts['plans']} plans checked, "
        f"{counts['bounds']} bounds verified, {counts['unproven']} bounds without a certificate"
    )
    return counts["wrong"]


def summarise(rows: Sequence[Row]) -> None:
    """Print a line for each family of some rows that have a plan and a bound."""
    families: dict[str, list[Row]] = {}
    for row in rows:
        if is_known(row):
            families.setdefault(family_of(row.instance) or row.instance, []).append(row)
    for name, found in families.items():
        objectives = [row.objective for row in found]
        gaps = [relative_gap(row.objective, row.upper_bound) for row in found]
        print(
            f"{name}: {len(found)} rows, objective {statistics.fmean(objectives):.2f} in the mean "
            f"({min(objectives):g}–{max(objectives):g}), bound "
            f"{statistics.fmean(row.upper_bound for row in found):.2f}, gap "
            f"{100.0 * statistics.fmean(gaps):.2f} %, {gaps.count(0.0)} proven"
        )


def verified(folder: Path, row: Row, counts: dict[str, int]) -> tuple[list[str], list[str]]:
    """What is found of a row: what was verified, and what is wrong with it."""
    said: list[str] = []
    wrong: list[str] = []
    try:
        instance = committed(folder, row.instance, row.sha256)
        plan = None
        if row.order:
            plan = adr_opt.load_plan(folder / row.plan) if row.plan else plan_of(folder, row)
            wrong += wrong_with_plan(instance, plan, row)
            counts["plans"] += not wrong
            said.append(f"plan {row.objective:g} checked")
        if math.isfinite(row.upper_bound):
            wrong += wrong_with_gap(row)
            said.append(proof_of(folder, row, instance, plan, wrong, counts))
    except InputError as error:
        wrong.append(str(error))
    return said or ["neither a plan nor a bound"], wrong


def wrong_with_plan(instance: Instance, plan: Plan, row: Row) -> list[str]:
    """Why a plan is illegal, or not that of the row."""
    wrong = [str(violation) for violation in adr_opt.check(instance, plan)]
    if order_of(instance, plan) != row.order:
        wrong.append("the plan has another order than the row")
    if abs(plan.objective - row.objective) > tolerance(row.objective):
        wrong.append(f"the plan collects {plan.objective:g}, not {row.objective:g}")
    if abs(plan.delta_v_m_s - row.delta_v_m_s) > ROUNDING * row.delta_v_m_s:
        wrong.append(f"the plan takes {plan.delta_v_m_s!r} m/s, not {row.delta_v_m_s!r}")
    return wrong


def wrong_with_gap(row: Row) -> list[str]:
    """Why bound, objective and gap of a row do not go together."""
    if not row.order:
        return []
    if row.upper_bound < row.objective:
        return [f"the bound {row.upper_bound:g} is below the plan"]
    gap = relative_gap(row.objective, row.upper_bound)
    return [] if gap == row.gap else [f"the gap is {gap!r}, not {row.gap!r}"]


def proof_of(
    folder: Path,
    row: Row,
    instance: Instance,
    plan: Plan | None,
    wrong: list[str],
    counts: dict[str, int],
) -> str:
    """How the bound of a row is proven; what is wrong with its certificate is added."""
    bound = f"bound {row.upper_bound:g}"
    total = sum(target.prize for target in instance.targets)
    if row.certificate:
        verdict = adr_opt.verify(instance, plan, adr_opt.load_certificate(folder / row.certificate))
        reasons = list(verdict.reasons)
        if not reasons and verdict.upper_bound > row.upper_bound + tolerance(row.upper_bound):
            reasons.append(f"its certificate proves {verdict.upper_bound:g}, not {bound}")
        wrong += reasons
        counts["bounds"] += not reasons
        return f"{bound} verified"
    if row.upper_bound >= total - tolerance(total):
        counts["bounds"] += 1
        return f"{bound} is the sum of all prizes"
    counts["unproven"] += 1
    return f"{bound} without a certificate"


# --- the command line ---------------------------------------------------------------------------


def parser() -> argparse.ArgumentParser:
    """The verbs and their options."""
    made = argparse.ArgumentParser(description="Keep and verify instances/best-known.csv.")
    made.add_argument("--folder", type=Path, default=FOLDER, help="folder of the table")
    verbs = made.add_subparsers(dest="verb", required=True, metavar="VERB")
    verify = verbs.add_parser("verify", help="verify rows one by one")
    summary = verbs.add_parser("summary", help="means of families")
    add = verbs.add_parser("add", help="take plans and certificates, only for the better")
    plan = verbs.add_parser("plan", help="write the plan of a row")
    certify = verbs.add_parser("certify", help="prove bounds again and keep their certificates")
    solve = verbs.add_parser("solve", help="plan and bound instances, only for the better")
    for each in (verify, summary, certify):
        each.add_argument("inputs", nargs="*", metavar="INSTANCE|FAMILY", help="by default all")
    add.add_argument(
        "inputs",
        nargs="+",
        metavar="FILE",
        help="plan, certificate, or what 'bound --json' printed",
    )
    add.add_argument("--who", default=WHO, metavar="NAME", help="whose they are")
    plan.add_argument("name", metavar="INSTANCE")
    plan.add_argument("--out", type=Path, metavar="FILE", required=True)
    solve.add_argument("inputs", nargs="*", metavar="FILE|NAME", help="instance, or its name")
    solve.add_argument("--family", action="append", metavar="NAME", help="all of it, repeatable")
    solve.add_argument("--missing", action="store_true", help="skip what has plan and bound")
    solve.add_argument("--method", default="auto", help="planner")
    solve.add_argument("--bound", default="lagrangian", help="beside it; none: the planner's own")
    solve.add_argument("--seed", type=int, default=0)
    for each in (certify, solve):
        each.add_argument(
            "--time-limit", type=float, default=60.0, metavar="S", help="per instance"
        )
    return made


def main(argv: Sequence[str] | None = None) -> int:
    """Do what a verb asks for; a refusal counts more than a wrong file in the exit status."""
    arguments = parser().parse_args(argv)
    if arguments.verb == "solve" and not (arguments.inputs or arguments.family):
        parser().error("nothing to solve; name files, instances or a --family")
    try:
        if arguments.verb == "verify":
            return 1 if verify_rows(arguments) else 0
        if arguments.verb == "summary":
            summarise(chosen(arguments))
            return 0
        if arguments.verb == "plan":
            write_plan(arguments.folder, arguments.name, arguments.out)
            return 0
        kinds = {"add": claimed, "certify": provable, "solve": solvable}
        work = list(kinds[arguments.verb](arguments))
    except InputError as error:
        print(f"wrong: {error}", file=sys.stderr)
        return 2
    seen = set()
    for number, (name, claim) in enumerate(work, start=1):
        # A file that fails does not keep the others back.
        try:
            said = update(arguments.folder, claim())
            print(f"[{number}/{len(work)}] {said}", flush=True)
        except InputError as error:
            print(f"wrong: {error}", file=sys.stderr)
            seen.add(2)
        except (Refused, InvalidBound) as error:
            print(f"refused: {name}: {error}", file=sys.stderr)
            seen.add(1)
    return min(seen, default=0)


if __name__ == "__main__":
    sys.exit(main())
