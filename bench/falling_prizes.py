"""Prizes that fall in benchmarks: one after the other in equal parts of the mission."""

from __future__ import annotations

from collections.abc import Sequence

from adr_opt import Instance


def numbers(text: str) -> list[float]:
    """Prizes as typed: ``2,1``; none of an empty text."""
    return [float(each) for each in text.split(",") if each]


def falling(instance: Instance, prizes: Sequence[float]) -> Instance:
    """The same with these prizes of each target; with its own where there are none."""
    if not prizes:
        return instance
    part_s = instance.mission.duration_s / len(prizes)
    levels = tuple((part_s * (n + 1), prize) for n, prize in enumerate(prizes[:-1])) or None
    targets = (target.replace(prize=prizes[-1], prize_until=levels) for target in instance.targets)
    return instance.replace(targets=tuple(targets))
