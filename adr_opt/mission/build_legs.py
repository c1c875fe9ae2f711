"""Plans from sequences of bodies: legs, burns, and propellant that is vented."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ..common.constants import SLACK_M_S
from ..common.errors import InputError
from ..legs.connections import Connections
from ..legs.families.family import StatedLeg, ThrustArc
from ..plan.cargo import followed
from ..plan.leg_kinds import GIVEN, leg_kinds
from ..plan.plan import Burn, Leg, LowThrustArc, burns_of
from ..plan.plan import Tow as TowFlown
from ..plan.routes import weighed
from ..plan.tows import RemovalFlight, burn_vectors, removals_by_name, removals_of
from ..problem.chasers import Chaser, TankByMass
from ..problem.drives import drive_of
from ..problem.instance import Instance
from .mission import Mission
from .schedule import Schedule

FloatArray = npt.NDArray[np.float64]

APPROXIMATE = (
    "some orbits are eccentric: burns fly between circles of the same semi-major axes, and "
    "delta_v_m_s includes the least cost of matching the eccentricity vectors; this is an "
    "approximation"
)

FREELY = (
    "delta_v_m_s is the price of free burns, which refine finds; the burns of legs fly between "
    "circles of the same semi-major axes, and state times only"
)

ON_PRICES = frozenset({APPROXIMATE, FREELY})
"""Notes at the beginning of plans, which searches do not repeat."""


def legs(
    mission: Mission, sequence: Iterable[int], timing: Schedule | None = None
) -> tuple[Leg, ...]:
    """Legs of a sequence of bodies, each with its price.

    Parameters
    ----------
    mission : Mission
    sequence : iterable of int
    timing : Schedule, optional
        When they are visited; by default their best schedule.

    Raises
    ------
    InputError
        A move is illegal; the sentence says which.
    """
    moves = [int(j) for j in sequence]
    timing = mission.time_by_class(moves) if timing is None else timing
    if timing.made < len(moves):
        raise InputError(
            f"move {timing.made + 1} of the sequence, to {mission.names[moves[timing.made]]!r}, "
            "breaks the mission rules"
        )
    priced: list[Leg] = []
    i, ready = mission.rules.start, mission.rules.ready
    tows = removals_of(mission.instance, mission.connecting.drive)
    stays_s = [mission.connecting.corrections.stays_s.get(mission.names[j], 0.0) for j in moves]
    spared = 0.0  # of the tank by the model, other than by corrected connections
    for at, j in enumerate(moves):
        leg = transfer_leg(mission, (i, j), float(ready), timing.connections, at)
        spare = timing.delta_vs[at] - mission.connecting.spent_m_s(i) - leg.delta_v_m_s
        spared = 0.0 if mission.rules.is_station[j] else spared + spare
        left = float(timing.lefts[at] - SLACK_M_S + spared) + mission.reserve_m_s
        free = float(timing.ends[at]) - stays_s[at]
        end = free - (tows[j].time_s if j in tows else 0.0)
        priced.append(leg.replace(end_s=end, delta_v_left_m_s=left))
        i, ready = j, free
    last_stay_s = stays_s[-1] if stays_s else 0.0
    towing = _towing(mission, tows, moves, priced, last_stay_s)
    return weighed(
        mission.instance, mission.chaser, vented(mission.instance, mission.chaser, towing)
    )


def _towing(
    mission: Mission,
    tows: Mapping[int, RemovalFlight],
    moves: list[int],
    legs: list[Leg],
    last_stay_s: float,
) -> Iterator[Leg]:
    """Legs with the tows that follow them, each as late as the next leg allows.

    The last one follows its service after a stay.
    """
    for at, (j, leg) in enumerate(zip(moves, legs, strict=True)):
        tow = tows.get(j)
        if tow is None:
            yield leg
            continue
        start = leg.end_s + last_stay_s
        if at + 1 < len(legs):
            # From where a tow from apogee leads, a drift begins at the time of its grid.
            later = legs[at + 1]
            start = (later.leaves_s if tow.apogees is None else later.departure_s) - tow.time_s
        yield leg.replace(tow=tow_flown(mission.transfer_inputs[1][j], tow, start))


def tow_flown(orbit: FloatArray, tow: RemovalFlight, start_s: float) -> TowFlown:
    """A tow that begins at a time, as stated in plans.

    Parameters
    ----------
    orbit : (columns,) float64
        Row of the object, :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
    """
    end_s = start_s + tow.time_s
    burns: tuple[Burn, ...] = ()
    if tow.burns_m_s is not None:
        begins_s = start_s if tow.apogees is None else tow.begins_s(end_s)
        phases = ("tow", "return" if tow.back_m_s else "tow")
        vectors = burn_vectors(orbit, tow, begins_s)
        burns = burns_of(tow.burn_times_s(begins_s), vectors, phases[: len(vectors)])
    return TowFlown(start_s=start_s, end_s=end_s, delta_v_m_s=tow.delta_v_m_s, burns=burns)


def transfer_leg(
    mission: Mission, ends: tuple[int, int], ready_s: float, found: Connections, row: int
) -> Leg:
    """A connection of a mission as a leg, without the service that follows.

    Parameters
    ----------
    mission : Mission
    ends : (origin, destination)
        Numbers of bodies.
    ready_s : float
        Since when the chaser is free at the origin [s].
    found : Connections
    row : int
        Which of them.

    Raises
    ------
    InputError
        It cannot be flown.
    """
    family, revolutions = int(found.family[row]), int(found.revolutions[row])
    kind = leg_kinds()[family]
    departure, arrival = float(found.departure[row]), float(found.arrival[row])
    connecting = mission.connecting
    delta_v_m_s = connecting.modelled(*ends, family, float(found.delta_v[row]))
    largest = math.inf if found.mass_kg is None else float(found.mass_kg[row])
    mass_kg = largest if math.isfinite(largest) else None
    stated = StatedLeg(departure, arrival, revolutions)
    flown = connecting.flown(*ends, family, stated, delta_v_m_s, mass_kg)
    return Leg(
        kind=kind.name,
        origin=mission.names[ends[0]],
        destination=mission.names[ends[1]],
        ready_s=ready_s,
        departure_s=flown.departure,
        arrival_s=arrival,
        end_s=arrival,
        delta_v_m_s=delta_v_m_s,
        delta_v_left_m_s=0.0,
        phasing_revolutions=max(revolutions, 0) if kind is not GIVEN else 0,
        eccentricity_delta_v_m_s=flown.eccentricity_m_s,
        burns=burns_of(*flown.manoeuvres),
        manoeuvres=tuple(map(_arc, flown.arcs)) or None,
        mass_class_kg=mass_kg,
    )


def _arc(arc: ThrustArc) -> LowThrustArc:
    """An arc as stated in plans."""
    return LowThrustArc(
        start_s=arc.start,
        end_s=arc.end,
        delta_v_m_s=arc.delta_v,
        window_deg=math.degrees(arc.window),
        argument_of_latitude_deg=math.degrees(arc.place),
        size_m_s=arc.climb,
        inclination_deg=math.degrees(arc.tilt),
        raan_deg=math.degrees(arc.turn),
    )


LEAST_KG = 1e-9
"""Amount of propellant below which nothing is vented: it is due to rounding [kg]."""


def vented(instance: Instance, chaser: Chaser, legs: Iterable[Leg]) -> Iterator[Leg]:
    """Legs of a chaser with vented propellant, so that each is flown with a mass of its class.

    A leg of a class of masses can be flown by a chaser that is no heavier at its departure. One
    that would be vents propellant at the start of that tank (docs/model.md section 11.4): then it
    is lighter, and no worse off, on all legs before as well.

    Parameters
    ----------
    instance : Instance
    chaser : Chaser
    legs : iterable of Leg
        Whose tank suffices for their classes.
    """
    legs, tank = tuple(legs), chaser.usable
    if not isinstance(tank, TankByMass) or all(leg.mass_class_kg is None for leg in legs):
        yield from legs
        return
    most_kg = _most_kg(instance, chaser, tank, legs)
    # The mass at the start of a tank does not depend on what is vented before it.
    stages = followed(instance, chaser, [(leg.destination, leg.delta_v_m_s) for leg in legs])
    starts = True
    for leg, stage, most in zip(legs, stages, most_kg, strict=False):
        excess = (stage.mass_kg or 0.0) - most if starts else 0.0
        yield leg.replace(vented_kg=excess) if excess > LEAST_KG else leg
        starts = leg.destination in instance.station_names


def _most_kg(
    instance: Instance, chaser: Chaser, tank: TankByMass, legs: Sequence[Leg]
) -> list[float]:
    """Largest mass before each leg with which it and the later legs of the tank can be flown."""
    takers = {target.name for target in instance.targets if target.service.takes_kit}
    tows, exhaust = removals_by_name(instance, drive_of(chaser, instance.targets)), tank.exhaust_m_s
    after, found = math.inf, []
    for leg in reversed(legs):
        if leg.destination in instance.station_names:
            after = math.inf
        elif leg.destination in takers:
            after += chaser.kit_mass_kg
        elif leg.destination in tows:
            after = tows[leg.destination].needed_kg(after, exhaust)
        class_kg = math.inf if leg.mass_class_kg is None else leg.mass_class_kg
        after = min(class_kg, after * math.exp(leg.delta_v_m_s / exhaust))
        found.append(after)
    return found[::-1]
