"""Differences of a variant of a mission, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ...common.constants import DAY_S
from ...common.wording import counted, shortened
from ...problem.bodies import Target
from ...problem.instance import Instance
from .drafts import amount_of, unit_of

FEW = 2
"""Maximum number of targets named one by one; more are counted."""

LONGEST_NAME = 18


def differences(first: Instance, now: Instance) -> str:
    """Differences between two missions, such as "without SL-16 R/B 23405, 9 d"; empty if equal.

    Parameters
    ----------
    first, now : Instance
    """
    before = {target.name: target for target in first.targets}
    after = {target.name: target for target in now.targets}
    kept = [(before[name], after[name]) for name in after if name in before]

    def of(changed: Callable[[Target, Target], bool]) -> list[str]:
        return [new.name for old, new in kept if changed(old, new)]

    in_file = first.windows != now.windows
    said = [
        _named("without", before.keys() - after.keys()),
        _named("with", after.keys() - before.keys()),
        _named("required:", of(lambda old, new: new.required and not old.required)),
        _named("not required:", of(lambda old, new: old.required and not new.required)),
        _named("prizes of", of(lambda old, new: old.greatest_prize != new.greatest_prize)),
        _named("windows of", [] if in_file else of(lambda a, b: _windows(a) != _windows(b))),
        _named("services of", of(lambda old, new: old.removal != new.removal)),
        _named("masses of", of(lambda old, new: old.mass_kg != new.mass_kg)),
    ]
    if first.mission.duration_s != now.mission.duration_s:
        said.append(f"{now.mission.duration_s / DAY_S:.6g} d")
    tanks = {chaser.name: amount_of(chaser) for chaser in first.chasers}
    for chaser in now.chasers:
        if chaser.name in tanks and tanks[chaser.name] != amount_of(chaser):
            whose = f"{chaser.name} with " if len(now.chasers) > 1 else ""
            said.append(f"{whose}{amount_of(chaser):.6g} {unit_of(chaser)}")
    said += [
        f"other {part}"
        for part, old, new in (
            ("chasers", list(tanks), [chaser.name for chaser in now.chasers]),
            ("stations", first.stations, now.stations),
            ("transfers", first.transfer, now.transfer),
            ("objective", first.objective, now.objective),
        )
        if old != new
    ]
    if in_file:
        said.append("captures in windows" if now.windows is not None else "captures at any time")
    if first.dynamics != now.dynamics:
        said.append(now.dynamics)
    return ", ".join(part for part in said if part)


def _windows(target: Target) -> tuple[object, ...]:
    return target.window_s, target.windows_s, target.capture_s


def _named(words: str, names: Iterable[str]) -> str:
    """A change to some targets, which are named if few, else counted; empty without targets."""
    names = sorted(names)
    if not names:
        return ""
    if len(names) > FEW:
        return f"{words} {counted(len(names), 'target')}"
    short = shortened(names, LONGEST_NAME)
    return f"{words} {' and '.join(short[name] for name in names)}"
