"""Consistency checks of an instance's parts; each raises ``ValueError`` and names the field."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..common.constants import EARTH_RADIUS_M, OBLATENESS_M2
from ..common.tolerance import common_step
from ..kernels.legs.free_burns import MOST_REVOLUTIONS
from ..kernels.orbits.ephemeris import EPOCH_S, revolution_at
from .approach import approach_of
from .bodies import Station, Target
from .chasers import AtStation, Chaser, InOrbit, TankByMass
from .disposal import DisposalCircle
from .settings import MissionSettings, Objective, TransferSettings


def check_names(
    stations: Sequence[Station], targets: Sequence[Target], chasers: Sequence[Chaser]
) -> None:
    """Names of bodies and chasers must be unique."""
    seen = set()
    named: tuple[tuple[str, Sequence[Station | Target | Chaser]], ...] = (
        ("stations", stations),
        ("targets", targets),
        ("chasers", chasers),
    )
    for field, them in named:
        for number, one in enumerate(them):
            if one.name in seen:
                raise ValueError(
                    f"field {field}[{number}].name = {one.name!r}: another body has this name; "
                    "give each its own"
                )
            seen.add(one.name)


MOST_STEPS_THAT_FALL = 2**26
"""Largest sum of falling prizes [steps]: one number holds both lost prize and cost."""


def check_falling_prizes(targets: Sequence[Target]) -> None:
    """Prizes that fall need a common step with all others, and a sum of few enough steps."""
    if all(target.prize_until is None for target in targets):
        return
    step = common_step(prize for target in targets for prize in target.prizes)
    total = math.fsum(target.greatest_prize for target in targets)
    if total and not 0.0 < total <= MOST_STEPS_THAT_FALL * step:
        has = "have no common unit" if not step else f"are {total / step:.2g} units of {step:g}"
        raise ValueError(
            f"field targets: prizes that fall with time must be whole multiples of a unit of which "
            f"all together are at most {MOST_STEPS_THAT_FALL}; these {has}: round them"
        )


def check_windows(
    targets: Sequence[Target], mission: MissionSettings, *, in_file: bool, drifts: bool
) -> None:
    """Windows are given in one place only, and a capture is no longer than its service."""
    for number, target in enumerate(targets):
        if in_file and target.windows != ((0.0, None),):
            raise ValueError(
                f"field targets[{number}]: has windows of its own, but the field windows gives "
                "them too; leave one of the two out"
            )
        if target.capture_s is None:
            continue
        stay_s = mission.service_s
        if mission.service_revolutions is not None:  # then there is an orbit, which is checked
            row = target.orbit.row(OBLATENESS_M2 if drifts else 0.0) if target.orbit else None
            if row is not None:
                stay_s = mission.service_revolutions * float(revolution_at(np.array(row), EPOCH_S))
        if stay_s is not None and target.capture_s > stay_s:
            raise ValueError(
                f"field targets[{number}].capture_s = {target.capture_s!r}: longer than the "
                f"service, {stay_s!r} s; give less, or leave it out for all of that"
            )


def check_decay(targets: Sequence[Target], chasers: Sequence[Chaser], *, drifts: bool) -> None:
    """Orbits decay only in secular motion under J2, and of objects that are not towed."""
    for number, chaser in enumerate(chasers):
        start = chaser.start
        if isinstance(start, InOrbit) and start.decay_m_per_day is not None and not drifts:
            raise ValueError(
                f"field chasers[{number}].start.decay_m_per_day = {start.decay_m_per_day!r}: "
                'nothing decays in two-body motion; leave it out, or write dynamics "j2"'
            )
    for number, target in enumerate(targets):
        if target.decay_m_per_day is not None and not drifts:
            raise ValueError(
                f"field targets[{number}].decay_m_per_day = {target.decay_m_per_day!r}: nothing "
                'decays in two-body motion; leave it out, or write dynamics "j2"'
            )
        if target.decay_m_per_day and target.removal == "tow":
            raise ValueError(
                f"field targets[{number}].decay_m_per_day = {target.decay_m_per_day!r}: tows of "
                "decaying objects are not planned; leave it out, as `import --ephemerides` does, "
                "or choose another removal"
            )


def check_stations(stations: Sequence[Station], chasers: Sequence[Chaser]) -> None:
    """Stations named by chasers must exist, and limited propellant must be measurable by mass."""
    known = [station.name for station in stations]
    for number, chaser in enumerate(chasers):
        for field in ("start", "end"):
            place = getattr(chaser, field)
            if isinstance(place, AtStation) and place.station not in known:
                listed = ", ".join(map(repr, known)) or "there is none"
                raise ValueError(
                    f"field chasers[{number}].{field}.station = {place.station!r}: unknown "
                    f"station; name one of the stations: {listed}"
                )
    by_delta_v = [chaser.name for chaser in chasers if not isinstance(chaser.tank, TankByMass)]
    for number, station in enumerate(stations):
        if station.max_propellant_kg is not None and by_delta_v:
            raise ValueError(
                f"field stations[{number}].max_propellant_kg = {station.max_propellant_kg!r}: the "
                f"tank of {by_delta_v[0]!r} is given in ΔV, without masses; give its "
                "dry_mass_kg, propellant_kg and isp_s, or limit max_refuellings"
            )


def check_separation(chasers: Sequence[Chaser], mission: MissionSettings) -> None:
    """Missions that are kept apart each begin with a launch at a time that the plan chooses."""
    there = [number for number, chaser in enumerate(chasers) if not chaser.is_launched]
    if mission.mission_separation_s is not None and there:
        raise ValueError(
            f"field mission.mission_separation_s = {mission.mission_separation_s!r}: it keeps "
            f"launches apart from earlier missions, but chasers[{there[0]}] starts in space; "
            'write its start "anywhere", or leave the separation out'
        )


def check_launches(
    chasers: Sequence[Chaser], mission: MissionSettings, *, is_given: bool, drifts: bool
) -> None:
    """Launches into orbits need drifting nodes, the model's connections and times of their own."""
    for number, chaser in enumerate(chasers):
        for wrong, why in (
            (not drifts, 'needs planes that drift; write dynamics "j2"'),
            (is_given, "needs the model's legs, but connections are given; leave one of them out"),
            (
                mission.launch_separation_s is not None,
                "the plan chooses its time, mission.launch_separation_s its order; leave that "
                "field out, and give available_s",
            ),
        ):
            if chaser.launch is not None and wrong:
                raise ValueError(f"field chasers[{number}].start.launch: {why}")


