"""The table of facts and rules: every field of an instance, and when each rule binds.

A *fact* (a name, an orbit, the epoch) limits nothing. Every other field belongs to one rule or
more. Who follows which rule is said by each follower itself (:mod:`.support`), never here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from .tours import tour_obstacle

if TYPE_CHECKING:  # specifications of methods are read before anything is loaded
    from .chasers import Chaser
    from .instance import Instance


class Rule(NamedTuple):
    """A rule.

    Attributes
    ----------
    fields : tuple of str
        Fields that state it, as paths in the file; messages name the first one.
    binds : callable
        Whether it binds an instance; a text says where it does.
    cure : str
        What helps an instance where nobody follows it, as the end of a sentence.
    """

    fields: tuple[str, ...]
    binds: Callable[[Instance], bool | str | None]
    cure: str = "leave it out"


def _at(place: str, fields: str) -> tuple[str, ...]:
    """Paths of the fields of a record."""
    return tuple(f"{place}.{field}" for field in fields.split())


ORBIT = (
    "semi_major_axis_m eccentricity inclination_deg raan_deg argument_of_perigee_deg "
    "true_anomaly_deg"
)

FACTS = frozenset(
    (
        "format",
        "name",
        "epoch",
        "frame",
        "stations",
        "targets",
        "mission",
        "transfer",
        "objective",
        *_at("frame", "name axes_epoch"),
        *_at("stations[]", "name orbit object_id"),
        *_at("stations[].orbit", ORBIT),
        *_at("targets[]", "name orbit mass_kg object_id fit success area_to_mass_m2_kg"),
        *_at("targets[].orbit", ORBIT),
        "targets[].fit.eccentricity_offset",
        "chasers[].name",
    )
)
"""Fields that limit nothing. The chance of a capture is for rehearsals, which draw from it."""


CHANCES = frozenset(
    (
        "format",
        "legs",
        "service_s",
        "capture",
        "gone",
        "launches",
        "tanks",
        "targets",
        *_at("legs", "delta_v_factor kinds"),
        *_at("legs.delta_v_factor", "lognormal_sigma least most"),
        *_at("legs.kinds[]", "lognormal_sigma least most"),
        *_at("service_s", "factor added"),
        *_at("service_s.factor", "lognormal_sigma least most"),
        *_at("service_s.added", "chance mean_s most_s"),
        *_at("capture", "success tries"),
        *_at("launches", "slip_s chasers"),
        *_at("launches.slip_s", "chance mean_s most_s"),
        *_at("launches.chasers[]", "chance mean_s most_s"),
        *_at("tanks", "least most"),
        *_at("targets[]", "delta_v_factor service_s success tries gone"),
        *_at("targets[].delta_v_factor", "lognormal_sigma least most"),
        *_at("targets[].service_s", "factor added"),
        *_at("targets[].service_s.factor", "lognormal_sigma least most"),
        *_at("targets[].service_s.added", "chance mean_s most_s"),
    )
)
"""Fields of an uncertainty file, which everything that reads one follows."""


def _always(_: Instance) -> bool:
    return True


def _chasers(binds: Callable[[Chaser], bool]) -> Callable[[Instance], bool]:
    return lambda instance: any(map(binds, instance.chasers))


def _is_set(part: str, field: str) -> Callable[[Instance], bool]:
    """Whether a field of some station, target or chaser is set."""
    return lambda instance: any(getattr(one, field) is not None for one in getattr(instance, part))


def most_targets(instance: Instance, chaser: Chaser) -> int | None:
    """Maximum number of targets of a chaser; ``None`` if unlimited."""
    limits = [chaser.max_targets]
    if all(target.service.takes_kit for target in instance.targets):
        limits.append(chaser.kits)
    return min((limit for limit in limits if limit is not None), default=None)


def _limits_targets(instance: Instance) -> bool:
    most = [most_targets(instance, chaser) for chaser in instance.chasers]
    return any(each is not None and each < len(instance.targets) for each in most)


def _limits_visits(instance: Instance) -> bool:
    most = [chaser.max_visits_between_refuels for chaser in instance.chasers]
    return any(each is not None and each < len(instance.targets) for each in most)


def _kits_count(instance: Instance) -> bool:
    """Whether kits weigh something, or are fewer than some targets that take one."""
    wanted = sum(target.service.takes_kit for target in instance.targets)
    return wanted > 0 and any(
        chaser.kit_mass_kg > 0.0
        or (chaser.kits is not None and chaser.kits < wanted < len(instance.targets))
        for chaser in instance.chasers
    )


def _has_functions(instance: Instance) -> bool:
    return instance.transfer.given is not None and instance.transfer.given.functions is not None


def _is_of_tours(instance: Instance) -> bool:
    missions_s = instance.mission.mission_separation_s
    return instance.transfer.max_leg_s is not None or missions_s is not None


def _beyond_tours(instance: Instance) -> str | None:
    return tour_obstacle(instance) if _is_of_tours(instance) else None


def _functions_of_several(instance: Instance) -> bool:
    return _has_functions(instance) and len(instance.chasers) > 1


def _functions_with_cargo(instance: Instance) -> bool:
    words = (CAMPAIGNS | {"visits between refuellings"}) - {"several chasers"}
    return _has_functions(instance) and any(RULES[word].binds(instance) for word in words)


def _falling_beyond_lists(instance: Instance) -> bool:
    return any(target.prize_until for target in instance.targets) and (
        _has_functions(instance) or _is_of_tours(instance)
    )


RULES = {
    "duration": Rule(("mission.duration_s",), _always),
    "services": Rule(_at("mission", "service_revolutions service_s"), _always),
    "refuelling": Rule(("mission.refuel_revolutions",), lambda i: bool(i.stations)),
    "transfers": Rule(
        _at(
            "transfer",
            (
                "first_leg_fraction standoff_m max_phasing_revolutions "
                "min_altitude_m max_altitude_m delta_v_resolution_m_s departure_spacing_s"
            ),
        ),
        _always,
    ),
    "drift": Rule(
        _at("transfer", "max_drift_s drift_step_s"), lambda i: i.transfer.max_drift_s > 0.0
    ),
    "fixed planes": Rule(("dynamics",), lambda i: i.dynamics == "two-body", 'write "j2"'),
    "ephemerides": Rule(
        ("ephemerides", *_at("ephemerides", "kind file sha256")),
        lambda i: i.ephemerides is not None,
        "import without ephemerides",
    ),
    "given connections": Rule(
        ("transfer.given", *_at("transfer.given", "file sha256")),
        lambda i: i.transfer.given is not None,
        "leave connections to the model",
    ),
    "functions of time": Rule(
        _at("transfer.given", "functions functions_sha256"),
        _has_functions,
        "give connections in place of functions",
    ),
    "bodies without an orbit": Rule(
        ("targets[].orbit", "stations[].orbit"), lambda i: not i.has_orbits, "give orbits"
    ),
    "prizes": Rule(("targets[].prize",), _always),
    "required targets": Rule(("targets[].required",), lambda i: any(t.required for t in i.targets)),
    "windows": Rule(
        ("targets[].window_s",), lambda i: any(t.window_s != (0.0, None) for t in i.targets)
    ),
    "capture windows": Rule(
        (
            *("targets[].windows_s", "targets[].capture_s"),
            *("windows", "windows.file", "windows.sha256"),
        ),
        lambda i: (
            i.windows is not None
            or any(t.windows_s is not None or t.capture_s is not None for t in i.targets)
        ),
        "give one window_s",
    ),
    "prizes that fall": Rule(("targets[].prize_until",), _is_set("targets", "prize_until")),
    "decay": Rule(
        ("targets[].decay_m_per_day", "chasers[].start.decay_m_per_day"), lambda i: i.decays
    ),
    "number of stations": Rule(
        ("stations",), lambda i: len(i.stations) != 1, "give exactly one station"
    ),
    "starts": Rule(
        ("chasers[].start", "chasers[].start.station"), _chasers(lambda c: c.starts_at_station)
    ),
    "start orbits": Rule(
        ("chasers[].start", "chasers[].start.orbit", *_at("chasers[].start.orbit", ORBIT)),
        _chasers(lambda c: not (c.starts_at_station or c.is_launched or c.launch)),
        "start at a station",
    ),
    "launches into orbits": Rule(
        (
            *("chasers[].start", "chasers[].start.launch"),
            *_at("chasers[].start.launch", "altitude_m inclination_deg launcher"),
        ),
        _chasers(lambda c: c.launch is not None),
        'start "anywhere"',
    ),
    "launches": Rule(
        ("chasers[].start", "mission.launch_separation_s"),
        _chasers(lambda c: c.is_launched),
        "start at a station",
    ),
    "late availability": Rule(
        ("chasers[].available_s",), _chasers(lambda c: c.available_s[0] > 0.0)
    ),
    "end of availability": Rule(
        ("chasers[].available_s",), _chasers(lambda c: c.available_s[1] is not None)
    ),
    "ends": Rule(
        ("chasers[].end", "chasers[].end.station"), _chasers(lambda c: c.end != "anywhere")
    ),
    "most targets": Rule(("chasers[].max_targets", "chasers[].kits"), _limits_targets),
    "visits between refuellings": Rule(("chasers[].max_visits_between_refuels",), _limits_visits),
    "tanks": Rule(
        ("chasers[].tank", *_at("chasers[].tank", "delta_v_m_s dry_mass_kg propellant_kg isp_s")),
        _always,
    ),
    "tanks not full": Rule(
        _at("chasers[].tank", "initial_delta_v_m_s initial_propellant_kg"),
        _chasers(lambda c: c.spent_m_s > 0.0),
    ),
    "low thrust": Rule(
        ("chasers[].thrust_n", "chasers[].duty_cycle", "transfer.mass_class"),
        lambda i: i.has_low_thrust,
    ),
    "keep-out zones": Rule(
        ("keep_out_zones", *_at("keep_out_zones[]", "min_altitude_m max_altitude_m start_s end_s")),
        lambda i: bool(i.keep_out_zones),
    ),
    "cost": Rule(
        _at("objective", "cost time_m_s_per_day"),
        lambda i: i.objective.cost == "duration",
        'write "delta-v"',
    ),
    "several chasers": Rule(("chasers",), lambda i: len(i.chasers) > 1, "keep only one"),
    "kits": Rule(("chasers[].kits", "chasers[].kit_mass_kg", "targets[].removal"), _kits_count),
    "tows": Rule(
        (
            *("targets[].removal", "targets[].disposal", "mission.disposal"),
            *("targets[].disposal.circle_m", "mission.disposal.circle_m"),
        ),
        lambda i: any(target.service.is_flown for target in i.targets),
        "choose another removal",
    ),
    "tanks not full by mass": Rule(
        ("chasers[].tank.initial_propellant_kg",), _chasers(lambda c: c.lacks_by_mass)
    ),
    "limited refuellings": Rule(
        ("stations[].max_refuellings",), _is_set("stations", "max_refuellings")
    ),
    "limited propellant": Rule(
        ("stations[].max_propellant_kg",), _is_set("stations", "max_propellant_kg")
    ),
    "expense": Rule(
        (
            "objective.cost",
            "chasers[].expense",
            *_at("chasers[].expense", "fixed per_kg per_kg_squared"),
        ),
        lambda i: i.objective.cost == "expense",
        'write "delta-v"',
    ),
    "longest leg": Rule(("transfer.max_leg_s",), lambda i: i.transfer.max_leg_s is not None),
    "missions apart": Rule(
        ("mission.mission_separation_s",), lambda i: i.mission.mission_separation_s is not None
    ),
    "safety ellipse": Rule(
        _at("transfer", "approach keep_out_m approach_revolutions inspection_revolutions"),
        lambda i: i.transfer.approach == "safety-ellipse",
        'write "half-lap"',
    ),
    "free burns": Rule(
        ("transfer.burns",), lambda i: i.transfer.burns == "free", 'write "sequence"'
    ),
    "disposal by perigee": Rule(
        ("mission.disposal.perigee_m", "targets[].disposal.perigee_m"),
        lambda i: any(
            target.service.is_flown and hasattr(i.disposal_of(target), "perigee_m")
            for target in i.targets
        ),
        'give {"circle_m": ALTITUDE}',
    ),
    "lifetimes": Rule(
        ("mission.max_lifetime_years",), lambda i: i.mission.max_lifetime_years is not None
    ),
    "controlled re-entry": Rule(
        ("mission.max_uncontrolled_kg",), lambda i: i.mission.max_uncontrolled_kg is not None
    ),
    "end of life": Rule(
        ("chasers[].end_of_life_m_s",), _chasers(lambda c: c.end_of_life_m_s is not None)
    ),
    # What some follow each alone, and not together.
    "rules of tours beyond tours": Rule(
        ("transfer.max_leg_s", "mission.mission_separation_s"),
        _beyond_tours,
        "see docs/campaigns.md, or leave it out",
    ),
    "functions of time for several chasers": Rule(
        ("transfer.given.functions",), _functions_of_several, "keep one chaser"
    ),
    "functions of time beyond chasers without cargo": Rule(
        ("transfer.given.functions",),
        _functions_with_cargo,
        "give connections in place of functions",
    ),
    "prizes that fall beyond lists of connections": Rule(
        ("targets[].prize_until",), _falling_beyond_lists
    ),
}
"""All rules, by the words that followers declare."""

# Bundles of words, as they were in 1.0. A rule that came later is in none of them.

FIRST = frozenset(
    {
        "duration",
        "services",
        "refuelling",
        "transfers",
        "drift",
        "fixed planes",
        "ephemerides",
        "given connections",
        "bodies without an orbit",
        "prizes",
        "required targets",
        "windows",
        "prizes that fall",
        "decay",
        "number of stations",
        "starts",
        "start orbits",
        "launches",
        "late availability",
        "end of availability",
        "ends",
        "most targets",
        "tanks",
        "tanks not full",
        "low thrust",
        "keep-out zones",
        "cost",
    }
)
"""Rules that every method of 1.0 followed, assumed of a planner that declares none."""

CARGO = frozenset({"kits", "tows", "tanks not full by mass"})

SUPPLIES = frozenset({"limited refuellings", "limited propellant"})

CAMPAIGNS = CARGO | SUPPLIES | {"several chasers", "expense"}
"""Rules that need more than one route in a plan."""

TOURS = frozenset({"longest leg", "missions apart"})
"""Where to be earlier is not always better (docs/model.md section 5.5): planned in tours alone."""

TOGETHER = frozenset(
    {
        "rules of tours beyond tours",
        "functions of time beyond chasers without cargo",
        "prizes that fall beyond lists of connections",
    }
)
"""Rules that planners follow one at a time only; judges follow them together as well."""

RELEASES = frozenset({"disposal by perigee", "lifetimes", "controlled re-entry"})
"""Requirements on released objects."""

MODELLED = frozenset({"free burns", "safety ellipse", "launches into orbits"})
"""Rules built into the model's own connections: all methods that use these follow them."""

