"""Policies by name.

A policy of another package is an entry point of the group ``adr_opt.rehearsal_policies``: a
callable that takes a :class:`.mission_facts.MissionFacts`, a :class:`.intended.Intended`, an
uncertainty and a seed, and gives a :class:`.flight.MissionPolicy` for one rehearsal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import entry_points

from ...common.errors import InputError
from ...common.packages import load
from ...problem.uncertainty import Uncertainty
from .flight import MissionPolicy
from .intended import Intended
from .mission_facts import MissionFacts

ENTRY_POINTS = "adr_opt.rehearsal_policies"

PolicyMaker = Callable[[MissionFacts, Intended, Uncertainty, int], MissionPolicy]


BUILT_IN: Mapping[str, tuple[str, str]] = {
    "follow": ("planned_order", "Follow"),
    "skip": ("planned_order", "Skip"),
    "replan": ("replanning", "AtDeviations"),
    "beam": ("replanning", "AtEveryService"),
    "learned": ("learned", "Learned"),
    "ppo": ("learned", "Learned"),
}
"""Module and class of each policy, imported on use."""

NEED_PLAN = frozenset({"follow", "skip"})
"""Policies that follow a given plan."""


def policy_of(name: str) -> PolicyMaker:
    """The policy with a name.

    Raises
    ------
    InputError
        There is none.
    """
    if name in BUILT_IN:
        module, kind = BUILT_IN[name]
        own: PolicyMaker = getattr(import_module(f".{module}", __package__), kind)
        return own
    others = {entry.name: entry for entry in entry_points(group=ENTRY_POINTS)}
    if name not in others:
        known = ", ".join(sorted({*BUILT_IN, *others}))
        raise InputError(f"policy {name!r} is unknown; use one of: {known}")
    made: PolicyMaker = load(others[name])
    return made
