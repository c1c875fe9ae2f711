"""Cards of objects: one line at a prompt, a small table in a notebook.

A class that is :class:`adr_opt.common.card.Shown` is shown by the function that is named here for
it, in the module ``of_…`` of its kind. Names come from files of others, so pages escape them.
"""

from __future__ import annotations

from importlib import import_module

from ...common.card import Card

VIEWS = {
    "AllConnections": ("of_connections", "of_all"),
    "Certificate": ("of_refined", "of_certificate"),
    "Comparison": ("of_analysis", "of_comparison"),
    "Connections": ("of_connections", "of_connections"),
    "DesignPoint": ("of_designs", "of_point"),
    "DesignStudy": ("of_designs", "of_study"),
    "Given": ("of_connections", "of_given"),
    "Instance": ("of_instance", "of_instance"),
    "Leg": ("of_plan", "of_leg"),
    "Matrices": ("of_timetable", "of_matrices"),
    "Mission": ("of_instance", "of_problem"),
    "Plan": ("of_plan", "of_plan"),
    "Point": ("of_analysis", "of_point"),
    "Problem": ("of_instance", "of_problem"),
    "PricedOrder": ("of_analysis", "of_priced_order"),
    "PricedRoute": ("of_analysis", "of_priced_route"),
    "RefinedPlan": ("of_refined", "of_refined"),
    "RefinedResult": ("of_refined", "of_refined_result"),
    "Rehearsals": ("of_rehearsals", "of_rehearsals"),
    "Replanned": ("of_analysis", "of_replanned"),
    "Result": ("of_result", "of_result"),
    "Route": ("of_plan", "of_route"),
    "Timetable": ("of_timetable", "of_timetable"),
    "Tradeoff": ("of_analysis", "of_tradeoff"),
}
"""Module and function by name of the class."""


def view(shown: object) -> Card | None:
    """The card of an object; None for classes without one."""
    for kind in type(shown).__mro__:
        if kind.__name__ in VIEWS and kind.__module__.startswith("adr_opt."):
            module, function = VIEWS[kind.__name__]
            card: Card = getattr(import_module(f".{module}", __name__), function)(shown)
            return card
    return None
