"""Fields whose targets are on ellipses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adr_opt.problem.instance import Instance


def eccentric(instance: Instance, most: float, seed: int | Sequence[int]) -> Instance:
    """The field with eccentricities drawn up to some value, and perigees anywhere."""
    rng = np.random.default_rng(seed)
    targets = tuple(
        target.replace(
            orbit=target.orbit.replace(
                eccentricity=most * float(rng.random()),
                argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
            )
        )
        for target in instance.targets
        if target.orbit is not None
    )
    return instance.replace(targets=targets)
