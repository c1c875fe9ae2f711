"""``.lp`` and ``.mps``: the model of method `mip`, for any solver that reads such files.

``matrix`` finds these two by their entry points in the group ``adr_opt.models``. The model is the
exact one of :mod:`solvers.mip.constraints` on the whole network, nothing removed: its optimum is
that of the mission, and the bound of any relaxation of it holds for the mission.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from shutil import copyfileobj
from typing import Any

import numpy as np

from adr_opt.errors import InputError, MissingExtra
from adr_opt.mission import Mission

from ..exact_models.network import Network, unroll

MOST_MOVES = 500_000
"""Larger models are refused: a move takes about 240 bytes of a .lp file, 350 of a .mps file, and
2 kB of memory while it is written."""

COLUMN = re.compile(r"move\((\d+)_(\d+)_(\d+)\)")
"""Name of the column of a move: node left, node reached, body reached."""


def write_lp(mission: Mission, path: Path) -> None:
    """Write the mission as a mixed-integer program in LP format.

    Raises
    ------
    MissingExtra
        Pyomo is not installed.
    InputError
        There is no legal move, or there are more than :data:`MOST_MOVES`.
    """
    _write(mission, path, "lp", "\\ ")


def write_mps(mission: Mission, path: Path) -> None:
    """Write the mission as a mixed-integer program in free MPS format, maximising (OBJSENSE).

    Raises
    ------
    MissingExtra, InputError
        As :func:`write_lp`.
    """
    _write(mission, path, "mps", "* ")


def _write(mission: Mission, path: Path, file_format: str, mark: str) -> None:
    if find_spec("pyomo") is None:
        raise MissingExtra(f"writing a .{file_format} file", "pyomo", "mip")
    network = unroll(mission.rules)
    name = mission.instance.name
    if network.arcs == 0:
        raise InputError(f"{name!r} has no legal move: there is nothing to write a model of")
    if network.arcs > MOST_MOVES:
        raise InputError(
            f"the model of {name!r} has {network.arcs} moves, more than the {MOST_MOVES} that fit "
            f"a .{file_format} file; take fewer targets or a shorter mission"
        )
    body = path.with_name(f"{path.name}.body")
    try:
        _block(mission, network).write(
            str(body), format=file_format, io_options={"labeler": _names(network)}
        )
        with path.open("w", encoding="ascii", newline="\n") as file, body.open() as written:
            file.writelines(f"{mark}{line}\n" for line in _heading(mission, network))
            copyfileobj(written, file)
    finally:
        body.unlink(missing_ok=True)


def _block(mission: Mission, network: Network) -> Any:
    """The model of method `mip`, in prizes as they are."""
    import pyomo.environ as pyo

    from .constraints import Constraints
    from .objective import Objective
    from .variables import Variables

    rules = mission.rules
    block = pyo.ConcreteModel()
    variables = Variables(block, network)
    Constraints(block, network, variables, rules.budget or 1.0)
    Objective(block, network, variables, np.array(rules.prize))
    return block


def _names(network: Network) -> Callable[[Any], str]:
    """Names of columns and rows that a solution can be read from."""
    from pyomo.core.base.label import LPFileLabeler

    plain = LPFileLabeler()
    tail, head = network.tail.tolist(), network.successor.tolist()
    body = network.body[network.successor].tolist()

    def name(component: Any) -> str:
        if component.parent_component().local_name == "move":
            arc = component.index()
            return f"move({tail[arc]}_{head[arc]}_{body[arc]})"
        return str(plain(component))

    return name


def _heading(mission: Mission, network: Network) -> list[str]:
    """What a reader of the file alone has to know."""
    instance = mission.instance
    name = instance.name.encode("ascii", "backslashreplace").decode()
    return [
        f"{re.sub(r'[^ -~]', ' ', name)}: adr-opt instance with sha256 {instance.sha256}",
        "maximise the sum of the prizes of the targets visited; every departure is exact",
        f"{network.nodes} nodes: node 0 is the start, every other one a leg that can be flown",
        "move(a_b_c) = 1: after node a the leg of node b is flown, to body c",
        "used(i_j): share of the budget used since refuelling when body i is left for body j",
        "body 0 is the station, then the targets in order; follow the moves from node 0",
    ]


def order_of(columns: dict[str, float]) -> tuple[int, ...]:
    """The bodies of a solution in order, from the values of the columns by name.

    Parameters
    ----------
    columns : dict
        Columns that are not moves are ignored.
    """
    following = {}
    for column, value in columns.items():
        found = COLUMN.fullmatch(column)
        if found is not None and value > 0.5:
            node, after, body = map(int, found.groups())
            following[node] = after, body
    node, order = 0, []
    while node in following:
        node, body = following[node]
        order.append(body)
    return tuple(order)
