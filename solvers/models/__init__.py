"""Shared parts of ``mip`` and ``cpsat``: the network as arrays, and the driver of a proof.

1. :mod:`.network` has all connections and waits that a plan can need.
2. :mod:`.reduction` drops legs that no plan worth a goal can use, by reduced costs.
3. :mod:`.course` sets the goals, hands the networks to a solver and keeps incumbent and bound.
4. :mod:`.answer` is what the course and a solver say to each other.
"""
