"""Adapter of brahe: free motion with its forces, in its integrator, in the frame of an instance.

brahe is a maintained library in Rust. Its wheel carries EGM2008 and computes NRLMSISE-00, the
places of Sun and Moon in closed form, and the conical shadow of the Earth; the rotation of the
Earth is read from the tables of the IERS in the wheel ``astropy-iers-data``. Nothing is loaded from
the network. Its data of rotation and space weather are settings of the whole process.

Its method of order 12 for second-order equations would be the most exact one for gravity, but takes
the velocity that drag depends on from the beginning of a step. So the method of Runge, Kutta and
Fehlberg of order 8 is used, in equal steps: those that it chooses by itself are less exact at the
same work.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import MissingExtra
from ...kernels.orbits.short_periods import Array
from ...plan.refined_thrust import RefinedThrust
from ...problem.frame import Frame
from ...problem.instance import Instance
from .settings import DEGREE, Forces, SpaceWeather


class PushedWindow(NamedTuple):
    """Thrust over a window.

    Attributes
    ----------
    begin_s, end_s : float
    steering : tuple of float
        A to E of docs/model.md section 11.6.
    mass_kg : float
        At its beginning.
    force_n, flow_kg_s : float
    """

    begin_s: float
    end_s: float
    steering: tuple[float, float, float, float, float]
    mass_kg: float
    force_n: float
    flow_kg_s: float

    def law(self, start_s: float, axes: Array) -> Callable[[float, Array, object], Array]:
        """Rates of a state due to thrust, in the form and axes of the library.

        Parameters
        ----------
        start_s : float
            What its times count from.
        axes : (3, 3) float64
            From the frame of the plan to that of the library.
        """
        # The node is told by the third axis of the plan, as it is seen in the library.
        pole = np.ascontiguousarray(axes[:, 2])
        begin_s = self.begin_s - start_s

        def rates(time_s: float, state: Array, parameters: object) -> Array:
            mass = self.mass_kg - self.flow_kg_s * (time_s - begin_s)
            found = np.zeros(6)
            found[3:] = self.force_n / mass * direction(state, pole, self.steering)
            return found

        return rates


def direction(
    state: Array, pole: Array, steering: tuple[float, float, float, float, float]
) -> Array:
    """Unit vector of thrust at a state, latitudes counted from the equator of a pole."""
    a, b, c, d, e = steering
    place = state[:3]
    outward = place / math.sqrt(place @ place)
    momentum = _cross(place, state[3:])
    normal = momentum / math.sqrt(momentum @ momentum)
    node = _cross(pole, normal)
    node /= math.sqrt(node @ node)
    cosine, sine = float(node @ outward), float(_cross(normal, node) @ outward)
    along = c + 2.0 * (a * cosine + b * sine)
    found = (a * sine - b * cosine) * outward + along * _cross(normal, outward)
    found += (d * cosine + e * sine) * normal
    unit: Array = found / math.sqrt(found @ found)
    return unit


def _cross(first: Array, second: Array) -> Array:
    """Vector product, several times as fast as NumPy's."""
    a, b, c = first
    x, y, z = second
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


def pushes(thrust: RefinedThrust) -> Iterator[PushedWindow]:
    """Windows of a leg in order, with the mass at the beginning of each."""
    flow, mass = thrust.force_n / thrust.exhaust_m_s, thrust.mass_kg
    for arc in thrust.arcs:
        for begin_s, end_s in arc.windows_s:
            yield PushedWindow(begin_s, end_s, arc.steering, mass, thrust.force_n, flow)
            mass -= flow * (end_s - begin_s)


STEPS = 85
"""Steps per revolution at the perigee; a week ends within a metre of twice as many."""

ANY_ERROR = 1e3
"""Tolerance so wide that no step is rejected or changed."""

EXTRA = ("flying with all forces", "brahe", "forces")


