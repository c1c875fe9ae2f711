"""Units and types of given connections in files: converted to seconds and m/s, or refused."""

from __future__ import annotations

import sys
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from toy_roads import DEPARTURES, NAMES, as_rows, matrices, road, roads

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.given import Given, of_rows
from adr_opt.problem.given_files import read_given
from adr_opt.problem.given_units import cost_factor, time_factor

DURATION, COST = matrices()


def from_parquet(units: dict[str, str], more: tuple[Any, ...] = (), **columns: Any) -> Given:
    """The roads read from a Parquet file with other columns, units or columns besides."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    named = [*(as_rows() | columns).items(), *more]
    arrays = [each if isinstance(each, pa.Array) else pa.array(each) for _, each in named]
    fields = [
        pa.field(name, array.type, metadata={"units": units[name]} if name in units else None)
        for (name, _), array in zip(named, arrays, strict=True)
    ]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), "t.parquet")
    return read_given("t.parquet", NAMES)


def write_netcdf(
    duration: Any = DURATION,
    cost: Any = COST,
    departures: Any = DEPARTURES,
    *,
    units: dict[str, str] | None = None,
    drop: str = "",
) -> Path:
    """The roads as a NetCDF file, with other values or units, or without a variable."""
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    cube = ("departure", "origin", "destination")

    def stated(name: str) -> dict[str, str]:
        return {"units": units[name]} if units is not None and name in units else {}

    made = xarray.Dataset(
        {
            "duration": (cube, duration, stated("duration")),
            "delta_v": (cube, cost, stated("delta_v")),
        },
        coords={
            "departure": ("departure", departures, stated("departure")),
            "origin": list(NAMES),
            "destination": list(NAMES),
        },
    )
    made.drop_vars([drop] if drop else []).to_netcdf("t.nc", engine="h5netcdf")
    return Path("t.nc")


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def close(given: Given) -> bool:
    """Whether connections are those of the roads, to rounding."""
    right = of_rows(as_rows(), NAMES)
    return all(
        np.allclose(getattr(given, name), getattr(right, name), rtol=1e-12)
        for name in ("origin", "destination", "departure", "arrival", "cost")
    )


@pytest.mark.parametrize("unit", ["minutes", "min", "Minute"])
@pytest.mark.parametrize("speed", ["km s-1", "km/s", "km / s", "kilometers per second", "km s^-1"])
def test_units_of_columns_are_converted(unit: str, speed: str) -> None:
    """A column in minutes or km/s, by the metadata of its field, is the same connections."""
    rows = as_rows()
    given = from_parquet(
        {"departure_s": unit, "arrival_s": "h", "delta_v_m_s": speed},
        departure_s=np.array(rows["departure_s"]) / 60.0,
        arrival_s=np.array(rows["arrival_s"]) / 3600.0,
        delta_v_m_s=np.array(rows["delta_v_m_s"]) / 1000.0,
    )
    assert close(given)


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_durations_of_columns_are_converted(unit: str) -> None:
    """A column of Arrow's durations says itself what it counts in."""
    pa = pytest.importorskip("pyarrow")
    rows, each_s = as_rows(), {"s": 1, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    times = {
        name: pa.array((np.array(rows[name]) * each_s).astype(np.int64), pa.duration(unit))
        for name in ("departure_s", "arrival_s")
    }
    assert close(from_parquet({}, **times))


def test_numbers_of_other_types_are_numbers() -> None:
    """Decimals, integers and packed numbers are taken as they are."""
    pa = pytest.importorskip("pyarrow")
    rows = as_rows()
    decimals = [Decimal(round(1000 * cost)) / 1000 for cost in rows["delta_v_m_s"]]
    packed = pa.array(np.array(rows["departure_s"]).astype(np.int32)).dictionary_encode()
    assert close(from_parquet({}, delta_v_m_s=decimals, departure_s=packed))


def test_units_of_matrices_are_converted() -> None:
    """Variables in minutes, days and km/s, and differences of times, are the same connections."""
    path = write_netcdf(
        DURATION / 60.0,
        COST / 1000.0,
        DEPARTURES / 86400.0,
        units={"duration": "minutes", "delta_v": "km s-1", "departure": "days"},
    )
    assert close(read_given(path, NAMES))
    there = np.where(np.isfinite(DURATION), DURATION, 0.0)
    path = write_netcdf((1e9 * there).astype("m8[ns]"))
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(path, decode_times=False) as file:
        assert file["duration"].attrs["units"] != "s"  # xarray has chosen one of its own
    with pytest.raises(InputError, match=r"'farm' to 'mill': takes 0.0 s"):
        read_given(path, NAMES)
    assert close(read_given(write_netcdf(), NAMES))


@pytest.mark.parametrize(
    ("units", "said"),
    [
        ({"delta_v": "kWh"}, "delta_v: its unit 'kWh' is not a known unit of speed"),
        ({"delta_v": "S"}, "delta_v: its unit 'S' is not a known unit of speed"),
        ({"duration": "fortnights"}, "duration: its unit 'fortnights' is not a known unit of time"),
        ({"duration": "1"}, "duration: its unit '1' is not a known unit of time"),
        ({"departure": "days since 2026-05-04"}, "departure: its unit .* counts from a date"),
    ],
)
def test_other_units_are_refused(units: dict[str, str], said: str) -> None:
    """A unit that cannot be converted is one sentence that names the variable."""
    path = write_netcdf(units=units)
    with pytest.raises(InputError, match=said):
        read_given(path, NAMES)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"cost": COST > 3.0}, "delta_v holds bool; it must hold numbers"),
        ({"cost": COST.astype(str)}, "delta_v holds .*; it must hold numbers"),
        ({"duration": DURATION > 3.0}, "duration holds bool; it must hold numbers"),
        ({"departures": DEPARTURES.astype(str)}, "departure holds .*; it must hold numbers"),
        ({"drop": "departure"}, "no variable departure"),
        ({"drop": "origin"}, "no variable origin"),
    ],
)
def test_variables_of_other_types_are_refused(values: dict[str, Any], said: str) -> None:
    """Text, truth values and dimensions without a variable are no matrices."""
    path = write_netcdf(**values)
    with pytest.raises(InputError, match=said):
        read_given(path, NAMES)


