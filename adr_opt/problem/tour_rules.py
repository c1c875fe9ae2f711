"""Rules that only tours through time are planned with.

Where the time from one arrival to the next is limited, or missions are kept apart, to be earlier is
not always better (docs/model.md section 5.5), and planners that rely on it do not apply.
"""

from __future__ import annotations

from ..common.errors import InputError
from .instance import Instance

LONGEST_LEG, SEPARATION = "transfer.max_leg_s", "mission.mission_separation_s"


def tour_rule(instance: Instance) -> str | None:
    """Field of a rule that only tours through time are planned with; None if none is set."""
    if instance.transfer.max_leg_s is not None:
        return LONGEST_LEG
    return None if instance.mission.mission_separation_s is None else SEPARATION


def refuse_tour_rules(instance: Instance, who: str) -> None:
    """Refuse what follows no rule that only tours through time are planned with.

    Parameters
    ----------
    instance : Instance
    who : str
        Begins the sentence.

    Raises
    ------
    InputError
        Such a rule is set.
    """
    rule = tour_rule(instance)
    if rule is not None:
        raise InputError(f"{who} does not follow {rule} yet, which {instance.name!r} sets")
