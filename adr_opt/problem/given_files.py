"""Files of given connections: rows in ``.parquet``, matrices in ``.nc`` (``[io]``).

What `matrix` writes with these suffixes can be given back.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..common.errors import InputError, MissingExtra
from ..common.files import write_whole
from ..common.memory import available_bytes
from .given import COLUMNS, Given, of_matrices, of_rows, refuse_exceptions
from .given_units import cost_factor, time_factor
from .settings import GivenFile

UNITS = {"departure_s": "s", "arrival_s": "s", "delta_v_m_s": "m s-1"}
BODIES = COLUMNS[:2]
COST = COLUMNS[4]

BYTES_EACH = 24
"""Memory for each number of a file, while it is read, stored and sorted [bytes]."""

LONGEST_SHOWN = 150
"""Length beyond which texts from files are cut in error messages."""


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
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of libraries, about what is judged here
            return read(path, names)
    except MissingExtra:
        raise
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def read_named(
    instance_path: str | os.PathLike[str], reference: GivenFile, names: Sequence[str]
) -> Given:
    """Read the connections that an instance file names, from a file beside it.

    Raises
    ------
    InputError, MissingExtra
        As :func:`read_given`; or they are others than the instance says.
    """
    assert reference.file is not None
    path = Path(instance_path).parent / reference.file
    given = read_given(path, names)
    if reference.sha256 not in (None, given.sha256):
        raise InputError(
            f"{path}: not the connections that {instance_path} names in transfer.given: their "
            f"sha256 is {given.sha256}; put the right file there, or leave the field sha256 out"
        )
    return given


def write_given(path: str | os.PathLike[str], given: Given) -> None:
    """Write connections as ``.parquet``, completely or not at all.

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
            pq.write_table(table, sink, compression="zstd", use_dictionary=list(BODIES))

    write_whole(path, write)