def check_thrust(
    chasers: Sequence[Chaser], transfer: TransferSettings, *, zones: bool, drifts: bool
) -> None:
    """Low thrust needs drifting nodes, the model's connections, and no keep-out zones."""
    for number, chaser in enumerate(chasers):
        if chaser.thrust_n is None:
            continue
        stated = f"field chasers[{number}].thrust_n = {chaser.thrust_n!r}"
        if transfer.given is not None:
            raise ValueError(f"{stated}: connections are given, whatever the thrust; leave it out")
        if not drifts or not transfer.max_drift_s > 0.0:
            raise ValueError(
                f"{stated}: transfers of low thrust take days to months, in which nodes drift; "
                'write dynamics "j2", and give transfer.max_drift_s'
            )
        if zones:
            raise ValueError(
                f"{stated}: spirals cannot be planned around keep-out zones; leave "
                "keep_out_zones out"
            )


def check_burns(transfer: TransferSettings, *, zones: bool) -> None:
    """Refuse free burns of more phasing revolutions than can be priced, or with keep-out zones."""
    if transfer.burns != "free":
        return
    if transfer.max_phasing_revolutions > MOST_REVOLUTIONS:
        raise ValueError(
            f"field transfer.max_phasing_revolutions = {transfer.max_phasing_revolutions!r}: free "
            f'burns can be priced up to {MOST_REVOLUTIONS}; write at most that, or burns "sequence"'
        )
    if zones:
        raise ValueError(
            "field keep_out_zones: the paths of free burns are not checked against zones; leave "
            'zones out, or write transfer.burns "sequence"'
        )


def check_expense(chasers: Sequence[Chaser], objective: Objective) -> None:
    """Minimising the expense requires a chaser that states one."""
    if objective.cost == "expense" and all(chaser.expense is None for chaser in chasers):
        raise ValueError(
            'field objective.cost = "expense": no chaser has one; give chasers[0] an expense, as '
            '{"fixed": 1.0}, or write "delta-v"'
        )


def check_orbits(
    stations: Sequence[Station],
    targets: Sequence[Target],
    mission: MissionSettings,
    *,
    is_given: bool,
) -> None:
    """All bodies need an orbit, unless connections are given."""
    fields: tuple[tuple[str, Sequence[Station | Target], str, str], ...] = (
        ("stations", stations, "refuel_revolutions", "write 0.0"),
        ("targets", targets, "service_revolutions", "give service_s instead"),
    )
    for field, bodies, time, instead in fields:
        for number, body in enumerate(bodies):
            if body.orbit is not None:
                continue
            if not is_given:
                raise ValueError(f"field {field}[{number}].orbit: missing; add it")
            stated = getattr(mission, time)
            if stated:
                raise ValueError(
                    f"field mission.{time} = {stated!r}: {body.name!r} has no orbit and so no "
                    f"period; {instead}"
                )


