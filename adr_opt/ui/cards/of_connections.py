"""Cards of connections, found or given."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.card import Card, CardTable, days
from ...common.wording import counted

if TYPE_CHECKING:
    from ...legs.connections import AllConnections, Connections
    from ...problem.given import Given


def of_connections(found: Connections) -> Card:
    """The card of a pair's connections; on a page, with all of them."""
    count = int(found.departure.size)
    facts = [str(count) if count else "none"]
    if count:
        facts += [
            f"day {days(found.departure[0])} to {days(found.arrival.max())}",
            f"{found.delta_v.min():,.1f} to {found.delta_v.max():,.1f} m/s",
        ]
    columns = zip(found.departure, found.arrival, found.delta_v, found.revolutions, strict=True)
    rows = [
        (days(leaves), days(lands), f"{cost:,.1f}", f"{turns}")
        for leaves, lands, cost, turns in columns
    ]
    heads = ("departure day", "arrival day", "ΔV m/s", "revolutions")
    return Card("Connections", "", tuple(facts), (), (CardTable(heads, rows, texts=0),))


def of_all(found: AllConnections) -> Card:
    """The card of all pairs' connections."""
    pairs = len(set(zip(found.origin.tolist(), found.destination.tolist(), strict=True)))
    facts = [f"{len(found)}" if len(found) else "none", f"of {pairs} pairs"]
    if len(found):
        facts.append(f"{found.delta_v.min():,.1f} to {found.delta_v.max():,.1f} m/s")
    return Card("AllConnections", "", tuple(facts), (), ())


def of_given(given: Given) -> Card:
    """The card of given connections."""
    facts = (
        counted(int(given.departure.size), "connection"),
        counted(len(given.names), "body", "bodies"),
        f"sha256 {given.sha256[:12]}…",
    )
    return Card("Given", "", facts)
