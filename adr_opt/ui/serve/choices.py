"""Choices offered by the page."""

from __future__ import annotations

from typing import Any

from ...run.methods import BOUNDS, PLANNERS, names
from ...run.run_options import DEFAULT_METHOD, DEFAULT_TIME_LIMIT_S
from .jobs.verbs import VERBS
from .objects.import_options import OPTIONS


def choices() -> dict[str, Any]:
    """Methods, bounds, options of an import, and verbs with theirs, as JSON data."""
    return {
        "methods": list(names(PLANNERS)),
        "bounds": list(names(BOUNDS)),
        "method": DEFAULT_METHOD,
        "time_limit_s": DEFAULT_TIME_LIMIT_S,
        "import": [option.to_dict() for option in OPTIONS],
        "verbs": {name: verb.to_dict() for name, verb in VERBS.items()},
    }
