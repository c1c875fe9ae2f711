"""Low-thrust campaigns after mcrdv: its estimate of legs, its plan, and what is cheapest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from from_outside import DATA, external
from outside.odrc import published
from outside.odrc.estimate import equinoctial, greatest_rates, matrices
from outside.odrc.ours import plan
from outside.odrc.reading import read_debris, with_centroid
from outside.odrc.scoring import Route, score

FILE = DATA / "mcrdv" / "odrc.csv"

pytestmark = external("mcrdv")


@pytest.fixture(scope="module")
def bodies():
    return with_centroid(read_debris(FILE))


def test_the_published_plan_has_its_published_cost(bodies):
    """The plan with three chasers costs 44,830.8 m/s by the scorer too, and breaks no rule."""
    found = score(bodies, published.PLAN)
    assert found.total_m_s == pytest.approx(published.TOTAL_M_S, abs=1e-3)
    assert found.routes_m_s == pytest.approx([20626.1255, 15093.0426, 9111.6277], abs=1e-3)
    assert found.violations == ()


def test_the_centroid_is_in_the_middle(bodies):
    """Chasers begin on the mean size, and at the mean directions of angles around the circle."""
    debris = bodies[1:]
    assert bodies.shape == (14, 6)
    assert bodies[0, :3] == pytest.approx(debris[:, :3].mean(axis=0))
    turned = debris.copy()
    turned[:, 3:] += 1.0
    away = with_centroid(turned)[0, 3:] - bodies[0, 3:] - 1.0
    assert np.cos(away) == pytest.approx(1.0)


def test_a_change_of_size_costs_what_its_rate_says(bodies):
    """Between circles that differ in size alone, ΔV is the change over the greatest rate, × 1.5."""
    two = np.array([[7.0e6, 0.0, 1.5, 0.3, 0.0, 0.0], [7.1e6, 0.0, 1.5, 0.3, 0.0, 0.0]])
    duration, delta_v = matrices(two, np.array([0.0]))
    expected = 1.5 * 1e5 / (2.0 * math.sqrt(7.0e6**3 / 3.986004e14))
    assert delta_v[0, 0, 1] == pytest.approx(expected)
    assert duration[0, 0, 1] == pytest.approx(expected / 3e-3)
    assert np.isinf(delta_v[0, 0, 0])


def test_nodes_drift(bodies):
    """After a year, h and k have turned by the secular rate of the node and kept their length."""
    early, late = equinoctial(bodies, np.array([0.0, 365.0 * 86400.0])).transpose(1, 0, 2)
    assert np.hypot(*late[3:]) == pytest.approx(np.hypot(*early[3:]))
    axis, eccentricity, inclination = bodies[:, 0], bodies[:, 1], bodies[:, 2]
    slowed = (6.378137e6 / (axis * (1.0 - eccentricity**2))) ** 2 * np.sqrt(3.986004e14 / axis**3)
    turned = -1.5 * 1.082626e-3 * slowed * np.cos(inclination) * 365.0 * 86400.0
    measured = np.arctan2(late[4], late[3]) - np.arctan2(early[4], early[3])
    assert np.cos(measured - turned) == pytest.approx(1.0)
    assert greatest_rates(early).shape == early.shape


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda plan: plan[:2], "debris 0: met 0 times"),
        (lambda plan: (Route((13,), (0.0,)), *plan), "numbered from 0 to 12"),
        (lambda plan: (*plan, Route((11,), (0.0,))), "debris 11: met 2 times"),
        (lambda plan: (Route((11,), (3e7,)), *plan[1:]), "chaser 0: 432"),
        (lambda plan: (plan[0], Route((8, 6, 9), (0.0, 9e5, 3e6)), plan[2]), "chaser 1: leaves at"),
        (lambda plan: (*plan[:2], Route((7, 1, 8, 6, 9, 11), (0.0, *5 * [1e6]))), "25"),
    ],
)
def test_broken_rules_are_named(bodies, change, said):
    """A plan that breaks a rule is told by a sentence about that rule."""
    found = score(bodies, change(published.PLAN))
    assert any(said in sentence for sentence in found.violations), found.violations


def test_too_many_debris_are_named(bodies):
    """A chaser that meets more debris than it may carry for is told."""
    assert any("9 debris" in said for said in score(bodies, published.PLAN, load=8).violations)


def test_our_plan_is_proven_and_beats_the_published_one(bodies):
    """On a grid of five days the campaign is proven, legal by the scorer, and cheaper."""
    ours = plan(bodies, 73, 3, 60.0)
    scored = score(bodies, ours.routes)
    assert ours.proven
    assert scored.violations == ()
    assert scored.total_m_s == pytest.approx(ours.total_m_s)
    assert ours.total_m_s < published.TOTAL_M_S
