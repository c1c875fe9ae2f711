"""One window of one body, for kernels."""

import math

import numpy as np

from adr_opt.kernels.core.windows import Windows, windows_of


def one_window(opens: float = -math.inf, latest: float = math.inf) -> Windows:
    """Services of body 0 that begin between two times, by default always [s]."""
    return windows_of(np.zeros(1, dtype=np.int64), np.array([opens]), np.array([latest]))
