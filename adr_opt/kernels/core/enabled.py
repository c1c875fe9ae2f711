"""Whether Numba compiles: without it no kernel can be called."""

import os

from ...common.errors import InputError

VARIABLE = "NUMBA_DISABLE_JIT"
"""Environment variable of Numba under which nothing is compiled."""


def obstacle() -> str | None:
    """Why Numba compiles nothing, in a sentence that says what to do; None if it compiles."""
    if os.environ.get(VARIABLE, "0") in ("", "0"):
        return None
    return f"{VARIABLE} is set, so that nothing is compiled; unset it"


def need() -> None:
    """Raise :class:`InputError` if nothing is compiled."""
    said = obstacle()
    if said is not None:
        raise InputError(said)
