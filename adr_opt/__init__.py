"""adr-opt: plan active-debris-removal missions, and prove how good the plans are.

Conventions, everywhere: SI units (metres, seconds, metres per second, radians), with the unit in a
name where it can be mistaken; degrees only in instance files; times count from the epoch of the
instance; altitudes are radii minus 6378.137 km; bodies are numbered from 0, the stations first.

>>> import adr_opt
>>> instance = adr_opt.generate("tiny", seed=0)
>>> result = adr_opt.solve(instance, method="greedy-guarded")
>>> adr_opt.check(instance, result.plan)
()
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .version import __version__

if TYPE_CHECKING:
    from .analysis.departures import plan_of
    from .certificate import Certificate, load_certificate
    from .checking import Violation, check
    from .errors import InputError, MissingExtra
    from .front import bound, solve
    from .generator import generate
    from .instance import Instance, load
    from .matrices import Matrices
    from .mission import Mission
    from .plan import Plan, load_plan
    from .refining import RefinedPlan, load_refined, refine
    from .refining.loop import RefinedResult, solve_refined
    from .result import Result
    from .timetable import Timetable
    from .verifying import Verdict, verify

# Importing the package must cost next to nothing, so names are imported when first used.
_HOME = {
    "plan_of": "analysis.departures",
    "Certificate": "certificate",
    "load_certificate": "certificate",
    "Verdict": "verifying",
    "verify": "verifying",
    "Violation": "checking",
    "check": "checking",
    "InputError": "errors",
    "MissingExtra": "errors",
    "bound": "front",
    "solve": "front",
    "generate": "generator",
    "Instance": "instance",
    "load": "instance",
    "Mission": "mission",
    "Plan": "plan",
    "load_plan": "plan",
    "RefinedPlan": "refining",
    "load_refined": "refining",
    "refine": "refining",
    "RefinedResult": "refining.loop",
    "solve_refined": "refining.loop",
    "Result": "result",
    "Matrices": "matrices",
    "Timetable": "timetable",
}

__all__ = [
    "Certificate",
    "InputError",
    "Instance",
    "Matrices",
    "MissingExtra",
    "Mission",
    "Plan",
    "RefinedPlan",
    "RefinedResult",
    "Result",
    "Timetable",
    "Verdict",
    "Violation",
    "__version__",
    "bound",
    "check",
    "generate",
    "load",
    "load_certificate",
    "load_plan",
    "load_refined",
    "plan_of",
    "refine",
    "solve",
    "solve_refined",
    "verify",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOME[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
