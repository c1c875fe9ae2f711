"""Walks through the house, counted: an instance to a plan, a deadline, a tow, a rule.

    python bench/walks.py

The first follows the calls of ``solve INSTANCE --method auto`` until the planner is called: a
*stay* is a stretch of calls in one room, and a call is a *climb* if it leads into a room above its
caller's. The others read the code: where a window, a tow, and the limit on visits between
refuellings are known, and where their rules stand.
"""

from __future__ import annotations

import ast
import contextlib
import io
import sys
import tempfile
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path
from types import FrameType
from typing import Any

from house import TOW, identifiers, is_window_rule, knows_visits, modules, room_of, storey_of_rooms

import adr_opt
from adr_opt.ui.cli.entry import main as command_line

PLANNER = ("solvers.planners.auto", "auto")
"""Module and function at whose call the first walk ends."""

WINDOW = {"opens", "closes", "window_s", "windows_s"}
"""Names of a window."""


class Walk:
    """The calls between modules of the product until the planner is called.

    Attributes
    ----------
    calls : list of (str, str)
        Modules of caller and called, calls within a module left out.
    """

    def __init__(self) -> None:
        self.calls: list[tuple[str, str]] = []

    def __call__(self, frame: FrameType, event: str, argument: Any) -> None:
        """Receive an event, as from :func:`sys.setprofile`."""
        if event != "call":
            return
        module, caller = (_module(at) for at in (frame, frame.f_back))
        if module is None or module == caller:
            return
        if (module, frame.f_code.co_name) == PLANNER:
            sys.setprofile(None)
        if frame.f_code.co_name != "<module>":
            self.calls.append((caller or "", module))


def _module(frame: FrameType | None) -> str | None:
    """The module of the product that a frame is of."""
    name = "" if frame is None else str(frame.f_globals.get("__name__"))
    return name if name.startswith(("adr_opt.", "solvers.")) else None


def instance_to_plan() -> Walk:
    """The first walk, over a small instance; a run before it has compiled and imported."""
    walk = Walk()
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "field.json")
        adr_opt.generate("tiny", 0).save(file)
        words = ["solve", file, "--method", "auto", "--time-limit", "5", "--quiet"]
        with contextlib.redirect_stdout(io.StringIO()):
            _run(words)
            sys.setprofile(walk)
            try:
                _run(words)
            finally:
                sys.setprofile(None)
    return walk


def _run(words: list[str]) -> None:
    with contextlib.suppress(SystemExit):
        command_line(words)


def rooms(names: Iterable[str]) -> str:
    """The rooms of modules, in words."""
    found = sorted({room_of(name) for name in names})
    return f"{len(found)} rooms ({', '.join(found)})"


def main() -> None:
    """Print the walks."""
    walk, order, trees = instance_to_plan(), storey_of_rooms(), modules()
    stays = [room for room, _ in groupby(room_of(called) for _, called in walk.calls)]
    climbs = [
        (room_of(caller), room_of(called))
        for caller, called in walk.calls
        if order.get(room_of(caller), 99) < order.get(room_of(called), 0)
    ]
    reached = {called for _, called in walk.calls}
    print("an instance, from its file to the call of auto:")
    print(f"  {len(reached)} of {len(trees)} modules in {rooms(reached)}")
    print(f"  {len(stays)} stays, {len(climbs)} climbs")
    for (caller, called), number in sorted({each: climbs.count(each) for each in climbs}.items()):
        print(f"    {caller} calls {called}: {number}")
    known = [name for name, tree in trees.items() if WINDOW & set(identifiers(tree))]
    rule = [name for name, tree in trees.items() if any(map(is_window_rule, ast.walk(tree)))]
    print("a deadline:")
    print(f"  windows are known in {len(known)} modules in {rooms(known)}")
    print(f"  when a service begins is stated in {', '.join(rule)}")
    known = [name for name, tree in trees.items() if any(map(TOW.search, identifiers(tree)))]
    print("a tow:")
    print(f"  tows are known in {len(known)} modules in {rooms(known)}")
    known = [name for name, tree in trees.items() if knows_visits(tree)]
    print("a rule, max_visits_between_refuels:")
    print(f"  it is known in {len(known)} modules in {rooms(known)}:")
    for name in known:
        print(f"    {name}")


if __name__ == "__main__":
    main()