class Moving(NamedTuple):
    """A state, shape (6,) [m, m/s], its forces, its own thrust, and steps per revolution."""

    state: Array
    forces: Any
    push: PushedWindow | None = None
    steps: int = STEPS


class World:
    """Free motion in the frame of an instance, with brahe.

    Parameters
    ----------
    start : datetime
        What times count from.
    frame : Frame
        In which states are given and returned.

    Raises
    ------
    MissingExtra
        brahe, or the tables of the Earth's rotation, are not installed.
    """

    def __init__(self, start: datetime, frame: Frame) -> None:
        try:
            import brahe
            from astropy_iers_data import IERS_A_FILE
        except ImportError:
            raise MissingExtra(*EXTRA) from None
        self._brahe = brahe
        rotation = brahe.FileEOPProvider.from_standard_file(IERS_A_FILE, True, "Hold")
        brahe.set_global_eop_provider_from_file_provider(rotation)
        # Within 12 cm a week of the full series of nutation, and several times as fast.
        brahe.set_precession_nutation_model(brahe.PrecessionNutationModel.IAU2000B)
        self._start = self._epoch(start)
        self._axes = self._to_gcrf(frame)

    @classmethod
    def of(cls, instance: Instance) -> World:
        """The world of an instance; elements without a frame are taken as TEME at its epoch."""
        assumed = Frame(name="TEME", axes_epoch=instance.epoch)
        return cls(instance.epoch, instance.frame or assumed)

    def all_forces(self, settings: Forces, area_mass_m2_kg: float) -> Any:
        """Gravity, drag, Sun, Moon and radiation pressure on an object."""
        brahe = self._brahe
        self._set_weather(settings.weather)
        value = brahe.ParameterSource.value
        nearby = brahe.EphemerisSource.LowPrecision
        return brahe.ForceModelConfig(
            gravity=brahe.GravityConfiguration.spherical_harmonic(degree=DEGREE, order=DEGREE),
            drag=brahe.DragConfiguration(
                model=brahe.AtmosphericModel.NRLMSISE00,
                area=value(area_mass_m2_kg),
                cd=value(settings.drag),
            ),
            srp=brahe.SolarRadiationPressureConfiguration(
                area=value(area_mass_m2_kg),
                cr=value(settings.reflection),
                eclipse_model=brahe.EclipseModel.CONICAL,
            ),
            third_body=[
                brahe.ThirdBodyConfiguration(body, ephemeris_source=nearby)
                for body in (brahe.ThirdBody.SUN, brahe.ThirdBody.MOON)
            ],
            mass=value(1.0),
        )

    def zonal(self, zonals: Array) -> Any:
        """J2, J3 and J4 alone about the axis of GCRF, with the constants of refined plans."""
        brahe = self._brahe
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "zonal.gfc"
            path.write_text(_coefficients(zonals))
            field = brahe.GravityModel.from_file(str(path))
        brahe.set_global_gravity_model(field)
        gravity = brahe.GravityConfiguration.spherical_harmonic(degree=4, order=4, use_global=True)
        return brahe.ForceModelConfig(
            gravity=gravity, frame_transform=brahe.FrameTransformationModel.EARTH_ROTATION_ONLY
        )

    def coast(self, objects: Sequence[Moving], start_s: float, end_s: float) -> list[Array]:
        """States after a coast, of several objects side by side.

        Raises
        ------
        ArithmeticError
            They lead into the Earth or away from it.
        """
        if start_s == end_s:
            return [one.state for one in objects]
        flying = [self._propagator(one, start_s) for one in objects]
        until = self._start + end_s
        if any(one.push is not None for one in objects):
            # A law in Python cannot be asked from several threads.
            for one in flying:
                one.propagate_to(until)
        else:
            self._brahe.par_propagate_to(flying, until)
        found = [self._turned(one.current_state(), self._axes.T) for one in flying]
        for state in found:
            _perigee_revolution_s(state)
        return found

    def _propagator(self, one: Moving, start_s: float) -> Any:
        brahe = self._brahe
        how = self.integration(_perigee_revolution_s(one.state) / one.steps)
        found = brahe.NumericalOrbitPropagator(
            self._start + start_s,
            self._turned(one.state, self._axes),
            how,
            one.forces,
            control_input=None if one.push is None else one.push.law(start_s, self._axes),
        )
        found.set_trajectory_mode(brahe.TrajectoryMode.DISABLED)
        return found

    def integration(self, step_s: float) -> Any:
        """Integration method and step length."""
        brahe = self._brahe
        equal = brahe.IntegratorConfig(
            abs_tol=ANY_ERROR, rel_tol=1.0, initial_step=step_s, max_step=step_s
        )
        return brahe.NumericalPropagationConfig(
            brahe.IntegrationMethod.RKF78, equal, brahe.VariationalConfig()
        )

    @staticmethod
    def _turned(state: Array, axes: Array) -> Array:
        return np.concatenate([axes @ state[:3], axes @ state[3:]])

    def _epoch(self, time: datetime) -> Any:
        utc = time.astimezone(UTC)
        return self._brahe.Epoch.from_datetime(
            utc.year,
            utc.month,
            utc.day,
            utc.hour,
            utc.minute,
            float(utc.second),
            1e3 * utc.microsecond,
            self._brahe.TimeSystem.UTC,
        )

    def _to_gcrf(self, frame: Frame) -> Array:
        """Rotation matrix from a frame to GCRF, shape (3, 3)."""
        if frame.axes_epoch is not None:
            return np.asarray(self._brahe.rotation_teme_to_gcrf(self._epoch(frame.axes_epoch)))
        if frame.name == "EME2000":
            return np.asarray(self._brahe.rotation_eme2000_to_gcrf())
        return np.eye(3)

    def _set_weather(self, weather: SpaceWeather) -> None:
        constant = self._brahe.StaticSpaceWeatherProvider.from_values(
            kp=weather.kp, ap=weather.ap, f107=weather.f107, f107a=weather.f107, s=0
        )
        self._brahe.set_global_space_weather_provider(constant)