JUDGED = (
    FIRST
    | CAMPAIGNS
    | TOURS
    | TOGETHER
    | RELEASES
    | MODELLED
    | {"functions of time", "functions of time for several chasers", "visits between refuellings"}
    | {"capture windows", "end of life"}
)
"""What both judges state once more, and all follow that make, hold, compare and show what planners
are told and plan: a rule comes in here by hand, with its judges."""

PLAYED = (FIRST | MODELLED | {"visits between refuellings", "capture windows"}) - {
    "bodies without an orbit",
    "prizes that fall",
    "number of stations",
    "start orbits",
    "launches",
    "launches into orbits",
    "late availability",
    "ends",
    "most targets",
    "tanks not full",
}
"""What the environment and its policies play. Episodes begin at the only station, at t = 0, may
service any number of targets, know no kits and no tows, and may end anywhere."""


@dataclass(frozen=True)
class Follower:
    """A reader of instances, and the rules that it follows.

    Attributes
    ----------
    name : str
        Begins the sentence.
    follows : frozenset of str
        Words of :data:`RULES`.
    instead : str
        What to do instead, as the end of a sentence, where that is not the rule's own cure.
    """

    name: str
    follows: frozenset[str]
    instead: str = ""

    def __post_init__(self) -> None:
        check_words(self.name, self.follows)


def check_words(name: str, follows: Collection[str]) -> None:
    """Raise ``ValueError`` for a word that is no rule."""
    strange = sorted(set(follows) - RULES.keys())
    if strange:
        raise ValueError(
            f"{name} follows {strange[0]!r}, which is no rule of adr_opt.problem.rules"
        )
