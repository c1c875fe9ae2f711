"""Options of ``import`` for chasers and single objects: launches, expenses, deadlines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...common.constants import DAY_S
from ...common.wording import counted
from . import take
from .fitting import fitting_options

if TYPE_CHECKING:
    from ...problem.instance import Instance


crew_options = take.together(
    fitting_options("default 3000"),
    take.count("--launches", "N", "Launch N chasers, each to its first target."),
    take.number(
        "--launch-every", "DAYS", "Interval between launches; default 365; 0 for a shared rocket."
    ),
    take.number(
        "--launch-separation",
        "DAYS",
        "Least interval between launches, whose times are then optimised.",
    ),
    take.word(
        "--expense",
        "FIXED[,PER_KG[,PER_KG2]]",
        "Cost of each chaser used; the least total decides between equal plans.",
    ),
    take.number("--thrust", "N", "Low thrust of each chaser, in place of impulses."),
    take.number("--duty-cycle", "SHARE", "Share of the time in which it is on; default 1."),
    take.number(
        "--service-days", "D", "Duration of each service; by default one revolution of the target."
    ),
    take.many(
        "--deadline", "OBJECT=DAYS", "Latest end of its service; repeatable.", name="deadlines"
    ),
    take.many(
        "--require",
        "OBJECT",
        "Must be serviced; an error if filters omit it; repeatable.",
        name="required",
    ),
    take.many(
        "--must", "OBJECT[,OBJECT...]", "Must be serviced, regardless of filters.", name="musts"
    ),
    take.many(
        "--exclude", "OBJECT[,OBJECT...]", "Not to be a target; repeatable.", name="excluded"
    ),
    take.file(
        "--prizes",
        "CSV: object, prize, required, window, mass, removal, prize_until.",
        name="prizes_path",
    ),
)
"""The options of chasers and of single objects, for ``import``."""


def told(instance: Instance) -> str | None:
    """A sentence on the launches of an instance; None if there are none."""
    if not instance.launches:
        return None
    days = ", ".join(f"{since_s / DAY_S:g}" for since_s in instance.launches.values())
    return f"{counted(len(instance.launches), 'launch', 'launches')}, on day {days}"
