"""Side by side with the peers: PyVRP on a static relaxation, DIDPPy on a model in slots, and ours.

    python bench/peers.py --family nominal --count 4 --time-limit 10 --seed 0
    python bench/peers.py --instances instances/nominal/nominal-000.json --peers didppy

Same instances, time limit, seed and cores. Every clock starts with a ready timetable; building a
peer's model from it is not charged to the peer and is listed as "build". What a peer *promises* is
the number of targets that its own model visits; what it *keeps* is left of that when the plan is
timed exactly on the timetable and passes ``check``. Needs ``pip install 'adr-opt[peers]'``.

**PyVRP** plans with one matrix: the mean ΔV and duration of each pair over all departures, which it
keeps best, and the best of them, which is the static relaxation proper (``--static``). Prizes are
optional clients, time is the shift's, refuelling is a reload at the station and takes its time. A
tank that legs empty cannot be expressed, only loads that clients carry: a target's load is the mean
static ΔV of the five cheapest legs to it. The route ends anywhere.

**DIDPPy** (CABS) plans the real problem in slots of time: the state is body, slot, ΔV left and
the targets left; arrivals are rounded up to a slot and ΔV up to 1 m/s. A chaser that is free a
little before its slot may meet an earlier departure event than the model's, so even this plan may
change when timed exactly. Its bound holds for the rounded model, not for the mission.

**Timing** a peer's order exactly. "as it is": the legal beginning of its order, its own refuelling
stops included. "mended": the same order with and without its stops, with and without keeping the
way to the station open; a move that is not legal is made after a refuelling stop, or else left
out. The best of all these counts.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from machine import heading

import adr_opt
from adr_opt.errors import InputError, MissingExtra
from adr_opt.front import method_of, takes_jobs
from adr_opt.generator import FAMILIES
from adr_opt.kernels import rules as rule_kernels
from adr_opt.kernels.compile import kernel
from adr_opt.kernels.constants import STATION
from adr_opt.result import certify

OURS = ("auto", "beam", "ortools")
CHEAPEST = 5
"""Legs into a target whose mean static ΔV is its load in PyVRP."""
PRIZE_UNITS = 100_000
"""PyVRP's costs are whole numbers: a prize of 1 outweighs any saving of ΔV [m/s]."""
SLACK = 1e-9
State = tuple[int, float, float, int]
"""Body, time [s], ΔV left [m/s], targets since the last refuelling."""


def need(package: str) -> ModuleType:
    """Import an optional package.

    Raises
    ------
    MissingExtra
        It is not installed.
    """
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtra("comparing with the peers", package, "peers") from None


@dataclass(frozen=True)
class Promise:
    """What a peer says that it can do.

    Attributes
    ----------
    order : tuple of int
        Bodies in order, the station for refuelling.
    visits : float
        Prizes that the peer's model collects.
    bound : float
        The peer's bound on its own model; +inf for none.
    build_s, solve_s : float
        Wall times [s].
    history : tuple of (float, float)
        Seconds since the beginning of the search, and the bound proven by then.
    """

    order: tuple[int, ...]
    visits: float
    bound: float
    build_s: float
    solve_s: float
    history: tuple[tuple[float, float], ...] = ()


# --- exact timing of a peer's order -------------------------------------------------------------


def as_it_is(mission: adr_opt.Mission, order: Iterable[int]) -> tuple[int, ...]:
    """The legal beginning of an order."""
    moves = tuple(order)
    return moves[: mission.time(moves).made]


def mended(mission: adr_opt.Mission, order: Iterable[int]) -> tuple[int, ...]:
    """The best of all simple ways to fly an order, see the head of this file."""
    moves = tuple(order)
    bare = tuple(j for j in moves if j != STATION)
    candidates = [as_it_is(mission, moves)]
    candidates += [_follow(mission, some, guard) for some in (moves, bare) for guard in (0, 1)]
    timings = [mission.time(candidate) for candidate in candidates]
    best = max(range(len(candidates)), key=lambda c: (timings[c].objective, -timings[c].delta_v))
    return candidates[best]


