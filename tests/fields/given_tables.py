"""Tables of given connections that are spoilt in what they say, not only in their bytes."""

from __future__ import annotations

import random
from io import BytesIO
from typing import Any

import numpy as np
from toy_roads import DEPARTURES, NAMES, as_rows, matrices

UNITS = (
    "s",
    "minutes",
    "min",
    "h",
    "days",
    "days since 2026-05-04",
    "m s-1",
    "km s-1",
    "km/h",
    "1",
    "",
    "fortnights",
    "kWh",
    "\x1b[2J",
    "m" * 500,
    "%",
    "s-1",
    "m/s/s",
    "ns",
    "µs",
)
FLOATS = (np.nan, np.inf, -np.inf, 1e308, -1e308, -0.0, 1e-320, -1.0, 1e12, 1e13, 0.0)


def parquet(rng: random.Random) -> bytes:
    """A Parquet file of the roads with other columns, types, values, units or rows."""
    import pyarrow as pa

    try:
        return _parquet(rng)
    except pa.ArrowException:  # what the library cannot write, nobody can be given
        return parquet(rng)


def _parquet(rng: random.Random) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = [(name, _array(values), dict[str, str]()) for name, values in as_rows().items()]
    for _ in range(rng.choice([1, 1, 2, 4])):
        if not columns:
            break
        at = rng.randrange(len(columns))
        name, array, stated = columns[at]
        how = rng.randrange(9)
        if how == 0:
            del columns[at]
        elif how == 1:
            columns.insert(rng.randrange(len(columns) + 1), columns[at])
        elif how == 2:
            columns[at] = name, _other_type(array, rng), stated
        elif how == 3:
            columns[at] = name, _other_values(array, rng), stated
        elif how == 4:
            columns[at] = name, array, {rng.choice(["units", "unit"]): rng.choice(UNITS)}
        elif how == 5:
            columns[at] = rng.choice([name.upper(), f"{name}.x", "", "a\nb", name[:-2]]), array, {}
        elif how == 6:
            rows = [rng.randrange(len(array)) for _ in range(rng.choice([0, 1, len(array)]))]
            columns = [
                (each, one.take(pa.array(rows, pa.int64())), said)
                for each, one, said in columns
                if len(one) == len(array)
            ]
            if not rows:
                break
        elif how == 7:
            other = columns[rng.randrange(len(columns))]
            columns[at] = name, other[1], stated
        else:
            columns[at] = name, pa.nulls(len(array)), stated
    fields = [
        pa.field(name, array.type, metadata=stated or None) for name, array, stated in columns
    ]
    sink = BytesIO()
    table = pa.Table.from_arrays([array for _, array, _ in columns], schema=pa.schema(fields))
    pq.write_table(table, sink)
    return sink.getvalue()


def _array(values: list[Any]) -> Any:
    import pyarrow as pa

    return pa.array(values)


def _other_type(array: Any, rng: random.Random) -> Any:
    """The column as another type, as far as Arrow knows how, or something of no use."""
    import pyarrow as pa

    size = len(array)
    kinds: list[Any] = [
        pa.list_(array.type),
        pa.large_string(),
        pa.int32(),
        pa.int64(),
        pa.float16(),
        pa.float32(),
        pa.duration("ms"),
        pa.timestamp("s"),
        pa.binary(),
        pa.bool_(),
        pa.decimal128(30, 6),
        pa.date32(),
        pa.time64("us"),
        pa.string_view(),
    ]
    kind = rng.choice([*kinds, "struct", "packed", "map"])
    try:
        if kind == "struct":
            return pa.StructArray.from_arrays([array], ["a"])
        if kind == "packed":
            return array.dictionary_encode()
        if kind == "map":
            return pa.array([[("a", 1)]] * size, pa.map_(pa.string(), pa.int64()))
        if pa.types.is_list(kind):
            return pa.array([[each] for each in array.to_pylist()], kind)
        if pa.types.is_boolean(kind):
            return pa.array([True] * size)
        return array.cast(kind, safe=False)
    except (pa.ArrowException, TypeError, ValueError):
        return pa.array(range(size)).cast(pa.float64())


def _other_values(array: Any, rng: random.Random) -> Any:
    import pyarrow as pa

    values = array.to_pylist()
    is_text = any(isinstance(each, str) for each in values)
    for _ in range(rng.choice([1, 1, 5]) if values else 0):
        names = (*NAMES, "moon", "", "\x1b[2J", "x" * 1000, None)
        values[rng.randrange(len(values))] = rng.choice(names if is_text else (*FLOATS, None))
    try:
        return pa.array(values)
    except (pa.ArrowException, TypeError, ValueError):
        return array


Variables = dict[str, tuple[list[str], Any, dict[str, Any]]]


def _roads() -> Variables:
    duration, cost = (np.array(values) for values in matrices())
    cube = ["departure", "origin", "destination"]
    return {
        "duration": (list(cube), duration, {"units": "s"}),
        "delta_v": (list(cube), cost, {"units": "m s-1"}),
        "departure": (["departure"], np.array(DEPARTURES), {"units": "s"}),
        "origin": (["origin"], np.array(NAMES), {}),
        "destination": (["destination"], np.array(NAMES), {}),
    }


def whole_netcdf() -> bytes:
    """A NetCDF file of the roads as they are."""
    import xarray

    return bytes(xarray.Dataset(_roads()).to_netcdf(engine="h5netcdf"))


def netcdf(rng: random.Random) -> bytes:
    """A NetCDF file of the roads with other variables, dimensions, types, values or units."""
    import xarray

    made = _roads()
    for _ in range(rng.choice([1, 1, 2, 4])):
        name = rng.choice(list(made))
        dimensions, values, stated = made[name]
        how = rng.choice([0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 5, 6, 6, 7])
        if how == 0:
            del made[name]
            if not made:
                break
        elif how == 1:
            stated["units"] = rng.choice([*UNITS, 3, np.float64(1.0), np.array([1, 2])])
        elif how == 2:
            kind = rng.choice(
                ["i4", "f4", "f2", "?", "U", "S", "i8", "u1", "c16", "m8[ns]", "M8[ns]"]
            )
            try:
                with np.errstate(all="ignore"):
                    values = values.astype(kind)
            except (ValueError, TypeError):
                values = np.zeros(values.shape)
            made[name] = dimensions, values, {} if kind[0] in "mM" else stated
        elif how == 3 and values.dtype.kind == "f" and values.size:
            values.flat[rng.randrange(values.size)] = rng.choice(FLOATS)
        elif how == 4 and values.dtype.kind == "U":
            values = values.astype("U1000")
            values[rng.randrange(len(values))] = rng.choice(["moon", "", NAMES[0], "\x1b[2J"])
            made[name] = dimensions, values, stated
        elif how == 5:
            made[name] = dimensions[::-1], values.T, stated
        elif how == 6:
            stated.update(
                rng.choice(
                    [
                        {"_FillValue": 0.0},
                        {"scale_factor": 60.0},
                        {"add_offset": np.nan},
                        {"missing_value": 1.5},
                        {"scale_factor": "x"},
                        {"dtype": "bool"},
                        {"_Unsigned": "true"},
                    ]
                )
            )
        else:
            made[rng.choice(["service", "x", name.upper()])] = made.pop(name)
    try:
        return bytes(xarray.Dataset(made).to_netcdf(engine="h5netcdf"))
    except Exception:  # what the library cannot write, nobody can be given
        return netcdf(rng)
