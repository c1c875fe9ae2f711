"""Assembly of the page."""

from __future__ import annotations

import os
from dataclasses import dataclass
from datetime import UTC
from string import Template
from typing import Any, NamedTuple

from ...common.constants import DAY_S
from ...common.errors import InputError
from ...common.files import check_writable, write_text
from ...common.json_text import loaded
from ...common.version import __version__
from ...common.wording import counted, proof_words
from ...fly.flight.flights import Flight, TankFlight
from ...fly.flight.fly import fly
from ...fly.flight.refined_result import RefinedFlight
from ...fly.flight.tanks import tanks_of
from ...judge.admit import Admitted, AnyPlan, AnyRefined, admit
from ...judge.check.violation import Violation
from ...plan.launched import as_launched
from ...plan.phases import PHASES
from ...plan.plan import Plan
from ...plan.refined_plan import RefinedPlan
from ...problem.instance import Instance
from ...problem.rules import JUDGED, Follower
from ...problem.support import refuse
from ..plot.courses import arcs_of
from ..plot.gantt import segments
from ..plot.strands import DrawnArc, Track
from . import burns, figures, flights, sections, space, tables, thrust
from .assets import asset, chart_library, page_script, policy
from .facts import facts, flown_paragraph
from .figures.plotly_traces import leg_title
from .motion import motion
from .text import escape, in_days, in_script


@dataclass(frozen=True)
class Report:
    """The written page.

    Attributes
    ----------
    path : str
    size_bytes : int
    violations : tuple of Violation
        What the check of the plan found.
    tanks : tuple of TankFlight or None
        Whether each tank holds when flown, on the true orbits or under J2; None if that was not
        or need not be flown. Of a plan that is refined, whether it holds with the refined legs.
    trouble : str or None
        Why the chaser's path could not be drawn, if it could not.
    complaints : tuple of str
        What is wrong with the refined plan.
    """

    path: str
    size_bytes: int
    violations: tuple[Violation, ...]
    tanks: tuple[TankFlight, ...] | None
    trouble: str | None
    complaints: tuple[str, ...] = ()


FOLLOWS = Follower("report", JUDGED)


def write_report(
    instance: Instance,
    plan: AnyPlan,
    path: str | os.PathLike[str],
    refined: AnyRefined | None = None,
    *,
    flight: Flight | None = None,
    refined_flight: RefinedFlight | None = None,
) -> Report:
    """Write a mission as one HTML file, completely or not at all.

    Parameters
    ----------
    instance : Instance
    plan : Plan or Admitted
        Violations do not stop the report: they head it.
    path : path
    refined : RefinedPlan or Admitted, optional
        The same plan, refined: what its legs take is told beside what they were planned with, and
        whether the plan holds is judged by them alone.
    flight : Flight, optional
        What :func:`adr_opt.fly.flight.fly` found of the plan. Where nodes drift or orbits are
        eccentric the plan is flown here if it is not given, and no refined plan is.
    refined_flight : RefinedFlight, optional
        What :func:`adr_opt.fly.flight.fly_refined` found of the refined plan.

    Raises
    ------
    InputError
        The plan belongs to another instance, the refined plan was made of another plan or has
        violations, or the file cannot be written.
    MissingExtra
        plotly is not installed.
    """
    check_writable(path)
    found = _found(instance, plan, refined, flight, refined_flight)
    text = _page(found)
    write_text(path, text)
    tanks = found.flight.tanks if isinstance(found.flight, Flight) else None
    if found.refined is not None:
        tanks = tanks_of(found.admitted.instance, found.refined)
    return Report(
        os.fspath(path),
        len(text.encode()),
        found.admitted.violations,
        tanks,
        found.trouble,
        found.complaints,
    )


def page(
    instance: Instance,
    plan: AnyPlan,
    refined: AnyRefined | None = None,
    *,
    flight: Flight | None = None,
    refined_flight: RefinedFlight | None = None,
) -> str:
    """The HTML of the report; the parameters are those of :func:`write_report`.

    Raises
    ------
    InputError, MissingExtra
        As in :func:`write_report`.
    """
    return _page(_found(instance, plan, refined, flight, refined_flight))


class _Found(NamedTuple):
    """Findings about a plan beyond its own claims."""

    admitted: Admitted[Plan]
    flight: Flight | str | None
    drawn: tuple[DrawnArc, ...]
    trouble: str | None
    refined: RefinedPlan | None
    refined_flight: RefinedFlight | None
    complaints: tuple[str, ...]


def _found(
    instance: Instance,
    given: AnyPlan,
    given_refined: AnyRefined | None,
    flight: Flight | None,
    refined_flight: RefinedFlight | None,
) -> _Found:
    refuse(instance, FOLLOWS)
    admitted = admit(instance, given, unjudged=True)
    plan, refined = admitted.plan, None
    if given_refined is not None:
        refined = admit(instance, given_refined, refined_from=plan).plan
    # Of a refined plan its own flight is what counts; the plan is flown only if that is asked for.
    flown = _flown(instance, admitted) if flight is None and refined is None else flight
    drawn, trouble = _drawn(instance, plan)
    return _Found(
        admitted,
        flown,
        drawn,
        trouble,
        refined,
        refined_flight,
        flights.complaints(instance, refined, refined_flight),
    )


