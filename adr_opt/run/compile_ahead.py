"""A second process that compiles the late kernels of a method while the first begins to plan.

With an empty cache, planning waits for one kernel after another, on one core. Those called last,
the kernels of a proof, can be compiled meanwhile on another core.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from ..kernels.core import archive, cache
from .method_spec import MethodSpec
from .methods import BOUNDS


@contextmanager
def compiling_ahead(method: MethodSpec, drifts: bool) -> Iterator[None]:
    """Compile the late kernels of a method in a second process, if the cache is empty.

    Parameters
    ----------
    method : MethodSpec
    drifts : bool
        Whether nodes drift, as in :func:`.method_call.warm_up`.
    """
    is_cold = cache.is_empty() and not archive.is_usable()
    if not (is_cold and method.late is not None and (os.cpu_count() or 1) > 1):
        yield
        return
    program = (
        f"from adr_opt.run.front import warm_up\nwarm_up({BOUNDS!r}, {method.late!r}, {drifts=})"
    )
    silent = subprocess.DEVNULL
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=silent, stdout=silent, stderr=silent
    ) as worker:
        try:
            yield
        finally:
            worker.terminate()
