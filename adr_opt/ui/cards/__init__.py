"""How objects show themselves: in one line at a prompt, as a small table in a notebook.

A class that is :class:`Shown` says what is worth knowing of it as a :class:`Card`; the modules
`of_…` make those of each kind. Names come from files of others, so pages escape all of them.
"""

from __future__ import annotations

from ...common.card import Card, Shown, Table

__all__ = ["Card", "Shown", "Table"]
