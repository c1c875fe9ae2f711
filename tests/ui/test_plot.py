"""Pictures for notebooks."""

from __future__ import annotations

import subprocess
import sys
from itertools import combinations, pairwise

import numpy as np
import pytest
from plans import with_legs

import adr_opt
from adr_opt.common.constants import EARTH_RADIUS_M
from adr_opt.plan.plan import Plan
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import KeepOutZone
from adr_opt.ui import plot
from adr_opt.ui.plot.budget import budgets
from adr_opt.ui.plot.nodes import raan_deg
from adr_opt.ui.plot.strands import tracks

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
pyplot = pytest.importorskip("matplotlib.pyplot")

ZONE = KeepOutZone(min_altitude_m=820e3, max_altitude_m=840e3, start_s=1e4, end_s=5e4)


@pytest.fixture(scope="module")
def flown() -> tuple[Instance, Plan]:
    """An instance with a zone, and a plan that refuels."""
    instance = adr_opt.generate("nominal", 0)
    instance = instance.replace(keep_out_zones=(ZONE,))
    result = adr_opt.solve(instance, "greedy-guarded")
    assert result.plan is not None
    assert instance.stations[0].name in result.plan.destinations
    return instance, result.plan


@pytest.fixture
def ax():
    """An axis of its own."""
    figure, axis = pyplot.subplots()
    yield axis
    pyplot.close(figure)


@pytest.mark.slow
def test_importing_does_not_import_matplotlib() -> None:
    """The functions use the axis that they are given, so the package needs no matplotlib."""
    code = "import sys, adr_opt.ui.plot; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("name", ["altitude", "delta_v_left", "gantt", "planes"])
def test_each_adds_to_the_axis_and_returns_it(flown, ax, name: str) -> None:
    """A plot leaves what was drawn, adds something, labels the axes and returns the axis."""
    (before,) = ax.plot([0.0], [0.0])
    count = len(ax.get_children())
    assert getattr(plot, name)(ax, *flown) is ax
    assert before in ax.lines
    assert len(ax.get_children()) > count
    assert ax.get_xlabel()
    assert ax.get_ylabel()


def test_labels_of_the_caller_stay(flown, ax) -> None:
    """An axis that has its label keeps it."""
    ax.set_xlabel("mine")
    assert plot.altitude(ax, *flown).get_xlabel() == "mine"


@pytest.mark.parametrize("name", ["altitude", "delta_v_left", "gantt", "planes"])
def test_a_plan_without_legs_can_be_drawn(flown, ax, name: str) -> None:
    """A plan that stays at the station gives a picture, not an error."""
    instance, plan = flown
    assert getattr(plot, name)(ax, instance, with_legs(plan, ())) is ax


def test_segments_fill_the_mission_without_gaps(flown) -> None:
    """Each phase begins when the one before ends, from the epoch to the end of the last leg."""
    instance, plan = flown
    found = plot.segments(instance, plan)
    assert found[0].start_s == 0.0
    assert found[-1].end_s == plan.legs[-1].end_s
    assert {segment.phase for segment in found} <= set(plot.PHASES)
    assert "refuelling" in {segment.phase for segment in found}
    for before, after in pairwise(found):
        assert after.start_s == pytest.approx(before.end_s, abs=1e-3)
        assert after.leg in (before.leg, before.leg + 1)


def test_tracks_and_segments_agree(flown) -> None:
    """The sampled flight has the phases that are read off the plan, at the same times."""
    cut = [s for s in plot.segments(*flown) if s.duration_s > 0.01]
    sampled = [t for t in tracks(*flown) if t.times_s[-1] - t.times_s[0] > 0.01]
    assert [(t.leg, t.phase) for t in sampled] == [(s.leg, s.phase) for s in cut]
    np.testing.assert_allclose(
        [(t.times_s[0], t.times_s[-1]) for t in sampled],
        [(s.start_s, s.end_s) for s in cut],
        atol=1e-3,
    )


