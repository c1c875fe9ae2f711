"""Instances of the format 1 as JSON content, for tests."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np

import adr_opt
from adr_opt import Instance, Plan
from adr_opt.files import to_text

Content = dict[str, Any]


def content_of(instance: Instance) -> Content:
    """An instance in format 1, restated from what that format was."""
    stated = instance.model_dump(mode="json")
    (station,), (chaser,) = stated["stations"], stated["chasers"]
    mission, transfer = stated["mission"], stated["transfer"]
    return {
        "format": "adr-opt-instance/1",
        "name": stated["name"],
        "epoch": stated["epoch"],
        "station": station,
        "targets": [
            {name: target[name] for name in ("name", "prize", "orbit")}
            for target in stated["targets"]
        ],
        "mission": {
            "duration_s": mission["duration_s"],
            "delta_v_m_s": chaser["tank"]["delta_v_m_s"],
            "service_revolutions": mission["service_revolutions"],
            "refuel_revolutions": mission["refuel_revolutions"],
        },
        "transfer": {
            **{name: transfer[name] for name in list(transfer)[:6]},
            "time_value_m_s_per_h": 75.0,
        },
        "keep_out_zones": stated["keep_out_zones"],
    }


def plan_content_of(instance: Instance, plan: Plan) -> Content:
    """A plan in format 1, for the file of its instance in format 1."""
    stated = plan.to_dict()
    (route,) = stated.pop("routes")
    digest = hashlib.sha256(to_text(content_of(instance)).encode()).hexdigest()
    return {
        **{
            name: value
            for name, value in stated.items()
            if not name.startswith("cost") and name not in ("model", "flown")
        },
        "format": "adr-opt-plan/1",
        "instance": {"name": instance.name, "sha256": digest},
        "legs": [
            {name: value for name, value in leg.items() if name != "kind"} for leg in route["legs"]
        ],
    }


def drawn(seed: int, former: Callable[[Instance], Content] = content_of) -> Content:
    """An instance of format 1 with prizes, limits and settings drawn by a seed."""
    rng = np.random.default_rng(seed)
    family, targets = [("tiny", 7), ("reduced-time", 14), ("cloud", 12)][seed % 3]
    content = former(adr_opt.generate(family, seed, targets=targets, zones=4 * (seed % 2)))
    for target in content["targets"]:
        target["prize"] = float(rng.integers(0, 5))
    mission, transfer = content["mission"], content["transfer"]
    mission["duration_s"] = 86400.0 * float(rng.integers(2, 5))
    mission["delta_v_m_s"] = float(rng.choice([1000.0, 2000.0, 4000.0]))
    mission["service_revolutions"] = float(rng.choice([0.0, 1.0, 2.5]))
    mission["refuel_revolutions"] = float(rng.choice([0.5, 1.0]))
    transfer["time_value_m_s_per_h"] = float(rng.choice([0.0, 20.0, 75.0, 300.0]))
    transfer["max_phasing_revolutions"] = int(rng.integers(3, 13))
    transfer["first_leg_fraction"] = float(rng.choice([0.5, 0.75]))
    return content
