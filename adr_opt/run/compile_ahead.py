"""A second process that compiles late kernels of a method while the first begins to plan.

Where no kernel has been compiled yet, planning waits for one after the other, on one core. What a
method calls last, the kernels of a proof, can be compiled meanwhile on another one.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from ..kernels.core import archive, cache
from .method_call import warm_up
from .method_spec import MethodSpec
from .methods import BOUNDS

DRIFTS = "--drifts"


@contextmanager
def compiling_ahead(method: MethodSpec, drifts: bool) -> Iterator[None]:
    """Compile in a process of its own what a method calls late, where nothing is compiled yet.

    Parameters
    ----------
    method : MethodSpec
    drifts : bool
        Whether nodes drift, as in :func:`.method_call.warm_up`.
    """
    is_cold = cache.is_empty() and not archive.is_usable()
    if not (is_cold and method.late and (os.cpu_count() or 1) > 1):
        yield
        return
    call = [sys.executable, "-m", __name__, *method.late, *([DRIFTS] if drifts else [])]
    silent = subprocess.DEVNULL
    with subprocess.Popen(call, stdin=silent, stdout=silent, stderr=silent) as worker:
        try:
            yield
        finally:
            worker.terminate()


def main(arguments: list[str]) -> None:
    """Compile the kernels of bounds."""
    for bound in arguments:
        if bound != DRIFTS:
            warm_up(BOUNDS, bound, drifts=DRIFTS in arguments)


if __name__ == "__main__":
    main(sys.argv[1:])
