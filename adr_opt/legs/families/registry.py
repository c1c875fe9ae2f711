"""The families of legs that there are, and how one more is registered."""

from __future__ import annotations

from ...plan.leg_kinds import SHORT, add_leg_kind, drop_leg_kind, leg_kinds
from ...plan.phases import add_phase, drop_phase, refuse_known_phase
from ...problem.instance import Instance
from .family import LegFamily, RegisteredFamily

_own: list[LegFamily] = []
_registered: list[RegisteredFamily] = []


def bring_along(*found: LegFamily) -> None:
    """Make the families known that come with the package, whose kinds are known already."""
    _own.extend(found)


def register(family: RegisteredFamily) -> None:
    """Make a family known: its legs are planned, judged, flown and shown from then on.

    An installed package has a function that does so in its entry points of the group
    ``adr_opt.leg_families``.

    Raises
    ------
    ValueError
        The name of its kind is taken, or that of one of its phases.
    """
    for phase in family.phases:
        refuse_known_phase(phase)
    add_leg_kind(family.kind)
    for phase in family.phases:
        add_phase(phase)
    _registered.append(family)


def unregister(family: RegisteredFamily) -> None:
    """Forget the family that was registered last, as if it never had been.

    Raises
    ------
    ValueError
        Another one was, or none: the numbers of those after it would change.
    """
    if not _registered or _registered[-1] is not family:
        raise ValueError("only the family that was registered last can be forgotten")
    _registered.pop()
    drop_leg_kind(family.kind)
    for phase in family.phases:
        drop_phase(phase)


def families() -> tuple[LegFamily, ...]:
    """All families; the place of each is its number."""
    leg_kinds()  # those that installed packages register are known from here
    return (*_own, *_registered)


def registered_of(instance: Instance) -> tuple[RegisteredFamily, ...]:
    """Those that do not come with the package and that an instance may have legs of."""
    leg_kinds()
    return tuple(family for family in _registered if family.applies(instance))


def families_of(instance: Instance) -> tuple[LegFamily, ...]:
    """Those that an instance may have legs of, in the order in which they find connections."""
    return tuple(family for family in families() if family.applies(instance))


def has_only_short(instance: Instance) -> bool:
    """Whether an instance has short legs alone."""
    return [family.kind for family in families_of(instance)] == [SHORT]
