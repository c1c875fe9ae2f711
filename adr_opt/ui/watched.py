"""Progress for a program that watches the command line: lines of JSON on standard error."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress

VARIABLE = "ADR_OPT_PROGRESS"
"""Environment variable that requests the lines if it is not empty."""

SIGN = "adr-opt-progress: "
"""Beginning of each line; a JSON object follows, with ``share`` (0 to 1, or null) and ``said``."""

PAUSE_S = 0.3
"""Least interval between lines [s]."""


def teller() -> Callable[[float | None, str], None] | None:
    """A function that reports share and words of the progress; None if not requested."""
    if not os.environ.get(VARIABLE):
        return None
    last = [-PAUSE_S]

    def tell(share: float | None, said: str) -> None:
        now = time.monotonic()
        if now - last[0] < PAUSE_S:
            return
        last[0] = now
        with suppress(OSError, ValueError):
            print(
                f"{SIGN}{json.dumps({'share': share, 'said': said})}", file=sys.stderr, flush=True
            )

    return tell
