"""Construction of an instance from a catalogue."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import ValidationError

from ...common.constants import DAY_S, EARTH_RADIUS_M
from ...common.errors import InputError
from ...common.sentences import sentence
from ...common.wording import counted
from ...plan.kit_sizes import with_sized_kits
from ...plan.plane_drift import drift_warning
from ...problem.bodies import Station
from ...problem.chasers import AtStation, InOrbit
from ...problem.frame import Frame
from ...problem.instance import Instance
from ...problem.least_time import too_short
from ...problem.orbit import Orbit
from ...problem.settings import MissionSettings, TransferSettings
from ...problem.transfer_sizes import burns_for, transfers_for
from .crew import Crew
from .demands import Demands, check_musts, filled, targets_of, told_left_out, told_masses
from .drag import drag_warning, end_windows
from .filters import Filters
from .finding import ANY, Finder
from .propagation import FLOAT, mean_elements, true_anomaly
from .records import Catalogue, Dropped, ElementSet
from .records import shown as shown_name
from .selection import densest, named, nearest, parse_orbit, within_limits

FAR_DAYS = 7.0
"""Age of elements at the epoch that causes a warning: SGP4 loses kilometres a day [days]."""

AT_ANOTHER_EPOCH = ("far-epoch", "sgp4-error")
"""Reasons for omitting an object that another epoch might avoid."""

NO_FILTERS = ("malformed", "duplicate", "not-sgp4", "decayed", *AT_ANOTHER_EPOCH)
"""Reasons for omitting objects that are not due to a filter."""

PLACED = "at the densest plane"
LAUNCHED = "at the first target of each chaser"
LAUNCHED_INTO = "with a launch of each chaser, in the plane of its first target's node"

MANY_TARGETS = 1000
"""Number of targets that causes a warning: the timetable grows with its square."""


def _place(instance: Instance, placed: str) -> str:
    """Where chasers start, in words."""
    if instance.stations or not instance.chasers[0].awaits_launch:
        return placed
    return LAUNCHED if instance.chasers[0].is_launched else LAUNCHED_INTO


@dataclass(frozen=True)
class MissionOutline:
    """The mission made from a catalogue, without its bodies and chasers.

    Attributes
    ----------
    name : str, optional
        Of the instance.
    epoch : datetime, optional
        With its time zone; by default the latest epoch of the elements.
    duration_s : float
        Of the mission.
    dynamics : {"j2", "two-body"}
        How bodies move after the epoch.
    transfer : TransferSettings or mapping, optional
        Or some of its fields; what is left open follows from the mission under J2
        (:func:`adr_opt.problem.transfer_sizes.transfers_for`), else from the defaults of the file.
    refuelling : bool
        Whether there is a station; else the chaser starts in its place, without refuelling.
    """

    name: str | None = None
    epoch: datetime | None = None
    duration_s: float = 7.0 * DAY_S
    dynamics: Literal["two-body", "j2"] = "j2"
    transfer: TransferSettings | Mapping[str, float | str | None] | None = None
    refuelling: bool = True

    def __post_init__(self) -> None:
        epoch = self.epoch
        if epoch is not None and epoch.tzinfo is None:
            raise InputError(f"epoch {epoch.isoformat()}: must say its time zone; add Z for UTC")

    def transfer_settings(self, orbits: Sequence[Orbit]) -> TransferSettings:
        """Transfer settings: as requested, and otherwise derived from the mission."""
        wanted = self.transfer
        if isinstance(wanted, TransferSettings):
            return wanted
        given: dict[str, Any] = {
            name: value for name, value in (wanted or {}).items() if value is not None
        }
        whatever = {name: given.pop(name) for name in WHATEVER_DRIFTS if name in given}
        made = TransferSettings().replace(**given)
        if self.dynamics == "j2":
            made = transfers_for(self.duration_s, orbits=orbits, **given)
        return made.replace(**{"burns": burns_for(orbits), **whatever})


WHATEVER_DRIFTS = ("burns", "approach", "keep_out_m")
"""Fields of transfers that sizes of the grid do not depend on."""

A_WEEK = MissionOutline()


@dataclass(frozen=True)
class Imported:
    """An instance made from a catalogue, with a record of how it was made.

    Attributes
    ----------
    instance : Instance
    read : int
        Good records, duplicates not counted.
    dropped : tuple of Dropped
        Everything that is not in the instance, with its reason.
    warnings : tuple of str
    station : str
        Where the station is from, or the orbit in which the chaser starts where there is none.
    records : dict
        Element sets of the bodies by name.
    """

    instance: Instance
    read: int
    dropped: tuple[Dropped, ...]
    warnings: tuple[str, ...]
    station: str
    records: Mapping[str, ElementSet] = field(default_factory=dict)

    @property
    def home(self) -> Orbit | None:
        """Orbit of the station, or of the chaser's start; None if the chaser is launched."""
        chasers, stations = self.instance.chasers, self.instance.stations
        nowhere = not stations and chasers[0].awaits_launch
        return None if nowhere else self.instance.body_orbits[0]

    @property
    def counts(self) -> dict[str, int]:
        """Number of omitted objects by reason."""
        return dict(Counter(drop.reason for drop in self.dropped))

    def to_dict(self) -> dict[str, Any]:
        """The record as JSON data, without the instance."""
        content = self.instance.model_dump(mode="json", include={"name", "epoch"})
        return {
            "instance": content["name"],
            "epoch": content["epoch"],
            "elements": "mean elements of SGP4, TEME of the epoch",
            "read": self.read,
            "targets": len(self.instance.targets),
            "dynamics": self.instance.dynamics,
            "transfer": self.instance.transfer.model_dump(mode="json"),
            "chasers": [chaser.name for chaser in self.instance.chasers],
            "station" if self.instance.stations else "start": {
                "name": self.instance.names[0],
                "from": self.station,
                "orbit": None if self.home is None else self.home.model_dump(mode="json"),
            },
            "dropped_counts": self.counts,
            "dropped": [drop.to_dict() for drop in self.dropped],
            "warnings": list(self.warnings),
        }


