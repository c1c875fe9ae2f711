"""Runs the mission sequence of a GMAT script, as far as this project writes such scripts."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Protocol

import numpy as np

from adr_opt.common.constants import MU_M3_S2
from adr_opt.fly.trajectory import propagate
from adr_opt.kernels.orbits import ephemeris

Array = np.ndarray
AXES = ("X", "Y", "Z", "VX", "VY", "VZ")
BROUWER = ("SMA", "ECC", "INC", "RAAN", "AOP", "MA")


def on_circle(axis_m: float, inclination: float, node: float, latitude: float) -> Array:
    """Position [m] and velocity [m/s] on a circle, angles in rad: a mean state."""
    towards, ahead, _ = ephemeris.frame(inclination, node)
    u, speed = latitude, math.sqrt(MU_M3_S2 / axis_m)
    return np.concatenate(
        [
            axis_m * (math.cos(u) * towards + math.sin(u) * ahead),
            speed * (math.cos(u) * ahead - math.sin(u) * towards),
        ]
    )


class Engine(Protocol):
    """What thrusts for a script: it keeps the mass, and the history of thrust."""

    def fuel(self, fields: dict[str, dict[str, str]], fuel_kg: float) -> None:
        """A tank is filled."""

    def push(self, state: Array, since_s: float, duration_s: float) -> Array:
        """The state after thrust, from a time of the script on."""
        ...

    def impulse(self, size_m_s: float, exhaust_m_s: float) -> None:
        """An impulse takes propellant."""


def fly_script(
    text: str,
    coast: Callable[..., tuple[Array, Array]] = propagate,
    mean: Callable[[float, float, float, float], Array] = on_circle,
    engine: Engine | None = None,
) -> tuple[list[tuple[Array, Array]], float]:
    """Fly the sequence of a script: where chaser and target are at each arrival, and its length.

    ``mean`` makes a state of the mean elements of a circle; ``engine`` is for scripts with thrust.
    """
    fields: dict[str, dict[str, str]] = {}
    created: set[str] = {"Earth"}
    setup, _, sequence = text.partition("BeginMissionSequence;")
    for line in setup.splitlines():
        if line.startswith("Create "):
            created.add(re.fullmatch(r"Create \w+ (\w+);", line)[1])
        elif line.startswith("GMAT "):
            name, field, value = re.fullmatch(r"GMAT (\w+)\.([\w.]+) = (.+);", line).groups()
            assert name in created, line
            fields.setdefault(name, {})[field] = value
        else:
            assert not line or line.startswith("%"), line
    ships = {
        name: _state(field, mean) for name, field in fields.items() if "DisplayStateType" in field
    }
    reports, clock, thrusting = [], 0.0, False
    for line in sequence.splitlines():
        if match := re.fullmatch(
            r"Propagate '[^']+' (Fly|Push)\(([\w, ]+)\) \{Chaser\.ElapsedSecs = ([\d.]+)\};", line
        ):
            assert set(match[2].split(", ")) == set(ships)
            assert (match[1] == "Push") == thrusting
            duration = float(match[3])
            since, clock = clock, clock + duration
            for name, state in ships.items():
                if thrusting and name == "Chaser":
                    ships[name] = engine.push(state, since, duration)
                    continue
                r, v = coast(state[:3], state[3:], [duration])
                ships[name] = np.concatenate([r[0], v[0]])
        elif match := re.fullmatch(r"Maneuver '[\w-]+' (\w+)\(Chaser\);", line):
            burn = fields[match[1]]
            assert burn["DecrementMass"] == ("false" if engine is None else "true")
            added = [1e3 * float(burn[f"Element{i}"]) for i in (1, 2, 3)]
            ships["Chaser"][3:] += added
            if engine is not None:
                exhaust = float(burn["Isp"]) * float(burn["GravitationalAccel"])
                engine.impulse(math.hypot(*added), exhaust)
        elif match := re.fullmatch(r"(Begin|End)FileThrust Thrust\(Chaser\);", line):
            assert thrusting == (match[1] == "End")
            thrusting = match[1] == "Begin"
        elif match := re.fullmatch(r"GMAT Chaser\.Propellant\.FuelMass = ([\d.]+);", line):
            engine.fuel(fields, float(match[1]))
        elif match := re.match(r"Report Arrivals .* (\w+)\.\w+\.Z;", line):
            reports.append((ships["Chaser"][:3].copy(), ships[match[1]][:3].copy()))
        elif match := re.fullmatch(r"GMAT Chaser\.\w+\.(\w+) = (\w+)\.\w+\.(\w+);", line):
            assert match[1] == match[3]
            axis = AXES.index(match[1])
            ships["Chaser"][axis] = ships[match[2]][axis]
        else:
            assert not line or line.startswith("%"), line
    return reports, clock


def _state(field: dict[str, str], mean: Callable[[float, float, float, float], Array]) -> Array:
    """Position [m] and velocity [m/s] of a spacecraft at its epoch."""
    if field["DisplayStateType"] == "Cartesian":
        return np.array([1e3 * float(field[axis]) for axis in AXES])
    assert field["DisplayStateType"] == "BrouwerMeanShort"
    axis, e, inclination, node, perigee, anomaly = (
        float(field[f"BrouwerShort{element}"]) for element in BROUWER
    )
    assert e == 0.0
    angles = (math.radians(angle) for angle in (inclination, node, perigee + anomaly))
    return mean(1e3 * axis, *angles)
