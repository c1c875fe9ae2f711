"""Orbits from which chasers continue after a tow (docs/model.md section 5.4).

After a tow between circles a chaser that leaves at a time t is on the disposal orbit then,

    u(t) = u_j(t − T) + π,    Ω(t) = Ω_j(t − T) + Ω̇_h T,

with T and Ω̇_h of the half ellipse (docs/model.md section 2): a body whose angles advance as the
object's do, by the time of departure, on another radius. A row of such a body is that of the object
*as it is left*. What has left drifts as its own radius says, which is one column more.

A tow from apogee ends once in a revolution of the object, and then the chaser waits on the orbit
that it leads to. So between two ends it is a body of its own, with that orbit's own rates, and its
rows are those of *pieces* of time. What is left at any time is told by the row of its piece.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..kernels.orbits import ephemeris
from ..kernels.orbits.body_rows import as_left, with_orbit
from ..kernels.orbits.eccentricity import matchings
from ..kernels.orbits.ephemeris import EPOCH_S
from ..problem.drives import Drive
from ..problem.instance import Instance
from ..problem.orbit import Orbit
from .tows import RemovalFlight, from_apogee, removals_of

FloatArray = npt.NDArray[np.float64]

KEPLER_STEPS = 30
"""Number of Newton steps, far more than nearly circular orbits take."""


class Pieces(NamedTuple):
    """Rows of a body at departure, piece by piece of time.

    Attributes
    ----------
    rows : (pieces, columns) float64
    since, until : (pieces,) float64
        A chaser leaves not before and not after [s].
    """

    rows: FloatArray
    since: FloatArray
    until: FloatArray


class Pieced(NamedTuple):
    """Departures from an object whose tow begins at an apogee.

    Attributes
    ----------
    row : (columns,) float64
        Of the object.
    tow : RemovalFlight
    oblateness_m2 : float
        J2 R², 0 for two bodies.
    """

    row: FloatArray
    tow: RemovalFlight
    oblateness_m2: float

    def ended_s(self, leaves_s: float) -> float:
        """End of the last burn of the tow after which a chaser leaves at a time [s]."""
        return self.tow.begins_s(leaves_s) + self.tow.flight_s

    def row_at(self, leaves_s: float) -> FloatArray:
        """Row of a chaser that leaves at a time, shape (columns + 1,)."""
        tow, ended_s = self.tow, self.ended_s(leaves_s)
        begun_s = ended_s - tow.flight_s
        inclination = float(ephemeris.inclination_at(self.row, begun_s))
        perigee = float(ephemeris.perigee_at(self.row, begun_s))
        node = float(ephemeris.node_at(self.row, begun_s)) + tow.shift_rad
        shape = tow.radius_m, tow.eccentricity, inclination, self.oblateness_m2
        node_rate, perigee_rate, anomaly_rate = ephemeris.secular_rates(*shape)
        latitude_rate = perigee_rate + anomaly_rate
        made = ephemeris.body_row(
            tow.radius_m,
            inclination,
            node - node_rate * ended_s,
            perigee + math.pi + tow.turned_rad - latitude_rate * ended_s,
            eccentricity=tow.eccentricity,
            perigee=perigee - perigee_rate * ended_s,
            oblateness_m2=self.oblateness_m2,
        )
        row: FloatArray = as_left(np.array([made]))[0]
        return row

    def spaced(self, spacing_s: float, until_s: float) -> Pieces:
        """Pieces up to a time, each at least a spacing after the previous one [s]."""
        assert self.tow.apogees is not None
        period_s, lap = self.tow.apogees.period_s, 0
        first_s = self.ended_s(period_s)
        begins = []
        while (begin_s := first_s + lap * period_s) <= until_s:
            begins.append(begin_s)
            lap += max(1, math.ceil(spacing_s / period_s - 1e-9))
        since = np.array(begins)
        rows = np.array([self.row_at(begin_s) for begin_s in begins])
        width = self.row.size + 1
        return Pieces(rows.reshape(-1, width), since, since + period_s)

    def on_grid(self, step_s: float, until_s: float) -> FloatArray:
        """Rows of chasers that leave at the times of a grid, shape (times, columns + 1)."""
        return np.array([self.row_at(at * step_s) for at in range(int(until_s / step_s) + 1)])


def pieced_of(instance: Instance, tows: dict[int, RemovalFlight]) -> dict[int, Pieced]:
    """Objects of an instance whose tows begin at an apogee, by number of the body."""
    rows = instance.orbits()
    return {
        body: Pieced(rows[body], tow, instance.oblateness_m2)
        for body, tow in tows.items()
        if tow.apogees is not None
    }


def left_row(instance: Instance, name: str, time_s: float) -> FloatArray | None:
    """Row of a chaser that leaves a body at a time, (columns + 1,), after a tow from apogee.

    None for a body that is not towed so by impulses.
    """
    body = instance.names.index(name)
    target = (
        instance.targets[body - instance.first_target] if body >= instance.first_target else None
    )
    if target is None or not from_apogee(instance, target):
        return None
    return pieced_of(instance, removals_of(instance, None))[body].row_at(time_s)


def leaving_orbits(instance: Instance, drive: Drive | None) -> FloatArray:
    """Bodies at departure, shape (bodies, columns): as in :meth:`Instance.orbits`.

    Those that are towed are left from where the tow leads; those of tows from apogee as in their
    first piece. Where there are some, rows have one column more, see
    :func:`adr_opt.kernels.orbits.body_rows.as_left`.
    """
    rows, tows = instance.orbits(), removals_of(instance, drive)
    if not tows:
        return rows
    pieced = pieced_of(instance, tows)
    rows = as_left(rows)
    for body, tow in tows.items():
        if body in pieced:
            rows[body] = pieced[body].row_at(tow.time_s)
            continue
        row = rows[body]
        node, node_rate = ephemeris.node_tangent(row, EPOCH_S)
        latitude, latitude_rate = ephemeris.latitude_tangent(row, EPOCH_S)
        inclination = ephemeris.inclination_at(row, EPOCH_S)
        rows[body] = with_orbit(
            row,
            radius_m=tow.radius_m,
            node=node + (tow.shift_rad - node_rate * tow.time_s),
            latitude=latitude + (tow.turned_rad - latitude_rate * tow.time_s),
            eccentricity=0.0,
            coasting_node_rate=ephemeris.node_rate(
                tow.radius_m, inclination, instance.oblateness_m2
            ),
        )
    return rows


def released_orbit(instance: Instance, drive: Drive | None, name: str, time_s: float) -> Orbit:
    """Orbit of a chaser that released an object at a time, and stays there."""
    body = instance.names.index(name)
    pieced = pieced_of(instance, removals_of(instance, drive)).get(body)
    row = leaving_orbits(instance, drive)[body] if pieced is None else pieced.row_at(time_s)
    radius = float(ephemeris.radius_at(row, time_s))
    inclination = float(ephemeris.inclination_at(row, time_s))
    eccentricity = float(ephemeris.eccentricity_at(row, time_s))
    coasting = float(ephemeris.coasting_node_rate_at(row, time_s))
    node = float(ephemeris.node_at(row, time_s)) - coasting * time_s
    perigee = float(ephemeris.perigee_at(row, EPOCH_S)) if eccentricity else 0.0
    shape = radius, eccentricity, inclination, instance.oblateness_m2
    _, perigee_rate, anomaly_rate = ephemeris.secular_rates(*shape)
    latitude = float(ephemeris.latitude_at(row, time_s)) - (perigee_rate + anomaly_rate) * time_s
    return Orbit(
        semi_major_axis_m=radius,
        eccentricity=eccentricity,
        inclination_deg=math.degrees(inclination),
        raan_deg=math.degrees(node) % 360.0,
        argument_of_perigee_deg=math.degrees(perigee) % 360.0,
        true_anomaly_deg=math.degrees(_true_anomaly(latitude - perigee, eccentricity)) % 360.0,
    )


def _true_anomaly(mean: float, eccentricity: float) -> float:
    """True anomaly of a mean one, by Newton's method for Kepler's equation [rad]."""
    if eccentricity == 0.0:
        return mean
    angle = mean
    for _ in range(KEPLER_STEPS):
        behind = angle - eccentricity * math.sin(angle) - mean
        angle -= behind / (1.0 - eccentricity * math.cos(angle))
    stretch = math.sqrt((1.0 + eccentricity) / (1.0 - eccentricity))
    return 2.0 * math.atan2(stretch * math.sin(0.5 * angle), math.cos(0.5 * angle))


def leaving_eccentricity_delta_v(instance: Instance, leaving: FloatArray) -> FloatArray:
    """Cost of matching eccentricity vectors alone after such a departure [m/s].

    As :meth:`Instance.eccentricity_delta_v`, shape (origin, destination).
    """
    costs, rows = instance.eccentricity_delta_v(), instance.orbits()
    if instance.nodes_drift:
        return costs
    for body in removals_of(instance, None):
        columns = rows.shape[1]
        for other in range(len(rows)):
            ends = np.array([leaving[body, :columns], rows[other]])
            costs[body, other] = 0.0 if other == body else matchings(ends, EPOCH_S)[0, 1]
    return costs
