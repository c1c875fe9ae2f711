"""Objects that the catalogue says come down: a date against the epoch and the mission."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from ...common.errors import InputError
from ...common.wording import counted
from .records import ElementSet


def end_windows(
    fields: Mapping[int, Mapping[str, Any]],
    targets: Sequence[ElementSet],
    host: ElementSet | None,
    epoch: datetime,
    duration_s: float,
) -> tuple[dict[int, dict[str, Any]], str | None]:
    """Windows of targets that come down within a mission end when they do.

    Parameters
    ----------
    fields : mapping of int to mapping
        Fields of targets by their numbers.
    targets : sequence of ElementSet
        In orbit at the epoch.
    host : ElementSet or None
        The station, if it is an object.
    epoch : datetime
        Of the instance.
    duration_s : float
        Of the mission.

    Returns
    -------
    fields : dict
        With such windows.
    said : str or None
        A sentence about them, if there are any.

    Raises
    ------
    InputError
        The station comes down within the mission, or a target before its window opens.
    """
    if host is not None and _down_s(host, epoch) < duration_s:
        raise InputError(
            f"--station {host.label}: comes down on {host.decays:%Y-%m-%d}, within the mission; "
            "give another one, or a shorter mission"
        )
    ended = {number: dict(its) for number, its in fields.items()}
    falling = [n for n, record in enumerate(targets) if _down_s(record, epoch) < duration_s]
    for number in falling:
        record, its = targets[number], ended.setdefault(number, {})
        opens, closes = its.get("window_s", (0.0, None))
        closes = min(_down_s(record, epoch), math.inf if closes is None else closes)
        if opens >= closes:
            raise InputError(
                f"{record.label}: comes down on {record.decays:%Y-%m-%d}, before its window opens; "
                "leave it out with --exclude"
            )
        its["window_s"] = (opens, closes)
    if not falling:
        return ended, None
    first = min((targets[number] for number in falling), key=lambda record: _down_s(record, epoch))
    return ended, (
        f"{counted(len(falling), 'target comes', 'targets come')} down within the mission, says "
        f"the file, and can be serviced until then; the first is {first.label}, on "
        f"{first.decays:%Y-%m-%d}"
    )


def _down_s(record: ElementSet, epoch: datetime) -> float:
    """When an object comes down, after the epoch [s]; +inf if the file does not say."""
    return math.inf if record.decays is None else (record.decays - epoch).total_seconds()
