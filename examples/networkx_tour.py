"""networkx finds a quick tour by the durations of one departure; the mission ends on the way.

    python -m adr_opt matrix my.json --at 0 --out costs.nc
    python examples/networkx_tour.py my.json costs.nc

Needs networkx, xarray and h5netcdf. Durations know no fuel.
"""

import sys

import networkx as nx
import numpy as np
import xarray as xr
from coming_back import come_back

import adr_opt


def solve(matrix: str) -> list[int]:
    """The targets whose service ends within the mission, in the order of the tour."""
    with xr.open_dataset(matrix, engine="h5netcdf") as costs:
        hours = (costs.duration.isel(departure=0) + costs.service).values / 3600.0
        limit_h = costs.attrs["mission_duration_s"] / 3600.0
    never = 2.0 * np.nansum(np.where(np.isfinite(hours), hours, np.nan))
    hours = np.where(np.isfinite(hours), hours, never)
    np.fill_diagonal(hours, 0.0)
    graph = nx.from_numpy_array(hours, create_using=nx.DiGraph)
    tour = nx.approximation.simulated_annealing_tsp(graph, "greedy", source=0, seed=0)
    ends_h = np.cumsum(hours[tour[:-1], tour[1:]])
    return [body for body, end_h in zip(tour[1:-1], ends_h, strict=False) if end_h <= limit_h]


if __name__ == "__main__":
    instance, matrix = sys.argv[1:3]
    come_back("networkx", adr_opt.Mission(adr_opt.load(instance)), solve(matrix))
