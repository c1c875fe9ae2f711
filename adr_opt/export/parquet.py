"""``.parquet``: the whole exact timetable, a row for every departure event (extra ``[io]``).

MODEL section 3: between two departure events nothing depends on the time but the wait, so these
rows are all there is to know. A chaser that is ready at a time takes the first row of its pair
that departs then or later, whether or not there is a transfer at that event.
"""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..errors import MissingExtra
from ..kernels import timetable as kernels
from ..kernels.compile import kernel
from ..mission import Mission
from .attributes import attributes

if TYPE_CHECKING:
    import pyarrow

COLUMNS = {
    "origin": ("body that the chaser leaves", None),
    "event": ("number of the departure event of the pair, from 0 in order of time", "1"),
    "destination": ("body that it goes to", None),
    "departure_s": ("departure event since the epoch", "s"),
    "delta_v_m_s": ("ΔV of the transfer, +inf where there is none", "m s-1"),
    "arrival_s": ("end of the approach since the epoch, before service, +inf for none", "s"),
    "phasing_revolutions": ("phasing revolutions k, -1 where there is no transfer", "1"),
}
"""What each column is, and its unit."""


def require() -> None:
    """Raise :class:`MissingExtra` if pyarrow is not installed."""
    try:
        import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtra("writing a .parquet file", "pyarrow", "io") from None


@kernel
def _rows(
    table: kernels.Table,
    origin: int,
    numbers: npt.NDArray[np.int32],
    values: npt.NDArray[np.float64],
) -> int:
    """All events of one origin by destination and time; returns how many.

    ``numbers`` (rows, 3) gets event, destination and revolutions, ``values`` (rows, 3) departure,
    ΔV and arrival.
    """
    row = 0
    for j in range(table.first.shape[0]):
        for event in range(kernels.events(table, origin, j)):
            numbers[row, 0], numbers[row, 1] = event, j
            numbers[row, 2] = table.revolutions[origin, event, j]
            values[row, 0] = kernels.departure_at(table, origin, j, event)
            values[row, 1], values[row, 2] = kernels.entry_at(table, origin, j, event)
            row += 1
    return row


def schema(mission: Mission) -> pyarrow.Schema:
    """Columns with ``long_name`` and ``units``; settings, constants and bodies as metadata."""
    import pyarrow as pa

    instance = mission.instance
    body = pa.dictionary(pa.int32(), pa.string())
    types = (body, pa.int32(), body, pa.float64(), pa.float64(), pa.float64(), pa.int8())
    fields = []
    for (name, (meaning, unit)), kind in zip(COLUMNS.items(), types, strict=True):
        stated = {"long_name": meaning} | ({} if unit is None else {"units": unit})
        fields.append(pa.field(name, kind, nullable=False, metadata=stated))
    bodies = [
        {"name": name, "prize": float(prize), "service_s": float(service)}
        for name, prize, service in zip(
            mission.names, mission.rules.prize, mission.rules.service, strict=True
        )
    ]
    stated = attributes(instance) | {
        "title": f"every transfer at every departure event between the bodies of {instance.name}",
        "bodies_json": json.dumps(bodies, ensure_ascii=False),
    }
    return pa.schema(fields, metadata={key: str(value) for key, value in stated.items()})


def write(path: Path, mission: Mission) -> None:
    """Write the rows in order of origin, destination and event; a row group for each origin."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = mission.rules.table
    names = pa.array(mission.names, pa.string())
    columns = schema(mission)
    most = max(1, int(table.total.sum(axis=1).max()))
    numbers, values = np.empty((most, 3), dtype=np.int32), np.empty((most, 3))
    # Not by its name, which pyarrow insists on having in UTF-8.
    with (
        path.open("wb") as sink,
        pq.ParquetWriter(
            sink, columns, compression="zstd", use_dictionary=["origin", "destination"]
        ) as file,
    ):
        for origin in range(len(mission.names)):
            count = _rows(table, origin, numbers, values)
            event, destination, revolutions = numbers[:count].T
            departure, delta_v, arrival = values[:count].T
            here = np.full(count, origin, dtype=np.int32)
            arrays = [
                pa.DictionaryArray.from_arrays(pa.array(here), names),
                pa.array(event),
                pa.DictionaryArray.from_arrays(pa.array(destination), names),
                pa.array(departure),
                pa.array(delta_v),
                pa.array(arrival),
                pa.array(revolutions.astype(np.int8)),
            ]
            file.write_table(pa.Table.from_arrays(arrays, schema=columns), max(1, count))
