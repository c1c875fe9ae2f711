"""``.opm``: where the chaser starts and what it burns, as a CCSDS Orbit Parameter Message.

502.0-B-2, section 3. One state and any number of manoeuvres are all that the format can say.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .axes import Axes, axes_of
from .clock import Clock, states_at_labels
from .kvn import comment, header, metadata, object_name, origin, who
from .sampling import Trajectory

MASS_KG = 1000.0
"""The format wants a mass where there are manoeuvres; the model has none."""


def to_opm(trajectory: Trajectory, frame: str | None = None) -> str:
    """The first state and all burns in key-value notation.

    Whoever propagates it flies on what the burns leave: the few centimetres and tenths of a
    millimetre per second that an approach leaves are carried through service, where the plan has
    the chaser docked, and add up to decimetres over a week. A message of one leg has none of
    that.
    """
    return "\n".join(_lines(trajectory, axes_of(trajectory.instance, frame))) + "\n"


def _lines(trajectory: Trajectory, axes: Axes) -> Iterator[str]:
    clock = Clock(trajectory.instance)
    first = trajectory.legs[0].arcs[0]
    position, velocity = (
        axes.turned(states_at_labels(first)[0][0]),
        axes.turned(first.velocities_m_s[0]),
    )
    instance, chaser = trajectory.instance, trajectory.chaser
    said = [*origin(instance, trajectory.plan, axes), *who(instance, chaser)]
    yield from header("CCSDS_OPM_VERS", said)
    yield ""
    yield from metadata(instance, axes, object_name(chaser))
    yield ""
    yield from comment(f"State at the beginning of leg {trajectory.legs[0].number}")
    if instance.dynamics == "j2":
        yield from comment(
            "It is a mean state: its velocity is that within the plane, to which the burns add. "
            "Propagated as an osculating state it leads elsewhere"
        )
    yield f"EPOCH = {clock.label(first.start_s)}"
    for axis, value in zip("XYZ", position / 1e3, strict=True):
        yield f"{axis} = {value:.9f} [km]"
    for axis, value in zip("XYZ", velocity / 1e3, strict=True):
        yield f"{axis}_DOT = {value:.12f} [km/s]"
    yield ""
    yield from comment("The mass is a placeholder that the format asks for: the plan has none")
    yield f"MASS = {MASS_KG:.3f} [kg]"
    for path in trajectory.legs:
        for burn in path.leg.all_burns:
            yield ""
            yield from comment(
                f"leg {path.number}, {path.leg.origin} to {path.leg.destination}: {burn.phase}"
            )
            yield f"MAN_EPOCH_IGNITION = {clock.label(burn.time_s)}"
            yield "MAN_DURATION = 0.000 [s]"
            yield "MAN_DELTA_MASS = 0.000 [kg]"
            yield f"MAN_REF_FRAME = {axes.frame.name}"
            for number, part in enumerate(axes.turned(np.array(burn.delta_v_m_s)), start=1):
                yield f"MAN_DV_{number} = {part / 1e3:.12f} [km/s]"
