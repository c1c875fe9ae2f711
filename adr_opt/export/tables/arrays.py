"""Labelled arrays: ``.npz`` (NumPy), ``.nc`` (NetCDF 4 by xarray), ``.parquet`` (all connections).

The last two need the extra ``[io]``. In a Parquet file each connection is a row (docs/model.md
section 4): a chaser that is ready at a time may take any row of its pair that departs then or
later. Connections that another one dominates, up to the instance's resolution, are left out.
"""

from __future__ import annotations

import json
import math
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...common.constants import EARTH_RADIUS_M, MU_M3_S2
from ...common.errors import MissingExtra
from ...common.version import __version__
from ...legs.matrices import Matrices
from ...legs.service_limits import limits_of
from ...mission.mission import Mission
from ...problem.instance import Instance

if TYPE_CHECKING:
    import pyarrow
    import xarray


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
        "transfer_approach": instance.transfer.approach,
        **{f"transfer_{key}": value for key, value in stated["transfer"].items()},
        **{f"given_{key}": value for key, value in given.items()},
        **{f"mission_{key}": value for key, value in stated["mission"].items()},
        "mission_delta_v_m_s": instance.chaser.usable.delta_v_m_s,
        "time_value_m_s_per_h": instance.time_value_m_s_per_h,
        "keep_out_zones_json": json.dumps(stated["keep_out_zones"]),
    }


def write_npz(path: Path, mission: Mission, matrices: Matrices) -> None:
    """Write the arrays.

    ``departures_s`` (departures,) [s], ``names`` (bodies,) with the stations first,
    ``delta_v_m_s`` and ``duration_s`` (departures, bodies, bodies) [m/s], [s], ``service_s``
    (bodies,) [s], and the scalars ``instance`` (its name), ``sha256`` and ``transfers`` (which
    ones, in words). +inf stands where there is no transfer; durations are from ready to arrival,
    without service.
    """
    # A file and not a name: NumPy would append .npz to a name that ends in .NPZ.
    with path.open("wb") as file:
        np.savez_compressed(
            file,
            departures_s=matrices.departures,
            names=np.array(matrices.names, dtype=np.str_),
            delta_v_m_s=matrices.delta_v,
            duration_s=matrices.duration,
            service_s=mission.rules.service,
            instance=np.array(mission.instance.name, dtype=np.str_),
            sha256=np.array(mission.instance.sha256, dtype=np.str_),
            transfers=np.array(matrices.choice, dtype=np.str_),
        )


def _windows(instance: Instance) -> dict[str, tuple[str, Any, dict[str, str]]]:
    """Rows of targets' windows, and the part of each service that must lie within one."""
    every = [(each, instance.intervals_of(each)) for each in instance.targets]
    limited = [(each, rows) for each, rows in every if instance.is_limited(each) and len(rows)]
    if not limited:
        return {}
    times = np.concatenate([rows for _, rows in limited])
    captures = [
        math.nan if target.capture_s is None else target.capture_s
        for target, rows in limited
        for _ in rows
    ]
    names = [target.name for target, rows in limited for _ in rows]
    return {
        "window_target": ("window", names, {"long_name": "target of the window"}),
        "window_opens": ("window", times[:, 0], {"long_name": "it opens", "units": "s"}),
        "window_closes": (
            "window",
            times[:, 1],
            {"long_name": "it closes, +inf for never", "units": "s"},
        ),
        "window_capture": (
            "window",
            captures,
            {"long_name": "part of a service within it, NaN for all of it", "units": "s"},
        ),
    }


CUBE = ("departure", "origin", "destination")


def require_netcdf() -> None:
    """Raise :class:`MissingExtra` if xarray or its backend is not installed."""
    for package in ("xarray", "h5netcdf", "h5py"):
        try:
            import_module(package)
        except ImportError:
            raise MissingExtra("writing a .nc file", package, "io") from None


