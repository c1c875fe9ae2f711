"""Points of a trade-off: plans and bounds, their implications for other points, and their table.

With a larger tank or more time, every plan of a smaller point can be flown. So the best plan of a
point counts for all larger ones, and a bound of a point for all smaller ones. Points of different
thrust or specific impulse say nothing of each other: times of thrust depend on both.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Container, Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ...common.card import Shown
from ...common.files import write_text
from ...common.tolerance import meets, tolerance
from ...problem.instance import Instance
from .axes import Axis, PointLimits

Routes = tuple[tuple[str, ...], ...]
"""Names of bodies in order, for each chaser."""


@dataclass(frozen=True, repr=False)
class Point(Shown):
    """Results for one variant of an instance.

    Attributes
    ----------
    delta_v_m_s, duration_s : float
        Its limits.
    prize : float
        Of the best plan; −inf without one.
    upper_bound : float
        No plan collects more; +inf if nothing is proven.
    visits : int
        Targets of the best plan.
    cost : float
        Of the best plan, as the instance counts it.
    routes : tuple of tuple of str
        The best plan: bodies in order, for each chaser.
    methods : tuple of str
        Planners that were run for this point; none where its neighbours say it all.
    runtime_s, cpu_s : float
        Wall time and processor time of these.
    propellant_kg : float or None
        Of a full tank, where that is varied; ``delta_v_m_s`` is what it is worth then.
    thrust_n, isp_s : float or None
        Of chasers with low thrust, where they are varied.
    """

    delta_v_m_s: float
    duration_s: float
    prize: float = -math.inf
    upper_bound: float = math.inf
    visits: int = 0
    cost: float = math.nan
    routes: Routes = ()
    methods: tuple[str, ...] = ()
    runtime_s: float = 0.0
    cpu_s: float = 0.0
    propellant_kg: float | None = None
    thrust_n: float | None = None
    isp_s: float | None = None

    def value(self, kind: str) -> float:
        """A limit of the point, in SI units."""
        value = {
            "delta-v": self.delta_v_m_s,
            "duration": self.duration_s,
            "propellant": self.propellant_kg,
            "thrust": self.thrust_n,
            "isp": self.isp_s,
        }[kind]
        assert value is not None
        return value

    @property
    def limits(self) -> PointLimits:
        """Position of the point in the grid."""
        return PointLimits(self.delta_v_m_s, self.duration_s, self.thrust_n, self.isp_s)

    @property
    def proven(self) -> bool:
        """Whether the point's best known plan is proven to collect the most."""
        return meets(self.prize, self.upper_bound)

    @property
    def status(self) -> str:
        """Status of the point, as in plans."""
        if self.prize == -math.inf:
            return "infeasible" if self.upper_bound == -math.inf else "unknown"
        return "optimal" if self.proven else "feasible"

    def beats(self, other: Point) -> bool:
        """Whether the point's plan collects more than another's, or as much at less cost."""
        if self.prize != other.prize:
            return self.prize > other.prize
        return self.cost < other.cost

    def joined(self, other: Point) -> Point:
        """Merged results of two runs for one point."""
        best = other if other.beats(self) else self
        return replace(
            best,
            upper_bound=min(self.upper_bound, other.upper_bound),
            methods=(*self.methods, *other.methods),
            runtime_s=self.runtime_s + other.runtime_s,
            cpu_s=self.cpu_s + other.cpu_s,
        )

    def to_dict(self) -> dict[str, Any]:
        """The point as JSON data, with propellant, thrust and specific impulse only if varied."""
        fields = asdict(self)
        for name in ("propellant_kg", "thrust_n", "isp_s"):
            if fields[name] is None:
                del fields[name]
        return {
            **fields,
            "status": self.status,
            "routes": [list(route) for route in self.routes],
            "methods": list(self.methods),
        }


class Impossible(RuntimeError):
    """A plan exceeds a bound that claims to be proven: a method is wrong."""


@dataclass(frozen=True, repr=False)
class Tradeoff(Shown):
    """A curve or a surface of plans and bounds.

    Attributes
    ----------
    instance : Instance
    axes : tuple of Axis
    points : tuple of Point
        Ascending, the ΔV first; each with what its neighbours say of it.
    runtime_s, cpu_s : float
        Of all runs.
    """

    instance: Instance
    axes: tuple[Axis, ...]
    points: tuple[Point, ...]
    runtime_s: float = field(default=0.0, compare=False)
    cpu_s: float = field(default=0.0, compare=False)

    @property
    def proven(self) -> int:
        """Number of proven points."""
        return sum(point.proven for point in self.points)

    def along(self, kind: str) -> dict[tuple[float, ...], tuple[Point, ...]]:
        """Rows of points by the values of the other axes, each ascending in this one."""
        others = [axis.kind for axis in self.axes if axis.kind != kind]
        rows: dict[tuple[float, ...], list[Point]] = {}
        for point in sorted(self.points, key=lambda each: each.value(kind)):
            rows.setdefault(tuple(map(point.value, others)), []).append(point)
        return {key: tuple(rows[key]) for key in sorted(rows)}

    def to_dict(self) -> dict[str, Any]:
        """The trade-off as JSON data."""
        return {
            "instance": {"name": self.instance.name, "sha256": self.instance.sha256},
            "varied": {axis.kind: list(axis.values) for axis in self.axes},
            "points": [point.to_dict() for point in self.points],
            "proven": self.proven,
            "runtime_s": self.runtime_s,
            "cpu_s": self.cpu_s,
        }