def to_instance(
    catalogue: Catalogue | Iterable[ElementSet],
    *,
    filters: Filters | None = None,
    max_targets: int | None = None,
    station: str | None = None,
    skip_bad: bool = False,
    mission: MissionOutline = A_WEEK,
    crew: Crew | None = None,
    demands: Demands | None = None,
) -> Imported:
    """Propagate a catalogue to one epoch, filter it, and make an instance.

    Parameters
    ----------
    catalogue : Catalogue or records
    filters : Filters, optional
    max_targets : int, optional
        Maximum number of targets, those with planes nearest to the station's first.
    station : str, optional
        ``ALTITUDE_KM,INCLINATION,RAAN[,U]``, or an object by number or name, which is then no
        target; by default the densest plane among the objects that pass the filters.
    skip_bad : bool
        Leave out objects that SGP4 cannot bring to the epoch; else the first one is an error.
    mission : MissionOutline
    crew : Crew, optional
        The chasers; by default one with a tank of 3000 m/s.
    demands : Demands, optional
        What is asked of some objects.

    Returns
    -------
    Imported
        Orbits are SGP4's mean elements at the epoch, in TEME.

    Raises
    ------
    InputError
        SGP4 fails for an object, no object is left, or a value is out of range.
    MissingExtra
        sgp4 is not installed.
    """
    filters = filters or Filters()
    records = tuple(catalogue)
    dropped = list(catalogue.dropped) if isinstance(catalogue, Catalogue) else []
    if max_targets is not None and max_targets < 1:
        raise InputError(f"max targets = {max_targets}: must be at least 1")

    told = None if station is None else parse_orbit(station)
    host = None
    if station is not None and told is None:
        instead = f"{ANY}, or ALTITUDE_KM,INCLINATION,RAAN"
        host = records[Finder(records).one(station, "--station", instead)]
    demands = demands or Demands()
    choice = demands.choice(records, host)
    candidates = named(records, host, filters, dropped, choice)
    if not candidates:
        raise _nothing_left(len(records), dropped, _names_told(records))
    moved = candidates if host is None else [host, *candidates]
    epoch = mission.epoch or max(record.epoch for record in moved)
    elements, failed = mean_elements(moved, epoch)
    if failed and (not skip_bad or (host is not None and np.isnan(elements[0, 0]))):
        raise InputError(_failed_sentence(failed, epoch, host))
    dropped += failed
    if host is not None:
        told, elements = elements[0], elements[1:]
    rows = within_limits(candidates, elements, filters, dropped, choice)
    if rows.size == 0:
        raise _nothing_left(len(records), dropped, filters.told_ranges(elements))
    place = told if told is not None else densest(elements[rows])
    if max_targets is not None and rows.size > max_targets:
        rows = nearest(candidates, elements, rows, place, max_targets, dropped, choice)

    targets = [candidates[row] for row in rows]
    home = host.label if host else "station"
    check_musts(choice, targets, candidates, dropped)
    asked = demands.of(targets, records, choice)
    crew, refuelling = crew or Crew(), mission.refuelling
    fields, falling = end_windows(
        filled(asked, targets, records, crew, by_criticality=demands.by_criticality),
        targets,
        host,
        epoch,
        mission.duration_s,
    )
    instance = _instance(
        replace(mission, name=mission.name or _default_name(targets, len(rows)), epoch=epoch),
        Station(name=home, object_id=host.designator if host else None) if refuelling else None,
        place,
        unique([record.label for record in targets], {home} if refuelling else set()),
        _orbits(elements[rows]),
        crew,
        fields,
    )
    placed = f"at {host.label}" if host else "as told" if told is not None else PLACED
    return Imported(
        instance=instance,
        read=len(records),
        dropped=tuple(dropped),
        warnings=(
            *((told_masses(targets, fields),) if demands.by_criticality else ()),
            *((told_left_out(asked.left_out),) if asked.left_out else ()),
            *((falling,) if falling else ()),
            *_warnings(targets, host, instance, epoch),
        ),
        station=_place(instance, placed),
        records={
            **({home: host} if host and refuelling else {}),
            **{one.name: record for one, record in zip(instance.targets, targets, strict=True)},
        },
    )


