"""Fates of all objects that a plan releases, and of all chasers.

Orbits at release are those of the plan. Lifetimes are those of the decay model at constant solar
activity, low, mean and high: their spread is that of the Sun. A chaser is disposed of after its
last service by a burn at an apogee, the cheapest that meets the rules and that its tank allows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2, STANDARD_GRAVITY_M_S2
from ...common.errors import InputError
from ...fly.trajectory.bodies import after_burns, body_states
from ...judge.admit import AnyPlan, admit
from ...kernels.legs.burns import half_ellipse_speeds
from ...plan.lifetimes import ASSUMED_AREA_TO_MASS_M2_KG, MOST_YEARS, shells_of
from ...plan.plan import Leg
from ...plan.routes import Flown, routes_of
from ...problem.air import ACTIVITIES, lifetimes
from ...problem.bodies import Target
from ...problem.chasers import TankByMass
from ...problem.disposal import CONTROLLED_M, DisposalPerigee, comes_down_at_once
from ...problem.drives import drive_of
from ...problem.instance import Instance
from .casualties import Array, Debris, casualty_area_m2, density_below, density_per_km2
from .reentry import Reentry, lowering, reentry, to_apogee

YEARS = 25.0
"""Longest lifetime where a mission states none."""

MOST_CASUALTIES = 1e-4
"""Casualty expectation above which a re-entry has to be controlled (NASA-STD-8719.14)."""

LOWEST_M, CLOSE_M = 130e3, 100.0
"""Perigee below which lifetimes are not computed, and tolerance of perigees [m]."""


@dataclass(frozen=True)
class Fate:
    """The fate of one object or chaser.

    Attributes
    ----------
    name : str
    how : str
        ``tow``, ``kit`` or ``chaser``.
    chaser : str
        Which releases it, or itself.
    mass_kg : float or None
        None where it is not known.
    released_s : float
        When it is released, or when it or its kit makes its last burn [s].
    perigee_m, apogee_m : float
        Altitudes of the orbit that it is left on [m].
    inclination_deg : float
    area_to_mass_m2_kg : float
    area_is_assumed : bool
    lifetimes_years : dict of str to float
        By solar activity; at most 1,000 [years].
    controlled : bool
        Whether it re-enters at once, where its burn is aimed.
    delta_v_m_s : float
        Of its disposal: of the tow, of the kit, or of the chaser's own [m/s].
    propellant_kg : float or None
        That this takes from the chaser, or that a kit has to have; None where masses are not known.
    left_m_s : float or None
        What a chaser has for its disposal; None of others [m/s].
    casualty_area_m2, casualties : float or None
        Area in which surviving debris meets a person, and the number expected to be hit.
    reentry : Reentry or None
        Where it is controlled.
    broken : tuple of str
        Rules that are not met; nothing if all are.
    """

    name: str
    how: str
    chaser: str
    mass_kg: float | None
    released_s: float
    perigee_m: float
    apogee_m: float
    inclination_deg: float
    area_to_mass_m2_kg: float
    area_is_assumed: bool
    lifetimes_years: dict[str, float]
    controlled: bool
    delta_v_m_s: float
    propellant_kg: float | None
    left_m_s: float | None
    casualty_area_m2: float | None
    casualties: float | None
    reentry: Reentry | None
    broken: tuple[str, ...]

    @property
    def meets(self) -> bool:
        """Whether all rules are met."""
        return not self.broken

    def to_dict(self) -> dict[str, Any]:
        """The fate as JSON data."""
        return asdict(self) | {"meets": self.meets}


def fates(
    instance: Instance,
    plan: AnyPlan,
    *,
    years: float | None = None,
    most_uncontrolled_kg: float | None = None,
    debris: Debris | None = None,
    kit_isp_s: float = 220.0,
) -> tuple[Fate, ...]:
    """Fates of all objects that a plan releases, and of its chasers, in the order of the plan.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
    years : float, optional
        Longest lifetime; by default the mission's, or 25.
    most_uncontrolled_kg : float, optional
        Mass above which a re-entry has to be controlled; by default the mission's, or none.
    debris : Debris, optional
        What is assumed to survive.
    kit_isp_s : float
        Specific impulse of kits, from which their propellant follows [s].

    Raises
    ------
    InputError
        The plan belongs to another instance or has violations, a number is out of range, or orbits
        are not known.
    """
    admitted = admit(instance, plan)
    instance, mission = admitted.instance, admitted.instance.mission
    if years is None:
        years = YEARS if mission.max_lifetime_years is None else mission.max_lifetime_years
    if most_uncontrolled_kg is None:
        most_uncontrolled_kg = mission.max_uncontrolled_kg
    for what, value in (("years", years), ("kit_isp_s", kit_isp_s)):
        if not 0.0 < value < math.inf:
            raise InputError(f"{what} = {value:g}: must be a positive number")
    if most_uncontrolled_kg is not None and not most_uncontrolled_kg >= 0.0:
        raise InputError(
            f"most_uncontrolled_kg = {most_uncontrolled_kg:g}: must be a mass of at least 0"
        )
    if not instance.has_orbits or instance.given is not None:
        raise InputError(f"{instance.name!r} has given connections, so its orbits are unknown")
    judge = _Rules(instance, years, most_uncontrolled_kg, debris or Debris(), kit_isp_s)
    return tuple(
        fate
        for route in routes_of(instance, admitted.plan)
        if route.legs
        for fate in (*judge.released(route), judge.of_chaser(route))
    )


@dataclass(frozen=True)
class _Left:
    """An object or chaser on the orbit where it is left, before its last burn.

    ``before`` is the state at that burn, ``burn`` nothing where none is needed, and ``more_m_s``
    what a second one takes, on to a circle.
    """

    perigee_m: float
    apogee_m: float
    burn_s: float
    before: Array
    burn: Array
    more_m_s: float = 0.0


@dataclass(frozen=True)
class _Rules:
    instance: Instance
    years: float
    most_kg: float | None
    debris: Debris
    kit_isp_s: float

    def released(self, route: Flown) -> Iterator[Fate]:
        """Fates of the objects that a chaser releases."""
        instance = self.instance
        shells = shells_of(instance, drive_of(route.chaser, instance.targets))
        stages = route.aboard(instance)[1:]
        for (_, leg), aboard in zip(route.legs, stages, strict=True):
            body = instance.names.index(leg.destination)
            if body not in shells:
                continue
            target = instance.targets[body - instance.first_target]
            left = self._left_by(leg, target, shells[body])
            delta_v = leg.removal_m_s
            propellant: float | None = aboard.removal_kg
            if leg.tow is None:
                delta_v = float(np.linalg.norm(left.burn)) + left.more_m_s
                propellant = None
                if target.mass_kg is not None:
                    exhaust_m_s = STANDARD_GRAVITY_M_S2 * self.kit_isp_s
                    moved_kg = target.mass_kg + route.chaser.kit_mass_kg
                    propellant = moved_kg * -math.expm1(-delta_v / exhaust_m_s)
            fate = self._fate(
                target.name,
                "kit" if leg.tow is None else "tow",
                route.chaser.name,
                target.mass_kg,
                target.area_to_mass_m2_kg,
                left,
                (delta_v, propellant, None),
            )
            kit_kg = route.chaser.kit_mass_kg
            if fate.how == "kit" and 0.0 < kit_kg < (propellant or 0.0):
                lacking = f"a kit of {kit_kg:g} kg holds no {propellant:.1f} kg of propellant"
                fate = replace(fate, broken=(*fate.broken, lacking))
            yield fate

    def _left_by(self, leg: Leg, target: Target, shell: tuple[float, float]) -> _Left:
        """Orbit on which a tow or a kit leaves an object."""
        tow = leg.tow
        if tow is not None and tow.burns:
            docked = tuple(burn for burn in tow.burns if burn.phase != "return")
            now, position, velocity = after_burns(self.instance, target.name, docked)
            burn = np.array(docked[-1].delta_v_m_s)
            return _Left(*shell, now, np.concatenate([position, velocity - burn]), burn)
        state = self._beside(target.name, leg.done_s)
        if tow is not None:  # a spiral, which ends on a circle
            return _Left(*shell, leg.done_s, state, np.zeros(3))
        wait_s, at_apogee = to_apogee(state)
        burn, more_m_s = lowering(at_apogee, shell[0]), 0.0
        if target.disposal is not None and not isinstance(target.disposal, DisposalPerigee):
            _, arrives_m_s = half_ellipse_speeds(float(np.linalg.norm(at_apogee[:3])), shell[0])
            more_m_s = abs(arrives_m_s - math.sqrt(MU_M3_S2 / shell[0]))
        return _Left(*shell, leg.end_s + wait_s, at_apogee, burn, more_m_s)

    def _beside(self, name: str, time_s: float) -> Array:
        positions, velocities = body_states(self.instance, name, time_s, true_orbits=True)
        return np.concatenate([positions[0], velocities[0]])

    def of_chaser(self, route: Flown) -> Fate:
        """The fate of a chaser after its last service or tow."""
        chaser, (_, last), tank = route.chaser, route.legs[-1], route.chaser.tank
        end = route.aboard(self.instance)[-1]
        left_m_s, mass_kg = end.left_m_s + (chaser.end_of_life_m_s or 0.0), end.mass_kg
        if isinstance(tank, TankByMass) and mass_kg is not None:
            left_m_s = tank.exhaust_m_s * math.log(mass_kg / tank.dry_mass_kg)
        state, time_s = self._chaser_state(last)
        wait_s, at_apogee = to_apogee(state)
        apogee = float(np.linalg.norm(at_apogee[:3]))
        axis = 1.0 / (2.0 / apogee - float(at_apogee[3:] @ at_apogee[3:]) / MU_M3_S2)
        here = min(2.0 * axis - apogee, apogee)
        tried = []
        for perigee in self._perigees(chaser.thrust_n is None, here, apogee):
            burn = lowering(at_apogee, perigee) if perigee < here else np.zeros(3)
            high = apogee
            if chaser.thrust_n is not None and perigee < here:  # by a spiral, to a circle
                high = perigee
                slower = math.sqrt(MU_M3_S2 / perigee) - math.sqrt(MU_M3_S2 / axis)
                burn *= slower / np.linalg.norm(burn)
            left = _Left(perigee, high, time_s + wait_s, at_apogee, burn)
            delta_v, propellant = float(np.linalg.norm(burn)), None
            if isinstance(tank, TankByMass) and mass_kg is not None:
                propellant = mass_kg * -math.expm1(-delta_v / tank.exhaust_m_s)
            dry_kg = tank.dry_mass_kg if isinstance(tank, TankByMass) else None
            costs = delta_v, propellant, left_m_s
            fate = self._fate(chaser.name, "chaser", chaser.name, dry_kg, None, left, costs)
            tried.append(fate)
            if fate.meets and delta_v <= left_m_s:
                return fate
        within = [fate for fate in tried if fate.delta_v_m_s <= left_m_s]
        return min(within, key=lambda fate: len(fate.broken))

    def _chaser_state(self, last: Leg) -> tuple[Array, float]:
        tow = last.tow
        if tow is not None and tow.burns:
            now, position, velocity = after_burns(self.instance, last.destination, tow.burns)
            return np.concatenate([position, velocity]), now
        state = self._beside(last.destination, last.done_s)
        if tow is not None:  # where its spiral has led, on a circle
            low = EARTH_RADIUS_M + self.instance.circle_m(last.destination)
            shrunk = low / float(np.linalg.norm(state[:3]))
            state *= np.repeat([shrunk, shrunk**-0.5], 3)
        return state, last.done_s

    def _perigees(self, aims: bool, perigee: float, apogee: float) -> Iterator[float]:
        """Radii of perigee for a chaser's disposal, the more expensive ones last [m].

        Where it is; the highest with which it keeps to the longest lifetime, on a circle where it
        cannot aim; and that of a controlled re-entry.
        """
        yield perigee
        low, high = EARTH_RADIUS_M + LOWEST_M, perigee
        while high - low > CLOSE_M:
            middle = 0.5 * (low + high)
            apsides = middle, apogee if aims else middle
            years = _years(apsides, ASSUMED_AREA_TO_MASS_M2_KG, "mean")
            low, high = (middle, high) if years <= self.years else (low, middle)
        yield low
        if aims:
            yield EARTH_RADIUS_M + CONTROLLED_M

    def _fate(
        self,
        name: str,
        how: str,
        chaser: str,
        mass_kg: float | None,
        area: float | None,
        left: _Left,
        costs: tuple[float, float | None, float | None],
    ) -> Fate:
        apsides = left.perigee_m, left.apogee_m
        used = ASSUMED_AREA_TO_MASS_M2_KG if area is None else area
        lasting = {activity: _years(apsides, used, activity) for activity in ACTIVITIES}
        normal = np.cross(left.before[:3], left.before[3:])
        tilt = math.degrees(math.acos(normal[2] / np.linalg.norm(normal)))
        aimed = None
        if comes_down_at_once(left.perigee_m) and left.burn.any():
            aimed = reentry(self.instance, left.burn_s, left.before, left.burn)
        controlled = aimed is not None
        struck = None if mass_kg is None else casualty_area_m2(mass_kg, self.debris)
        hit = None if struck is None else self._casualties(struck, tilt, aimed)
        broken = []
        if lasting["mean"] > self.years:
            broken.append(f"stays longer than {self.years:g} years")
        if self.most_kg is not None and not controlled and (mass_kg or math.inf) > self.most_kg:
            broken.append(f"heavier than {self.most_kg:g} kg and not controlled")
        if hit is not None and hit > MOST_CASUALTIES:
            broken.append(f"casualty expectation above {MOST_CASUALTIES:g}")
        return Fate(
            name=name,
            how=how,
            chaser=chaser,
            mass_kg=mass_kg,
            released_s=left.burn_s,
            perigee_m=left.perigee_m - EARTH_RADIUS_M,
            apogee_m=left.apogee_m - EARTH_RADIUS_M,
            inclination_deg=tilt,
            area_to_mass_m2_kg=used,
            area_is_assumed=area is None,
            lifetimes_years=lasting,
            controlled=controlled,
            delta_v_m_s=costs[0],
            propellant_kg=costs[1],
            left_m_s=costs[2],
            casualty_area_m2=struck,
            casualties=hit,
            reentry=aimed,
            broken=tuple(broken),
        )

    def _casualties(self, area_m2: float, tilt_deg: float, aimed: Reentry | None) -> float:
        """Casualty expectation: anywhere below the orbit, or along the track aimed at."""
        anywhere = 1e-6 * area_m2 * density_below(tilt_deg)
        if aimed is None:
            return anywhere
        latitudes = np.array([row[1] for row in aimed.track if row[0] >= aimed.entry_s])
        aimed_at = density_per_km2(latitudes if latitudes.size else np.array([aimed.entry[0]]))
        fails = self.debris.fails
        return fails * anywhere + (1.0 - fails) * 1e-6 * area_m2 * aimed_at


def _years(apsides_m: tuple[float, float], area: float, activity: str) -> float:
    (found,) = lifetimes(np.array([apsides_m]), np.array([area]), activity, MOST_YEARS)
    return min(float(found), MOST_YEARS)