def _flown(instance: Instance, admitted: Admitted[Plan]) -> Flight | str | None:
    """The flight, or the reason why there is none; None for circles in two-body motion.

    Under J2 the burns of legs that drift differ from what the plan counts with. Given connections
    are not flown.
    """
    if not instance.nodes_drift and not instance.is_approximate:
        return None
    try:
        return fly(instance, admitted)
    except InputError as error:  # also a missing extra: the page is worth having without it
        return str(error)


def _drawn(instance: Instance, plan: Plan) -> tuple[tuple[DrawnArc, ...], str | None]:
    if not _is_moved(instance):
        return (), None
    try:
        return arcs_of(instance, plan), None
    except InputError as error:  # a plan so wrong that it leads nowhere; the check says more
        return (), str(error)


def _page(known: _Found) -> str:
    instance, plan = known.admitted.instance, known.admitted.plan
    found, refined, trouble = facts(instance, plan), known.refined, known.trouble
    burned = burns.impulses(plan, _flown_arcs(known), refined)
    library, script = chart_library(), page_script()
    lanes_title, lanes_note = sections.lanes(instance)
    done = {segment.phase for segment in segments(instance, plan)}
    epoch = instance.epoch.astimezone(UTC)
    subtitle = (
        f"{epoch.day} {epoch:%B %Y, %H:%M} UTC · "
        f"{in_days(instance.mission.duration_s)} · "
        f"{counted(len(instance.targets), 'target')} · planned by {escape(plan.method)} · "
        f"{'proven ' if plan.status == 'optimal' else ''}"
        f"{proof_words(plan.status, plan.cost_status)}"
    )
    left_out = (
        tables.reasons(plan) + tables.unvisited(instance, plan)
        if plan.unvisited
        else "<p>None: the plan lists no target as not visited.</p>"
    )
    return Template(asset("page.html")).substitute(
        policy=policy(library, script),
        version=__version__,
        title=escape(f"{instance.name} · {found.visits} of {counted(found.targets, 'target')}"),
        name=escape(instance.name),
        style=asset("page.css"),
        story=sections.story(plan, found, refined),
        subtitle=subtitle,
        verdict=sections.verdict(
            instance,
            known.admitted.violations,
            known.flight,
            known.complaints,
            refined,
            known.refined_flight,
            plan.own_flight,
        ),
        headline=sections.headline(found, refined),
        crew=sections.crew(instance, plan, refined),
        globe=space.globe(instance),
        lanes_title=lanes_title,
        lanes_note=lanes_note,
        flight=space.flight(instance, plan),
        budget_note=sections.budget_note(instance),
        ends="service or refuelling" if instance.stations else "service",
        gantt_note=sections.gantt_note(instance),
        timebar=space.timebar(plan),
        phases=space.phases([phase for phase in PHASES if phase in done]),
        trouble="" if trouble is None else sections.not_drawn(space.path_of(instance), trouble),
        mass=space.mass(instance),
        nodes=space.nodes(instance),
        costs_note=sections.costs_note(plan, refined),
        planes=space.planes(instance),
        legs=tables.legs(instance, plan, refined),
        thrust=thrust.section(instance, plan, known.drawn),
        burns=burns.section(instance, plan, burned),
        flown=flown_paragraph(known.admitted, refined)
        + flights.section(instance, known.flight, refined, known.refined_flight),
        unvisited=left_out,
        certificate=sections.certificate(plan, found),
        origin=sections.origin(instance, plan),
        data=in_script(_data(instance, plan, known, burned)),
        library=library,
        script=script,
    )


def _is_moved(instance: Instance) -> bool:
    """Whether the page shows where chasers are at a time."""
    return instance.has_trajectories or instance.has_low_thrust


def _flown_arcs(known: _Found) -> tuple[Track, ...]:
    """What is drawn and has been flown, so that it can be moved along."""
    return tuple(arc for arc in known.drawn if isinstance(arc, Track))


def _data(
    instance: Instance, plan: Plan, known: _Found, burned: tuple[burns.ReportedBurn, ...]
) -> dict[str, Any]:
    """Data for the script of the page."""
    instance, drawn, is_moved = as_launched(instance, plan), known.drawn, _is_moved(instance)
    numbers = range(1, len(plan.legs) + 1)
    charts = {
        "budget": figures.budget(instance, plan),
        "costs": figures.costs(plan, known.refined),
        "gantt": figures.gantt(instance, plan),
        "lanes": figures.lanes(instance, plan),
    }
    if is_moved:
        charts["altitude"] = figures.altitude(instance, plan, drawn)
    if instance.has_low_thrust:
        charts["mass"] = figures.mass(instance, plan)
    if instance.has_orbits:
        charts["planes"] = figures.planes(instance, plan)
    if instance.nodes_drift:
        charts["nodes"] = figures.nodes(instance, plan, drawn)
    last = charts["gantt"]["layout"]["xaxis"]["range"][1]
    return {
        "epoch_ms": round(instance.epoch.timestamp() * 1000.0),
        "end_s": last * DAY_S,
        "motion": motion(instance, plan, drawn) if is_moved else None,
        "coast": loaded(asset("coast/coastline.json")) if is_moved else None,
        "burns": burns.of_page(instance, plan, burned),
        "figures": charts,
        "titles": ["start", *(leg_title(plan, number) for number in numbers)],
        "windows": [
            [round(leg.ready_s / DAY_S, 6), round(leg.end_s / DAY_S, 6)] for leg in plan.legs
        ],
    }
