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

from .common.version import __version__

if TYPE_CHECKING:
    from .analysis.departures import plan_of
    from .common.errors import InputError, MissingExtra
    from .fly.refine import RefinedPlan, load_refined, refine
    from .fly.refine.loop import RefinedResult, solve_refined
    from .judge.check.verdict import check
    from .judge.check.violation import Violation
    from .judge.verify import Verdict, verify
    from .legs.matrices import Matrices
    from .legs.timetable import Timetable
    from .mission.mission import Mission
    from .mission.result import Result
    from .plan.certificate import Certificate, load_certificate
    from .plan.plan import Plan, load_plan
    from .problem.instance import Instance, load
    from .run.front import bound, solve
    from .sources.generator import generate

# Importing the package must cost next to nothing, so names are imported when first used.
_HOME = {
    "plan_of": "analysis.departures",
    "Certificate": "plan.certificate",
    "load_certificate": "plan.certificate",
    "Verdict": "judge.verify",
    "verify": "judge.verify",
    "Violation": "judge.check.violation",
    "check": "judge.check.verdict",
    "InputError": "common.errors",
    "MissingExtra": "common.errors",
    "bound": "run.front",
    "solve": "run.front",
    "generate": "sources.generator",
    "Instance": "problem.instance",
    "load": "problem.instance",
    "Mission": "mission.mission",
    "Plan": "plan.plan",
    "load_plan": "plan.plan",
    "RefinedPlan": "fly.refine",
    "load_refined": "fly.refine",
    "refine": "fly.refine",
    "RefinedResult": "fly.refine.loop",
    "solve_refined": "fly.refine.loop",
    "Result": "mission.result",
    "Matrices": "legs.matrices",
    "Timetable": "legs.timetable",
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
