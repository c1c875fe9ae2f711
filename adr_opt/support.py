"""What an instance may state, but nothing can plan yet."""

from __future__ import annotations

from collections.abc import Iterator

from .chasers import Chaser, InOrbit
from .errors import InputError
from .instance import Instance
from .settings import TransferSettings

ALWAYS = (0.0, None)
"""The window that is always open."""


def unsupported(instance: Instance) -> str | None:
    """The first thing that an instance states and that cannot be planned with yet, in a sentence.

    Returns
    -------
    str or None
        None if it can be planned with.
    """
    said = next(_departures(instance), None)
    return None if said is None else f"{instance.name!r}: {said}"


def refuse_unsupported(instance: Instance) -> None:
    """Raise :class:`InputError` for an instance that cannot be planned with yet."""
    said = unsupported(instance)
    if said is not None:
        raise InputError(said)


def _departures(instance: Instance) -> Iterator[str]:
    """Each with the field that departs and what to write there."""
    if not instance.stations:
        yield "field stations: a mission without a station is not supported yet; give one"
    if len(instance.stations) > 1:
        yield f"field stations: {len(instance.stations)} are not supported yet; give one"
    for number, target in enumerate(instance.targets):
        field = f"field targets[{number}]"
        if target.window_s != ALWAYS:
            yield f"{field}.window_s is not supported yet; write [0.0, null]"
        if target.required:
            yield f"{field}.required = true is not supported yet; write false"
    for number, chaser in enumerate(instance.chasers):
        yield from _departures_of(f"field chasers[{number}]", chaser)
    if instance.mission.service_s is not None:
        yield "field mission.service_s is not supported yet; write service_revolutions"
    usual = TransferSettings()
    for name in ("delta_v_resolution_m_s", "departure_spacing_s"):
        known = getattr(usual, name)
        if getattr(instance.transfer, name) != known:
            yield f"field transfer.{name} is not supported yet; write {known!r}"
    if instance.objective.cost != "delta-v":
        yield (
            f'field objective.cost = "{instance.objective.cost}" is not supported yet; '
            'write "delta-v"'
        )


def _departures_of(field: str, chaser: Chaser) -> Iterator[str]:
    if isinstance(chaser.start, InOrbit):
        yield f'{field}.start in an orbit is not supported yet; write {{"station": NAME}}'
    if chaser.available_s != ALWAYS:
        yield f"{field}.available_s is not supported yet; write [0.0, null]"
    if chaser.end != "anywhere":
        yield f'{field}.end at a station is not supported yet; write "anywhere"'
    if chaser.max_targets is not None:
        yield f"{field}.max_targets is not supported yet; write null"
