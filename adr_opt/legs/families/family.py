"""Interface of a family of legs, for planning, judging and flying."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ...kernels.legs.co_elliptic import TransferRule
from ...kernels.legs.departure_events import Times
from ...kernels.legs.found import ConnectionArrays
from ...plan.after_tows import Pieced, Pieces
from ...plan.leg_kinds import LegKind, leg_kinds
from ...plan.phases import Phase
from ...problem.drives import Drive
from ...problem.instance import Instance

FloatArray = npt.NDArray[np.float64]


class PiecedEnd(NamedTuple):
    """An origin whose row changes between pieces of time: its rows at events and on a grid.

    Attributes
    ----------
    pieced : Pieced
    pieces : Pieces
    on_grid : (times, columns) float64
        At the times of the grid of long transfers.
    """

    pieced: Pieced
    pieces: Pieces
    on_grid: FloatArray


class PairEnds(NamedTuple):
    """Data that determine the legs of a pair of bodies.

    Attributes
    ----------
    instance : Instance
    origin, destination : int
        Numbers of the bodies.
    leaving, arriving : (columns,) float64
        The origin as it is left and the destination as it is arrived at, rows of
        :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    eccentricity_m_s : float
        What matching the eccentricity vectors alone costs [m/s].
    rule : TransferRule
    times : Times or None
        When transfers may leave; None where departure events are regular.
    latest_s : float
        No connection arrives later [s].
    drive : Drive or None
        Of a chaser with low thrust; None for impulses.
    relaxed : bool
        Whether connections of low thrust are to be lower bounds for all masses of the chaser.
    pieces : PiecedEnd or None
        The origin as it is left, where that is another body from piece to piece of time.
    since_s : float
        Connections that leave before may be left out [s].
    """

    instance: Instance
    origin: int
    destination: int
    leaving: FloatArray
    arriving: FloatArray
    eccentricity_m_s: float
    rule: TransferRule
    times: Times | None
    latest_s: float
    drive: Drive | None = None
    relaxed: bool = False
    pieces: PiecedEnd | None = None
    since_s: float = -math.inf

    def left_at(self, time_s: float) -> FloatArray:
        """Row of the origin as the chaser leaves it at a time, shape (columns,)."""
        return self.leaving if self.pieces is None else self.pieces.pieced.row_at(time_s)


class Manoeuvres(NamedTuple):
    """Impulses in time order: (burns,) [s], (burns, 3) inertial [m/s], and the phases they begin.

    The last two are those of the approach.
    """

    times: FloatArray
    vectors: FloatArray
    phases: tuple[str, ...]


class ThrustArc(NamedTuple):
    """An arc of thrust about two opposite places of each revolution.

    Attributes
    ----------
    start, end : float
        [s].
    delta_v : float
        [m/s].
    window, place : float
        Half-width of both windows, and argument of latitude of the middle of one [rad].
    climb : float
        Circular speed before less that after [m/s].
    tilt, turn : float
        Changes of inclination and node [rad].
    """

    start: float
    end: float
    delta_v: float
    window: float
    place: float
    climb: float
    tilt: float
    turn: float


NO_MANOEUVRES = Manoeuvres(np.empty(0), np.empty((0, 3)), ())


class FlownLeg(NamedTuple):
    """The flight of a connection.

    Attributes
    ----------
    departure : float
        When it really leaves [s].
    eccentricity_m_s : float
        Part of its ΔV that eccentricity adds, without burns [m/s].
    manoeuvres : Manoeuvres
    arcs : tuple of ThrustArc
        Of low thrust, in place of impulses.
    """

    departure: float
    eccentricity_m_s: float = 0.0
    manoeuvres: Manoeuvres = NO_MANOEUVRES
    arcs: tuple[ThrustArc, ...] = ()


class StatedLeg(NamedTuple):
    """Times [s] and phasing revolutions of a leg as stated in a plan."""

    departure: float
    arrival: float
    revolutions: int


class RecomputedLeg(NamedTuple):
    """A leg recomputed from its statement, for a judge.

    Attributes
    ----------
    departure, arrival : float
        The nearest that the family has to what is stated [s].
    delta_v, eccentricity_m_s : float
        [m/s].
    manoeuvres : Manoeuvres
    """

    departure: float
    arrival: float
    delta_v: float
    eccentricity_m_s: float
    manoeuvres: Manoeuvres


class Way(NamedTuple):
    """A transfer: departure and arrival [s], and ΔV [m/s].

    ``early`` is by how much another one may leave before it and still be as good [s].
    """

    departure: float
    arrival: float
    delta_v: float
    early: float = 0.0


class LegFamily(ABC):
    """A family of legs.

    Attributes
    ----------
    kind : LegKind
        Its public name and what follows from its data alone.
    phases : tuple of Phase
        Those that only its burns begin; they become known when it is registered.
    """

    kind: LegKind
    phases: tuple[Phase, ...] = ()

    @property
    def number(self) -> int:
        """Number of the family in columns of connections."""
        return leg_kinds().index(self.kind)

    @abstractmethod
    def applies(self, instance: Instance) -> bool:
        """Whether an instance may have such legs."""

    def serves(self, drive: Drive | None) -> bool:
        """Whether chasers with a drive, or with impulses, may fly such legs."""
        return True

    def claims(self, ends: PairEnds) -> bool:
        """Whether a pair is reached only by legs of this family."""
        return False

    def of_class(
        self, ends: PairEnds, heavier: ConnectionArrays, resolution_m_s: float
    ) -> ConnectionArrays:
        """Connections for a class of lighter chasers alone; none by default.

        Parameters
        ----------
        ends : PairEnds
            With the class as the heaviest chaser of the drive.
        heavier : ConnectionArrays
            Of all heavier chasers, in order of departure; what they dominate is left out.
        resolution_m_s : float
            A connection that saves no more than this is dominated [m/s].
        """
        return ConnectionArrays(*(column[:0] for column in heavier))

    @abstractmethod
    def connections(
        self, ends: PairEnds, found: ConnectionArrays | None, resolution_m_s: float
    ) -> ConnectionArrays:
        """Connections of a pair, merged with those found by other families.

        Parameters
        ----------
        ends : PairEnds
        found : ConnectionArrays or None
            Those of the families before; None for the first one.
        resolution_m_s : float
            A connection that saves no more than this is dominated [m/s].

        Returns
        -------
        ConnectionArrays
            In order of departure, then of arrival; none arrives after ``ends.latest_s`` or is
            dominated by another one (:func:`.merging.merged` sees to both).
        """

    @abstractmethod
    def flown(self, ends: PairEnds, stated: StatedLeg) -> FlownLeg:
        """The flight of a connection of the family.

        Raises
        ------
        InputError
            It cannot be; the sentence says why.
        """

    def flown_at(self, ends: PairEnds, stated: StatedLeg, delta_v_m_s: float) -> FlownLeg:
        """The leg with a given ΔV, where there may be several between the same times.

        By default the one that :meth:`flown` makes.
        """
        return self.flown(ends, stated)


class RegisteredFamily(LegFamily):
    """A family of legs from outside the package, which also serves judges and bounds.

    Of the families of the package :mod:`adr_opt.judge` and the bounds know by code of their own.
    """

    def least(self, instance: Instance) -> tuple[float, float]:
        """Lower bounds on time [s] and ΔV [m/s] of the family's legs.

        By default nothing, which is always true.
        """
        return 0.0, 0.0

    @abstractmethod
    def recomputed(self, ends: PairEnds, stated: StatedLeg) -> RecomputedLeg:
        """A leg recomputed from a plan's statement, for ``check``.

        Raises
        ------
        InputError
            The family has no such leg; the sentence says what is wrong.
        """

    @abstractmethod
    def ways(self, ends: PairEnds, after_s: float) -> Iterator[Way]:
        """Legs that leave soon after a time [s], all of which the connections must match.

        ``verify`` samples them.
        """
