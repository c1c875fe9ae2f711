"""OR-Tools routing solves the orienteering problem of one fuel load at the ΔV of one departure.

    python -m adr_opt matrix my.json --at 0 --out costs.oplib
    python examples/ortools_orienteering.py my.json costs.oplib

Needs vrplib, which reads any file of this family.
"""

import sys

import vrplib
from coming_back import come_back
from ortools.constraint_solver import pywrapcp
from ortools.constraint_solver.routing_enums_pb2 import LocalSearchMetaheuristic

import adr_opt


def solve(matrix: str, seconds: int = 2) -> list[int]:
    """The cycle through the station within COST_LIMIT that scores most."""
    problem = vrplib.read_instance(matrix)
    limit, nodes = problem["cost_limit"], pywrapcp.RoutingIndexManager(problem["dimension"], 1, 0)
    model = pywrapcp.RoutingModel(nodes)
    cost = model.RegisterTransitMatrix(problem["edge_weight"].astype(int).tolist())
    model.SetArcCostEvaluatorOfAllVehicles(cost)
    model.AddDimension(cost, 0, limit, True, "cost")
    for node, score in enumerate(problem["node_score"].astype(int).tolist()[1:], start=1):
        model.AddDisjunction([nodes.NodeToIndex(node)], score * (limit + 1))
    search = pywrapcp.DefaultRoutingSearchParameters()
    search.local_search_metaheuristic = LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    search.time_limit.seconds = seconds
    found, at, order = model.SolveWithParameters(search), model.Start(0), []
    while not model.IsEnd(at := found.Value(model.NextVar(at))):
        order.append(nodes.IndexToNode(at))
    return order


if __name__ == "__main__":
    come_back("OR-Tools", adr_opt.Mission(adr_opt.load(sys.argv[1])), solve(sys.argv[2]))
