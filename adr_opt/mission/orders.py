"""The rule of orders: which body may come next in an order, regardless of times and the tank."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..kernels.rules.loads import most_kits
from ..kernels.rules.resources import ANY, CountLimits
from ..kernels.rules.rules import Rules

UNEARNED = "refuels, but no target was visited since the last refuelling"
ITSELF = "goes from {name} to itself"
START = "goes to {name}, where a chaser starts"
AGAIN = "goes to {name}, which was visited before"
KITS = "goes to {name}, one more kit than the {kits} of the chaser"
FULL = {
    "targets": "goes to {name}, one more target than the {targets} of the chaser",
    "between": "goes to {name}, one more target than the {between} between refuellings",
}
"""Messages where a limit allows no further target."""

NOTHING = CountLimits(targets=0, between=0)
"""Counts of an order without moves."""


def counts_after(rules: Rules, counts: CountLimits, j: int) -> CountLimits:
    """Counts of an order after a move, of limited quantities only."""
    if rules.is_station[j]:
        return counts._replace(between=0)
    limited = zip(counts, rules.limits, strict=True)
    return CountLimits(*(count + (most != ANY) for count, most in limited))


def why_full(rules: Rules, counts: CountLimits) -> str:
    """Why an order may go to no further target, as one of the sentences above; empty if it may."""
    limits = zip(counts, rules.limits, CountLimits._fields, strict=True)
    return next((FULL[name] for count, most, name in limits if count == most), "")


def first_break(rules: Rules, moves: Sequence[int]) -> tuple[int, str]:
    """The first move of an order that breaks the rule.

    Returns
    -------
    made : int
        Number of moves before it.
    why : str
        One of the sentences above, to which :func:`told` gives names; empty if there is none.
    """
    body, since, visited, counts = rules.start, 0, set[int](), NOTHING
    for made, j in enumerate(moves):
        if rules.is_station[j]:
            if since == 0:
                return made, UNEARNED
            since = 0
        elif j == body:
            return made, ITSELF
        elif j < rules.first_target:
            return made, START
        elif j in visited:
            return made, AGAIN
        elif full := why_full(rules, counts):
            return made, full
        else:
            visited.add(j)
            since += 1
        body, counts = j, counts_after(rules, counts, j)
    return len(moves), ""


def why_broken(
    rules: Rules, moves: Sequence[int], kits_for: Callable[[tuple[int, ...]], float]
) -> str:
    """Why the last move of an order breaks the rule, or takes one kit too many; empty if neither.

    Those before it do not.
    """
    why = first_break(rules, moves)[1]
    if not why and rules.loads is not None:
        needed = kits_for(tuple(moves))
        why = KITS if needed > most_kits(rules.loads) else ""
    return why


def told(rules: Rules, why: str, name: str) -> str:
    """A reason, filled in with the name of a body and the limits of a mission."""
    most = rules.limits._asdict()
    return why.format(name=repr(name), kits=most_kits(rules.loads), **most)