def _follow(mission: adr_opt.Mission, order: Iterable[int], guard: int) -> tuple[int, ...]:
    """Fly an order; refuel where the next move is not legal, else leave it out.

    With ``guard`` a move to a target also counts as not legal if the station is out of reach
    after it; at the end the guard is dropped, as nobody has to return.
    """
    rules = mission.rules
    visited = np.zeros(len(mission.names), dtype=np.bool_)
    state = (STATION, 0.0, rules.budget, 0)
    made: list[int] = []
    passed_by: list[int] = []

    def after(state: State, j: int) -> State | None:
        body, now, left, since = state
        if not rule_kernels.may_go(body, since, visited, j):
            return None
        legal, delta_v, end = rule_kernels.fits(rules, body, now, left, j)
        if not legal:
            return None
        if j == STATION:
            return j, end, rules.budget, 0
        return j, end, left - delta_v, since + 1

    def open_way(state: State | None) -> bool:
        return state is not None and (not guard or after(state, STATION) is not None)

    for j in order:
        direct = after(state, j)
        if direct is not None and (j == STATION or open_way(direct)):
            state = direct
            visited[j] = j != STATION
            made.append(j)
            continue
        if j == STATION:
            continue
        refuelled = after(state, STATION)
        onward = None if refuelled is None else after(refuelled, j)
        if onward is not None and open_way(onward):
            state = onward
            visited[j] = True
            made += [STATION, j]
        else:
            passed_by.append(j)
    for j in passed_by if guard else []:
        onward = after(state, j)
        if onward is not None:
            state = onward
            visited[j] = True
            made.append(j)
    while made and made[-1] == STATION:
        made.pop()
    return tuple(made)


# --- PyVRP --------------------------------------------------------------------------------------


def static_costs(mission: adr_opt.Mission, statistic: str) -> tuple[np.ndarray, np.ndarray]:
    """One matrix for all times, from samples every half hour.

    Parameters
    ----------
    mission : Mission
    statistic : {"mean", "quartile", "best", "epoch"}
        Over the ready times from which a leg exists and ends within the mission: the mean, the
        lower quartile or the least of each quantity by itself, or the first time's.

    Returns
    -------
    delta_v, duration : (bodies, bodies) float64
        [m/s]; from ready to the end of service [s]; +inf where there is never a transfer.
    """
    rules = mission.rules
    times = np.arange(0.0, max(rules.duration, 1.0), 1800.0)
    sampled = mission.timetable.matrices(times)
    duration = sampled.duration + rules.service
    exists = (times[:, None, None] + duration <= rules.duration) & np.isfinite(sampled.delta_v)
    count = exists.sum(axis=0)
    found = []
    for values in (sampled.delta_v, duration):
        if statistic == "mean":
            total = np.where(exists, values, 0.0).sum(axis=0)
            single = np.where(count > 0, total / np.maximum(count, 1), np.inf)
        elif statistic in ("quartile", "best"):
            ordered = np.sort(np.where(exists, values, np.inf), axis=0)
            rank = count // 4 if statistic == "quartile" else np.zeros_like(count)
            single = np.take_along_axis(ordered, rank[None], axis=0)[0]
        else:
            first = np.take_along_axis(values, exists.argmax(axis=0)[None], axis=0)[0]
            single = np.where(count > 0, first, np.inf)
        np.fill_diagonal(single, 0.0)
        found.append(single)
    return found[0], found[1]


