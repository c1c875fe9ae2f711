"""Features of a state for a learned policy: one row per choice, and one row for the mission.

:data:`CHOICE_FIELDS` and :data:`MISSION_FIELDS` name every number in order, with its unit and
scale; all are clipped to :data:`LIMIT`. Episodes fill :class:`Choices` from timetables, rehearsals
from connections on demand, and :func:`.choice_rows.write_rows` makes the same rows of both. What a
world has drawn is never among them: they hold what is planned, and what may come of it. Where
planes drift, RAANs and phases are those of the present time.
"""

import math
from typing import NamedTuple

import numpy as np

LIMIT = 5.0
"""Largest magnitude of a number in an observation."""

# Factors, not divisors: the kernels below are called for every step of a training.
PER_50_KM = 1.0 / 50e3
PER_KM_S = 1.0 / 1e3
PER_HOUR = 1.0 / 3600.0
PER_TEN_HOURS = 1.0 / 36000.0
WEEK_S = 604800.0
DEGREES = 180.0 / math.pi

M_S_PER_HOUR = 450.0
"""ΔV equivalent to an hour where a single cost is needed [m/s]: about the ratio of the two weights
with which beam search compares partial plans."""

CHOICE_FIELDS = (
    "legal",
    "is a station",
    "open: an unvisited target, or a refuelling that is earned",
    "ΔV of the move as planned [km/s]",
    "ΔV of the move / ΔV left",
    "time from now to the planned end of service [10 h]",
    "that time / time left",
    "cost: hours + ΔV / (450 m/s) [10 h]",
    "ΔV left afterwards [km/s]",
    "time left afterwards [10 h]",
    "ΔV of the way back to a station from there [km/s]",
    "ΔV left after the way back [km/s]",
    "a station stays reachable",
    "time of the way back, refuelling included [10 h]",
    "ΔV of the cheapest move after it [km/s]",
    "time of the cheapest move after it [10 h]",
    "cost of the cheapest move after it [10 h]",
    "cost of the second cheapest move after it [10 h]",
    "share of the nearest targets that are open",
    "radius less the chaser's [50 km]",
    "inclination less the chaser's [deg]",
    "RAAN less the chaser's, times sin i [deg]",
    "root of the sum of the squares of both [deg]",
    "radius less the station's [50 km]",
    "inclination less the station's [deg]",
    "RAAN less the station's, times sin i [deg]",
    "phase ahead of the chaser now [half turns]",
    "prize [mean prizes of the field]",
    "mean worth: prize times the chance of a service [mean prizes of the field]",
    "chance that it is gone",
    "chance that a try succeeds",
    "standard deviation of the ΔV of the move [km/s]",
    "chance that the tank holds it",
    "mean time of a try [10 h]",
    "time that a try exceeds once in ten [10 h]",
    "mean time of the stay with all tries [10 h]",
)

(
    LEGAL,
    IS_STATION,
    IS_OPEN,
    NEEDED,
    NEEDED_OF_LEFT,
    TAKEN,
    TAKEN_OF_LEFT,
    COST,
    LEFT_AFTER,
    TIME_AFTER,
    BACK,
    LEFT_AFTER_BACK,
    SAFE,
    BACK_TIME,
    NEXT_NEEDED,
    NEXT_TAKEN,
    NEXT_COST,
    SECOND_COST,
    NEAR_OPEN,
    RADIUS_FROM_CHASER,
    INCLINATION_FROM_CHASER,
    RAAN_FROM_CHASER,
    ANGLE_FROM_CHASER,
    RADIUS_FROM_HOME,
    INCLINATION_FROM_HOME,
    RAAN_FROM_HOME,
    PHASE,
    PRIZE,
    WORTH,
    IS_GONE,
    SUCCEEDS,
    SPREAD_NEEDED,
    HOLDS,
    MEAN_TRY,
    LATE_TRY,
    MEAN_STAY,
) = range(len(CHOICE_FIELDS))
# Columns of the choices, in the order of their names.

