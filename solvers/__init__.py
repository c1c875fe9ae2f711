"""The answers: one module (or folder) per planner, one per bound.

Imports :mod:`adr_opt`, never another planner's insides; :mod:`adr_opt` finds the planners by the
entry-point groups ``adr_opt.planners`` and ``adr_opt.bounds``.
"""
