"""Given connections that are not there, and files that state more than there is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from toy_roads import DEPARTURES, NAMES, as_rows, matrices, roads

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.given import Given
from adr_opt.problem.given_files import read_given

HALVES = {"arrival_s": "delta_v_m_s", "delta_v_m_s": "arrival_s"}

ENCODINGS: dict[str, dict[str, Any]] = {
    "NaN": {},
    "packed": {"dtype": "int32", "scale_factor": 0.5, "_FillValue": -1},
    "packed, of unsigned bytes": {"dtype": "uint16", "scale_factor": 60.0, "_FillValue": 65535},
    "a number": {"dtype": "float64", "_FillValue": 9.96921e36},
}


def netcdf(duration: Any, cost: Any, **encoding: Any) -> Given:
    """Matrices through a file that xarray writes."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    cube = ("departure", "origin", "destination")
    axes = {"departure": DEPARTURES, "origin": list(NAMES), "destination": list(NAMES)}
    data = xarray.Dataset({"duration": (cube, duration), "delta_v": (cube, cost)}, axes)
    data.to_netcdf("t.nc", engine="h5netcdf", encoding=dict.fromkeys(data.data_vars, encoding))
    return read_given("t.nc", NAMES)


def parquet(rows: dict[str, list[Any]], **written: Any) -> Given:
    """Rows through a Parquet file, None as null."""
    pa = pytest.importorskip("pyarrow")
    pq = pytest.importorskip("pyarrow.parquet")
    pq.write_table(pa.table(rows), "t.parquet", **written)
    return read_given("t.parquet", NAMES)


def some_missing() -> tuple[Any, Any, Any]:
    """Matrices in minutes and whole numbers, and which connections are not there."""
    duration, cost = matrices()
    absent = ~np.isfinite(duration) | (np.random.default_rng(3).random(duration.shape) < 0.3)
    duration, cost = (
        60.0 * np.ceil(np.where(np.isfinite(duration), values, 60.0) / 60.0)
        for values in (duration, cost)
    )
    return duration, cost, absent


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_missing_values_of_matrices_are_no_connections(encoding: str) -> None:
    """What is missing in both variables is what +inf is, however a file writes it."""
    duration, cost, absent = some_missing()
    inf = [np.where(absent, np.inf, values) for values in (duration, cost)]
    wanted = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *inf).instance.given
    nan = [np.where(absent, np.nan, values) for values in (duration, cost)]
    found = netcdf(*nan, **ENCODINGS[encoding])
    in_python = adr_opt.Timetable.from_matrices(roads(), DEPARTURES, *nan).instance.given
    assert wanted is not None
    assert in_python is not None
    assert found.sha256 == in_python.sha256 == wanted.sha256


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("half", ["duration", "cost"])
def test_half_a_connection_of_matrices_is_refused(encoding: str, half: str) -> None:
    """A value that is missing alone is named with its place; beside +inf it is no connection."""
    duration, cost, _ = some_missing()
    spoilt, other = (duration, cost) if half == "duration" else (cost, duration)
    spoilt[1, 2, 3] = np.nan
    said = (
        rf"departure {DEPARTURES[1]:g} s, '{NAMES[2]}' to '{NAMES[3]}': {half}\[1, 2, 3\] is miss"
    )
    with pytest.raises(InputError, match=said):
        netcdf(duration, cost, **ENCODINGS[encoding])
    if encoding == "NaN":
        other[1, 2, 3] = np.inf
        assert netcdf(duration, cost).departure.size > 0


@pytest.mark.parametrize("missing", [None, np.nan])
@pytest.mark.parametrize("whole", [False, True])
def test_missing_values_of_rows_are_no_connections(missing: float | None, whole: bool) -> None:
    """A row without arrival and cost is left out, null or NaN, of integers or floats."""
    if whole and missing is not None:
        return  # integers have no NaN
    rows = as_rows()
    for name in ("departure_s", *HALVES) if whole else ():
        rows[name] = [round(value) for value in rows[name]]
    absent = set(range(0, len(rows["origin"]), 3))
    left = {
        name: [value for at, value in enumerate(values) if at not in absent]
        for name, values in rows.items()
    }
    wanted = parquet(left)
    for name in HALVES:
        rows[name] = [missing if at in absent else v for at, v in enumerate(rows[name])]
    found = parquet(rows)
    assert found.sha256 == wanted.sha256
    rows["arrival_s"][1] = rows["departure_s"][1]
    with pytest.raises(InputError, match=r"row 1, .* takes 0\.0 s"):
        parquet(rows)


@pytest.mark.parametrize("missing", [None, np.nan])
@pytest.mark.parametrize("name", HALVES)
def test_half_a_row_is_refused(missing: float | None, name: str) -> None:
    """A row with only one of both is named; one without a body or a departure, too."""
    rows = as_rows()
    rows[name][7] = missing
    with pytest.raises(InputError, match=f"row 7, .*: {name} is missing and {HALVES[name]} is not"):
        parquet(rows)
    for other in ("origin", "departure_s"):
        rows = as_rows()
        rows[other][7] = None
        with pytest.raises(InputError, match=f"column {other} has rows without a value"):
            parquet(rows)


@pytest.mark.parametrize(
    ("variable", "shape", "kind"),
    [
        ("departure", (10**13,), "f8"),
        ("departure", (10**13,), "i1"),
        ("duration", (10**6, 10**4, 10**4), "f4"),
        ("origin", (1,), "S2000000000"),
        ("service", (10**13,), "f8"),
        ("phony", (10**13,), "f8"),
    ],
)
def test_shapes_that_a_file_only_states_take_no_memory(
    variable: str, shape: tuple[int, ...], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A NetCDF file of some kilobytes that claims terabytes is refused, or they are not read."""
    h5py = pytest.importorskip("h5py")
    monkeypatch.setattr("adr_opt.problem.given_files.available_bytes", lambda: 1e9)
    netcdf(*matrices())
    with h5py.File("t.nc", "a") as file:
        if variable in file:
            del file[variable]
        file.create_dataset(variable, shape, kind, chunks=tuple(min(8, size) for size in shape))
        if variable == "service":
            file[variable].make_scale(variable)
    assert Path("t.nc").stat().st_size < 10**5
    if variable == "service":
        assert read_given("t.nc", NAMES).departure.size > 0
        return
    with pytest.raises(InputError, match="too many for the memory"):
        read_given("t.nc", NAMES)


def test_names_that_are_repeated_take_no_memory() -> None:
    """A Parquet file may repeat a name of a megabyte a million times; it is read once."""
    pa = pytest.importorskip("pyarrow")
    rows = 10**6
    columns: dict[str, Any] = {
        name: pa.DictionaryArray.from_arrays(pa.array(np.zeros(rows, np.int8)), ["x" * 10**6])
        for name in ("origin", "destination")
    }
    columns |= {name: np.zeros(rows) for name in ("departure_s", *HALVES)}
    with pytest.raises(InputError, match=r"'xxx.*…' is not a body of the instance"):
        parquet(columns, store_schema=False, compression="zstd")
