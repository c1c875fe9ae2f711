"""Kinds of service that a target may need, with the kits or flights they take."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ServiceKind:
    """A kind of service.

    Attributes
    ----------
    name : str
        What instances call it, as ``removal`` of a target.
    counted : str
        What of it may make loads count, as a word; empty if nothing does.
    takes_kit : bool
        Whether the chaser leaves a kit with the object.
    is_flown : bool
        Whether the chaser carries the object away afterwards; how is for :mod:`adr_opt.plan.tows`
        to say.
    """

    name: str
    counted: str = ""
    takes_kit: bool = False
    is_flown: bool = False


SERVICES = {
    kind.name: kind
    for kind in (
        ServiceKind("visit"),
        ServiceKind("kit", "kits", takes_kit=True),
        ServiceKind("tow", "tows", is_flown=True),
    )
}
"""All kinds by name."""
