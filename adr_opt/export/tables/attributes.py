"""Attributes of labelled files, which make them readable without the instance."""

from __future__ import annotations

import json
from typing import Any

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.version import __version__
from ...problem.instance import Instance


def attributes(instance: Instance) -> dict[str, Any]:
    """Constants of the model and settings of an instance, flat, with units in the names."""
    stated = instance.model_dump(mode="json")
    given = stated["transfer"].pop("given", None) or {}
    return {
        "title": f"ΔV and duration of transfers between the bodies of {instance.name}",
        "source": f"adr-opt {__version__}",
        "instance": instance.name,
        "sha256": instance.sha256,
        "epoch": stated["epoch"],
        **{f"frame_{key}": value for key, value in stated.get("frame", {}).items()},
        "station": ", ".join(instance.station_names),
        "mu_m3_s2": MU_M3_S2,
        "earth_radius_m": EARTH_RADIUS_M,
        **{f"transfer_{key}": value for key, value in stated["transfer"].items()},
        **{f"given_{key}": value for key, value in given.items()},
        **{f"mission_{key}": value for key, value in stated["mission"].items()},
        "mission_delta_v_m_s": instance.chaser.tank.delta_v_m_s,
        "time_value_m_s_per_h": instance.time_value_m_s_per_h,
        "keep_out_zones_json": json.dumps(stated["keep_out_zones"]),
    }