@pytest.mark.parametrize("name", ["origin", "departure_s", "delta_v_m_s"])
@pytest.mark.parametrize("kind", ["list", "struct", "bool", "text", "timestamp", "bytes"])
def test_columns_of_other_types_are_refused(name: str, kind: str) -> None:
    """A column of lists, structs, truth values, dates or bytes, or numbers as text, is refused."""
    pa = pytest.importorskip("pyarrow")
    values = as_rows()[name]
    column = {
        "list": [[each] for each in values],
        "struct": [{"is": each} for each in values],
        "bool": [True] * len(values),
        "text": [str(each) for each in values] if name != "origin" else [0] * len(values),
        "timestamp": pa.array(range(len(values)), pa.timestamp("s")),
        "bytes": [str(each).encode() for each in values],
    }[kind]
    with pytest.raises(InputError, match=f"column {name} holds .*; it must hold n"):
        from_parquet({}, **{name: column})


def test_a_duration_is_no_cost() -> None:
    """What a connection costs is not taken from a column of durations."""
    pa = pytest.importorskip("pyarrow")
    column = pa.array(range(len(as_rows()["origin"])), pa.duration("s"))
    with pytest.raises(InputError, match=r"delta_v_m_s holds duration\[s\]"):
        from_parquet({}, delta_v_m_s=column)


@pytest.mark.parametrize("name", ["origin", "arrival_s"])
def test_columns_that_are_there_twice_are_refused(name: str) -> None:
    """Two columns of one name are ambiguous and refused."""
    with pytest.raises(InputError, match=f"column {name} occurs twice"):
        from_parquet({}, ((name, as_rows()[name]),))


