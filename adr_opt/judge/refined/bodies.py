"""Whether the stated states of bodies at the epoch are those of their orbits."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...common.constants import OBLATENESS_M2
from ...kernels.orbits import elements
from ...kernels.orbits.short_periods import osculating
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ..check.violation import Violation
from .as_reported import ReportedStates
from .world import FIELDS

Array = npt.NDArray[np.float64]

SAME_M, SAME_M_S = 10.0, 1e-2
"""Tolerances of states [m], [m/s]."""

KEPT_UP_M, KEPT_UP_M_S = 5e3, 5.0
"""The same of states at the epoch where harmonics act: the size of an orbit is corrected such that
the body keeps up with its mean elements, and so is its place."""


def check_bodies(
    instance: Instance, refined: RefinedPlan, reported: ReportedStates | None
) -> Iterator[Violation]:
    """Check each body: at the epoch it is where the instance, or its ephemeris, says.

    Parameters
    ----------
    reported : ReportedStates or None
        Of a plan that was refined onto ephemerides.
    """
    orbits = dict(zip(instance.names, instance.body_orbits, strict=True))
    gravity = refined.gravity
    two_body = gravity == "two-body"
    limit = (SAME_M, SAME_M_S) if two_body else (KEPT_UP_M, KEPT_UP_M_S)
    for body in refined.bodies:
        if body.name not in orbits:
            yield Violation(None, "body", f"{body.name!r} is not a body of the instance")
            continue
        stated = np.array([*body.position_m, *body.velocity_m_s])
        if reported is not None and body.name in reported.bodies:
            true, most = reported.state(body.name, 0.0), (SAME_M, SAME_M_S)
        elif instance.decay_of(body.name):
            yield Violation(
                None,
                "body",
                f"the orbit of {body.name!r} decays, and the plan is not refined onto ephemerides",
            )
            continue
        else:
            row = np.array(orbits[body.name].row(0.0 if two_body else OBLATENESS_M2))
            true, most = osculating(*elements.equinoctial_at(row, 0.0), FIELDS[gravity]), limit
        off, fast = math.dist(stated[:3], true[:3]), math.dist(stated[3:], true[3:])
        if not (off <= most[0] and fast <= most[1]):
            yield Violation(
                None,
                "body",
                f"{body.name!r} is {off:.3g} m and {fast:.3g} m/s off its place at the epoch",
            )
