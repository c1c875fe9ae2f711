"""Files of given connections: ``.parquet`` with a row for each, ``.nc`` with matrices (``[io]``).

What `matrix` writes with these suffixes can be given back.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import InputError, MissingExtra
from .files import write_whole
from .given import COLUMNS, Given, of_matrices, of_rows
from .settings import GivenFile

UNITS = {"departure_s": "s", "arrival_s": "s", "delta_v_m_s": "m s-1"}


def read_given(path: str | os.PathLike[str], names: Sequence[str]) -> Given:
    """Read connections.

    Parameters
    ----------
    path : path
        The suffix says which format it is.
    names : sequence of str
        The bodies that may occur.

    Raises
    ------
    InputError
        No such file, one of another format, or connections that cannot be planned on.
    MissingExtra
        The package that reads the format is not installed.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file; put the given connections there")
    read = _read_parquet if path.suffix.lower() == ".parquet" else _read_netcdf
    try:
        return read(path, names)
    except MissingExtra:
        raise
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def read_named(
    instance_path: str | os.PathLike[str], reference: GivenFile, names: Sequence[str]
) -> Given:
    """The connections that an instance file names; they lie beside it.

    Raises
    ------
    InputError, MissingExtra
        As :func:`read_given`; or they are others than the instance says.
    """
    path = Path(instance_path).parent / reference.file
    given = read_given(path, names)
    if reference.sha256 not in (None, given.sha256):
        raise InputError(
            f"{path}: not the connections that {instance_path} names in transfer.given: their "
            f"sha256 is {given.sha256}; put the right file there, or leave the field sha256 out"
        )
    return given


def write_given(path: str | os.PathLike[str], given: Given) -> None:
    """Write connections as ``.parquet``, whole or not at all.

    Raises
    ------
    InputError
        Another suffix, or the file cannot be written.
    MissingExtra
        pyarrow is not installed.
    """
    if Path(path).suffix.lower() != ".parquet":
        raise InputError(f"{path}: connections are written as .parquet; name such a file")
    pa = _need("pyarrow", "writing given connections")
    pq = _need("pyarrow.parquet", "writing given connections")
    names = pa.array(given.names, pa.string())
    arrays = [
        *(
            pa.DictionaryArray.from_arrays(pa.array(numbers), names)
            for numbers in (given.origin, given.destination)
        ),
        *(pa.array(values) for values in (given.departure, given.arrival, given.cost)),
    ]
    fields = [
        pa.field(name, array.type, nullable=False, metadata={"units": UNITS.get(name, "1")})
        for name, array in zip(COLUMNS, arrays, strict=True)
    ]
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields))

    def write(temporary: Path) -> None:
        # Not by its name, which pyarrow insists on having in UTF-8.
        with temporary.open("wb") as sink:
            pq.write_table(table, sink, compression="zstd", use_dictionary=list(COLUMNS[:2]))

    write_whole(path, write)


def _need(module: str, what: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtra(what, module.partition(".")[0], "io") from None


def _read_parquet(path: Path, names: Sequence[str]) -> Given:
    pq = _need("pyarrow.parquet", "reading given connections")
    try:
        with path.open("rb") as source:
            file = pq.ParquetFile(source)
            there = [name for name in COLUMNS if name in file.schema_arrow.names]
            table = file.read(columns=there)
    except (OSError, ValueError, import_module("pyarrow").ArrowException) as error:
        raise InputError(f"not a Parquet file that can be read ({_first_line(error)})") from None
    columns = {}
    for name in there:
        column = table.column(name)
        if column.null_count:
            raise InputError(f"column {name} has rows without a value; leave such rows out")
        is_body = name in COLUMNS[:2]
        columns[name] = _bodies(column, name, names) if is_body else column.to_numpy()
    return of_rows(columns, names)


def _bodies(column: Any, name: str, names: Sequence[str]) -> npt.NDArray[Any]:
    """A column of names as numbers of bodies; each name is looked up once."""
    known, parts = {name: number for number, name in enumerate(names)}, []
    for chunk in column.dictionary_encode().chunks:
        told = chunk.dictionary.to_pylist()
        strange = [one for one in told if one not in known]
        if strange:
            raise InputError(f"column {name}: {strange[0]!r} is not a body of the instance")
        numbers = np.array([known[one] for one in told], dtype=np.int32)
        parts.append(numbers[chunk.indices.to_numpy()])
    return np.concatenate([np.empty(0, dtype=np.int32), *parts])


def _read_netcdf(path: Path, names: Sequence[str]) -> Given:
    """Matrices (departure, origin, destination) of ``duration`` and ``delta_v``, with names."""
    _need("h5netcdf", "reading given connections")
    xarray = _need("xarray", "reading given connections")
    try:
        with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as file:
            found = {name: np.asarray(file[name].values) for name in _CUBE}
            shaped = [
                np.asarray(file[name].transpose("departure", "origin", "destination").values)
                for name in ("duration", "delta_v")
            ]
    except (OSError, KeyError, ValueError, RuntimeError) as error:
        raise InputError(
            "not a NetCDF 4 file with duration and delta_v over departure, origin and destination "
            f"({_first_line(error)})"
        ) from None
    known = {name: number for number, name in enumerate(names)}
    ends = []
    for axis in _CUBE[1:]:
        told = [str(name) for name in found[axis].tolist()]
        strange = [name for name in told if name not in known]
        if strange:
            raise InputError(f"{axis} {strange[0]!r} is not a body of the instance")
        if len(set(told)) < len(told):
            raise InputError(f"{axis} names a body twice; give each once")
        ends.append([known[name] for name in told])
    size = len(names)
    cubes = []
    for values in shaped:
        cube = np.full((found["departure"].size, size, size), np.inf)
        cube[np.ix_(range(cube.shape[0]), *ends)] = values
        cubes.append(cube)
    return of_matrices(found["departure"], cubes[0], cubes[1], names)


_CUBE = ("departure", "origin", "destination")


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