def pyvrp_promise(
    mission: adr_opt.Mission, *, time_limit_s: float, seed: int, statistic: str = "mean"
) -> Promise:
    """The best route of PyVRP on the static relaxation.

    Raises
    ------
    MissingExtra
        PyVRP is not installed.
    InputError
        It is too old to know locations.
    """
    pyvrp: Any = need("pyvrp")
    if not hasattr(pyvrp.Model, "add_location"):
        raise InputError(f"PyVRP {version('pyvrp')} is too old: install PyVRP 0.14 or later")
    began = time.perf_counter()
    rules = mission.rules
    bodies = rules.service.size
    if bodies < 2:
        return Promise((), 0.0, math.inf, 0.0, 0.0)
    delta_v, duration = static_costs(mission, statistic)
    model = pyvrp.Model()
    places = [model.add_location(0.0, 0.0) for _ in range(bodies + 1)]
    station = model.add_depot(places[STATION])
    anywhere = model.add_depot(places[bodies])
    for j in range(1, bodies):
        incoming = np.sort(np.delete(delta_v[:, j], j))[:CHEAPEST]
        load = incoming[np.isfinite(incoming)]
        model.add_client(
            places[j],
            delivery=[math.ceil(load.mean()) if load.size else math.ceil(rules.budget) + 1],
            prize=round(PRIZE_UNITS * float(rules.prize[j])),
            required=False,
        )
    model.add_vehicle_type(
        1,
        capacity=[math.floor(rules.budget)],
        start_depot=station,
        end_depot=anywhere,
        shift_duration=math.floor(rules.duration),
        reload_depots=[station],
        max_reloads=bodies,
    )
    for i in range(bodies):
        model.add_edge(places[i], places[bodies], 0, 0)
        for j in range(bodies):
            # Arrival and service in one: PyVRP's reloads take no time of their own.
            if i != j and delta_v[i, j] <= rules.budget:
                costs = round(delta_v[i, j]), round(duration[i, j])
                model.add_edge(places[i], places[j], *costs)
    built = time.perf_counter()
    found = model.solve(pyvrp.stop.MaxRuntime(time_limit_s), seed=seed, display=False)
    solved = time.perf_counter()
    order: list[int] = []
    if found.best.is_feasible():
        for route in found.best.routes():
            for activity in list(route)[1:-1]:
                order.append(1 + activity.idx if activity.is_client() else STATION)
    visits = float(sum(rules.prize[j] for j in order))
    return Promise(tuple(order), visits, math.inf, built - began, solved - built)


# --- DIDPPy -------------------------------------------------------------------------------------


@kernel
def _ends(rules, times, delta_v, end):
    """ΔV and end of service of (origin, destination, ready time); +inf where none is in time."""
    for i in range(rules.service.size):
        for j in range(rules.service.size):
            for s in range(times.size):
                delta_v[i, j, s] = np.inf
                end[i, j, s] = np.inf
                if i != j:
                    legal, cost, done = rule_kernels.fits(rules, i, times[s], rules.budget, j)
                    if legal:
                        delta_v[i, j, s] = cost
                        end[i, j, s] = done


