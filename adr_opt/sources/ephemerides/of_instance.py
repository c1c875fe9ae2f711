"""Ephemerides of the bodies of an instance."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from datetime import datetime
from functools import partial

import numpy as np
import numpy.typing as npt

from ...common.errors import InputError
from ...problem.ephemerides import EphemerisKind
from ...problem.frame import Frame
from ...problem.instance import Instance
from ..catalogue.propagation import satellite_of
from ..catalogue.records import ElementSet
from .by_table import ByTable
from .elements_file import read_elements
from .ephemeris import Array, Ephemeris, TurningAxes
from .oem import read_oem
from .oem_segment import MessageSegment


class ByElements:
    """States of an element set by SGP4, at 0.7 µs each without the turning of the axes.

    The velocities are SGP4's. They are not the derivatives of its positions: 2.6 cm/s lie between
    in the median of real element sets.

    Parameters
    ----------
    body : str
        Name of the body.
    record : ElementSet
    epoch : datetime
        Of the instance.
    axes : TurningAxes
        Into the frame of the instance; shared by its bodies.
    """

    def __init__(self, body: str, record: ElementSet, epoch: datetime, axes: TurningAxes) -> None:
        self.body, self.record, self._axes = body, record, axes
        self._satellite = satellite_of(record)
        self._since_s = (epoch - record.epoch).total_seconds()

    def state(self, times_s: npt.ArrayLike) -> Array:
        """As of :class:`.ephemeris.Ephemeris`.

        Raises
        ------
        InputError
            SGP4 fails at a time; it says that the object has decayed.
        """
        times = np.asarray(times_s, dtype=np.float64)
        flat = times.ravel()
        satellite = self._satellite
        # From the satellite's own epoch on, so that no digits of the date are lost.
        days = np.full(flat.size, satellite.jdsatepoch)
        fractions = satellite.jdsatepochF + (self._since_s + flat) / 86400.0
        codes, positions, velocities = satellite.sgp4_array(days, fractions)
        states = 1e3 * np.column_stack((positions, velocities)).reshape(-1, 6)
        bad = np.flatnonzero((codes != 0) | ~np.isfinite(states).all(axis=1))
        if bad.size:
            raise InputError(self._failure(int(codes[bad[0]]), float(flat[bad[0]])))
        turned: Array = self._axes.turned(states, flat).reshape(*times.shape, 6)
        return turned

    def _failure(self, code: int, time_s: float) -> str:
        from sgp4.api import SGP4_ERRORS

        said = SGP4_ERRORS.get(code, "no finite state")
        return (
            f"{self.body!r}: SGP4 error {code} {time_s / 86400.0:.3g} days after the epoch "
            f"({said}); leave the object out, or shorten the mission"
        )


class Ephemerides:
    """Ephemerides of bodies by name, each made on demand.

    Parameters
    ----------
    makers : mapping
        Body → how its ephemeris is made.
    name : str
        Of the instance.
    """

    def __init__(self, makers: Mapping[str, Callable[[], Ephemeris]], name: str) -> None:
        self._makers, self._name = makers, name
        self._made: dict[str, Ephemeris] = {}

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that have an ephemeris."""
        return tuple(self._makers)

    def of(self, body: str) -> Ephemeris:
        """The ephemeris of a body.

        Raises
        ------
        InputError
            It has none, or it cannot be read.
        """
        if body not in self._makers:
            raise InputError(f"{body!r} of {self._name!r} has no ephemeris; import it with one")
        if body not in self._made:
            self._made[body] = self._makers[body]()
        return self._made[body]


def ephemerides_of(instance: Instance) -> Ephemerides:
    """Ephemerides beside an instance, read from the folder of its file; their digest is checked.

    Raises
    ------
    InputError
        The instance names none, or their files are missing, others than it says, or bad.
    MissingExtra
        sgp4 or astropy is not installed.
    """
    reference = instance.ephemerides
    if reference is None:
        raise InputError(f"{instance.name!r} has no ephemerides; make it with import --ephemerides")
    assert instance.frame is not None  # the instance requires it
    contents = reference.contents(instance.folder())
    designators = {station.name: station.object_id for station in instance.stations}
    designators |= {target.name: target.object_id for target in instance.targets}
    return of_contents(
        reference.kind,
        contents,
        designators,
        epoch=instance.epoch,
        frame=instance.frame,
        name=instance.name,
    )


def ephemeris_of(instance: Instance, body: str) -> Ephemeris:
    """Ephemeris of one body; for several, ask :func:`ephemerides_of` once.

    Raises
    ------
    InputError, MissingExtra
        As of :func:`ephemerides_of` and :meth:`Ephemerides.of`.
    """
    return ephemerides_of(instance).of(body)


def of_contents(
    kind: EphemerisKind,
    contents: Mapping[str, bytes],
    designators: Mapping[str, str | None],
    *,
    epoch: datetime,
    frame: Frame,
    name: str = "",
) -> Ephemerides:
    """Ephemerides from the content of files.

    Parameters
    ----------
    kind : {"elements", "oem"}
    contents : mapping
        File → content.
    designators : mapping
        Body → its international designator, if known.
    epoch, frame, name
        Of the instance.

    Raises
    ------
    InputError
        A file is bad, or names two objects that are one body.
    """
    axes = TurningAxes(epoch, frame)
    makers: dict[str, Callable[[], Ephemeris]] = {}
    if kind == "elements":
        for source, content in contents.items():
            for body, record in read_elements(content, source).items():
                makers[body] = partial(ByElements, body, record, epoch, axes)
        return Ephemerides(makers, name)
    segments = [
        segment for source, content in contents.items() for segment in read_oem(content, source)
    ]
    for body, found in by_body(segments, designators).items():
        makers[body] = partial(ByTable, body, found, epoch, frame, axes)
    return Ephemerides(makers, name)


def by_body(
    segments: Iterable[MessageSegment], designators: Mapping[str, str | None]
) -> dict[str, list[MessageSegment]]:
    """Segments of each body: those whose object has its name or its designator.

    Raises
    ------
    InputError
        Two objects are one body.
    """
    by_name = {body.casefold(): body for body in designators}
    by_designator: dict[str, str | None] = {}
    for body, designator in designators.items():
        if designator is not None:
            # Of two bodies with one designator the name decides.
            by_designator[designator.upper()] = (
                None if designator.upper() in by_designator else body
            )
    found: dict[str, list[MessageSegment]] = {}
    for segment in segments:
        object_name, object_id = segment.names
        named = by_name.get(object_name.casefold()) or by_designator.get(object_id.upper())
        if named is None:
            continue
        others = found.setdefault(named, [])
        if others and others[0].names != segment.names:
            raise InputError(
                f"{segment.where}: {named!r} has another ephemeris, of another object, in "
                f"{others[0].source}, line {others[0].line}; give one of them"
            )
        others.append(segment)
    return found
