"""Refinement of plans: burns that hold in true dynamics (docs/model.md section 10).

Truth is the numerically integrated motion in the field of the Earth with its zonal harmonics, and
impulses. Bodies begin at the osculating states of their mean elements and keep up with their mean
model (:mod:`.bodies`); each leg is led to its stand-off by successive convex steps (:mod:`.leg`).
:func:`adr_opt.fly.flight.fly_refined` judges the result with another integrator.
"""

from ...plan.refined_plan import RefinedPlan, load_refined  # isort: skip
from .all_legs import refine

__all__ = ["RefinedPlan", "load_refined", "refine"]