def _need(module: str, what: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise MissingExtra(what, module.partition(".")[0], "io") from None


def _read_parquet(path: Path, names: Sequence[str]) -> Given:
    pa = _need("pyarrow", "reading given connections")
    pq = _need("pyarrow.parquet", "reading given connections")
    try:
        with path.open("rb") as source:
            file = pq.ParquetFile(source)
            fields = file.schema_arrow
            refuse_exceptions(fields.names)
            there = [name for name in COLUMNS if name in fields.names]
            doubled = [name for name in there if fields.names.count(name) > 1]
            kinds = {name: fields.field(name).type for name in there if name not in doubled}
            if not doubled:
                for name, kind in kinds.items():
                    _refuse_kind(name, kind)
                _refuse_size(file.metadata.num_rows * len(COLUMNS) + _stored(file.metadata, there))
                # Names once each: a column of a few kilobytes may repeat one without end.
                file = pq.ParquetFile(
                    source,
                    read_dictionary=[name for name in BODIES if name in there],
                    metadata=file.metadata,
                )
                table = file.read(columns=there)
    except InputError:
        raise
    except Exception as error:  # of a damaged file pyarrow raises whatever it runs into
        raise InputError(f"not a Parquet file that can be read ({_first_line(error)})") from None
    if doubled:
        raise InputError(f"column {doubled[0]} occurs twice; give each once")
    columns = {}
    for name in there:
        column, field = table.column(name), fields.field(name)
        # Arrival and cost may be missing together, which is judged where all rows are.
        if column.null_count and name not in COLUMNS[3:]:
            raise InputError(f"column {name} has rows without a value; leave such rows out")
        if name in BODIES:
            columns[name] = _bodies(column, name, names)
            continue
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        values = column.to_numpy()
        if values.dtype.kind != "m":  # a duration says itself what it counts in
            values = values.astype(np.float64) * _factor(name, field.metadata or {})
        columns[name] = values
    return of_rows(columns, names)


def _refuse_kind(name: str, kind: Any) -> None:
    """Raise :class:`InputError` for a column that holds neither names nor numbers."""
    types = import_module("pyarrow").types
    inner = kind.value_type if types.is_dictionary(kind) else kind
    if name in BODIES:
        wanted = "names of bodies"
        fits = [types.is_string(inner), types.is_large_string(inner), types.is_string_view(inner)]
    else:
        wanted = "numbers" if name == COST else "numbers or durations"
        fits = [
            types.is_integer(inner),
            types.is_floating(inner),
            types.is_decimal(inner),
            types.is_duration(inner) and name != COST,
        ]
    if not any(fits) and not types.is_null(inner):  # of no rows many programs know no type
        raise InputError(f"column {name} holds {_cut(str(kind))}; it must hold {wanted}")


def _stored(metadata: Any, columns: Sequence[str]) -> float:
    """What columns of a Parquet file take before they are decoded, in numbers of eight bytes."""
    groups = (metadata.row_group(at) for at in range(metadata.num_row_groups))
    chunks = (group.column(at) for group in groups for at in range(group.num_columns))
    sizes = (one.total_uncompressed_size for one in chunks if one.path_in_schema in columns)
    return math.fsum(sizes) / 8


def _refuse_size(values: float) -> None:
    """Raise :class:`InputError` before a small file takes more memory than is available."""
    if values * BYTES_EACH > available_bytes():
        raise InputError(
            f"holds {values:.3g} numbers, too many for the memory; leave out those not needed"
        )


def _factor(name: str, stated: Mapping[Any, Any]) -> float:
    """Conversion factor of a number by its stated unit."""
    said = [stated[key] for key in ("units", b"units", "unit", b"unit") if key in stated]
    unit = said[0] if said else None
    is_cost = name in (COST, "delta_v")
    return cost_factor(unit, name) if is_cost else time_factor(unit, name)


def _bodies(column: Any, name: str, names: Sequence[str]) -> npt.NDArray[Any]:
    """A column of names as body numbers; each name is looked up once."""
    known, parts = {name: number for number, name in enumerate(names)}, []
    try:
        chunks = column.dictionary_encode().chunks
        told_of = [chunk.dictionary.to_pylist() for chunk in chunks]
    except Exception as error:  # bytes that are no text, for one
        raise InputError(f"column {name} cannot be read ({_first_line(error)})") from None
    for chunk, told in zip(chunks, told_of, strict=True):
        strange = [one for one in told if one not in known]
        if strange:
            raise InputError(f"column {name}: {_cut(strange[0])!r} is not a body of the instance")
        numbers = np.array([known[one] for one in told], dtype=np.int32)
        parts.append(numbers[chunk.indices.to_numpy()])
    return np.concatenate([np.empty(0, dtype=np.int32), *parts])


def _read_netcdf(path: Path, names: Sequence[str]) -> Given:
    """Read matrices (departure, origin, destination) ``duration`` and ``delta_v``, with names."""
    h5py = _need("h5py", "reading given connections")
    _need("h5netcdf", "reading given connections")
    xarray = _need("xarray", "reading given connections")
    try:
        with h5py.File(path, "r") as file:
            # h5netcdf asks this first, and fails a second time, aloud, where that fails.
            file.attrs.get("_nc3_strict")
            # Before xarray reads axes: a shape that nothing is stored of takes no bytes in a file.
            _refuse_shapes({name: file[name] for name in (*_CUBE, *_VALUES) if name in file}, names)
            others = [name for name in file if name not in (*_CUBE, *_VALUES)]
        with xarray.open_dataset(
            path, engine="h5netcdf", decode_times=False, drop_variables=others
        ) as file:
            missing = [name for name in (*_CUBE, *_VALUES) if name not in file.variables]
            if missing:
                raise KeyError(f"no variable {missing[0]}")
            # Once more: xarray takes variables without named dimensions for others than they are.
            _refuse_shapes({name: file[name] for name in (*_CUBE, *_VALUES)}, names)
            ends = [_ends(np.asarray(file[axis].values), axis, names) for axis in _CUBE[1:]]
            departures = _scaled(file["departure"])
            shaped = [_scaled(file[name].transpose(*_CUBE)) for name in _VALUES]
    except InputError:
        raise
    except Exception as error:  # of a damaged file the libraries raise whatever they run into
        raise InputError(
            "not a NetCDF 4 file with duration and delta_v over departure, origin and destination "
            f"({_first_line(error)})"
        ) from None
    size = len(names)
    cubes = []
    for values in shaped:
        cube = np.full((departures.size, size, size), np.inf)
        cube[np.ix_(range(cube.shape[0]), *ends)] = values
        cubes.append(cube)
    return of_matrices(departures, cubes[0], cubes[1], names)


def _refuse_shapes(variables: Mapping[str, Any], names: Sequence[str]) -> None:
    """Raise :class:`InputError` before variables of a NetCDF file take too much memory."""
    sizes = {name: int(getattr(each, "size", 0)) for name, each in variables.items()}
    for axis in _CUBE[1:]:
        if sizes.get(axis, 0) > len(names):
            raise InputError(
                f"{axis} has {sizes[axis]} names, and the instance {len(names)} bodies; leave out "
                "the others"
            )
    stored = sum(
        (each.size + math.prod(each.chunks or ())) * each.dtype.itemsize
        for name, each in variables.items()
        if sizes[name]
    )
    _refuse_size(stored / 8 + len(_VALUES) * sizes.get(_CUBE[0], 0) * (1 + len(names) ** 2))


def _ends(found: npt.NDArray[Any], axis: str, names: Sequence[str]) -> list[int]:
    """Names along an axis as body numbers."""
    known = {name: number for number, name in enumerate(names)}
    told = [
        name.decode(errors="replace") if isinstance(name, bytes) else str(name)
        for name in found.tolist()
    ]
    strange = [name for name in told if name not in known]
    if strange:
        raise InputError(f"{axis} {_cut(strange[0])!r} is not a body of the instance")
    if len(set(told)) < len(told):
        raise InputError(f"{axis} names a body twice; give each once")
    return [known[name] for name in told]


def _scaled(variable: Any) -> npt.NDArray[np.float64]:
    """Values of a variable, converted to seconds or metres per second by its unit."""
    values, name = np.asarray(variable.values), str(variable.name)
    if values.dtype.kind not in "iuf":
        raise InputError(f"{name} holds {_cut(str(values.dtype))}; it must hold numbers")
    return values.astype(np.float64) * _factor(name, variable.attrs)


_CUBE = ("departure", "origin", "destination")
_VALUES = ("duration", "delta_v")


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 1] + "…"


def _first_line(error: BaseException) -> str:
    """The first line of a library's message, as far as it is printable."""
    told = error.args[0] if isinstance(error, KeyError) and error.args else error
    said = (str(told).splitlines() or [""])[0] or type(error).__name__
    return "".join(each if each.isprintable() else "�" for each in _cut(said))
