"""Local search: improves a plan by changing the order of its targets.

Two ways to change it take turns. *Annealing* swaps, replaces, relocates, reverses, inserts and
removes targets one move at a time; *ruin and recreate* keeps a beginning of the best plan and
builds a new end for it by a narrow noisy beam. Refuelling stops are not moved but solved for, see
:mod:`solvers.orders.timed_order`. Every candidate is timed exactly, from the first change on, and
given up as soon as it cannot be accepted.
"""

from .planner import local_search

__all__ = ["local_search"]
