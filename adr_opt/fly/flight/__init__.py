"""Flight of a plan: its burns propagated in the dynamics of its instance.

The second opinion on the physics. No state here comes from :mod:`adr_opt.kernels`: elements are
read from the instance, and boinor (extra ``[astro]``) turns them into states and propagates them.

Two questions are asked of each leg. Does it arrive in the model's world, where every body moves
on a circle? It must, to a millimetre, and under J2 to a metre. And where an orbit of the leg is
eccentric: what does it take to arrive in truth? That is the size of the approximation of
docs/model.md section 1, and decides whether each tank holds. The second alone is what
:func:`fly_mean` asks, in mean motion and without boinor.

A refined plan (:mod:`adr_opt.fly.refine`) is flown by :func:`fly_refined`: in true dynamics, by
another integrator than the one it was made with.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .flights import Flight, LegFlight, TankFlight
from .fly import fly
from .mean_flight import MeanFlight, fly_mean

__all__ = [
    "Flight",
    "LegFlight",
    "MeanFlight",
    "RefinedFlight",
    "RefinedLegFlight",
    "TankFlight",
    "fly",
    "fly_mean",
    "fly_refined",
]

if TYPE_CHECKING:
    from .refined import fly_refined
    from .refined_result import RefinedFlight, RefinedLegFlight

# SciPy's integrators take longer to import than `check` runs: only who asks for them waits.
_HOME = {
    "RefinedFlight": "refined_result",
    "RefinedLegFlight": "refined_result",
    "fly_refined": "refined",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)
