"""Errors of bodies, estimated from successive element sets of their objects.

Each element set is propagated by SGP4 to the epoch of every newer one of its object. What the two
then differ by is taken for the error of the older one at that age (D. Vallado and P. Cefola,
Two-Line Element Sets – Practice and Use, IAC-12-C1.6.12, 2012, compare them so). Across the track
and outward it is compared where both pass the same argument of latitude, so that the periodic
terms of gravity drop out, and does not grow; along the track its square is a constant, and one that
drag lets grow with the fourth power of the age.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...problem.instance import Instance
from ..catalogue.propagation import satellite_of
from ..catalogue.reading import load_bytes, read_bytes
from ..catalogue.records import ElementSet
from .target_error import Array, TargetError

FARTHEST_RAD = 0.5 * math.pi
"""Along-track distance above which two sets may differ by a revolution."""

SPREAD = 1.5
"""Ratio of largest to smallest age above which constant and growth can be separated."""


ROUNDS = 6
"""Rounds of the along-track fit, each weighted by the previous one."""

LEAST_M2 = 1.0
"""Least along-track variance used to weight a difference [m²]."""


class SetDifference(NamedTuple):
    """Difference of an element set from a newer one, at the newer set's epoch."""

    age_days: float
    radial_m: float
    along_m: float
    across_m: float


class ErrorGrowth(NamedTuple):
    """Standard deviations estimated from an object's element sets: at age zero, and of decay."""

    radial_m: float
    along_m: float
    across_m: float
    decay_m_per_day: float


@dataclass(frozen=True)
class SetsCompared:
    """Errors of the bodies of an instance, from comparing element sets.

    Attributes
    ----------
    errors : dict
        Body → its error at the epoch.
    growths : dict
        Body → what it was made of.
    differences : dict
        Body → the pairs that were compared.
    by_median : tuple of str
        Bodies with a single element set: they have the medians of the others.
    by_largest : tuple of str
        Bodies whose sets are too far apart to be compared, or fall: the largest of the others.
    """

    errors: dict[str, TargetError]
    growths: dict[str, ErrorGrowth]
    differences: dict[str, tuple[SetDifference, ...]] = field(repr=False)
    by_median: tuple[str, ...]
    by_largest: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """The comparison as plain data."""
        return {
            "compared": len(self.differences),
            "pairs": sum(map(len, self.differences.values())),
            "median_age_days": self.median_age_days,
            "by_median": list(self.by_median),
            "by_largest": list(self.by_largest),
            "bodies": {body: growth._asdict() for body, growth in self.growths.items()},
        }

    @property
    def median_age_days(self) -> float:
        """Median age at which sets were compared [days]."""
        every = [one.age_days for pairs in self.differences.values() for one in pairs]
        return float(np.median(every))


def compared(instance: Instance, paths: Sequence[str | os.PathLike[str]]) -> SetsCompared:
    """Errors of targets, from files with element sets of several epochs.

    Parameters
    ----------
    instance : Instance
        With a date of its epoch; objects are found by the names and designators of its targets.
    paths : sequence of paths

    Raises
    ------
    InputError
        A file is bad, no object has two element sets that can be compared, or a target has none.
    MissingExtra
        sgp4 is not installed.
    """
    sets = _sets_of_targets(instance, paths)
    differences: dict[str, tuple[SetDifference, ...]] = {}
    single: list[str] = []
    far: list[str] = []
    for body, records in sets.items():
        found = [_difference(older, newer) for older, newer in combinations(records, 2)]
        near = tuple(one for one in found if one is not None)
        if near:
            differences[body] = near
        else:
            (far if found else single).append(body)
    if not differences:
        raise InputError(
            f"{', '.join(map(str, paths))}: no target has element sets of two epochs that can be "
            "compared; give older ones, too"
        )
    growths = {
        body: growth_of(pairs, sets[body][-1].mean_motion_rev_day)
        for body, pairs in differences.items()
    }
    columns = np.array(list(growths.values()))
    growths |= dict.fromkeys(single, ErrorGrowth(*np.median(columns, axis=0).tolist()))
    growths |= dict.fromkeys(far, ErrorGrowth(*columns.max(axis=0).tolist()))
    growths = {body: growths[body] for body in sets}
    errors = {
        body: error_of(growth, sets[body][-1].mean_motion_rev_day, _age(instance, sets[body]))
        for body, growth in growths.items()
    }
    return SetsCompared(errors, growths, differences, tuple(single), tuple(far))