def didppy_promise(
    mission: adr_opt.Mission,
    *,
    time_limit_s: float,
    slot_s: float = 240.0,
    relaxed: bool = False,
    earlier_is_better: bool = False,
    threads: int = 1,
) -> Promise:
    """The best plan and bound of CABS on the model in slots.

    Parameters
    ----------
    mission : Mission
    time_limit_s : float
        For the search [s].
    slot_s : float
        Slot of time [s].
    relaxed : bool
        Round so that every plan of the mission is one of the model; then, and only then, the bound
        holds for the mission. A state's slot is the one in which the chaser is free. From anywhere
        in it the next event is the next one of its beginning or of its end, so there are two
        moves to each destination; ΔV is rounded down.
    earlier_is_better : bool
        Let a state dominate another that is later. The model is not so (who is early may have to
        take a worse event), so the search is no longer complete and the bound is dropped.
    threads : int

    Raises
    ------
    MissingExtra
        DIDPPy is not installed.
    InputError
        The slot is not shorter than the time between two events, or DIDPPy is too old.
    """
    dp: Any = need("didppy")
    if not hasattr(dp, "fractional_knapsack"):
        raise InputError(f"DIDPPy {version('didppy')} is too old: install DIDPPy 0.11 or later")
    began = time.perf_counter()
    rules = mission.rules
    bodies = rules.service.size
    if bodies < 2:
        return Promise((), 0.0, 0.0, 0.0, 0.0)
    shortest = float(rules.table.spacing.min())
    if not 0.0 < slot_s < shortest:
        raise InputError(f"slot_s = {slot_s!r}: must be > 0 and < {shortest:.0f}")
    slots = math.ceil(rules.duration / slot_s) + 1
    late = slots  # the slot of what is not possible
    delta_v = np.empty((bodies, bodies, slots + 1))
    end = np.empty_like(delta_v)
    _ends(rules, slot_s * np.arange(slots + 1), delta_v, end)
    possible = np.isfinite(end)
    # Rounding to m/s; the small slack is on the side that the model is on.
    if relaxed:
        spent = np.maximum(0.0, np.floor(np.where(possible, delta_v, 0.0) - SLACK))
        reached = np.floor(np.where(possible, end, 0.0) / slot_s)
        tank = math.floor(rules.budget + SLACK)
    else:
        spent = np.ceil(np.where(possible, delta_v, 0.0) - SLACK)
        reached = np.ceil(np.where(possible, end, 0.0) / slot_s)
        tank = math.floor(rules.budget)
    arrive = np.where(possible, reached, late).astype(np.int64)
    cost = np.where(possible, spent, tank + 1).astype(np.int64)

    whole = mission.has_whole_prizes
    prizes = [int(p) if whole else float(p) for p in rules.prize]
    model = dp.Model(maximize=True, float_cost=not whole)
    kind = model.add_object_type(number=bodies)
    moments = model.add_object_type(number=slots + 1)
    todo = model.add_set_var(object_type=kind, target=list(range(1, bodies)))
    body = model.add_element_var(object_type=kind, target=STATION)
    if earlier_is_better:
        slot = model.add_element_resource_var(object_type=moments, target=0, less_is_better=True)
    else:
        slot = model.add_element_var(object_type=moments, target=0)
    left = model.add_int_resource_var(target=tank, less_is_better=False)
    over = model.add_int_var(target=0)
    arrival = model.add_element_table(arrive.tolist())
    needed = model.add_int_table(cost.tolist())
    one = model.add_element_table([*range(1, slots + 1), slots])

    number: dict[str, int] = {}
    rest = dp.IntExpr.state_cost() if whole else dp.FloatExpr.state_cost()
    for j in range(bodies):
        for which in range(1 + relaxed):
            at = one[slot] if which else slot
            ends = arrival[body, j, at]
            conditions = [over == 0, ends < late, needed[body, j, at] <= left]
            if which:
                # Two events only where the beginning and the end of the slot differ.
                conditions.append(
                    (arrival[body, j, slot] != ends)
                    | (needed[body, j, slot] != needed[body, j, at])
                )
            effects: list[Any] = [(body, j), (slot, ends)]
            if j == STATION:
                conditions.append(body != STATION)
                effects.append((left, tank))
            else:
                conditions.append(todo.contains(j))
                effects += [(left, left - needed[body, j, at]), (todo, todo.remove(j))]
            name = f"{j}/{which}"
            number[name] = j
            gain = rest if j == STATION else prizes[j] + rest
            model.add_transition(
                dp.Transition(name=name, cost=gain, preconditions=conditions, effects=effects)
            )
    # A plan may end at any time.
    model.add_transition(
        dp.Transition(name="end", cost=rest, preconditions=[over == 0], effects=[(over, 1)])
    )
    model.add_base_case([over == 1])

    # Σ least times ≤ time left, and refuelling buys at most tank − c₀ of ΔV for τ₀ of time: one
    # knapsack in which a target weighs τ + λ c and the state has room for its time + λ its ΔV.
    stays = arrive[:, :, :-1] - np.arange(slots)
    if relaxed:
        stays = np.minimum(stays, arrive[:, :, 1:] - np.arange(slots))
    reach = possible[:, :, :-1] | (possible[:, :, 1:] if relaxed else False)
    tau = np.where(reach, stays, late).min(axis=(0, 2))
    least = cost.min(axis=(0, 2))
    bought = tank - int(least[STATION])
    rate = float(tau[STATION]) / bought if bought > 0 and tau[STATION] < late else 0.0
    weights = [float(tau[j] + rate * least[j]) for j in range(bodies)]
    # The time left as a number: elements are names of slots to DIDPPy.
    time_left = model.add_float_table([float(max(0, slots - 1 - s)) for s in range(slots + 1)])
    room = time_left[slot] + rate * left + 1e-6
    knapsack = dp.fractional_knapsack(todo, room, [float(p) for p in rules.prize], weights)
    prize_table = model.add_int_table(prizes) if whole else model.add_float_table(prizes)
    for bound in (math.floor(knapsack + 1e-6) if whole else knapsack, prize_table[todo]):
        model.add_dual_bound((over == 0).if_then_else(bound, 0 if whole else 0.0))
    built = time.perf_counter()

    solver = dp.CABS(model, time_limit=time_limit_s, quiet=True, threads=threads)
    best: Any = None
    best_bound, history = math.inf, []
    while True:
        solution, ended = solver.search_next()
        if solution.best_bound is not None and solution.best_bound < best_bound:
            best_bound = float(solution.best_bound)
            history.append((float(solution.time), best_bound))
        if solution.cost is not None and (best is None or solution.cost > best.cost):
            best = solution
        if ended:
            break
    moves = [] if best is None else [number[t.name] for t in best.transitions if t.name in number]
    visits = 0.0 if best is None else float(best.cost)
    if earlier_is_better:
        best_bound, history = math.inf, []
    return Promise(
        tuple(moves), visits, best_bound, built - began, time.perf_counter() - built, tuple(history)
    )


