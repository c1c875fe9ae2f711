"""LKH, as the package elkai brings it, finds the cheapest tour at the ΔV of one departure.

    python -m adr_opt matrix my.json --at 0 --scale 1 --out costs.tsp
    python examples/lkh_tour.py my.json costs.tsp

Needs elkai and vrplib. LKH multiplies weights by 100 in 32 bits: --scale 1 keeps them small. An
LKH of your own reads the same file. LKH and elkai are free for non-commercial use only.
"""

import sys

import elkai
import vrplib
from coming_back import come_back

import adr_opt


def solve(matrix: str, runs: int = 10) -> list[int]:
    """The order of the targets on the shortest tour from the station through all of them."""
    weights = vrplib.read_instance(matrix)["edge_weight"].tolist()
    station, *targets, back = elkai.DistanceMatrix(weights).solve_tsp(runs)
    assert station == back == 0
    return targets


if __name__ == "__main__":
    instance, matrix = sys.argv[1:3]
    come_back("LKH", adr_opt.Mission(adr_opt.load(instance)), solve(matrix))
