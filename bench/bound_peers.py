"""Time to a bound: other methods, and `lagrangian` for an equally good one.

    python bench/bound_peers.py --family reduced-time --count 1 --time-limit 60

Upper bounds on the real mission, one core each by default, clocks from a ready timetable and with
the time to build the model. Prizes that are multiples of a step round every bound down.

**HiGHS** solves the linear relaxation of the time-expanded network. A column is a
connection; a node is what a chaser that has just serviced a body can still take: all connections of
the body from there on. Nodes whose times lie within one bucket are
one node (0 s: none are merged). Flow is conserved, each target is entered at most once, and the
ΔV of all legs is at most the budget × (1 + refuellings). Each of these is a relaxation. The bound
is worked out anew from HiGHS's dual values, whatever they are, so it is valid also where HiGHS was
stopped or ended within its tolerances.

**DIDPPy** is the model of ``bench/peers.py`` rounded so that every plan is in it; CABS's bound then
holds for the mission.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import peers
from machine import heading

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.common.tolerance import rounded_down
from solvers.networks.network import build

SOLVERS = ("ipm", "simplex", "pdlp")


@dataclass(frozen=True)
class LinearRelaxation:
    """Maximise gain · x over matrix · x ≤ limit, 0 ≤ x ≤ 1.

    Attributes
    ----------
    gain : (columns,) float64
        Prizes of the legs; 0 of waiting.
    matrix : (rows, columns) scipy.sparse.csc_array
        Rows: nodes, targets, ΔV.
    limit : (rows,) float64
    """

    gain: np.ndarray
    matrix: Any
    limit: np.ndarray


@dataclass(frozen=True)
class Bound:
    """A valid bound, the time it took [s], and what there is to say about it."""

    method: str
    value: float
    seconds: float
    note: str


def linear_relaxation(mission: adr_opt.Mission, bucket_s: float = 0.0) -> LinearRelaxation:
    """The linear relaxation of the time-expanded network.

    Parameters
    ----------
    mission : Mission
    bucket_s : float
        Nodes of a body within one bucket are merged: smaller, and no tighter [s].

    Raises
    ------
    InputError
        The bucket is longer than the shortest leg: a mission could use a column twice.
    """
    sparse: Any = peers.need("scipy.sparse")
    rules = mission.rules
    network = build(mission, jobs=1)
    if bucket_s > network.shortest:
        raise InputError(
            f"bucket of {bucket_s!r} s: must be ≤ {network.shortest:.0f}, the shortest leg"
        )
    bodies = rules.service.size
    # Node of a row: the last row at or before it at which a chaser can arrive. Any leg of the
    # node, or of a later one, may be taken from there.
    rows = int(network.start[-1])
    origin = np.repeat(np.arange(rows), np.diff(network.first))
    opens = np.zeros(rows, dtype=np.bool_)
    opens[network.start[:-1]] = True
    (root,) = network.roots
    opens[root] = True
    opens[network.landing] = True
    if bucket_s > 0.0:
        times = np.where(np.isfinite(network.departure), network.departure, rules.duration)
        bucket = np.floor(times / bucket_s)
        changes = np.ones(rows, dtype=np.bool_)
        changes[1:] = bucket[1:] != bucket[:-1]
        group = np.cumsum(changes | np.isin(np.arange(rows), network.start[:-1])) - 1
        opened = np.zeros(int(group[-1]) + 1, dtype=np.bool_)
        opened[group[opens]] = True
        # A bucket without an arrival goes with the one before it.
        opens = changes & opened[group]
        opens[network.start[:-1]] = True
    node = np.cumsum(opens) - 1
    nodes = int(node[-1]) + 1
    body_of = np.repeat(np.arange(bodies), np.diff(network.start))[opens]
    waits = np.flatnonzero(body_of[1:] == body_of[:-1])

    destination = network.destination[origin]
    leg = np.arange(origin.size)
    wait = leg.size + np.arange(waits.size)
    to_station = rules.is_station[destination]
    to_target = ~to_station
    spent = network.delta_v - rules.budget * to_station
    entries = (
        (node[origin], leg, np.ones(leg.size)),
        (node[network.landing], leg, -np.ones(leg.size)),
        (waits, wait, np.ones(waits.size)),
        (waits + 1, wait, -np.ones(waits.size)),
        (nodes + destination[to_target], leg[to_target], np.ones(to_target.sum())),
        (np.full(leg.size, nodes + bodies), leg, spent),
    )
    at, column, value = (np.concatenate([entry[part] for entry in entries]) for part in range(3))
    columns = leg.size + waits.size
    limit = np.zeros(nodes + bodies + 1)
    limit[node[root]] = 1.0
    limit[nodes : nodes + bodies] = 1.0
    limit[-1] = rules.budget
    gain = np.zeros(columns)
    gain[leg] = rules.prize[destination]
    matrix = sparse.csc_array((value, (at, column)), shape=(nodes + bodies + 1, columns))
    return LinearRelaxation(gain, matrix, limit)


def dual_bound(relaxation: LinearRelaxation, duals: np.ndarray) -> float:
    """A bound from any prices of the rows, also from wrong ones.

    For y ≥ 0: gain·x ≤ limit·y + Σ max(0, gain − matrixᵀ y), as no column exceeds 1. Leave out what
    is negative in y, and the bound holds whatever the solver's tolerances.
    """
    prices = np.maximum(duals, 0.0)
    reduced = relaxation.gain - relaxation.matrix.T @ prices
    return float(relaxation.limit @ prices + np.maximum(reduced, 0.0).sum())


def highs_bound(
    mission: adr_opt.Mission,
    *,
    time_limit_s: float,
    solver: str = "ipm",
    bucket_s: float = 0.0,
    threads: int = 1,
) -> Bound:
    """HiGHS on the linear relaxation; the trivial bound if it has no better one in time.

    Raises
    ------
    MissingExtra
        highspy or SciPy is not installed.
    """
    highspy: Any = peers.need("highspy")
    began = time.perf_counter()
    relaxation = linear_relaxation(mission, bucket_s)
    rows, columns = relaxation.matrix.shape
    built = time.perf_counter()
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = rows, columns
    model.sense_ = highspy.ObjSense.kMaximize
    model.col_cost_ = relaxation.gain
    model.col_lower_, model.col_upper_ = np.zeros(columns), np.ones(columns)
    model.row_lower_ = np.full(rows, -highspy.kHighsInf)
    model.row_upper_ = relaxation.limit
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_ = relaxation.matrix.indptr
    model.a_matrix_.index_ = relaxation.matrix.indices
    model.a_matrix_.value_ = relaxation.matrix.data
    highs = highspy.Highs()
    for name, value in (
        ("output_flag", False),
        ("solver", solver),
        ("run_crossover", "off"),
        ("threads", threads),
        ("time_limit", max(0.0, time_limit_s - (built - began))),
    ):
        highs.setOptionValue(name, value)
    highs.passModel(model)
    highs.run()
    duals = np.asarray(highs.getSolution().row_dual, dtype=float)
    seconds = time.perf_counter() - began
    status = highs.modelStatusToString(highs.getModelStatus()).lower()
    # Signs of duals are a convention of the solver; both are bounds, one of them is meant.
    values = [mission.total_prize]
    if duals.size == rows and np.isfinite(duals).all():
        values += [dual_bound(relaxation, duals), dual_bound(relaxation, -duals)]
    merged = f", {bucket_s:g} s" if bucket_s > 0.0 else ""
    return Bound(
        f"HiGHS {solver}{merged}",
        min(values),
        seconds,
        f"{rows} rows, {columns} columns, {built - began:.1f} s to build; {status}",
    )


def didppy_bound(
    mission: adr_opt.Mission, *, time_limit_s: float, slot_s: float, threads: int = 1
) -> Bound:
    """CABS on the relaxed model in slots."""
    found = peers.didppy_promise(
        mission, time_limit_s=time_limit_s, slot_s=slot_s, relaxed=True, threads=threads
    )
    at, value = found.history[-1] if found.history else (found.solve_s, mission.total_prize)
    return Bound(
        f"DIDPPy, {slot_s:g} s",
        min(value, mission.total_prize),
        found.build_s + at,
        f"{found.build_s:.1f} s to build, searched for {found.solve_s:.0f} s",
    )


def lagrangian_history(
    mission: adr_opt.Mission, time_limit_s: float, seed: int, jobs: int
) -> tuple[Bound, list[tuple[float, float]]]:
    """Our bound, and (seconds, bound) each time it fell."""
    heard: list[tuple[float, float]] = []
    began = time.perf_counter()

    def progress(incumbent: float, bound: float) -> None:
        if not heard or bound < heard[-1][1]:
            heard.append((time.perf_counter() - began, bound))

    result = adr_opt.bound(
        mission, "lagrangian", time_limit=time_limit_s, seed=seed, jobs=jobs, progress=progress
    )
    seconds = next((at for at, value in heard if value <= result.upper_bound), result.runtime_s)
    note = f"ran for {result.runtime_s:.0f} s" + (
        "; proven optimal" if result.status == "optimal" else ""
    )
    return Bound("lagrangian", result.upper_bound, seconds, note), heard


def rounded(mission: adr_opt.Mission, value: float) -> float:
    """The bound on whole prizes that a bound comes to; a millionth is left to rounding errors."""
    return rounded_down(value, mission.prize_step)


def as_good_after(history: list[tuple[float, float]], value: float) -> float:
    """Time until a bound at least as good was found [s]; +inf if never."""
    return next((at for at, bound in history if bound <= value + 1e-9), math.inf)


def compare(mission: adr_opt.Mission, arguments: argparse.Namespace) -> list[str]:
    """The lines of one instance."""
    limit, jobs = arguments.time_limit, arguments.jobs
    ours, history = lagrangian_history(mission, limit, arguments.seed, jobs)

    def bounds() -> Iterator[Bound]:
        yield ours
        for solver in arguments.lp:
            for bucket in arguments.buckets:
                yield highs_bound(
                    mission, time_limit_s=limit, solver=solver, bucket_s=bucket, threads=jobs
                )
        if not arguments.no_didppy:
            yield didppy_bound(mission, time_limit_s=limit, slot_s=arguments.slot, threads=jobs)

    lines = []
    for bound in bounds():
        value = rounded(mission, bound.value)
        after = as_good_after(history, value)
        lines.append(
            f"| {mission.instance.name} | {bound.method} | {bound.value:.2f} | {value:g} | "
            f"{bound.seconds:.1f} s | "
            + (f"{after:.1f} s" if math.isfinite(after) else f"not in {limit:g} s")
            + f" | {bound.note} |"
        )
        print(lines[-1], file=sys.stderr)
    return lines


def main() -> int:
    """Command line; 2 if the call or the installation is wrong."""
    parser = peers.parser_of(__doc__, 60.0)
    parser.set_defaults(family="reduced-time", count=1)
    parser.add_argument("--lp", nargs="*", default=["ipm"], choices=SOLVERS)
    parser.add_argument(
        "--buckets", nargs="+", type=float, default=[3600.0, 1800.0], help="merge nodes within [s]"
    )
    parser.add_argument("--no-didppy", action="store_true", help="leave DIDPPy out")
    arguments = parser.parse_args()
    try:
        peers.require_positive(arguments)
        if not all(0.0 <= bucket < math.inf for bucket in arguments.buckets):
            raise InputError(f"--buckets {arguments.buckets}: must be ≥ 0")
        for package in (["highspy", "scipy"] if arguments.lp else []) + (
            [] if arguments.no_didppy else ["didppy"]
        ):
            peers.need(package)
        lines = []
        warm = adr_opt.Mission(adr_opt.generate("tiny", 0))  # compile before the clock starts
        adr_opt.bound(warm, "lagrangian", time_limit=60.0, iterations=1000)
        for mission in peers.missions(arguments):
            mission.rules  # noqa: B018  builds the timetable
            lines += compare(mission, arguments)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(heading())
    print(
        f"{peers.packages('highspy', 'didppy', 'scipy')}; time limit {arguments.time_limit:g} s, "
        f"seed {arguments.seed}, {arguments.jobs} core(s)\n"
    )
    print(
        "| instance | method | bound | on whole prizes | reached after | "
        "`lagrangian` as good after | |\n|---|---|---|---|---|---|---|"
    )
    print("\n".join(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
