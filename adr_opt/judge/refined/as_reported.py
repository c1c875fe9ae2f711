"""States that ephemerides report of bodies, read for the judge.

Element sets are run by the ``sgp4`` package as their OMM says, without the records and tables of
:mod:`adr_opt.sources`, and turned by the axes of each date. Messages are interpolated by
:mod:`adr_opt.sources.ephemerides`.
"""

from __future__ import annotations

from datetime import timedelta
from typing import Any

import numpy as np
import numpy.typing as npt

from ...common.constants import DAY_S
from ...common.errors import InputError, MissingExtra
from ...common.json_text import loaded
from ...plan.refined_plan import EphemeridesReference
from ...problem.frame_rotation import from_gcrf, teme_axes
from ...problem.instance import Instance
from ...sources.ephemerides.coverage import Coverage
from ...sources.ephemerides.oem import read_oem
from ...sources.ephemerides.oem_segment import MessageSegment
from ...sources.ephemerides.of_instance import by_body
from .as_interpolated import interpolated_states

Array = npt.NDArray[np.float64]


class ReportedStates:
    """States of the bodies of an instance that have an ephemeris.

    Parameters
    ----------
    instance : Instance
    onto : EphemeridesReference
        Those that a plan was refined onto.

    Raises
    ------
    InputError
        They are not those of the instance, or cannot be read.
    MissingExtra
        sgp4 or astropy is not installed.
    """

    def __init__(self, instance: Instance, onto: EphemeridesReference) -> None:
        its = instance.ephemerides
        if its is None or (its.kind, its.sha256) != (onto.kind, onto.sha256):
            raise InputError(
                f"the plan was refined onto ephemerides (sha256 {onto.sha256[:12]}…) that are not "
                f"those of {instance.name!r}; refine it again"
            )
        self._instance, self._elements = instance, dict[str, dict[str, Any]]()
        self._segments: dict[str, list[MessageSegment]] = {}
        self._covered: dict[str, Coverage] = {}
        contents = its.contents(instance.folder())
        if onto.kind == "oem":
            every = [one for name, content in contents.items() for one in read_oem(content, name)]
            listed = {station.name: station.object_id for station in instance.stations}
            listed |= {target.name: target.object_id for target in instance.targets}
            self._segments = by_body(every, listed)
        else:
            for content in contents.values():
                self._elements |= loaded(content)["bodies"]
        self.bodies = tuple(self._segments or self._elements)

    def state(self, body: str, time_s: float) -> Array:
        """State reported of a body in the frame of the instance, shape (6,) [m, m/s]."""
        found: Array = self.states(body, np.array([time_s]))[0]
        return found

    def states(self, body: str, times_s: Array) -> Array:
        """States reported of a body at times, shape (times, 6) [m, m/s].

        Raises
        ------
        InputError
            The ephemeris does not reach as far.
        """
        instance = self._instance
        assert instance.frame is not None  # ephemerides require it
        if self._segments:
            if body not in self._covered:
                self._covered[body] = Coverage(body, self._segments[body], instance.epoch)
            return interpolated_states(self._covered[body], times_s, instance.epoch, instance.frame)
        try:
            from sgp4 import omm
            from sgp4.api import Satrec
            from sgp4.conveniences import jday_datetime
        except ImportError:
            raise MissingExtra("flying onto element sets", "sgp4", "astro") from None
        satellite = Satrec()
        omm.initialize(satellite, self._elements[body])
        day, fraction = jday_datetime(instance.epoch)
        fractions = fraction + times_s / DAY_S
        codes, *vectors = satellite.sgp4_array(np.full(times_s.size, day), fractions)
        if codes.any():
            raise InputError(f"{body!r}: SGP4 error {codes.max()}; refine the plan again")
        dates = [instance.epoch + timedelta(seconds=time_s) for time_s in times_s.tolist()]
        turns = from_gcrf(instance.frame) @ np.swapaxes(teme_axes(dates), 1, 2)
        turned = [np.einsum("tij,tj->ti", turns, vector) for vector in vectors]
        return 1e3 * np.column_stack(turned)
