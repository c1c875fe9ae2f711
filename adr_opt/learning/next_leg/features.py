"""What a learned policy sees of a decision: numbers for each leg, and of the mission.

All of it follows from the connections of one body at one time, the tank, the clock, and distances
between orbits; nothing needs a timetable. Numbers are scaled so that most lie within ±2, and
clipped at ±5. See docs/rehearsing.md.
"""

from __future__ import annotations

import numpy as np

from .choices import BoolArray, Choices, FloatArray, Standing
from .feature_rows import write_features
from .near_orbits import OrbitPlaces
from .onward import OnwardLegs

LEG_FEATURES = 38
"""Numbers for each leg."""

MISSION_FEATURES = 15
"""Numbers of the mission."""


def features(
    standing: Standing,
    choices: Choices,
    onward: OnwardLegs,
    places: OrbitPlaces,
    worths: FloatArray,
    required: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """What the policy sees.

    Parameters
    ----------
    standing : Standing
    choices : Choices
    onward : OnwardLegs
    places : OrbitPlaces
    worths : (bodies,) float64
        Of targets that are open, over the mean of all targets with a prize; 0 of all others.
    required : (bodies,) bool

    Returns
    -------
    legs : (legs, LEG_FEATURES) float64
    mission : (MISSION_FEATURES,) float64
    """
    legs, mission = np.zeros((choices.bodies.size, LEG_FEATURES)), np.empty(MISSION_FEATURES)
    tank, clock = standing.tank_ahead, standing.time_ahead
    here = (
        int(standing.body),
        float(standing.time),
        float(standing.end),
        float(standing.left),
        float(standing.full),
        int(standing.since),
        standing.stations,
        standing.chasers,
        tank is not None,
        0.0 if tank is None else float(tank),
        0.0 if clock is None else float(clock),
    )
    around = places.points, *places.neighbours_of(choices.bodies)
    write_features(here, choices, onward, around, worths, required, legs, mission)
    return legs, mission
