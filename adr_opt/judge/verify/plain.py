"""The core of the verifier as the NumPy that it is written in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from . import cargo, closed, completion, cuts


@contextmanager
def plain() -> Iterator[None]:
    """Within this, nothing of the core is compiled: it takes longer, and says the same."""
    of_modules = [(module, vars(module).copy()) for module in (cargo, completion, cuts, closed)]
    try:
        for module, names in of_modules:
            vars(module).update(
                (name, getattr(each, "py_func", each)) for name, each in names.items()
            )
        yield
    finally:
        for module, names in of_modules:
            vars(module).update(names)
