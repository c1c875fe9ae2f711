"""Print a mission with rules of its own; ``mission.json`` is what it prints.

Sixteen objects of the reference scenario, three days and 1.2 km/s. The chaser is launched within
a window of time and has to be back at the station at its end; two objects are worth twice as much
as the others, if they are serviced by their deadlines; one has to be serviced whatever it costs.
"""

import adr_opt
from adr_opt.problem.chasers import AtStation

HOUR_S = 3600.0


def main() -> None:
    """Draw the field, and change what the rules are about."""
    field = adr_opt.generate("nominal", seed=1, targets=16).with_limits(72.0 * HOUR_S, 1200.0)
    changes = {
        "debris-005": {"prize": 2.0, "window_s": (0.0, 24.0 * HOUR_S)},
        "debris-007": {"prize": 2.0, "window_s": (30.0 * HOUR_S, 40.0 * HOUR_S)},
        "debris-015": {"required": True},
    }
    chaser = field.chaser.replace(
        available_s=(6.0 * HOUR_S, 66.0 * HOUR_S), end=AtStation(station="station")
    )
    mission = field.replace(
        name="deadlines",
        targets=tuple(t.replace(**changes.get(t.name, {})) for t in field.targets),
        chasers=(chaser,),
    )
    print(mission.to_json(), end="")


if __name__ == "__main__":
    main()
