"""Value of an hour when a single transfer is chosen without lookahead."""

from __future__ import annotations

import math

from ..common.constants import HOUR_S
from ..common.errors import InputError

SPENT_BY_DRIFTING, REFUELLED = 0.8, 3.0
"""Value of an hour where planes drift, as a multiple of a tank over the mission; the second
number multiplies it where there are stations."""

TIME_VALUE_M_S_PER_H = 75.0
"""Default value of an hour for missions of days."""


def hurry_of(
    duration_s: float,
    tank_m_s: float,
    *,
    time_buys_delta_v: bool,
    refuels: bool,
    usual_is_a_limit: bool,
) -> float:
    """Value of time relative to a mission of days (:attr:`adr_opt.Instance.hurry`).

    Parameters
    ----------
    duration_s : float
        How long the mission lasts [s].
    tank_m_s : float
        The most ΔV that a chaser has at once [m/s].
    time_buys_delta_v : bool
        Whether waiting saves ΔV: where planes drift, and where connections are given.
    refuels : bool
        Whether there are stations; a chaser that can refuel spends more than one tank.
    usual_is_a_limit : bool
        Whether the usual value of an hour is an upper limit.
    """
    if not time_buys_delta_v or duration_s == 0.0:
        return 1.0
    share = SPENT_BY_DRIFTING * (REFUELLED if refuels else 1.0)
    spent = share * tank_m_s * HOUR_S / duration_s / TIME_VALUE_M_S_PER_H
    return min(1.0, spent) if usual_is_a_limit else spent


def check_time_value(time_value_m_s_per_h: float) -> None:
    """Check that the value of an hour is finite and not negative.

    Raises
    ------
    InputError
        It is not.
    """
    if not (math.isfinite(time_value_m_s_per_h) and time_value_m_s_per_h >= 0.0):
        raise InputError(
            f"time_value_m_s_per_h = {time_value_m_s_per_h!r}: must be a finite number ≥ 0"
        )
