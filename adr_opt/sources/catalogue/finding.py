"""Look-up of catalogue objects by number, name or designator."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...common.errors import InputError
from .records import ElementSet, shown

ANY = "one of the catalogue"


class Finder:
    """Finds objects in a list; a batch of look-ups takes one pass over the objects.

    Parameters
    ----------
    records : sequence of ElementSet
    """

    def __init__(self, records: Sequence[ElementSet]) -> None:
        self.records = records
        self._by_number: dict[str, list[int]] = {}
        self._by_name: dict[str, list[int]] = {}
        for at, record in enumerate(records):
            self._by_number.setdefault(str(record.number), []).append(at)
            for name in {record.name, record.label, record.object_id}:
                self._by_name.setdefault(name.casefold(), []).append(at)

    def all(self, text: str) -> list[int]:
        """Indices of all objects that a text denotes; case is ignored."""
        wanted = text.strip().casefold()
        found = self._by_number.get(wanted, []) if wanted.isdigit() else []
        return found or self._by_name.get(wanted, [])

    def one(self, text: str, option: str, instead: str = ANY) -> int:
        """Index of the object that a text denotes.

        Parameters
        ----------
        text : str
        option, instead : str
            Name of the option, and its expected value, for the sentences of errors.

        Raises
        ------
        InputError
            There is none, or more than one.
        """
        if not text.strip():
            raise InputError(f"{option} '': give {instead}")
        found = self.all(text)
        if not found:
            raise InputError(
                f"{option} {shown(text)!r}: no object has this number or name; give {instead}"
            )
        if len(found) > 1:
            raise InputError(
                f"{option} {shown(text)!r}: {len(found)} objects have this name; give the "
                f"catalogue number, {self.records[found[0]].number} for the first"
            )
        return found[0]

    def listed(self, texts: Iterable[str], option: str) -> dict[int, str]:
        """Indices of objects given singly or separated by commas, with the text of each.

        A text that is the name of an object is that object, commas and all.

        Raises
        ------
        InputError
            As for :meth:`one`.
        """
        found: dict[int, str] = {}
        for text in texts:
            parts = [text] if self.all(text) else text.split(",")
            found |= {self.one(part, option): part.strip() for part in parts}
        return found
