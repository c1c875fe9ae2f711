"""Tows, restated: their times, their burns, and the orbit on which they leave the object."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...kernels.orbits import ephemeris
from ...plan.plan import Burn, Leg
from .towed import Towed
from .violation import DELTA_V_TOLERANCE_M_S, MOST_RELEASE_OFF_M, TIME_TOLERANCE_S, Violation
from .zone_crossings import KEPLER_STEPS, ZonedArc

FloatArray = npt.NDArray[np.float64]

RELEASE_SPARE_M, PLACES = 500.0, 24
"""Margin on the error of a release that covers all places of an orbit [m], and the number of
places."""


def check_tow(
    towed: Towed | None,
    number: int,
    leg: Leg,
    end: float,
    following: Leg | None,
    oblateness_m2: float,
) -> Iterator[Violation]:
    """Check the tow after a leg if one is due, and its absence otherwise.

    Parameters
    ----------
    towed : Towed or None
        The destination, where it is towed.
    number : int
    leg : Leg
    end : float
        Of the service [s].
    following : Leg or None
        The leg that the same chaser flies next.
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    """
    if towed is None or leg.tow is None:
        if (towed is None) != (leg.tow is None):
            stated = "towed" if leg.tow else "not towed"
            yield Violation(number, "tow", f"{leg.destination!r} is {stated} by the plan")
        return
    # Who leads nowhere after it may wait before it, too, as far as the mission goes.
    last = max(end + towed.time_s, leg.tow.end_s)
    if following is not None:
        last = following.departure_s if towed.period_s else following.leaves_s
    for name, stated_s, true in (
        ("start_s", leg.tow.start_s, last - towed.time_s),
        ("end_s", leg.tow.end_s, last),
    ):
        if abs(stated_s - true) > TIME_TOLERANCE_S:
            yield Violation(number, "tow", f"{name} of the tow = {stated_s!r}, but it is {true!r}")
    if abs(leg.tow.delta_v_m_s - towed.delta_v_m_s) > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number,
            "tow",
            f"delta_v_m_s = {leg.tow.delta_v_m_s!r} of the tow, but it takes {towed.delta_v_m_s!r}",
        )
    if towed.slower is None:
        if leg.tow.burns:
            yield Violation(number, "tow", "the tow is a spiral, which has no burns")
        return
    phases = ["tow", "return" if towed.back_m_s > 0.0 else "tow"][: len(towed.slower)]
    if [burn.phase for burn in leg.tow.burns] != phases:
        yield Violation(number, "tow", f"the tow must have burns of the phases {', '.join(phases)}")
        return
    begins_s = towed.begins_s(last)
    times = begins_s, begins_s + towed.flight_s
    for which, burn in enumerate(leg.tow.burns):
        yield from _check_burn(towed, number, which, burn, times)
    low, high = released_between(towed, times, oblateness_m2)
    if release_off_m(towed, (low, high)) > MOST_RELEASE_OFF_M:
        wanted = " × ".join(f"{(radius - EARTH_RADIUS_M) / 1e3:g}" for radius in towed.released_m)
        low, high = ((radius - EARTH_RADIUS_M) / 1e3 for radius in (low, high))
        yield Violation(
            number,
            "release",
            f"{leg.destination!r} is released at {low:.1f} × {high:.1f} km, more than "
            f"{MOST_RELEASE_OFF_M / 1e3:g} km off {wanted} km",
        )


def release_off_m(towed: Towed, apsides_m: tuple[float, float]) -> float:
    """Errors of perigee and apogee of a release; of a lowered perigee, that error alone [m]."""
    off = [abs(is_ - due) for is_, due in zip(apsides_m, towed.released_m, strict=True)]
    return off[0] if towed.released_m[0] < towed.released_m[1] else max(off)


def may_end_far(towed: Towed, time_s: float, oblateness_m2: float) -> bool:
    """Whether a tow in the revolution after a time [s] may end nearly as far off as is allowed."""
    if towed.slower is None:
        return False
    if towed.period_s and any(towed.offset):
        return True  # which displaces the apogee
    lap_s = math.tau / float(ephemeris.latitude_rate_at(towed.orbit, time_s))
    for place in range(1 if towed.period_s else PLACES):
        begin_s = towed.begins_s(time_s + towed.time_s + place / PLACES * lap_s)
        between = released_between(towed, (begin_s, begin_s + towed.flight_s), oblateness_m2)
        if release_off_m(towed, between) > MOST_RELEASE_OFF_M - RELEASE_SPARE_M:
            return True
    return False


def released_between(
    towed: Towed, times: tuple[float, float], oblateness_m2: float
) -> tuple[float, float]:
    """Radii of perigee and apogee on which tangential burns release an object [m].

    It begins on its true orbit, as large as that is by then.
    """
    assert towed.slower is not None
    position, velocity = _true_state(towed, times[0])
    velocity -= towed.slower[0] / float(np.linalg.norm(velocity)) * velocity
    if times[1] > times[0]:
        arc = ZonedArc(position, velocity, *times, oblateness_m2)
        position, velocity = arc.state_at_end()
        velocity -= towed.slower[1] / float(np.linalg.norm(velocity)) * velocity
    after = ZonedArc(position, velocity, times[1], times[1], oblateness_m2)
    shape = math.hypot(after.e_cos, after.e_sin)
    return after.a * (1.0 - shape), after.a * (1.0 + shape)


def _true_state(towed: Towed, time_s: float) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of an object on its true orbit at a time [m], [m/s]."""
    row = towed.orbit
    e, perigee = (
        float(of(row, time_s)) for of in (ephemeris.eccentricity_at, ephemeris.perigee_at)
    )
    axis = float(ephemeris.radius_at(row, time_s)) - towed.sinks_m_s * time_s
    # With what odd harmonics add to the eccentricity vector.
    to_node = e * math.cos(perigee) + towed.offset[0]
    after = e * math.sin(perigee) + towed.offset[1]
    e, perigee = math.hypot(to_node, after), math.atan2(after, to_node)
    mean = math.remainder(float(ephemeris.latitude_at(row, time_s)) - perigee, math.tau)
    anomaly = mean
    for _ in range(KEPLER_STEPS):
        anomaly -= (anomaly - e * math.sin(anomaly) - mean) / (1.0 - e * math.cos(anomaly))
    ascending, ahead, _ = ephemeris.frame(
        ephemeris.inclination_at(row, time_s), ephemeris.node_at(row, time_s)
    )
    to_perigee = math.cos(perigee) * ascending + math.sin(perigee) * ahead
    across = math.cos(perigee) * ahead - math.sin(perigee) * ascending
    root, motion = math.sqrt(1.0 - e * e), math.sqrt(MU_M3_S2 / axis**3)
    c, s = math.cos(anomaly), math.sin(anomaly)
    pace = axis * motion / (1.0 - e * c)
    position = axis * ((c - e) * to_perigee + root * s * across)
    return position, pace * (root * c * across - s * to_perigee)


def _check_burn(
    towed: Towed, number: int, which: int, burn: Burn, times: tuple[float, float]
) -> Iterator[Violation]:
    """Check that a tow's burn opposes the motion, in the plane of the object at that time."""
    assert towed.slower is not None
    raan = ephemeris.node_at(towed.orbit, times[0]) + which * towed.shift
    latitude = ephemeris.latitude_at(towed.orbit, times[0]) + which * towed.turned
    tilt = ephemeris.inclination_at(towed.orbit, times[0])
    ascending, ahead, _ = ephemeris.frame(tilt, raan)
    motion = math.cos(latitude) * ahead - math.sin(latitude) * ascending
    late = abs(burn.time_s - times[which])
    off = float(np.linalg.norm(np.array(burn.delta_v_m_s) + towed.slower[which] * motion))
    if late > TIME_TOLERANCE_S or off > DELTA_V_TOLERANCE_M_S:
        yield Violation(
            number, "tow", f"burn {which + 1} of the tow is off by {late:.3g} s and {off:.3g} m/s"
        )