MISSION_FIELDS = (
    "ΔV left [km/s]",
    "ΔV left / budget",
    "ΔV budget [km/s]",
    "time left [weeks]",
    "time left / duration",
    "duration [weeks]",
    "open targets among the choices [50]",
    "share of the choices that are legal",
    "docked at a station",
    "refuelling is earned",
    "radius less the station's [50 km]",
    "inclination less the station's [deg]",
    "RAAN less the station's, times sin i [deg]",
    "a station is reachable now",
    "hours left for each open target among the choices [10 h]",
)

(
    LEFT,
    LEFT_OF_BUDGET,
    BUDGET,
    TIME,
    TIME_OF_DURATION,
    DURATION,
    OPEN_TARGETS,
    LEGAL_SHARE,
    DOCKED,
    EARNED,
    CHASER_RADIUS,
    CHASER_INCLINATION,
    CHASER_RAAN,
    HOME_REACHABLE,
    TIME_PER_TARGET,
) = range(len(MISSION_FIELDS))
# Columns of the mission, in the order of their names.

NEAREST = 16
"""Number of nearest targets listed per body."""

LOOKED_AHEAD = 12
"""Number of cheapest legal moves to targets that are examined one move further."""

ONWARD = 5
"""Number of nearest open targets examined after each of those moves."""

CERTAIN = (0.0, 1.0, 1.0, 1.0, 0.0)
"""Spread, bounds, mean and standard deviation of a factor that is 1."""

SIGMA, LEAST, MOST, MEAN, DEVIATION = range(len(CERTAIN))
"""Columns of :attr:`Choices.factor`."""

(CHANCE, GONE_CHANCE, SUCCESS, TRY_S, LATE_TRY_S, STAY_S) = range(6)
"""Columns of :attr:`Choices.stay`."""


class Standing(NamedTuple):
    """A chaser that decides, and its mission.

    Attributes
    ----------
    now, end : float
        [s].
    left, full : float
        ΔV in the tank, and in a full one [m/s].
    since : int
        Targets serviced since the last refuelling.
    docked : bool
    orbit, home : (columns,) float64
        Orbits of the body where it is, and of the station, or where there is none, of the start:
        rows of :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    """

    now: float
    end: float
    left: float
    full: float
    since: int
    docked: bool
    orbit: np.ndarray
    home: np.ndarray


class Choices(NamedTuple):
    """Moves open to a chaser: planned values, and distributions of their outcomes.

    Attributes
    ----------
    bodies : (choices,) int64
        Where they lead.
    station, open, legal : (choices,) bool
    needed, end, left : (choices,) float64
        ΔV [m/s], end of the service [s], ΔV left then [m/s]; +inf, +inf and −inf where there is no
        connection.
    back, back_end : (choices,) float64
        ΔV of the way back to a station from there [m/s], and end of refuelling [s]; 0 and the end
        of the service at a station, and where there is none.
    onward : (choices, 4) float64
        ΔV [m/s], seconds, and cost of the cheapest move after it [h], cost of the second [h]; +inf
        where none is known.
    near_open : (choices,) float64
        Share of the nearest targets that are open.
    worth : (choices,) float64
        Prize in mean prizes of the field.
    stay : (choices, 6) float64
        Chance of a service if there is time, chance that the target is gone, chance that a try
        succeeds; mean time of a try, time that one in ten exceeds, mean time of all tries [s].
    factor : (choices, 5) float64
        Of the ΔV of the leg: :data:`SIGMA` to :data:`DEVIATION`.
    """

    bodies: np.ndarray
    station: np.ndarray
    open: np.ndarray
    legal: np.ndarray
    needed: np.ndarray
    end: np.ndarray
    left: np.ndarray
    back: np.ndarray
    back_end: np.ndarray
    onward: np.ndarray
    near_open: np.ndarray
    worth: np.ndarray
    stay: np.ndarray
    factor: np.ndarray


def new_choices(count: int) -> Choices:
    """Storage for choices, in certain worlds."""
    flags, numbers = np.zeros((3, count), dtype=np.bool_), np.zeros((7, count))
    return Choices(
        np.zeros(count, dtype=np.int64),
        flags[0],
        flags[1],
        flags[2],
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        np.full((count, 4), np.inf),
        numbers[5],
        numbers[6],
        np.tile(np.array((1.0, 0.0, 1.0, 0.0, 0.0, 0.0)), (count, 1)),
        np.tile(np.array(CERTAIN), (count, 1)),
    )
