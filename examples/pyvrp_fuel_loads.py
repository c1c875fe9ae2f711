"""PyVRP packs targets into fuel loads, from the station and back, at the ΔV of one departure.

    python -m adr_opt matrix my.json --at 0 --out costs.vrp
    python examples/pyvrp_fuel_loads.py my.json costs.vrp

Needs pyvrp. A .vrp of ΔV knows no clock, so all targets are promised.
"""

import sys

import pyvrp
from coming_back import come_back

import adr_opt


def solve(matrix: str, seconds: float = 2.0) -> list[int]:
    """Visit all targets worth their ΔV, each route on one fuel load; a 0 is a refuelling."""
    data = pyvrp.read(matrix)
    stop = pyvrp.stop.MaxRuntime(seconds)
    best = pyvrp.solve(data, stop=stop, seed=0, display=False).best
    order: list[int] = []
    for route in best.routes():
        visits = [visit.idx + 1 for visit in route.schedule() if visit.is_client()]
        order += [0, *visits] if order else visits
    return order


if __name__ == "__main__":
    instance, matrix = sys.argv[1:3]
    come_back("PyVRP", adr_opt.Mission(adr_opt.load(instance)), solve(matrix))
