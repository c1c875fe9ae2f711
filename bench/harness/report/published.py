"""Results of the published study and its companion, for comparison."""

from __future__ import annotations

from dataclasses import dataclass

HARDWARE = "MacBook Pro M1 Max, 64 GB, Python 3.11 with Poliastro and Stable-Baselines3"

CALIBRATION = (
    "The published study states the number of targets, the altitudes, the station, the duration "
    "and the ΔV budget. It does not state how far the planes and phases of the targets are spread, "
    "how time is weighed against ΔV in phasing, or how its collision zones are drawn. Here planes "
    "lie within 96° ± 1° of inclination and 0° ± 1° of RAAN, an hour is worth 75 m/s, and zones "
    "are bands 10–25 km thick between 680 and 830 km, closed for 6–24 h. The first two are a "
    "calibration: values for which published greedy visits about as many targets as published when "
    "there are no zones. So compare methods with each other on this page, and with the published "
    "numbers only in order of magnitude. All fields are synthetic."
)


@dataclass(frozen=True)
class Published:
    """One planner of the study in one scenario.

    Attributes
    ----------
    planner : str
        As the study calls it.
    method : str
        Ours that stands for it.
    visits : (float, float)
        Least and greatest number of visits.
    mean : float or None
        Mean number of visits, where one is stated.
    seconds : (float, float) or None
        Planning time per mission [s].
    """

    planner: str
    method: str
    visits: tuple[float, float]
    mean: float | None = None
    seconds: tuple[float, float] | None = None


PUBLISHED = {
    "nominal": (
        Published("Greedy", "greedy", (15.0, 18.0), None, (1.0, 2.0)),
        Published("MCTS", "mcts", (25.0, 29.0), 27.1, (1000.0, 10000.0)),
        Published("Masked PPO", "ppo", (29.0, 32.0), 29.1, (1.0, 2.0)),
    ),
    "reduced-time": (
        Published("MCTS", "mcts", (11.9, 11.9), 11.9),
        Published("Masked PPO", "ppo", (12.6, 14.1)),
    ),
    "reduced-fuel": (
        Published("MCTS", "mcts", (15.0, 15.0), 15.0),
        Published("Masked PPO", "ppo", (3.2, 8.1)),
    ),
}
"""Results by suite. ``nominal`` is the study itself with means of its companion, the others are the
companion's."""
