"""Solvers: planners and bounds, found by the entry points ``adr_opt.planners`` and ``…bounds``.

1. :mod:`.planners`, :mod:`.bounds`: what a user calls, a module or a folder each; none imports
   another one.
2. :mod:`.models`: the mission as a network for solvers of integer programs.
3. :mod:`.beams`: beams, orders of targets, ruin and recreate.
4. :mod:`.walks`: the network with waiting arcs, its walks and labels, and proofs by them.
5. :mod:`.timed_tours`: tours by sets of targets, and bounds, where arrivals are functions of time.
6. :mod:`.progress.gap`, :mod:`.progress.incumbent`: the best plan and the bound, compared in one
   place.

Each imports only from further down.
"""
