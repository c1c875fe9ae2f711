"""Specifications of this package's planners and bounds, without importing these."""

from __future__ import annotations

from adr_opt.run.method_spec import ALL_RULES, MethodSpec, Practice

AUTO = MethodSpec(
    "auto", "solvers.planners.auto:auto",
    several=True, rules=ALL_RULES, starts=True, uses_cores=True,
    shows_evidence=True, bounds_all_pairs=True, functions=True, on_demand=True, tours=True,
    orders_all=True, practice=Practice(more="solvers.labels.practice:practise"),
)  # fmt: skip

EXACT = MethodSpec(
    "exact", "solvers.planners.exact:exact",
    several=True, rules=ALL_RULES, starts=True, uses_cores=True, shows_evidence=True,
    bounds_all_pairs=True, functions=True, on_demand=True, tours=True,
    practice=Practice(rounds=12, more="solvers.labels.practice:practise"),
)  # fmt: skip

GREEDY = MethodSpec(
    "greedy", "solvers.planners.greedy:greedy", several=True, rules=ALL_RULES, on_demand=True
)

GREEDY_GUARDED = MethodSpec(
    "greedy-guarded", "solvers.planners.greedy:greedy_guarded",
    several=True, rules=ALL_RULES, on_demand=True,
)  # fmt: skip

ORTOOLS = MethodSpec(
    "ortools", "solvers.planners.ortools_windows:ortools",
    several=True, starts=True, uses_cores=True,
)  # fmt: skip

BEAM = MethodSpec("beam", "solvers.planners.beam:beam", on_demand=True, table_options=("policy",))

LOCAL_SEARCH = MethodSpec("local-search", "solvers.planners.local_search:local_search", starts=True)

MCTS = MethodSpec("mcts", "solvers.planners.mcts:mcts")

PPO = MethodSpec("ppo", "solvers.planners.ppo:ppo", uses_cores=True)

CPSAT = MethodSpec(
    "cpsat", "solvers.planners.cpsat:cpsat",
    starts=True, uses_cores=True, practice=Practice(rounds=6, options={"evaluations": 4}),
)  # fmt: skip

MIP = MethodSpec(
    "mip", "solvers.planners.mip:mip",
    starts=True, uses_cores=True, practice=Practice(rounds=6, options={"evaluations": 4}),
)  # fmt: skip

LAGRANGIAN = MethodSpec(
    "lagrangian", "solvers.bounds.lagrangian:lagrangian",
    starts=True, uses_cores=True, shows_evidence=True, bounds_all_pairs=True,
    practice=Practice(rounds=12),
)  # fmt: skip

ROUTING_BOUND = MethodSpec(
    "routing-bound", "solvers.bounds.routing_bound:routing_bound", starts=True
)