def _perigee_revolution_s(state: Array) -> float:
    """Duration of a revolution on the circle of the perigee [s].

    Raises
    ------
    ArithmeticError
        The orbit is not closed, or its perigee is deep in the Earth.
    """
    position, velocity = state[:3], state[3:]
    radius = math.hypot(*position)
    inverse = 2.0 / radius - float(velocity @ velocity) / MU_M3_S2
    if inverse <= 0.0:
        raise ArithmeticError("the orbit leads away from the Earth")
    momentum = np.cross(position, velocity)
    square = max(1.0 - float(momentum @ momentum) * inverse / MU_M3_S2, 0.0)
    perigee = (1.0 - math.sqrt(square)) / inverse
    if not perigee > 0.9 * EARTH_RADIUS_M:  # and where there are no numbers left
        raise ArithmeticError("the orbit leads into the Earth")
    return math.tau * math.sqrt(perigee**3 / MU_M3_S2)


def _coefficients(zonals: Array) -> str:
    """A zonal field as a file of the ICGEM, whose coefficients are normalised."""
    lines = [
        "product_type gravity_field",
        "modelname zonal",
        f"earth_gravity_constant {MU_M3_S2!r}",
        f"radius {EARTH_RADIUS_M!r}",
        "max_degree 4",
        "errors no",
        "norm fully_normalized",
        "tide_system tide_free",
        "key L M C S",
        "end_of_head",
    ]
    terms = {0: 1.0} | {
        degree: -float(zonals[degree - 2]) / math.sqrt(2.0 * degree + 1.0) for degree in (2, 3, 4)
    }
    for degree in range(5):
        for order in range(degree + 1):
            term = terms.get(degree, 0.0) if order == 0 else 0.0
            lines.append(f"gfc {degree} {order} {term!r} 0.0")
    return "\n".join(lines) + "\n"
