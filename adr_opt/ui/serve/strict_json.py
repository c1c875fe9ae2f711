"""JSON as browsers read it: numbers that are not finite are null."""

from __future__ import annotations

import json
import math
from typing import Any


def to_json(content: Any) -> str:
    """JSON data as ASCII text, with null for each number that is not finite.

    Parameters
    ----------
    content : JSON data
    """
    try:
        return json.dumps(content, allow_nan=False)
    except ValueError:
        return json.dumps(_finite(content), allow_nan=False)


def _finite(content: Any) -> Any:
    if isinstance(content, float):
        return content if math.isfinite(content) else None
    if isinstance(content, dict):
        return {name: _finite(value) for name, value in content.items()}
    if isinstance(content, (list, tuple)):
        return [_finite(value) for value in content]
    return content
