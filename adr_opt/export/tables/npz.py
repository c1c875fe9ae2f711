"""``.npz``: arrays for NumPy, without pickles."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...legs.matrices import Matrices
from ...mission.mission import Mission


def write(path: Path, mission: Mission, matrices: Matrices) -> None:
    """Write the arrays.

    ``departures_s`` (departures,) [s], ``names`` (bodies,) with the stations first,
    ``delta_v_m_s`` and ``duration_s`` (departures, bodies, bodies) [m/s], [s], ``service_s``
    (bodies,) [s], and the scalars ``instance`` (its name), ``sha256`` and ``transfers`` (which
    ones, in words). +inf stands where there is no transfer; durations are from ready to arrival,
    without service.
    """
    # A file and not a name: NumPy would append .npz to a name that ends in .NPZ.
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            departures_s=matrices.departures,
            names=np.array(matrices.names, dtype=np.str_),
            delta_v_m_s=matrices.delta_v,
            duration_s=matrices.duration,
            service_s=mission.rules.service,
            instance=np.array(mission.instance.name, dtype=np.str_),
            sha256=np.array(mission.instance.sha256, dtype=np.str_),
            transfers=np.array(matrices.choice, dtype=np.str_),
        )
