"""Cards of objects: one line at a prompt, a small table in a notebook.

A class that is :class:`adr_opt.common.card.Shown` is shown by the function that is named here for
it, in the module ``of_…`` of its kind. Names come from files of others, so pages escape them.
"""

from __future__ import annotations

import re
from importlib import import_module

from ...common.card import Card

VIEWS = {
    "of_plan": "Certificate Leg Plan RefinedPlan RefinedResult Result Route",
    "of_instance": "AllConnections Connections Given Instance Matrices Mission Problem Timetable",
    "of_analysis": "Comparison DesignPoint DesignStudy Point PricedOrder PricedRoute Rehearsals "
    "Replanned Tradeoff",
}
MODULES = {name: module for module, names in VIEWS.items() for name in names.split()}
"""Module by name of the class; the function is that name with underscores, after ``of_``."""


def view(shown: object) -> Card | None:
    """The card of an object; None for classes without one."""
    for kind in type(shown).__mro__:
        name = kind.__name__
        if name in MODULES and kind.__module__.startswith("adr_opt."):
            function = "of" + re.sub("[A-Z]", lambda found: f"_{found[0].lower()}", name)
            card: Card = getattr(import_module(f".{MODULES[name]}", __name__), function)(shown)
            return card
    return None
