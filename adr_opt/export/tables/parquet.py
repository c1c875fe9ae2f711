"""``.parquet``: all connections, a row for each (extra ``[io]``).

docs/model.md section 4: a chaser that is ready at a time may take any row of its pair that departs
then or later. Connections that another one dominates, up to the instance's resolution, are left
out.
"""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...common.errors import MissingExtra
from ...legs.service_limits import limits_of
from ...mission.mission import Mission
from .attributes import attributes

if TYPE_CHECKING:
    import pyarrow

COLUMNS = {
    "origin": ("body that the chaser leaves", None),
    "destination": ("body that it goes to", None),
    "departure_s": ("departure since the epoch, of a short transfer a crossing of the nodes", "s"),
    "delta_v_m_s": ("ΔV of the transfer", "m s-1"),
    "arrival_s": ("end of the approach since the epoch, before service", "s"),
    "phasing_revolutions": ("phasing revolutions k, −1 of a drift, 0 of what is given", "1"),
}
"""Meaning and unit of each column."""


def require() -> None:
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


def write(path: Path, mission: Mission) -> None:
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
