"""``.nc``: NetCDF 4 via xarray, with names, units and constants (extra ``[io]``)."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.errors import MissingExtra
from ...legs.matrices import Matrices
from ...mission.mission import Mission
from .attributes import attributes

if TYPE_CHECKING:
    import xarray

CUBE = ("departure", "origin", "destination")


def require() -> None:
    """Raise :class:`MissingExtra` if xarray or its backend is not installed."""
    for package in ("xarray", "h5netcdf", "h5py"):
        try:
            import_module(package)
        except ImportError:
            raise MissingExtra("writing a .nc file", package, "io") from None


def dataset(mission: Mission, matrices: Matrices) -> xarray.Dataset:
    """Label the matrices with names, units and constants.

    The dimensions are ``departure`` (ready times), ``origin`` and ``destination`` (names).
    Settings and constants are attributes, with their units in their names.
    """
    import xarray

    names = list(matrices.names)
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


def write(path: Path, mission: Mission, matrices: Matrices) -> None:
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
