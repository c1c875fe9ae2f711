"""``.lp`` and ``.mps``: the model of method `mip`, for any solver that reads these formats.

``matrix`` finds these two by their entry points in the group ``adr_opt.models``. The model is the
exact one of :mod:`.constraints` on the network of all connections that a plan can need: its optimum
is that of the mission, and the bound of any relaxation of it holds for the mission.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from shutil import copyfileobj
from typing import Any

import numpy as np

from adr_opt.common.errors import InputError, MissingExtra
from adr_opt.mission.mission import Mission

from ...models.solver_network import SolverNetwork, of_rows
from ...networks.network import build

MOST_MOVES = 500_000
"""Maximum number of moves: one takes about 240 bytes of a .lp file, 350 of a .mps file, and 2 kB of
memory during writing."""

COLUMN = re.compile(r"move\((\d+)_(\d+)_(\d+)\)")
"""Name of a move's column: node left, node reached, body reached. There is only one leg per pair of
nodes, since another would cost more or less."""


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
    rules = mission.rules
    if not rules.prize.any():
        # Where nothing is worth anything, every move is.
        rules = rules._replace(prize=(np.arange(rules.prize.size) >= rules.first_target) + 0.0)
    network = of_rows(build(mission, jobs=1), rules)
    name = mission.instance.name
    if network.legs == 0:
        raise InputError(f"{name!r} has no legal move: there is nothing to write a model of")
    if network.legs > MOST_MOVES:
        raise InputError(
            f"the model of {name!r} has {network.legs} moves, more than the {MOST_MOVES} that fit "
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


def _block(mission: Mission, network: SolverNetwork) -> Any:
    """The model of method `mip`, with unscaled prizes."""
    import pyomo.environ as pyo

    from .constraints import MipConstraints
    from .variables import MipVariables, collect_prizes

    rules = mission.rules
    block = pyo.ConcreteModel()
    variables = MipVariables(block, network, rules)
    MipConstraints(block, network, variables, rules)
    collect_prizes(block, network, variables, rules.prize)
    return block


def _names(network: SolverNetwork) -> Callable[[Any], str]:
    """Names of columns and rows from which a solution can be read."""
    from pyomo.core.base.label import LPFileLabeler

    plain = LPFileLabeler()
    tail, landing = network.tail.tolist(), network.landing.tolist()
    body = network.destination.tolist()

    def name(component: Any) -> str:
        if component.parent_component().local_name == "move":
            leg = component.index()
            return f"move({tail[leg]}_{landing[leg]}_{body[leg]})"
        return str(plain(component))

    return name


def _heading(mission: Mission, network: SolverNetwork) -> list[str]:
    """Explanations for readers of the file alone."""
    instance = mission.instance
    name = instance.name.encode("ascii", "backslashreplace").decode()
    required = [f"a required target counts {mission.bonus!r} more than its prize"]
    required = required if mission.required else []
    return [
        f"{re.sub(r'[^ -~]', ' ', name)}: adr-opt instance with sha256 {instance.sha256}",
        "maximise the sum of the prizes of the targets visited; every departure is exact",
        *required,
        f"{network.nodes} nodes, numbered in order of time: node 0 is the start, every other one a "
        "body from a time on",
        "move(a_b_c) = 1: a leg is flown from node a to node b, of body c",
        "wait(a) = 1: from node a on, the chaser waits for the next node of its body",
        "used(i_j): share of the budget used since refuelling when body i is left for body j",
        f"bodies are {_bodies(mission)}; moves in order of a are the order of the plan",
    ]


def _bodies(mission: Mission) -> str:
    """Meaning of the body numbers."""
    rules = mission.rules
    parts = ["the station" if rules.stations == 1 else "the stations"] if rules.stations else []
    if rules.first_target > rules.stations:
        parts.append("the orbit of the start")
    return ", ".join([*parts, "the targets"]) + ", numbered from 0 in order"


def order_of(columns: dict[str, float]) -> tuple[int, ...]:
    """Bodies of a solution in order, from the values of its columns by name.

    Parameters
    ----------
    columns : dict
        Columns that are not moves are ignored.
    """
    moves = []
    for column, value in columns.items():
        found = COLUMN.fullmatch(column)
        if found is not None and value > 0.5:
            moves.append((int(found[1]), int(found[3])))
    return tuple(body for _, body in sorted(moves))
