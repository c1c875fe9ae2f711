"""The course of a plan."""

from __future__ import annotations

from ...fly.trajectory.axes import Axes
from ...fly.trajectory.sampling import Trajectory
from ...plan.routes import routes_of
from .course import Burnt, CourseLeg, FlightCourse, burnt_of
from .kvn import origin, who


def course_of(trajectory: Trajectory, axes: Axes) -> FlightCourse:
    """Legs of a trajectory as their burns, with masses from its plan."""
    instance, plan = trajectory.instance, trajectory.plan
    numbers = [path.number for path in trajectory.legs]
    burnt: dict[int, tuple[Burnt, ...]] = {}
    for flown in routes_of(instance, plan):
        route = [CourseLeg.of(number, leg) for number, leg in flown.legs]
        if any(leg.number in numbers for leg in route):
            burnt |= burnt_of(instance, flown.chaser, route)
    return FlightCourse(
        instance,
        trajectory.chaser,
        tuple(CourseLeg.of(path.number, path.leg) for path in trajectory.legs),
        (*origin(instance, plan, axes), *who(instance, trajectory.chaser)),
        burnt,
    )
