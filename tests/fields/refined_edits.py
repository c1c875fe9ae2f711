"""Refined plans with one thing changed at random, as files have it."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from typing import Any

Content = dict[str, Any]
"""A refined plan as plain data."""


def _leg(content: Content, rng: random.Random) -> Content:
    leg: Content = rng.choice(content["legs"])
    return leg


def _state(content: Content, rng: random.Random) -> Content:
    state: Content = rng.choice(_leg(content, rng)["states"])
    return state


def _burn(content: Content, rng: random.Random) -> tuple[Content, Content]:
    leg = _leg(content, rng)
    return leg, rng.choice(leg["burns"])


def _total(leg: Content) -> None:
    """State the ΔV that a leg then has, as whoever edits its burns would."""
    arcs = leg.get("thrust", {}).get("arcs", ())
    sizes = [sum(part**2 for part in burn["delta_v_m_s"]) ** 0.5 for burn in leg["burns"]]
    leg["flown_delta_v_m_s"] = sum(sizes) + sum(arc["delta_v_m_s"] for arc in arcs)


def reversed_velocity(content: Content, rng: random.Random) -> None:
    state = _state(content, rng)
    state["velocity_m_s"] = [-part for part in state["velocity_m_s"]]


def moved_state(content: Content, rng: random.Random) -> None:
    vector = _state(content, rng)[rng.choice(["position_m", "velocity_m_s"])]
    vector[rng.randrange(3)] *= 1.0 + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-9.0, 0.0)


def moved_body(content: Content, rng: random.Random) -> None:
    vector = rng.choice(content["bodies"])[rng.choice(["position_m", "velocity_m_s"])]
    vector[rng.randrange(3)] *= 1.0 + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-9.0, 0.0)


def swapped_bodies(content: Content, rng: random.Random) -> None:
    one, other = rng.sample(content["bodies"], 2)
    one["name"], other["name"] = other["name"], one["name"]


def lost_leg(content: Content, rng: random.Random) -> None:
    content["legs"].remove(_leg(content, rng))


def lost_last_leg(content: Content, rng: random.Random) -> None:
    del content["legs"][-1]


def swapped_legs(content: Content, rng: random.Random) -> None:
    one, other = rng.sample(content["legs"], 2)
    one["leg"], other["leg"] = other["leg"], one["leg"]
    content["legs"].sort(key=lambda leg: leg["leg"])


def more_legs(content: Content, rng: random.Random) -> None:
    leg = copy.deepcopy(_leg(content, rng))
    leg["leg"] = content["legs"][-1]["leg"] + rng.randint(1, 3)
    content["legs"].append(leg)


def other_number(content: Content, rng: random.Random) -> None:
    content["legs"][-1]["leg"] += rng.randint(1, 3)


def changed_burn(content: Content, rng: random.Random) -> None:
    leg, burn = _burn(content, rng)
    vector = burn["delta_v_m_s"]
    vector[rng.randrange(3)] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-7.0, 2.0)
    _total(leg)


def lost_burn(content: Content, rng: random.Random) -> None:
    leg, burn = _burn(content, rng)
    leg["burns"].remove(burn)
    _total(leg)


def later_burn(content: Content, rng: random.Random) -> None:
    _burn(content, rng)[1]["time_s"] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, 4.0)


def other_phase(content: Content, rng: random.Random) -> None:
    _burn(content, rng)[1]["phase"] = rng.choice(["transfer", "approach", "hohmann-1"])


def other_time(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    field = rng.choice(["ready_s", "standoff_s", "arrival_s", "end_s"])
    leg[field] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-2.0, 5.0)


def later_state(content: Content, rng: random.Random) -> None:
    _state(content, rng)["time_s"] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-5.0, 4.0)


def lost_state(content: Content, rng: random.Random) -> None:
    states = _leg(content, rng)["states"]
    states.remove(rng.choice(states))


def other_event(content: Content, rng: random.Random) -> None:
    _state(content, rng)["event"] = rng.choice(["departure", "burn", "stand-off", "arrival"])


def other_name(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    names = [body["name"] for body in content["bodies"]] + ["nowhere"]
    leg[rng.choice(["origin", "destination"])] = rng.choice(names)


def other_digest(content: Content, rng: random.Random) -> None:
    which = content[rng.choice(["instance", "plan"])]
    which["sha256"] = f"{rng.getrandbits(256):064x}"


def other_instance(content: Content, rng: random.Random) -> None:
    content["instance"]["name"] += rng.choice(["-1", "x", "-n7"])


def other_planner(content: Content, rng: random.Random) -> None:
    if rng.random() < 0.5:
        content["plan"]["seed"] += rng.randint(1, 9)
    else:
        content["plan"]["method"] += "-2"


def other_field(content: Content, rng: random.Random) -> None:
    content["gravity"] = rng.choice(["two-body", "j2", "j3", "j4"])


def other_price(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    field = rng.choice(["planned_delta_v_m_s", "flown_delta_v_m_s"])
    leg[field] *= rng.uniform(0.0, 2.0)


def said_missing(content: Content, rng: random.Random) -> None:
    content["status"] = "incomplete"
    content["missing"] = [{"leg": _leg(content, rng)["leg"], "reason": "interrupted"}]


def other_kind(content: Content, rng: random.Random) -> None:
    _leg(content, rng)["kind"] = rng.choice(["short", "drift", "low-thrust"])


def other_chaser(content: Content, rng: random.Random) -> None:
    _leg(content, rng)["chaser"] = rng.choice(["chaser-0", "chaser-1", "nobody"])


def other_mass(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    thrust = leg.get("thrust") or (leg.get("tow") or {}).get("thrust")
    if thrust is None:
        leg["vented_kg"] = 10.0 ** rng.uniform(-6.0, 2.0)
    else:
        field = rng.choice(["mass_kg", "force_n", "exhaust_m_s", "propellant_kg"])
        thrust[field] *= 1.0 + rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, -1.0)


def other_approach(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    begins = leg.pop("approach_m_s", [0.0, 0.0, 0.0])
    if rng.random() < 0.7:
        begins[rng.randrange(3)] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-1.5, 2.0)
        leg["approach_m_s"] = begins


def other_tow(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    tow = leg.get(rng.choice(["tow", "tow_before"]))
    if tow is None:
        lost_leg(content, rng)
    elif rng.random() < 0.3:
        tow["released"]["position_m"][rng.randrange(3)] *= 1.0 + 10.0 ** rng.uniform(-9.0, 0.0)
    elif tow["burns"]:
        burn = rng.choice(tow["burns"])
        burn["delta_v_m_s"][rng.randrange(3)] += 10.0 ** rng.uniform(-7.0, 2.0)
    else:
        window = rng.choice(rng.choice(tow["thrust"]["arcs"])["windows_s"])
        window[rng.randrange(2)] += rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-6.0, 2.0)


def lost_tow(content: Content, rng: random.Random) -> None:
    leg = _leg(content, rng)
    for field in rng.sample(["tow", "tow_before"], 2):
        if leg.pop(field, None) is not None:
            return
    lost_leg(content, rng)


EDITS: tuple[Callable[[Content, random.Random], None], ...] = (
    reversed_velocity,
    moved_state,
    moved_state,
    moved_body,
    swapped_bodies,
    lost_leg,
    lost_last_leg,
    swapped_legs,
    more_legs,
    other_number,
    changed_burn,
    other_approach,
    lost_burn,
    later_burn,
    other_phase,
    other_time,
    other_time,
    later_state,
    lost_state,
    other_event,
    other_name,
    other_digest,
    other_instance,
    other_planner,
    other_field,
    other_price,
    said_missing,
    other_kind,
    other_chaser,
    other_mass,
    other_tow,
    lost_tow,
)


def edited(content: Content, number: int) -> tuple[str, Content]:
    """A copy with an edit that is drawn from its number, and what the edit is called."""
    rng = random.Random(f"refined {number}")
    changed, edit = copy.deepcopy(content), EDITS[number % len(EDITS)]
    edit(changed, rng)
    return edit.__name__, changed
