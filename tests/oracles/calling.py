"""Methods, called with their options by name."""

from __future__ import annotations

import inspect
from typing import Any

from adr_opt.common.options import read
from adr_opt.common.progress import silent
from adr_opt.common.stop import MaxRuntime
from adr_opt.mission.mission import Mission
from adr_opt.mission.result import Result
from adr_opt.plan.plan import Plan
from adr_opt.run.methods import Planner, options_of


def call(method: Planner, mission: Mission, **arguments: Any) -> Result:
    """Run a method; what is no parameter of it is an option, and the progress may be left out."""
    known = inspect.signature(method).parameters
    options = {name: value for name, value in arguments.items() if name not in known}
    more = {name: value for name, value in arguments.items() if name in known}
    if options:
        more["options"] = read(options_of(method), options)
    begins = more.get("start")
    of_one = "problem" in known and isinstance(mission, Mission)
    if of_one and begins is not None and not isinstance(begins, Plan):
        more["start"] = (begins,)
    return method(mission, **{"seed": 0, "progress": silent, **more})


def prove(method: Planner, mission: Mission, **options: Any) -> Result:
    """Run a method to its end."""
    return call(method, mission, **{"stop": MaxRuntime(60.0), **options})