def test_service_is_drawn_at_the_altitude_of_the_target(flown) -> None:
    """While the chaser services a target, the altitude shown is that of the target's circle."""
    instance, plan = flown
    axes = {target.name: target.orbit.semi_major_axis_m for target in instance.targets}
    services = [track for track in tracks(instance, plan) if track.phase == "service"]
    assert len(services) > 10
    for track in services:
        expected = axes[plan.legs[track.leg - 1].destination] - EARTH_RADIUS_M
        np.testing.assert_allclose(track.altitudes_m, expected, atol=1.0)


def test_a_level_arc_is_two_points_and_a_ring_closes(flown) -> None:
    """Thinning out keeps the ends of level arcs and at most one closed revolution of any arc."""
    for track in tracks(*flown):
        if track.phase in ("service", "refuelling", "phasing"):
            assert len(track.times_s) == 2
        assert len(track.around_m) < 130
    ring = plot.strands.ring(flown[0], "station")
    np.testing.assert_allclose(ring[0], ring[-1], atol=1e-3)


def test_the_budget_ends_every_leg_as_the_plan_says(flown) -> None:
    """ΔV left falls burn by burn to what the plan states after each leg."""
    instance, plan = flown
    course = budgets(instance, plan)[instance.chaser.name]
    for number, leg in enumerate(plan.legs, start=1):
        last = max(at for at, of_leg in enumerate(course.legs) if of_leg == number)
        assert course.left_m_s[last] == pytest.approx(leg.delta_v_left_m_s, abs=1e-3)
    assert sum(course.refuelled) == plan.destinations.count("station")
    assert list(course.times_s) == sorted(course.times_s)


def test_zones_are_where_the_instance_has_them(flown, ax) -> None:
    """A keep-out zone is a box in days and km."""
    plot.keep_out_zones(ax, flown[0])
    (box,) = ax.collections
    low, high = box.get_paths()[0].vertices.min(axis=0), box.get_paths()[0].vertices.max(axis=0)
    np.testing.assert_allclose(low, [1e4 / 86400.0, 820.0])
    np.testing.assert_allclose(high, [5e4 / 86400.0, 840.0])


def test_planes_near_0_and_near_360_degrees_are_neighbours() -> None:
    """RAANs are shown without a jump between bodies around that of the station."""
    instance = adr_opt.generate("tiny", 0)
    turned = [
        target.replace(orbit=target.orbit.replace(raan_deg=raan))
        for target, raan in zip(instance.targets, (359.0, 2.0, -361.0, 720.5), strict=False)
    ]
    instance = instance.replace(
        stations=(
            instance.stations[0].replace(orbit=instance.stations[0].orbit.replace(raan_deg=360.0)),
        ),
        targets=tuple(turned),
    )
    np.testing.assert_allclose(raan_deg(instance), [0.0, -1.0, 2.0, -1.0, 0.5][: 1 + len(turned)])


@pytest.mark.parametrize("quantity", ["delta_v", "duration"])
def test_matrix_shows_the_costs_of_one_departure(ax, quantity: str) -> None:
    """The image holds the sampled costs, hours for durations, and nothing where none is."""
    matrices = adr_opt.Timetable(adr_opt.generate("tiny", 0)).matrices([0.0, 3600.0])
    shown = plot.matrix(ax, matrices, 1, quantity).images[-1].get_array().filled(np.nan)
    expected = getattr(matrices, quantity)[1] / (3600.0 if quantity == "duration" else 1.0)
    assert np.isnan(np.diag(shown)).all()
    mask = np.isfinite(shown)
    assert mask.sum() > 5
    np.testing.assert_array_equal(shown[mask], expected[mask])


