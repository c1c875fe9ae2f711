"""Reference frame of a file, and the rotation into it from an instance's own."""

from __future__ import annotations

from dataclasses import dataclass

from ...common.errors import InputError
from ...problem.frame import FRAMES, OF_DATE, Frame, FrameName
from ...problem.frame_rotation import rotation
from ...problem.instance import Instance
from .kepler import Array

UNKNOWN: FrameName = "EME2000"
"""Name given by default to the frame of an instance that does not state its own."""

KNOWN: FrameName = "GCRF"
"""Frame by default where that of the instance is known.

Not its own: readers take TEME for that of each state's date, whatever ``REF_FRAME_EPOCH`` says.
"""


@dataclass(frozen=True)
class Axes:
    """Axes in which a file states positions, velocities and burns.

    Attributes
    ----------
    frame : Frame
        As the file names them.
    own : Frame or None
        What the instance names; None where it names none.
    matrix : (3, 3) float64 or None
        From the axes of the elements to these; None where they are equal or unknown.
    """

    frame: Frame
    own: Frame | None = None
    matrix: Array | None = None

    def turned(self, vectors: Array) -> Array:
        """Vectors of shape (…, 3) in these axes."""
        if self.matrix is None:
            return vectors
        found: Array = vectors @ self.matrix.T
        return found

    @property
    def said(self) -> str:
        """A sentence that describes the axes."""
        if self.own is None:
            return (
                "The reference frame was named on export: the instance says only that its "
                "elements are inertial, and nothing was transformed."
            )
        if self.matrix is None:
            return f"The reference frame is that of the elements of the instance, {self.own}."
        return (
            f"States and burns were turned from the frame of the elements, {self.own}, to "
            f"{self.frame}, with astropy."
        )


def axes_of(instance: Instance, frame: str | None = None) -> Axes:
    """Axes of a frame for an instance.

    Parameters
    ----------
    instance : Instance
    frame : {"EME2000", "GCRF", "ICRF", "TEME"}, optional
        By default GCRF, and EME2000 if the instance names none. Where the instance names one,
        vectors are turned from that to this; else this is only a name. The axes of TEME are those
        of the instance's epoch, but where it is the instance's own, those that it says.

    Raises
    ------
    InputError
        An unknown frame.
    MissingExtra
        There is something to turn, and astropy is not installed.
    """
    own = instance.frame
    wanted = _named(frame or (UNKNOWN if own is None else KNOWN), instance)
    if own is None:
        return Axes(wanted)
    if wanted.name == own.name:
        return Axes(own, own)
    return Axes(wanted, own, rotation(own, wanted))


def _named(name: str, instance: Instance) -> Frame:
    for known in FRAMES:
        if name == known:
            return Frame(name=known, axes_epoch=instance.epoch if known in OF_DATE else None)
    raise InputError(f"frame = {name!r}: use one of {', '.join(FRAMES)}")