# --- the table ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """What one method did on one instance; NaN where it promises nothing beyond its plan."""

    method: str
    instance: str
    visits: float
    promised: float
    bound: float
    build_s: float
    solve_s: float


def legal(mission: adr_opt.Mission, order: Sequence[int], seed: int = 0) -> float:
    """The objective of an order of bodies that ``check`` finds nothing wrong with.

    Raises
    ------
    RuntimeError
        There is a violation.
    """
    result = certify(mission, "peer", order, seed=seed, runtime_s=0.0)
    return checked(mission, result)


def checked(mission: adr_opt.Mission, result: adr_opt.Result) -> float:
    """The objective of a result whose plan ``check`` finds nothing wrong with."""
    if result.plan is None:
        return 0.0
    violations = adr_opt.check(mission.instance, result.plan)
    if violations:
        raise RuntimeError(f"{result.method} on {mission.instance.name}: {violations[0]}")
    return result.objective


def peer_rows(
    name: str, variant: str, mission: adr_opt.Mission, *, time_limit_s: float, seed: int,
    slot_s: float, jobs: int,
) -> list[Row]:  # fmt: skip
    """A peer's rows: its order as it is, and mended; the variant is a statistic or "early"."""
    if name == "pyvrp":
        promise = pyvrp_promise(mission, time_limit_s=time_limit_s, seed=seed, statistic=variant)
        label = f"PyVRP, {variant}"
    else:
        early = variant == "early"
        promise = didppy_promise(
            mission, time_limit_s=time_limit_s, slot_s=slot_s, earlier_is_better=early, threads=jobs
        )
        label = f"DIDPPy, {slot_s:g} s" + (", earlier is better" if early else "")
    ways: tuple[tuple[str, Callable[..., tuple[int, ...]]], ...] = (
        ("as it is", as_it_is),
        ("mended", mended),
    )
    return [
        Row(
            f"{label}, {way}",
            mission.instance.name,
            legal(mission, follow(mission, promise.order), seed),
            promise.visits,
            promise.bound,
            promise.build_s,
            promise.solve_s,
        )
        for way, follow in ways
    ]


def our_row(
    name: str, mission: adr_opt.Mission, *, time_limit_s: float, seed: int, jobs: int
) -> Row:
    """One of our planners."""
    cores = jobs if takes_jobs(method_of(name)) else None
    began = time.perf_counter()
    result = adr_opt.solve(mission, name, time_limit=time_limit_s, seed=seed, jobs=cores)
    wall = time.perf_counter() - began
    visits = checked(mission, result)
    return Row(name, mission.instance.name, visits, visits, result.upper_bound, 0.0, wall)


