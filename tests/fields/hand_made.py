"""The hand-made instance, with its optimum derived on paper, and variants with one feature each.

All bodies fly the same circle, 700 km up, and cross the ascending node together; only their
inclinations differ:

    south 95°   station 96°   north 97°   beyond 98°   far 36°

So each pair meets on one line, every transfer starts at a node, nobody has to phase (but for the
kilometre of the stand-off, about 0.2 m/s), and costs never change: a leg across θ degrees costs
2 v sin(θ/2) + n L / 2 with v = 7504 m/s, that is

    132 m/s for 1°,  263 m/s for 2°,  394 m/s for 3°,  thousands of m/s to far.

With P the period, a leg flies 1.5 P, approaches for 0.5 P and serves for P. It ends just after a
node, so the next leg waits half a period: the first move ends at 3 P, every further one 3.5 P
later.

The budget is 300 m/s and the mission lasts 14 P: four moves (3, 6.5, 10, 13.5 P), not five.
far is never affordable, so three targets are left, and the question is whether all three fit into
four moves. A visit of south and a visit of north or beyond need a refuelling between them (132
and then 263 or more exceeds 300), so all four moves are used: three visits, one refuelling.

* Refuelling after the second visit: north, beyond (264 spent), and the 36 left do not reach the
  station 2° away. beyond, north (263 + 132 = 395) is beyond the budget.
* Refuelling after the first visit, and the other two on one tank: after north, south and beyond
  are 3° apart (132 + 394 or more). After beyond (263 of 300), there is no way back (263).
  After south (132, and 132 back), north (132) and beyond (132 more, 264 in all): legal.

The optimum is therefore 3 and its only plan is: south, station, north, beyond. Published greedy
takes north first (north and south cost the same, the first listed wins), goes on to beyond and is
stranded with 2; guarded greedy refuels after north, but then only south is left to it: 2.
"""

from __future__ import annotations

import math

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.problem.bodies import Station, Target
from adr_opt.problem.chasers import AtStation, Chaser, Tank
from adr_opt.problem.instance import Instance
from adr_opt.problem.orbit import Orbit
from adr_opt.problem.settings import MissionSettings
from adr_opt.sources.generator import EPOCH

RADIUS_M = EARTH_RADIUS_M + 700e3
PERIOD_S = 2.0 * math.pi * math.sqrt(RADIUS_M**3 / MU_M3_S2)

STATION, NORTH, BEYOND, SOUTH, FAR = range(5)
OPTIMAL_PLAN = (SOUTH, STATION, NORTH, BEYOND)
OPTIMUM = 3.0


def _orbit(inclination_deg: float) -> Orbit:
    return Orbit(
        semi_major_axis_m=RADIUS_M,
        eccentricity=0.0,
        inclination_deg=inclination_deg,
        raan_deg=0.0,
        argument_of_perigee_deg=0.0,
        true_anomaly_deg=0.0,
    )


def hand_made(*, periods: float = 14.0, delta_v_m_s: float = 300.0) -> Instance:
    """The instance, or a variant with another deadline or budget."""
    return Instance(
        name="hand-made",
        epoch=EPOCH,
        stations=(Station(name="station", orbit=_orbit(96.0)),),
        targets=(
            Target(name="north", orbit=_orbit(97.0)),
            Target(name="beyond", orbit=_orbit(98.0)),
            Target(name="south", orbit=_orbit(95.0)),
            Target(name="far", orbit=_orbit(36.0)),
        ),
        chasers=(
            Chaser(
                name="chaser",
                start=AtStation(station="station"),
                tank=Tank(delta_v_m_s=delta_v_m_s),
            ),
        ),
        mission=MissionSettings(duration_s=float(round(periods * PERIOD_S))),
    )
