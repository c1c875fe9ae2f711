"""What an instance may state, but nothing can plan yet."""

from __future__ import annotations

from collections.abc import Iterator

from .errors import InputError
from .instance import Instance
from .settings import TransferSettings


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
    usual = TransferSettings().departure_spacing_s
    if instance.transfer.departure_spacing_s != usual:
        yield f"field transfer.departure_spacing_s is not supported yet; write {usual!r}"
