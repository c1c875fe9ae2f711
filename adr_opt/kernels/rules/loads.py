"""Cargo of a chaser, and its effect on the ΔV of the tank (docs/model.md section 5).

A tank by mass is counted as the ΔV that is left in it, v = g₀ Isp ln(m / m_f): the mass there is
over the one without propellant. So a leg takes its ΔV off it, whatever is aboard, as of a tank
that is counted in ΔV. Only a service changes the masses otherwise. Leaving a kit behind takes the
same off both of them,

    exp(v' / g₀ Isp) = (m_f exp(v / g₀ Isp) − m_kit) / (m_f − m_kit) ,

and towing an object of mass D with burns of ΔV x, which are flown with the mass of both,

    exp(v' / g₀ Isp) = A exp(v / g₀ Isp) − (1 − A) D / m_f ,    A = exp(−x / g₀ Isp) .

Planners know masses only through such increasing affine maps of exp(v / g₀ Isp): more ΔV before a
service means more after it.
"""

import math
from typing import NamedTuple

import numpy as np

from ...common.constants import SLACK_M_S
from ..core.compile import inlined


class Loads(NamedTuple):
    """Cargo of a chaser.

    Attributes
    ----------
    exhaust : float
        g₀ Isp [m/s].
    takes : (bodies,) int64
        Kits that the service of each body takes.
    full : (most + 1,) float64
        ΔV of a full tank by number of kits aboard, with the slack of the model [m/s].
    first : (most + 1,) float64
        ΔV at the start; equal to ``full`` where the first leg pays for the difference.
    scale, loss : (bodies, most + 1) float64
        The service of a body turns exp(v / g₀ Isp) into scale · exp(v / g₀ Isp) − loss, by number
        of kits aboard.
    heavy : bool
        Whether kits weigh anything.
    flown : (bodies,) float64
        ΔV flown within the service of each body, as in a tow; part of the cost [m/s].
    """

    exhaust: float
    takes: np.ndarray
    full: np.ndarray
    first: np.ndarray
    scale: np.ndarray
    loss: np.ndarray
    heavy: bool
    flown: np.ndarray


NOT_ENOUGH = -1.0
"""Remaining ΔV that marks an infeasible service."""


@inlined
def full_tank(loads, budget, kits):
    """ΔV of a full tank with ``kits`` aboard [m/s]."""
    if loads is None:
        return budget
    return loads.full[kits]


@inlined
def first_tank(loads, budget, kits):
    """ΔV in the tank at the start with ``kits`` aboard [m/s]."""
    if loads is None:
        return budget
    return loads.first[kits]


@inlined
def after_service(loads, body, kits, left):
    """ΔV and kits remaining after a service.

    Parameters
    ----------
    loads : Loads or None
    body, kits : int
    left : float
        On arrival, with the slack of the model, which no service adds to [m/s].

    Returns
    -------
    left : float
        [m/s]; :data:`NOT_ENOUGH` where there is no kit or too little in the tank.
    kits : int
    """
    if loads is None:
        return left, kits
    rest = kits - loads.takes[body]
    if rest < 0:
        return NOT_ENOUGH, rest
    scale, loss = loads.scale[body, kits], loads.loss[body, kits]
    if loss == 0.0 or (scale >= 1.0 and left <= SLACK_M_S):
        return left, rest
    ratio = scale * math.exp((left - SLACK_M_S) / loads.exhaust) - loss
    if ratio <= 0.0:
        return NOT_ENOUGH, rest
    return loads.exhaust * math.log(ratio) + SLACK_M_S, rest


@inlined
def flown_in_service(loads, body):
    """ΔV flown within a service [m/s]."""
    if loads is None:
        return 0.0
    return loads.flown[body]


@inlined
def is_possible(loads, left):
    """Whether a service is feasible, from the ΔV remaining after it."""
    if loads is None:
        return True
    return left >= 0.0


@inlined
def most_kits(loads):
    """Maximum number of kits aboard."""
    if loads is None:
        return 0
    return loads.full.size - 1


@inlined
def may_stand_for(loads, kits, other):
    """Whether ``kits`` aboard dominate ``other``: every continuation remains possible.

    At equal remaining ΔV, fewer kits mean a lighter chaser, so that neither dominates.
    """
    if loads is None:
        return True
    return kits == other or (kits > other and not loads.heavy)
