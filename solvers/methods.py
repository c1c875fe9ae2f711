"""Specifications of this package's planners and bounds, without importing these."""

from __future__ import annotations

from adr_opt.problem.rules import CAMPAIGNS, FIRST, MODELLED, PLAYED, RELEASES, TOURS
from adr_opt.run.method_spec import MethodSpec, Practice

MODEL = FIRST | MODELLED | {"capture windows", "end of life"}
"""Rules of 1.0, and those that follow from the connections."""

ON_A_TANK = MODEL | {"visits between refuellings"}
"""Rules followed by moves, labels and walks of one chaser; walks that ignore a count bound those
that keep it."""

AUTO = MethodSpec(
    "auto",
    "solvers.planners.auto:auto",
    follows=ON_A_TANK
    | CAMPAIGNS
    | TOURS
    | RELEASES
    | {"functions of time", "functions of time for several chasers"},
    starts=True,
    uses_cores=True,
    shows_evidence=True,
    bounds_all_pairs=True,
    on_demand=True,
    orders_all=True,
    begins="solvers.routes.engine_rounds:first_routes",
    practice=Practice(more="solvers.labels.label_search:practise"),
)

EXACT = MethodSpec(
    "exact",
    "solvers.planners.exact:exact",
    follows=ON_A_TANK
    | CAMPAIGNS
    | TOURS
    | RELEASES
    | {"functions of time", "functions of time for several chasers"},
    starts=True,
    uses_cores=True,
    shows_evidence=True,
    bounds_all_pairs=True,
    on_demand=True,
    practice=Practice(rounds=12, more="solvers.labels.label_search:practise"),
)

GREEDY = MethodSpec(
    "greedy",
    "solvers.planners.greedy:greedy",
    follows=ON_A_TANK | CAMPAIGNS | RELEASES,
    on_demand=True,
)

GREEDY_GUARDED = MethodSpec(
    "greedy-guarded",
    "solvers.planners.greedy:greedy_guarded",
    quick="solvers.routes.one_chaser:guarded_routes",
    follows=ON_A_TANK | CAMPAIGNS | RELEASES,
    on_demand=True,
)

ORTOOLS = MethodSpec(
    "ortools",
    "solvers.planners.ortools_windows:ortools",
    follows=MODEL | {"several chasers"},
    starts=True,
    uses_cores=True,
)

BEAM = MethodSpec(
    "beam",
    "solvers.planners.beam:beam",
    follows=ON_A_TANK,
    on_demand=True,
    table_options=("policy",),
)

LOCAL_SEARCH = MethodSpec(
    "local-search", "solvers.planners.local_search:local_search", follows=MODEL, starts=True
)

MCTS = MethodSpec("mcts", "solvers.planners.mcts:mcts", follows=ON_A_TANK)

PPO = MethodSpec("ppo", "solvers.planners.ppo:ppo", follows=PLAYED, uses_cores=True)

MIP = MethodSpec(
    "mip",
    "solvers.planners.mip:mip",
    follows=MODEL,
    starts=True,
    uses_cores=True,
    practice=Practice(rounds=6, options={"evaluations": 4}),
)

LAGRANGIAN = MethodSpec(
    "lagrangian",
    "solvers.bounds.lagrangian:lagrangian",
    follows=ON_A_TANK,
    starts=True,
    uses_cores=True,
    shows_evidence=True,
    bounds_all_pairs=True,
    practice=Practice(rounds=12),
)

ROUTING_BOUND = MethodSpec(
    "routing-bound", "solvers.bounds.routing_bound:routing_bound", follows=ON_A_TANK, starts=True
)
