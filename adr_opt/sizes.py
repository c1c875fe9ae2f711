"""How finely the transfers of a mission are laid out, by how long it lasts.

The number of connections of a mission grows with the square of its length where transfers drift:
any of its departures may lead to any later time. A grid of so many steps, whatever the length,
keeps that number, and what a step is worth stays in proportion: over two years nobody minds a day.
"""

from __future__ import annotations

from .kernels.constants import DAY_S
from .settings import TransferSettings

SHORT_S = 14.0 * DAY_S
"""Missions that last no longer do without long transfers: planes hardly move against each other."""

STEPS = 150
"""Steps of the grid of long transfers over a mission, about."""

STEP_ROUNDING_S = 0.5 * DAY_S
"""Steps are multiples of it, so that files are read by people."""

LEAST_STEP_S = DAY_S
"""What a drift of hours saves, a short transfer that waits does as well."""

SPACING = 0.4
"""Departures of short transfers lie as many steps apart: some between any two of the grid."""

FINEST_M_S = TransferSettings().delta_v_resolution_m_s
COARSEST_M_S, COARSEST_FROM_S = 5.0, 365.0 * DAY_S
"""The resolution grows with the length of the mission up to here."""


def transfers_for(
    duration_s: float,
    *,
    departure_spacing_s: float | None = None,
    drift_step_s: float | None = None,
    max_drift_s: float | None = None,
    delta_v_resolution_m_s: float | None = None,
) -> TransferSettings:
    """The transfer settings for a mission under J2 that lasts so long.

    ======================  =====================  ==============================================
    setting                 up to 14 days          longer
    ======================  =====================  ==============================================
    drift step              (of no use)            a 150th of the mission, in half days, at least
                                                   a day
    longest drift           0: none                the mission
    departure spacing       0: every crossing      two fifths of the drift step
    resolution              0.1 m/s                5 m/s times the years of the mission, at most
                                                   5 m/s
    ======================  =====================  ==============================================

    Parameters
    ----------
    duration_s : float
        Of the mission [s].
    departure_spacing_s, drift_step_s, max_drift_s, delta_v_resolution_m_s : float, optional
        Instead of these; the spacing follows a step that is given [s], [s], [s], [m/s].

    Raises
    ------
    InputError
        One that is given is out of range.
    """
    chosen: dict[str, float] = {}
    if duration_s > SHORT_S:
        step = max(LEAST_STEP_S, STEP_ROUNDING_S * round(duration_s / STEPS / STEP_ROUNDING_S))
        share = min(1.0, duration_s / COARSEST_FROM_S)
        chosen = {
            "drift_step_s": step,
            "max_drift_s": float(duration_s),
            "departure_spacing_s": round(SPACING * (drift_step_s or step), 3),
            "delta_v_resolution_m_s": max(FINEST_M_S, round(COARSEST_M_S * share, 1)),
        }
    given = {
        "departure_spacing_s": departure_spacing_s,
        "drift_step_s": drift_step_s,
        "max_drift_s": max_drift_s,
        "delta_v_resolution_m_s": delta_v_resolution_m_s,
    }
    chosen |= {name: value for name, value in given.items() if value is not None}
    return TransferSettings().replace(**chosen)


def told(transfer: TransferSettings) -> str:
    """How transfers are laid out, for people."""
    spacing = transfer.departure_spacing_s
    departures = "every departure"
    if spacing > 0.0:
        departures = f"departures of a pair at least {_days(spacing)} apart"
    drifts = "no long transfers"
    if transfer.max_drift_s > 0.0:
        drifts = (
            f"long transfers of up to {_days(transfer.max_drift_s)} in steps of "
            f"{_days(transfer.drift_step_s)}"
        )
    return f"{drifts}, {departures}, ΔV to {transfer.delta_v_resolution_m_s:g} m/s"


def _days(seconds: float) -> str:
    days = round(seconds / DAY_S, 3)
    return f"{days:g} day{'' if days == 1.0 else 's'}"