def table(rows: Sequence[Row]) -> str:
    """Means over instances, the best method first, in Markdown."""
    lines = [
        "| method | visits, mean | visits by instance | promised, mean | kept | bound, mean | "
        "build | solve, max |",
        "|---|---|---|---|---|---|---|---|",
    ]
    methods = dict.fromkeys(row.method for row in rows)
    mine = {method: [row for row in rows if row.method == method] for method in methods}
    means = {m: statistics.mean(row.visits for row in some) for m, some in mine.items()}
    for method in sorted(methods, key=lambda m: -means[m]):
        some = mine[method]
        promised = sum(row.promised for row in some)
        kept = f"{100.0 * sum(row.visits for row in some) / promised:.0f} %" if promised else "–"
        bound = statistics.mean(row.bound for row in some)
        own_model = "†" if method.startswith("DIDPPy") else ""
        lines.append(
            f"| {method} | {means[method]:.2f} | {' '.join(f'{row.visits:g}' for row in some)} | "
            f"{promised / len(some):.2f} | {kept} | "
            + (f"{bound:.2f}{own_model}" if math.isfinite(bound) else "–")
            + f" | {statistics.mean(row.build_s for row in some):.1f} s | "
            f"{max(row.solve_s for row in some):.1f} s |"
        )
    if any(row.method.startswith("DIDPPy") for row in rows):
        lines += ["", "† of the rounded model, no bound on the mission"]
    return "\n".join(lines)


def missions(arguments: argparse.Namespace) -> list[adr_opt.Mission]:
    """The missions asked for: files, or the first fields of a family."""
    if arguments.instances:
        return [adr_opt.Mission(adr_opt.load(path)) for path in arguments.instances]
    fields = range(arguments.count)
    return [adr_opt.Mission(adr_opt.generate(arguments.family, field)) for field in fields]


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


def packages(*names: str) -> str:
    """Versions of the peers, for the heading."""
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} not installed")
    return ", ".join(found)


def run(arguments: argparse.Namespace) -> None:
    """Measure and print the table."""
    require_positive(arguments)
    contests = []
    for name in arguments.peers:
        package, _, variant = name.partition("-")
        need(package)
        contests += [(package, one) for one in (arguments.static if name == "pyvrp" else [variant])]
    common = {"time_limit_s": arguments.time_limit, "seed": arguments.seed, "jobs": arguments.jobs}
    warm = adr_opt.Mission(adr_opt.generate("tiny", 0))
    for name in arguments.ours:  # compile before the clock starts
        adr_opt.solve(warm, name, time_limit=20.0, iterations=3)
    rows: list[Row] = []
    for mission in missions(arguments):
        mission.rules  # noqa: B018  builds the timetable
        for name in arguments.ours:
            rows.append(our_row(name, mission, **common))
        for name, variant in contests:
            rows += peer_rows(name, variant, mission, slot_s=arguments.slot, **common)
        for row in rows:
            if row.instance == mission.instance.name:
                what = f"{row.instance} {row.method}"
                print(f"{what}: {row.visits:g} of {row.promised:g} promised", file=sys.stderr)
    print(heading())
    print(
        f"{packages('pyvrp', 'didppy')}; time limit {arguments.time_limit:g} s, seed "
        f"{arguments.seed}, {arguments.jobs} core(s); instances "
        f"{', '.join(dict.fromkeys(row.instance for row in rows))}\n"
    )
    print(table(rows))


def main() -> int:
    """Command line; 2 if the call or the installation is wrong."""
    parser = parser_of(__doc__, 10.0)
    parser.add_argument(
        "--static",
        nargs="+",
        default=["mean", "best"],
        choices=["mean", "quartile", "best", "epoch"],
        help="what PyVRP's matrix is made of",
    )
    parser.add_argument(
        "--peers",
        nargs="*",
        default=["pyvrp", "didppy", "didppy-early"],
        choices=["pyvrp", "didppy", "didppy-early"],
    )
    parser.add_argument("--ours", nargs="*", default=list(OURS))
    try:
        run(parser.parse_args())
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
