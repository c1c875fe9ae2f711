"""Tariffs of walks for ΔV, which never exceed a chaser's expense.

The expense of a chaser is f(c) = fixed + p c + q c² of what it carries,

    c = m_dry (exp(V / g₀ Isp) − 1) + Σ over its kits m_kit exp(x_i / g₀ Isp) ,

with V the ΔV of its route up to the first refuelling, and x_i that up to where the i-th kit is
left: a kit takes propellant as far as it is carried (a kit that is left after a refuelling counts
for no less, with x_i = V). f rises and is convex for c ≥ 0, and c is convex in the ΔV of the legs.
A tangent nowhere exceeds a convex function. So for any c₀, and any a, a_i,

    f(c) ≥ f(c₀) + f'(c₀) (c − c₀) ,    exp(x / g₀ Isp) ≥ exp(a) (1 + x / g₀ Isp − a) ,

and together the expense is at least a constant for each number of kits, and a price for each m/s,
which goes by how many kits are aboard: the r-th last one pays for what is flown with r or more.

One tangent is poor far from where it touches. So the range of c is split, and there is a tariff for
each part, with a tank that holds no more than takes c to its upper end: a full tank flies a route
if and only if the least propellant that flies it fits into it. Every route keeps to the tank of the
part that it belongs to, and pays no more in it than it takes. So what is the most over all parts is
no less than what any route is worth, less its expense.

Legs after a refuelling cost nothing. Where there are stations, routes that refuel pay for their
kits alone, in a tariff more; in the others each refuelling costs a fee, which a route that belongs
there does not pay. A chaser that has to end at a station may pay it once at the end, and so has
that one tariff only. A tow is flown with the object, which makes c greater than its ΔV alone would;
walks pay for that, at the least price.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from adr_opt.common.constants import SLACK_M_S
from adr_opt.mission.mission import Mission
from adr_opt.problem.chasers import TankByMass

PARTS = 4
"""Number of parts into which the range of carried mass is divided."""

TANK_OFF = 1e-9
"""Relative enlargement of partial tanks for rounding."""


class Tariff(NamedTuple):
    """Prices that walks pay.

    Attributes
    ----------
    price : (kits + 1,) float64
        For a m/s, by number of kits aboard.
    constant : (kits + 1,) float64
        Before they start, by number of kits.
    tank : (kits + 1,) float64
        What they start with, by number of kits [m/s]; less than 0 where they cannot.
    fee : bool
        Whether refuelling costs as much as any target may be worth.
    """

    price: np.ndarray
    constant: np.ndarray
    tank: np.ndarray
    fee: bool = False


def tariffs_of(mission: Mission) -> tuple[Tariff, ...]:
    """Tariffs of a chaser: worth less cost of any route is at most the best walk's over all.

    Where the cost is ΔV there is one, with a price of one; and with less than nothing to pay before
    the start where the first leg takes out of the tank what was spent by then.
    """
    loads, chaser = mission.rules.loads, mission.chaser
    full = np.array([mission.rules.budget]) if loads is None else np.array(loads.first)
    ones = np.ones(full.size)
    if mission.instance.objective.cost != "expense":
        spent = mission.connecting.spent_m_s(mission.rules.start)
        return (Tariff(ones, -spent * ones, full),)
    expense, tank = chaser.priced, chaser.usable
    if not expense.counts_mass or not isinstance(tank, TankByMass):
        return (Tariff(0.0 * ones, expense.fixed * ones, full),)
    kits_kg = chaser.kit_mass_kg * np.arange(full.size)
    for_kits = Tariff(0.0 * ones, np.array([expense.of(float(kg)) for kg in kits_kg]), full)
    has_stations = mission.rules.stations > 0
    if mission.rules.returns:
        return (for_kits,)
    ends = np.linspace(0.0, tank.propellant_kg + kits_kg[-1], PARTS + 1)
    parts = [
        _tangent(mission, 0.5 * (low + high), high, full)._replace(fee=has_stations)
        for low, high in pairwise(ends.tolist())
    ]
    return (*parts, for_kits) if has_stations else tuple(parts)


def _tangent(mission: Mission, carried_kg: float, most_kg: float, full: np.ndarray) -> Tariff:
    """Tariff tangent to the expense at a load, for loads up to another one.

    Parameters
    ----------
    mission : Mission
    carried_kg, most_kg : float
    full : (kits + 1,) float64
        Full tanks [m/s].
    """
    chaser, expense, tank = mission.chaser, mission.chaser.priced, mission.chaser.usable
    assert isinstance(tank, TankByMass)
    exhaust, dry, kit = tank.exhaust_m_s, tank.dry_mass_kg, chaser.kit_mass_kg
    kits = np.arange(full.size)
    # Where it touches: with about as many kits as belong to such a load, left one after the other.
    some = round((full.size - 1) * carried_kg / max(tank.propellant_kg + kits[-1] * kit, 1e-300))
    flown = math.log1p(max(carried_kg - some * kit, 0.0) / (dry + 0.5 * some * kit))
    left = flown * np.maximum(0.0, 1.0 - (kits - 1.0) / max(some, 1))
    rise = expense.per_kg + 2.0 * expense.per_kg_squared * carried_kg
    of_kit = np.where(kits > 0, kit * np.exp(left), 0.0)
    price = rise * (dry * math.exp(flown) + np.cumsum(of_kit)) / exhaust
    constant = (
        expense.of(carried_kg)
        - rise * carried_kg
        + rise * (dry * (math.exp(flown) * (1.0 - flown) - 1.0) + np.cumsum(of_kit * (1.0 - left)))
    )
    room = np.minimum(tank.propellant_kg, most_kg - kits * kit)
    starts = exhaust * np.log1p(np.maximum(room, 0.0) / (dry + kits * kit))
    starts = np.minimum(full, starts * (1.0 + TANK_OFF) + SLACK_M_S)
    starts[room < -TANK_OFF * most_kg] = -1.0
    return Tariff(price, constant, starts)


def most_expense(mission: Mission) -> float:
    """Strict upper bound on the cost of any route."""
    loads, chaser, tank = mission.rules.loads, mission.chaser, mission.chaser.usable
    carried = 0.0
    if isinstance(tank, TankByMass):
        kits = 0 if loads is None else loads.full.size - 1
        carried = tank.propellant_kg + kits * chaser.kit_mass_kg
    return chaser.priced.of(carried)