def test_a_damaged_file_is_complained_about_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever a header of a NetCDF file is damaged, one sentence says so, and nothing else."""
    again: list[Any] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda found: again.append(found.exc_value))
    content = write_netcdf().read_bytes()
    headers = [
        at for at in range(len(content)) if content[at : at + 4] in (b"OHDR", b"OCHK", b"FRHP")
    ]
    assert len(headers) > 5
    for at in headers:
        Path("t.nc").write_bytes(content[:at] + b"\0\0\0\0" + content[at + 4 :])
        with pytest.raises(InputError, match=r"^t\.nc: not a NetCDF 4 file") as error:
            read_given("t.nc", NAMES)
        assert str(error.value).isprintable()
    assert again == []


def test_a_file_that_needs_more_memory_than_there_is_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Before anything is read of a file, its size is held against the memory."""
    monkeypatch.setattr("adr_opt.problem.given_files.available_bytes", lambda: 1000.0)
    path = write_netcdf()
    with pytest.raises(InputError, match=r"t\.nc: holds .* numbers, too many for the memory"):
        read_given(path, NAMES)
    with pytest.raises(InputError, match=r"t\.parquet: holds .* numbers, too many"):
        from_parquet({})


@pytest.mark.parametrize(
    ("column", "values", "said"),
    [
        ("delta_v_m_s", np.full(132, "3.0"), "delta_v_m_s must be numbers, and is text"),
        ("delta_v_m_s", np.full(132, True), "delta_v_m_s must be numbers, and is true and false"),
        ("delta_v_m_s", np.full(132, 1j), "delta_v_m_s must be numbers, and is complex"),
        ("delta_v_m_s", np.full(132, 1, "m8[s]"), "delta_v_m_s must be numbers, and is times"),
        ("arrival_s", np.full(132, 9, "M8[s]"), "arrival_s must be numbers, and is dates"),
        ("arrival_s", np.full(132, "9", object), "arrival_s must be numbers, and is text"),
        ("origin", np.array([*[None] * 131, []], object), "row 0: origin = 'None' is not a body"),
    ],
)
def test_arrays_of_other_types_are_refused(column: str, values: Any, said: str) -> None:
    """What is given in Python is not made numbers of either, where it is none."""
    with pytest.raises(InputError, match=said):
        adr_opt.Timetable.from_connections(roads(), as_rows() | {column: values})


def test_differences_of_times_are_converted_in_python() -> None:
    """Columns, matrices and functions may give durations as NumPy's differences of times."""
    rows = {name: np.array(values) for name, values in as_rows().items()}
    for name in ("departure_s", "arrival_s"):
        rows[name] = (1000.0 * rows[name]).astype("m8[ms]")
    right = of_rows(as_rows(), NAMES).sha256
    assert adr_opt.Timetable.from_connections(roads(), rows).instance.given.sha256 == right

    def told(origin: int, destinations: Any, departure: float) -> Any:
        duration, cost = road(origin, destinations, departure)
        there = np.where(np.isfinite(duration), duration, 0.0)
        return there.astype("m8[s]"), np.where(np.isfinite(duration), cost, np.inf)

    found = adr_opt.Timetable.from_function(roads(), told, DEPARTURES.astype("m8[s]"))
    assert found.instance.given.sha256 == right


def test_every_spelling_of_a_unit_is_what_it_says() -> None:
    """Factors are those of the units; no unit stands for seconds and a number as it is."""
    for unit, seconds in (
        (None, 1.0),
        ("", 1.0),
        (b"s", 1.0),
        ("seconds", 1.0),
        ("Hours", 3600.0),
        ("d", 86400.0),
        ("days", 86400.0),
        ("ms", 1e-3),
        ("mins", 60.0),
    ):
        assert time_factor(unit, "x") == seconds
    for unit, speed in (
        (None, 1.0),
        ("1", 1.0),
        ("m s-1", 1.0),
        ("m.s-1", 1.0),
        ("m*s**-1", 1.0),
        ("metres per second", 1.0),
        ("cm/s", 0.01),
        ("km/h", 1000.0 / 3600.0),
        ("km s⁻¹", 1000.0),
    ):
        assert cost_factor(unit, "x") == speed
    for wrong in (3, "m", "s", "m s", "m s-2", "m/s/s", "EUR", "\x1b[31m"):
        with pytest.raises(InputError) as error:
            cost_factor(wrong, "x")
        assert str(error.value).isprintable()
