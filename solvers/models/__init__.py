"""Missions for solvers of integer programs: the network as arrays, the driver of a proof.

1. :mod:`.solver_network` has all connections and waits that a plan can need.
2. :mod:`.reduction` drops legs that no plan worth a goal can use, by reduced costs.
3. :mod:`.course` sets the goals, hands the networks to a solver and keeps incumbent and bound.
4. :mod:`.cp_sat` makes and runs solvers of CP-SAT.
"""
