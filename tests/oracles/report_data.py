"""What the script of a report draws from, and where it has a body."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np
import numpy.typing as npt


def data(text: str) -> dict[str, Any]:
    """What the script of a page draws from."""
    found = re.search(r'(?s)<script type="application/json" id="mission">(.*?)</script>', text)
    assert found is not None
    content: dict[str, Any] = json.loads(found[1])
    return content


def body_at(body: dict[str, Any], time_s: float) -> npt.NDArray[np.float64]:
    """Where the page has a body."""
    radius, inclination, node, node_rate, latitude, latitude_rate = body["row"]
    o, u = node + node_rate * time_s, latitude + latitude_rate * time_s
    ascending = np.array([math.cos(o), math.sin(o), 0.0])
    ahead = np.array([-math.sin(o), math.cos(o), 0.0]) * math.cos(inclination)
    ahead[2] = math.sin(inclination)
    return radius * (math.cos(u) * ascending + math.sin(u) * ahead)
