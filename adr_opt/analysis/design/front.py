"""The Pareto front of designs: most avoided against least euros."""

from __future__ import annotations

from collections.abc import Sequence

from .point import DesignPoint


def pareto_front(points: Sequence[DesignPoint]) -> tuple[int, ...]:
    """Numbers of the points that no other one beats in both worth and euros, cheapest first.

    Of points with equal worth and euros the first stays; those without a plan are left out.
    """
    there = [at for at, point in enumerate(points) if point.plan is not None]
    kept: list[int] = []
    for at in sorted(there, key=lambda at: (points[at].euros, -points[at].worth, at)):
        if not kept or points[at].worth > points[kept[-1]].worth:
            kept.append(at)
    return tuple(kept)