MOST_KEEP_OUT = 0.75
"""Largest keep-out radius, as a share of the smallest distance at the stand-off: under J2, a chaser
that waits there after a missed burn comes nearer to the target."""

ROUNDEST = 0.02
"""Largest eccentricity of a body at which safety ellipses are flown."""


def check_approach(transfer: TransferSettings, bodies: Sequence[Station | Target]) -> None:
    """The ellipse must fit between the target and the stand-off, and paths must be known."""
    if transfer.approach == "half-lap":
        return
    if transfer.given is not None:
        raise ValueError(
            f'field transfer.approach = "{transfer.approach}": the paths of given connections are '
            "not known; leave it out"
        )
    if transfer.max_drift_s > 0.0:
        raise ValueError(
            f'field transfer.approach = "{transfer.approach}": costs of drift legs do not include '
            "it yet; leave transfer.max_drift_s out"
        )
    approach_of(transfer)
    for body in bodies:
        assert body.orbit is not None
        e = body.orbit.eccentricity
        if e > ROUNDEST:
            raise ValueError(
                f'field transfer.approach = "{transfer.approach}": {body.name!r} has '
                f"eccentricity {e:.3g}, more than {ROUNDEST}; leave it out"
            )
        most = MOST_KEEP_OUT * transfer.standoff_m * (1.0 - e) / (1.0 + e)
        if transfer.keep_out_m > most:
            raise ValueError(
                f"field transfer.keep_out_m = {transfer.keep_out_m!r}: must be at most {most:.0f} "
                f"m, {MOST_KEEP_OUT} standoff_m (1 − e) / (1 + e) of {body.name!r}"
            )


def check_removals(
    targets: Sequence[Target],
    chasers: Sequence[Chaser],
    mission: MissionSettings,
    transfer: TransferSettings,
    *,
    zones: bool,
) -> None:
    """Towed objects need a mass and an orbit above the disposal orbit; chasers need masses, too.

    ``check_orbits`` has seen to orbits where connections are the model's.
    """
    towed = [(number, target) for number, target in enumerate(targets) if target.service.is_flown]
    if not towed:
        return
    field = f'field targets[{towed[0][0]}].removal = "tow"'
    if transfer.given is not None:
        raise ValueError(
            f'{field}: given connections hold no costs from the disposal orbit; write "visit" or '
            '"kit"'
        )
    if zones:
        raise ValueError(
            f"{field}: tows cannot be planned around keep-out zones; leave keep_out_zones out, "
            'or write "visit" or "kit"'
        )
    for chaser_number, chaser in enumerate(chasers):
        if not isinstance(chaser.tank, TankByMass):
            raise ValueError(
                f"{field}: the cost of a tow depends on masses, but the tank of "
                f"chasers[{chaser_number}] is given in ΔV; give its dry_mass_kg, propellant_kg and "
                "isp_s"
            )
    for number, target in towed:
        disposal = target.disposal or mission.disposal
        if disposal is None:
            raise ValueError(
                f'field targets[{number}].removal = "tow": no disposal orbit; give mission.disposal'
            )
        if target.mass_kg is None:
            raise ValueError(f"field targets[{number}].mass_kg: missing, and it is towed; give it")
        place = "mission" if target.disposal is None else f"targets[{number}]"
        spirals = any(chaser.thrust_n is not None for chaser in chasers)
        if not isinstance(disposal, DisposalCircle):
            if spirals:
                raise ValueError(
                    f"field {place}.disposal.perigee_m = {disposal.perigee_m!r}: low thrust tows "
                    "to circles only; give circle_m"
                )
            continue
        altitude = disposal.circle_m
        stated = f"field {place}.disposal.circle_m = {altitude!r}"
        if not transfer.min_altitude_m <= altitude <= transfer.max_altitude_m:
            raise ValueError(
                f"{stated}: must be within the altitude limits of transfers, "
                f"{transfer.min_altitude_m!r} to {transfer.max_altitude_m!r}"
            )
        assert target.orbit is not None
        above = target.orbit.semi_major_axis_m - EARTH_RADIUS_M
        if altitude >= above and spirals:
            raise ValueError(
                f"{stated}: must be below {target.name!r}, which low thrust tows from {above:.0f} m"
            )
