"""Analyses beyond planning: prices of orders, comparisons, replanning, rehearsals, trade-offs.

`price` times an order of bodies and says where it breaks; `compare` lays plans side by side;
`tradeoff` plans and proves over budgets and durations, and `frontier` says what it takes to be done
sooner; `design_study` plans, bounds and evaluates designs of campaigns, in euros; `replan` plans
the rest anew; `rehearse` flies a mission many times as it may happen, `robust` makes a plan that
is kept with a confidence, and `expected` one that collects most on average; `plan_of` makes a plan
of departures that the caller chose.
"""

from .comparison import Comparison, compare
from .departures import plan_of
from .design import CampaignPrices, DesignPoint, DesignStudy, design_study
from .orders import orders_of, read_orders
from .priced import PricedOrder, PricedRoute, price
from .rehearse.rehearsals import Rehearsals
from .rehearse.sampling import rehearse
from .replan.replanned import Replanned
from .replan.replanning import replan
from .robust.expected import ExpectedPlan, expected
from .robust.robust import robust
from .robust.robust_plan import RobustPlan
from .trade import Axis, Ending, Tradeoff, frontier, parse_axis, tradeoff

__all__ = [
    "Axis",
    "CampaignPrices",
    "Comparison",
    "DesignPoint",
    "DesignStudy",
    "Ending",
    "ExpectedPlan",
    "PricedOrder",
    "PricedRoute",
    "Rehearsals",
    "Replanned",
    "RobustPlan",
    "Tradeoff",
    "compare",
    "design_study",
    "expected",
    "frontier",
    "orders_of",
    "parse_axis",
    "plan_of",
    "price",
    "read_orders",
    "rehearse",
    "replan",
    "robust",
    "tradeoff",
]
