"""Registry of families of legs."""

from __future__ import annotations

from ...plan.leg_kinds import SHORT, add_leg_kind, drop_leg_kind, leg_kinds
from ...plan.phases import add_phase, drop_phase, refuse_known_phase
from ...problem.drives import Drive
from ...problem.instance import Instance
from .family import LegFamily, RegisteredFamily

_own: list[LegFamily] = []
_registered: list[RegisteredFamily] = []


def bring_along(*found: LegFamily) -> None:
    """Register the families of this package, whose kinds are already known."""
    _own.extend(found)


def register(family: RegisteredFamily) -> None:
    """Register a family: its legs can then be planned, judged, flown and shown.

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
    """Unregister the family that was registered last.

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
    """All families, each at its number."""
    leg_kinds()  # those that installed packages register are known from here
    return (*_own, *_registered)


def registered_of(instance: Instance) -> tuple[RegisteredFamily, ...]:
    """Families from outside the package whose legs an instance may have."""
    leg_kinds()
    return tuple(family for family in _registered if family.applies(instance))


def families_of(instance: Instance, drive: Drive | None = None) -> tuple[LegFamily, ...]:
    """Families of the legs of chasers with a drive, in the order in which they find connections."""
    return tuple(
        family for family in families() if family.applies(instance) and family.serves(drive)
    )


def has_only_short(instance: Instance) -> bool:
    """Whether an instance has only short legs."""
    return [family.kind for family in families_of(instance)] == [SHORT]
