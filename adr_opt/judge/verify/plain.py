"""The core of the verifier as the NumPy that it is written in."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from . import cargo, closed, completion, cuts


@contextmanager
def plain() -> Iterator[None]:
    """Within this, nothing of the core is compiled: it takes longer, and says the same."""
    modules = cargo, completion, cuts, closed
    kernels = [
        (module, name, each)
        for module in modules
        for name, each in vars(module).items()
        if hasattr(each, "py_func")
    ]
    try:
        for module, name, each in kernels:
            setattr(module, name, each.py_func)
        yield
    finally:
        for module, name, each in kernels:
            setattr(module, name, each)