def dataset(mission: Mission, matrices: Matrices) -> xarray.Dataset:
    """Label the matrices with names, units and constants.

    The dimensions are ``departure`` (ready times), ``origin`` and ``destination`` (names).
    Windows of targets are rows along ``window``. Settings and constants are attributes, with their
    units in their names.
    """
    import xarray

    names, instance = list(matrices.names), mission.instance
    return xarray.Dataset(
        {
            "delta_v": (
                CUBE,
                matrices.delta_v,
                {"long_name": "ΔV of the transfer, +inf where there is none", "units": "m s-1"},
            ),
            "duration": (
                CUBE,
                matrices.duration,
                {
                    "long_name": "time from ready to arrival, without service, "
                    "+inf where there is no transfer",
                    "units": "s",
                },
            ),
            "service": (
                "destination",
                mission.rules.service,
                {"long_name": "service after arrival, at the station refuelling", "units": "s"},
            ),
            **_windows(instance),
        },
        coords={
            "departure": (
                "departure",
                matrices.departures,
                {"long_name": "time since the epoch at which the chaser is ready", "units": "s"},
            ),
            "origin": ("origin", names, {"long_name": "body that the chaser leaves"}),
            "destination": ("destination", names, {"long_name": "body that it goes to"}),
        },
        attrs=attributes(mission.instance) | {"transfers": matrices.choice},
    )


def write_netcdf(path: Path, mission: Mission, matrices: Matrices) -> None:
    """Write the dataset."""
    # No fill value: xarray would read it back as "missing", and nothing here is missing.
    lossless = {"zlib": True, "complevel": 4, "_FillValue": None}
    # In memory first: on a full disk the HDF5 library leaves files open and crashes at exit.
    content = dataset(mission, matrices).to_netcdf(
        engine="h5netcdf",
        encoding={
            "delta_v": lossless,
            "duration": lossless,
            "service": {"_FillValue": None},
            "departure": {"_FillValue": None},
        },
    )
    path.write_bytes(content)


COLUMNS = {
    "origin": ("body that the chaser leaves", None),
    "destination": ("body that it goes to", None),
    "departure_s": ("departure since the epoch, of a short transfer a crossing of the nodes", "s"),
    "delta_v_m_s": ("ΔV of the transfer", "m s-1"),
    "arrival_s": ("end of the approach since the epoch, before service", "s"),
    "phasing_revolutions": ("phasing revolutions k, −1 of a drift, 0 of what is given", "1"),
}
"""Meaning and unit of each column."""


def require_parquet() -> None:
    """Raise :class:`MissingExtra` if pyarrow is not installed."""
    try:
        import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtra("writing a .parquet file", "pyarrow", "io") from None


def schema(mission: Mission) -> pyarrow.Schema:
    """Columns with ``long_name`` and ``units``; settings, constants and bodies as metadata."""
    import pyarrow as pa

    instance = mission.instance
    body = pa.dictionary(pa.int32(), pa.string())
    types = (body, body, pa.float64(), pa.float64(), pa.float64(), pa.int8())
    fields = []
    for (name, (meaning, unit)), kind in zip(COLUMNS.items(), types, strict=True):
        stated = {"long_name": meaning} | ({} if unit is None else {"units": unit})
        fields.append(pa.field(name, kind, nullable=False, metadata=stated))
    prizes = [0.0] * instance.first_target + [target.greatest_prize for target in instance.targets]
    bodies = [
        {"name": name, "prize": float(prize), "service_s": float(service)}
        for name, prize, service in zip(
            mission.names, prizes, limits_of(instance).service, strict=True
        )
    ]
    stated = attributes(instance) | {
        "title": f"every connection between the bodies of {instance.name}",
        "bodies_json": json.dumps(bodies, ensure_ascii=False),
    }
    return pa.schema(fields, metadata={key: str(value) for key, value in stated.items()})


def write_parquet(path: Path, mission: Mission) -> None:
    """Write the rows by origin, destination and departure; a row group for each origin."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = pa.array(mission.names, pa.string())
    bodies = range(len(mission.names))
    resolution = mission.instance.transfer.delta_v_resolution_m_s
    columns = schema(mission)
    # Not by its name, which pyarrow insists on having in UTF-8.
    with (
        path.open("wb") as sink,
        pq.ParquetWriter(
            sink, columns, compression="zstd", use_dictionary=["origin", "destination"]
        ) as file,
    ):
        for i in bodies:
            found = [mission.connecting.of_pair(i, j, resolution) for j in bodies]
            there = np.repeat(bodies, [each.departure.size for each in found]).astype(np.int32)
            here = np.full(there.size, i, dtype=np.int32)
            arrays = [
                pa.DictionaryArray.from_arrays(pa.array(here), names),
                pa.DictionaryArray.from_arrays(pa.array(there), names),
                *(
                    pa.array(np.concatenate([getattr(each, column) for each in found]))
                    for column in ("departure", "delta_v", "arrival", "revolutions")
                ),
            ]
            file.write_table(pa.Table.from_arrays(arrays, schema=columns), max(1, there.size))