def growth_of(differences: Sequence[SetDifference], mean_motion_rev_day: float) -> ErrorGrowth:
    """Standard deviations from the differences of an object."""
    table = np.array(differences)
    ages, along = table[:, 0], table[:, 2]
    # The decay d moves an object by 3/4 n d t² along its track (docs/model.md 1.2).
    grown = (0.75 * math.tau * mean_motion_rev_day * ages**2) ** 2
    columns = [grown]
    if ages.max() >= SPREAD * ages.min():
        columns.append(np.ones_like(grown))
    from scipy.optimize import nnls

    # Squares of differences vary as much as they are large: each counts by the fit before it.
    model, expected = np.column_stack(columns), ages**2
    for _ in range(ROUNDS):
        found, _ = nnls(model / expected[:, None], along**2 / expected)
        expected = np.maximum(model @ found, LEAST_M2)
    radial, across = (math.sqrt(float(np.mean(table[:, at] ** 2))) for at in (1, 3))
    constant = float(found[1]) if found.size > 1 else 0.0
    return ErrorGrowth(radial, math.sqrt(constant), across, math.sqrt(float(found[0])))


def error_of(growth: ErrorGrowth, mean_motion_rev_day: float, age_days: float) -> TargetError:
    """The error at an age of the element set, in elements.

    What is seen outward is of the eccentricity: an error of the semi-major axis would run away
    along the track.
    """
    sigmas = [
        0.0,
        growth.radial_m,
        growth.radial_m,
        growth.across_m,
        growth.across_m,
        growth.along_m,
        growth.decay_m_per_day,
    ]
    aged = np.eye(7)
    aged[0, 6] = -age_days
    aged[5, 6] = 0.75 * math.tau * mean_motion_rev_day * age_days**2
    covariance: Array = aged @ np.diag(np.square(sigmas)) @ aged.T
    return TargetError(covariance, "elements")


def _sets_of_targets(
    instance: Instance, paths: Sequence[str | os.PathLike[str]]
) -> dict[str, list[ElementSet]]:
    """Element sets of each target by epoch, the same one once."""
    by_name = {target.name.casefold(): target.name for target in instance.targets}
    listed = [target.object_id for target in instance.targets if target.object_id is not None]
    by_designator = {
        target.object_id: target.name
        for target in instance.targets
        if target.object_id is not None and listed.count(target.object_id) == 1
    }
    found: dict[str, dict[Any, ElementSet]] = {target.name: {} for target in instance.targets}
    for path in paths:
        for record in read_bytes(load_bytes(path), str(path)):
            body = by_name.get(record.label.casefold()) or by_designator.get(record.object_id)
            if body is not None and not record.not_sgp4:
                found[body][record.epoch] = record
    missing = [name for name, records in found.items() if not records]
    if missing:
        more = f" and {len(missing) - 1} more targets" if len(missing) > 1 else ""
        raise InputError(
            f"{', '.join(map(str, paths))}: no element set of {missing[0]!r}{more}; give the "
            "catalogue that they were imported from, too"
        )
    return {name: [of[at] for at in sorted(of)] for name, of in found.items()}


def _age(instance: Instance, records: Sequence[ElementSet]) -> float:
    """Age at the epoch of the newest element set up to it [days]."""
    ages = [(instance.epoch - record.epoch).total_seconds() / DAY_S for record in records]
    return min((age for age in ages if age >= 0.0), default=0.0)


def _difference(older: ElementSet, newer: ElementSet) -> SetDifference | None:
    """Difference of two sets at the newer epoch; None if it cannot be determined."""
    age_s = (newer.epoch - older.epoch).total_seconds()
    code, place, velocity = satellite_of(newer).sgp4_tsince(0.0)
    if code:
        return None
    there, speed = np.array(place), np.array(velocity)
    radius = float(np.linalg.norm(there))
    outward = there / radius
    normal = np.cross(there, speed)
    normal /= np.linalg.norm(normal)
    ahead = np.cross(normal, outward)
    rate = float(speed @ ahead) / radius
    satellite, late_s, angle = satellite_of(older), 0.0, 0.0
    for _ in range(4):  # to where the older set passes the same argument of latitude
        code, place, _ = satellite.sgp4_tsince((age_s + late_s) / 60.0)
        if code:
            return None
        here = np.array(place)
        step = math.atan2(float(here @ ahead), float(here @ outward))
        angle += step
        late_s -= step / rate
        if abs(angle) > FARTHEST_RAD:
            return None
    radial, across = float(here @ outward) - radius, float(here @ normal)
    return SetDifference(age_s / DAY_S, 1e3 * radial, 1e3 * radius * angle, 1e3 * across)