def _orbits(elements: FLOAT) -> list[Orbit]:
    degrees = np.degrees(elements[:, 2:5])
    true = np.degrees(true_anomaly(elements[:, 5], elements[:, 1]))
    # Rounded far below what the elements are good for, so that libraries which differ in the
    # last bit of a sine give the same file: to 1 mm, 1e-9 and 1e-8 degrees (1 mm along the orbit).
    return [
        Orbit(
            semi_major_axis_m=round(float(a), 3),
            eccentricity=round(float(e), 9),
            inclination_deg=round(float(i), 8),
            raan_deg=round(float(o) % 360.0, 8) % 360.0,
            argument_of_perigee_deg=round(float(w) % 360.0, 8) % 360.0,
            true_anomaly_deg=round(float(v) % 360.0, 8) % 360.0,
        )
        for (a, e), (i, o, w), v in zip(elements[:, :2], degrees, true, strict=True)
    ]


def _instance(
    mission: MissionOutline,
    station: Station | None,
    place: FLOAT,
    names: Sequence[str],
    orbits: Sequence[Orbit],
    crew: Crew,
    fields: Mapping[int, Mapping[str, Any]],
) -> Instance:
    """The instance of a mission with a known name and epoch."""
    transfer = mission.transfer_settings(orbits)
    assert mission.name is not None
    assert mission.epoch is not None
    epoch = mission.epoch.astimezone(UTC)
    try:
        (home,) = _orbits(place[None, :])
        stations: tuple[Station, ...] = ()
        start: AtStation | InOrbit = InOrbit(orbit=home)
        if station is not None:
            stations = (station.replace(orbit=home),)
            start = AtStation(station=station.name)
        made = Instance(
            name=mission.name,
            epoch=epoch,
            # SGP4 gives elements in TEME of date: at the epoch those of the epoch.
            frame=Frame(name="TEME", axes_epoch=epoch),
            stations=stations,
            targets=targets_of(names, orbits, crew, fields),
            chasers=crew.chasers(
                start, [*(station.name for station in stations), *names], mission.duration_s
            ),
            mission=MissionSettings(
                duration_s=float(mission.duration_s),
                service_s=crew.service_s,
                launch_separation_s=crew.separation_s,
                disposal=None if crew.towed_kg is None else crew.disposal,
                max_lifetime_years=crew.max_lifetime_years,
                max_uncontrolled_kg=crew.max_uncontrolled_kg,
            ),
            objective=crew.objective,
            dynamics=mission.dynamics,
            transfer=transfer,
        )
    except ValidationError as error:
        raise InputError(sentence(error)) from None
    return made if crew.kit_isp_s is None else with_sized_kits(made, crew.kit_isp_s, crew.disposal)