def test_matrix_refuses_what_is_not_there(ax) -> None:
    """A wrong quantity or departure is a sentence that names it."""
    matrices = adr_opt.Timetable(adr_opt.generate("tiny", 0)).matrices([0.0])
    with pytest.raises(adr_opt.InputError, match="quantity = 'prize'"):
        plot.matrix(ax, matrices, 0, "prize")
    with pytest.raises(adr_opt.InputError, match="departure = 1"):
        plot.matrix(ax, matrices, 1)


def test_names_are_not_taken_for_mathematics(flown) -> None:
    """A name with dollar signs is drawn as it is."""
    instance = adr_opt.generate("tiny", 0)
    targets = (instance.targets[0].replace(name="$\\frac$"), *instance.targets[1:])
    instance = instance.replace(targets=targets)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    figure, axis = pyplot.subplots()
    plot.gantt(axis, instance, plan)
    figure.canvas.draw()
    pyplot.close(figure)


def test_orbits_in_space(flown) -> None:
    """On a 3-D axis the Earth, the orbits and the path add up, to scale."""
    figure = pyplot.figure()
    axis = figure.add_subplot(projection="3d")
    assert plot.path(plot.orbits(plot.earth(axis), flown[0]), *flown) is axis
    for line in axis.lines:
        distance = np.linalg.norm(np.array(line.get_data_3d()), axis=0)
        assert np.nanmin(distance) > 6378.0
        assert np.nanmax(distance) < 9000.0
    pyplot.close(figure)


def test_a_flat_axis_is_refused_where_space_is_drawn(ax) -> None:
    """What is drawn in space says which axis it needs."""
    with pytest.raises(adr_opt.InputError, match="projection='3d'"):
        plot.earth(ax)


TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
WITHOUT = {
    "red": "0.152286 1.052583 -0.204868 0.114503 0.786281 0.099216 -0.003882 -0.048116 1.051998",
    "green": "0.367322 0.860646 -0.227968 0.280085 0.672501 0.047413 -0.01182 0.04294 0.968881",
    "blue": "1.255528 -0.076749 -0.178779 -0.078411 0.930809 0.147602 0.004733 0.691367 0.3039",
    "none": "1 0 0 0 1 0 0 0 1",
}
"""Linear colours as seen without one kind of cones: Machado, Oliveira and Fernandes (2009)."""


def linear(colour: str) -> np.ndarray:
    """Linear red, green and blue of ``#rrggbb``."""
    parts = np.array([int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def in_lab(rgb: np.ndarray) -> np.ndarray:
    """Linear colours in CIELAB, in which distances are differences that people see."""
    share = np.clip(rgb, 0.0, 1.0) @ TO_XYZ.T / (TO_XYZ @ np.ones(3))
    f = np.where(share > 216.0 / 24389.0, np.cbrt(share), (24389.0 / 27.0 * share + 16.0) / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("cones", WITHOUT)
def test_phases_are_told_apart_whatever_cones_an_eye_has(cones: str) -> None:
    """Any two phases differ by a clear step of colour, or by what their bars are hatched with."""
    eye = np.array(WITHOUT[cones].split(), dtype=float).reshape(3, 3)
    seen = {name: in_lab(eye @ linear(phase.colour)) for name, phase in plot.PHASES.items()}
    for (one, left), (other, right) in combinations(plot.PHASES.items(), 2):
        if left.pattern == right.pattern:
            assert np.linalg.norm(seen[one] - seen[other]) >= 15.0, (one, other)


def test_colours_can_be_told_from_both_backgrounds() -> None:
    """Every phase has a label and a colour of its own with 3:1 of contrast on light and dark."""

    def luminance(colour: str) -> float:
        return float(TO_XYZ[1] @ linear(colour))

    assert set(plot.COLOURS) == set(plot.LABELS) == set(plot.PHASES)
    assert len(set(plot.COLOURS.values())) == len(plot.PHASES)
    for phase, colour in plot.COLOURS.items():
        own = luminance(colour) + 0.05
        assert (luminance("#ffffff") + 0.05) / own >= 3.0, phase
        assert own / (luminance("#171e27") + 0.05) >= 3.0, phase