class KnownPoints:
    """Results of all points, kept consistent with each other.

    Parameters
    ----------
    limits : iterable of PointLimits
    slack_m_s : float
        A bound counts for a smaller tank only if that is smaller by this: what a plan may cost
        more on the connections of the larger one (:func:`.shared.slack_m_s`).
    """

    def __init__(self, limits: Iterable[PointLimits], slack_m_s: float = 0.0) -> None:
        self._slack_m_s = slack_m_s
        self.points: dict[PointLimits, Point] = {each: Point(**each._asdict()) for each in limits}

    def add(self, found: Point) -> None:
        """Add the results of a run, and apply them to the other points.

        Raises
        ------
        Impossible
            A plan collects more than a bound allows.
        """
        self.points[found.limits] = self.points[found.limits].joined(found)
        own = self.points[found.limits]
        for limits, point in self.points.items():
            if self.counts(own.limits, limits) and own.beats(point):
                self.points[limits] = replace(
                    point, prize=own.prize, visits=own.visits, cost=own.cost, routes=own.routes
                )
            if self.counts(limits, own.limits) and own.upper_bound < point.upper_bound:
                self.points[limits] = replace(self.points[limits], upper_bound=own.upper_bound)
        for point in self.points.values():
            none = point.upper_bound == -math.inf  # "there is no plan" leaves no room for rounding
            allowed = -math.inf if none else point.upper_bound + tolerance(point.upper_bound)
            if point.prize > allowed:
                raise Impossible(
                    f"at {point.limits} a plan of {point.prize!r} exceeds the bound "
                    f"{point.upper_bound!r}: a method is broken, please report it"
                )

    def counts(self, smaller: PointLimits, larger: PointLimits) -> bool:
        """Whether every plan of the smaller point is also a plan of the larger."""
        if smaller[2:] != larger[2:]:
            return False
        if smaller[0] == larger[0]:
            return smaller[1] <= larger[1]
        return smaller[0] + self._slack_m_s <= larger[0] and smaller[1] <= larger[1]

    def open(self, ran: Container[PointLimits]) -> Iterator[PointLimits]:
        """Points worth a run, most informative first.

        On a plateau, where points have equally good plans, the largest comes first: if nothing
        better is found there, it is proven for all of them.

        Parameters
        ----------
        ran : container of PointLimits
            Points that have had theirs.
        """
        waiting = [
            point for point in self.points.values() if not point.proven and point.limits not in ran
        ]

        def above(point: Point) -> int:
            return sum(
                other.prize == point.prize and self.counts(point.limits, other.limits)
                for other in waiting
                if other is not point
            )

        for point in sorted(waiting, key=lambda each: (above(each), each.limits)):
            yield point.limits


COLUMNS = (
    "instance_sha256",
    "delta_v_m_s",
    "duration_s",
    "method",
    "prize",
    "upper_bound",
    "status",
    "visits",
    "cost",
    "runtime_s",
    "cpu_s",
    "routes",
)

OF_DRIVES = {"thrust": "thrust_n", "isp": "isp_s"}
"""Further columns, after the duration, where these are varied, by the kind of axis."""


def write_table(path: str | os.PathLike[str], made: Tradeoff) -> None:
    """Write the CSV file completely or not at all."""
    kinds = {axis.kind for axis in made.axes}
    at = COLUMNS.index("method")
    drives = (name for kind, name in OF_DRIVES.items() if kind in kinds)
    columns = (*COLUMNS[:at], *drives, *COLUMNS[at:])
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for point in made.points:
        writer.writerow(
            {
                **point.to_dict(),
                "instance_sha256": made.instance.sha256,
                "method": "+".join(point.methods),
                "cost": "nan" if math.isnan(point.cost) else repr(point.cost),
                "runtime_s": f"{point.runtime_s:.3f}",
                "cpu_s": f"{point.cpu_s:.3f}",
                "routes": json.dumps(point.routes, ensure_ascii=False),
            }
        )
    write_text(path, text.getvalue())