def unique(labels: Sequence[str], taken: set[str]) -> list[str]:
    """Labels made unique by a trailing counter."""
    names = []
    for label in labels:
        name, count = label, 1
        while name in taken:
            count += 1
            name = f"{label} ({count})"
        taken.add(name)
        names.append(name)
    return names


def _default_name(records: Sequence[ElementSet], count: int) -> str:
    stem = re.sub(r"[^\w.-]+", "-", Path(records[0].source).stem) or "catalogue"
    return f"{stem}-n{count}"


def _failed_sentence(failed: Sequence[Dropped], epoch: datetime, host: ElementSet | None) -> str:
    first = failed[0]
    said = f"{first} (epoch {epoch.astimezone(UTC):%Y-%m-%dT%H:%M:%SZ}"
    if host is not None and first == Dropped.of(host, first.reason, first.detail):
        return f"{said}); give another --station or --epoch"
    more = ""
    if len(failed) > 1:
        more = counted(len(failed) - 1, "more object fails", "more objects fail")
        more = f"; {more}"
    other = ", or give another --epoch" if first.reason in AT_ANOTHER_EPOCH else ""
    return f"{said}{more}); leave such objects out with --skip-bad{other}"


NAMES_TOLD = 3
"""Maximum number of names listed where no name of a catalogue fits."""


def _names_told(records: Sequence[ElementSet]) -> str:
    names = list(dict.fromkeys(record.name for record in records if record.name))
    more = ", …" if len(names) > NAMES_TOLD else ""
    return f"names are {', '.join(map(shown_name, names[:NAMES_TOLD]))}{more}" if names else ""


def _nothing_left(read: int, dropped: Sequence[Dropped], has: str) -> InputError:
    counts = Counter(drop.reason for drop in dropped)
    listed = ", ".join(f"{reason} {count}" for reason, count in counts.items())
    advice = "widen the filters" if counts.keys() - set(NO_FILTERS) else "give other files"
    if counts.keys() & set(AT_ANOTHER_EPOCH):
        advice += ", or another --epoch"
    if has and advice.startswith("widen"):
        advice += f": in the catalogue {has}"
    return InputError(f"no object is left of {read} (left out: {listed or 'none'}); {advice}")


def _warnings(
    targets: Sequence[ElementSet], host: ElementSet | None, instance: Instance, epoch: datetime
) -> Iterable[str]:
    bodies = [*targets, *([host] if host else [])]
    days = [abs((epoch - record.epoch).total_seconds()) / DAY_S for record in bodies]
    far = sum(value > FAR_DAYS for value in days)
    if far:
        worst = int(np.argmax(days))
        yield (
            f"the elements of {far} of {counted(len(bodies), 'object')} are more than {FAR_DAYS:g} "
            f"days from the epoch; {bodies[worst].label} is {days[worst]:.1f} days from it"
        )
    rule = instance.transfer
    low, high = EARTH_RADIUS_M + rule.min_altitude_m, EARTH_RADIUS_M + rule.max_altitude_m
    launches = instance.launches
    there = [orbit for body, orbit in enumerate(instance.body_orbits) if body not in launches]
    beyond = sum(not low <= orbit.semi_major_axis_m <= high for orbit in there)
    if beyond:
        yield (
            f"{beyond} of {len(there)} bodies {'is' if beyond == 1 else 'are'} "
            f"outside the altitudes of phasing, {rule.min_altitude_m / 1e3:g} to "
            f"{rule.max_altitude_m / 1e3:g} km; few or no transfers will lead there"
        )
    duration_s = instance.mission.duration_s
    drag = drag_warning(bodies, epoch, duration_s)
    yield from filter(None, (drag, drift_warning(instance), too_short(instance)))
    if len(targets) > MANY_TARGETS:
        yield (
            f"{len(targets)} targets: the timetable grows with their square; --max-targets keeps "
            "the nearest planes"
        )
