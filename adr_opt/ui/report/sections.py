"""Text sections of the page: verdict, headline figures, bound, origin of the plan."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import UTC

from ...common.constants import DAY_S
from ...common.wording import counted, proof_words
from ...fly.flight.flights import Flight
from ...fly.flight.refined_result import RefinedFlight
from ...judge.check.violation import Violation
from ...plan.leg_kinds import GIVEN
from ...plan.plan import Plan
from ...plan.plan_flight import PlanFlight
from ...plan.refined_plan import RefinedPlan
from ...plan.routes import several
from ...problem.chasers import AtStation, Chaser, Expense, InOrbit, TankByMass
from ...problem.disposal import DisposalCircle
from ...problem.instance import Instance
from ..plot.budget import has_burns
from ..plot.course import RUN, course_chart
from ..plot.traffic import traffic_chart
from . import tables
from .charts import drawn
from .facts import Facts
from .text import NOTHING, clock, escape, in_days, length, number

LONG_DAYS = 100.0
"""From here on a duration used has one decimal."""

ROOM = 6
"""Longer figures are smaller in the headline, so that a tile holds them."""


def verdict(
    instance: Instance,
    violations: tuple[Violation, ...],
    flown: Flight | str | None,
    complaints: tuple[str, ...] = (),
    refined: RefinedPlan | None = None,
    refined_flight: RefinedFlight | None = None,
    own: PlanFlight | None = None,
) -> str:
    """Findings of the check, and of a flight on true orbits or in the mean dynamics.

    One quiet line if the plan holds, and a box that cannot be missed for all that breaks. Of a plan
    that is refined the refined flight alone says whether it holds: its burns are those to be flown.

    Parameters
    ----------
    instance : Instance
    violations : tuple of Violation
    flown : Flight or str or None
        On the true orbits or under J2, or why it was not flown; None if all flies as planned.
    complaints : tuple of str
        What is wrong with the refined plan.
    refined : RefinedPlan, optional
    refined_flight : RefinedFlight, optional
        Its flight by another integrator.
    own : PlanFlight, optional
        How the plan was flown when it was made.
    """
    drifts = instance.nodes_drift
    held = _held(own)
    if refined is not None:
        flown = None
    boxes = ""
    if violations:
        boxes += _box(
            f"This plan has {counted(len(violations), 'violation')}",
            "It must not be flown as it is. All figures below are as the plan states them.",
            violations,
        )
    if isinstance(flown, Flight) and flown.broken_tanks:
        why = (
            "The model counts legs that drift with a closed form, and flies between circles; the "
            "burns that arrive add up to more than is left."
            if drifts
            else "The model flies between circles; to arrive on the eccentric orbits after all "
            "costs more than is left."
        )
        boxes += _box(
            f"{'When flown' if drifts else 'On the true orbits'} this plan breaks "
            + counted(len(flown.broken_tanks), "tank"),
            f"{'In the model too it is not legal.' if violations else 'It is legal in the model.'} "
            f"{why}{held} Figures below are those of the model; <code>solve --refine</code> plans "
            "until the plan holds.",
            flown.broken_tanks,
        )
    if complaints:
        boxes += _box(
            "The refined plan does not hold",
            "In true dynamics something is missing. Figures below are those of the model.",
            complaints,
        )
    if boxes:
        return boxes
    if refined is not None:
        return _refined(instance, refined, refined_flight)
    if drifts:
        return _drifting(instance, flown, held)
    if isinstance(flown, str):
        not_flown = (
            "this page has not flown the plan there"
            if held
            else ("the plan was not flown on the true ones")
        )
        return (
            f'<p class="verdict">Checked against the instance: no violations in the model.{held} '
            f"Some orbits are eccentric, and {not_flown}: {escape(flown)}.</p>"
        )
    arrives = "" if flown is None else " Flown on the true orbits: every tank holds."
    return (
        '<p class="verdict good"><span aria-hidden="true">✓</span> '
        f"Checked against the instance: no violations.{arrives}{held}</p>"
    )


def _held(own: PlanFlight | None) -> str:
    """Sentence that a plan held when it was refined on being made; empty if it did not."""
    if own is None or own.how != "refined" or not own.holds:
        return ""
    return (
        f" The plan states that it was refined in the field {own.gravity} and that every tank "
        "held; this page has not judged that."
    )


def _refined(instance: Instance, refined: RefinedPlan, flight: RefinedFlight | None) -> str:
    """Verdict on a refined plan without faults."""
    left_m = max((leg.residual_m for leg in refined.legs), default=0.0)
    met = f"the stand-offs are met to {length(left_m)}"
    if flight is not None:
        met = f"another integrator finds the stand-offs met to {length(flight.worst_miss_m)}"
    return (
        '<p class="verdict good"><span aria-hidden="true">✓</span> Checked against the instance: '
        "no violations. Refined and flown in numerically integrated motion, in the field "
        f"{escape(refined.gravity)}: every tank holds, and {met}."
        + (" Targets on eccentric orbits are met there." * instance.is_approximate)
        + " Orbits, map, timeline and ΔV left show the plan as modelled; the tables of burns and "
        "of refined legs have what is to be flown.</p>"
    )


def _drifting(instance: Instance, flown: Flight | str | None, held: str) -> str:
    """Verdict on a plan under J2 without known faults."""
    checked = "Checked against the instance: no violations"
    if not isinstance(flown, Flight):
        return (
            f'<p class="verdict">{checked} in the model.{held} No independent program has flown '
            f"it here: {escape(flown)}.</p>"
        )
    arrives = (
        "Flown in the mean dynamics of J2: every tank holds, and the stand-offs are met to "
        f"{length(flown.worst_miss_m)}."
    )
    if instance.is_approximate:
        arrives += (
            " Some orbits are eccentric: the stand-offs are those of circles, and the tanks are "
            "judged by burns that are aimed at the true ones."
        )
    return (
        f'<p class="verdict good"><span aria-hidden="true">✓</span> {checked}. {arrives}{held}</p>'
    )


def crew(instance: Instance, plan: Plan, refined: RefinedPlan | None) -> str:
    """The section on chasers and stations if there are several, or else on cargo."""
    if not several(instance):
        load = tables.loads(instance, plan)
        return load and f"<section><h2>What the chaser carries</h2>{load}</section>"
    title, traffic = "Chasers", ""
    if instance.stations:
        title = "Chasers and stations"
        chart = traffic_chart(instance, plan)
        several_of_them = sum(len(line.x) - 1 for line in chart.series) > 1
        traffic = "<h3>Station traffic</h3>" + several_of_them * drawn(chart, "Station traffic")
        traffic += tables.traffic(instance, plan)
    return (
        f"<section><h2>{title}</h2><p>In charts a chaser has the colour of its dot.</p>"
        + tables.chasers(instance, plan, refined)
        + ("<h3>What they carry</h3>" + load if (load := tables.loads(instance, plan)) else "")
        + traffic
        + "</section>"
    )


def lanes(instance: Instance) -> tuple[str, str]:
    """Heading of the lanes, with their description."""
    title = "Chasers" if several(instance) else "Mission"
    said = f"A lane for {'each' if several(instance) else 'the'} chaser, coloured by phase"
    if instance.stations:
        said += ", and one for each station, coloured by the chaser that is there"
    return title, said + "."


def budget_note(instance: Instance) -> str:
    """Explanation of the steps in the chart of budgets."""
    step = "burn" if instance.has_trajectories else "arrival"
    refills = ", back to the full budget at every refuelling (▲)" if instance.stations else ""
    return f"A step down at every {step}{refills}."


def costs_note(plan: Plan, refined: RefinedPlan | None) -> str:
    """Explanation of the bars of legs."""
    if any(leg.kind == GIVEN.name for leg in plan.legs):
        return "What is given of each leg."
    if not has_burns(plan):
        return "What the plan counts with."
    said = "What the plan counts with, and what the burns of the leg add up to"
    if any(leg.traits.on_time_grid for leg in plan.legs):
        said += "; of a leg that drifts the first comes from a closed form"
    if any(leg.eccentricity_delta_v_m_s < 0.0 for leg in plan.legs):
        said += "; the first is the price of free burns, which may be less"
    elif any(leg.eccentricity_delta_v_m_s > 0.0 for leg in plan.legs):
        said += "; matching eccentricities is counted and has no burn"
    if refined is not None and refined.ephemerides is not None:
        said += "; what these burns come to when they lead to where ephemerides have the bodies"
    if refined is not None:
        said += "; and what it takes refined, in true dynamics"
    return said + "."


def not_drawn(path: str, trouble: str) -> str:
    """Message in place of a path that cannot be drawn."""
    said = f"{path[:1].upper()}{path[1:]} cannot be drawn: {escape(trouble)}."
    return f'<p class="verdict bad">{said}</p>'


def gantt_note(instance: Instance) -> str:
    """Explanation of the rows of the timeline."""
    said = "One row per leg, named by its destination"
    if several(instance):
        said += ", below the name of its chaser"
    return f"{said}. Select a bar to see its leg in all charts."


def _box(title: str, said: str, found: Iterable[object]) -> str:
    items = "".join(f"<li>{escape(each)}</li>" for each in found)
    return (
        f'<section class="verdict bad" role="alert"><h2>{title}</h2><p>{said}</p>'
        f"<ul>{items}</ul></section>"
    )


def story(plan: Plan, found: Facts, refined: RefinedPlan | None) -> str:
    """The plan in a sentence: its prize, its cost, and the bound."""
    said = f"<b>{number(found.visits)} of {counted(found.targets, 'target')}</b>"
    if not found.counts_visits:
        said += f", worth {_figure(found.prize)} of {_figure(found.total_prize)},"
    said += f" in {in_days(found.used_s)}"
    if found.flying > 1:
        said += f" by {found.flying} chasers"
    said += ", with "
    if found.refuellings:
        said += f"{counted(found.refuellings, 'refuelling')} and "
    said += f"{number(found.delta_v_m_s, 0)}\u202fm/s"
    if refined is not None and not refined.missing and found.delta_v_m_s > 0.0:
        share = refined.flown_delta_v_m_s / found.delta_v_m_s - 1.0
        if abs(share) < 0.005:
            said += "; refined it takes as much"
        else:
            said += (
                f"; refined {100.0 * abs(share):.0f}\u202f% {'dear' if share > 0.0 else 'cheap'}er"
            )
    if plan.status == "optimal":
        return said + f"; no plan {'visits' if found.counts_visits else 'collects'} more."
    if found.upper_bound is not None:
        return said + f"; at most {_figure(found.upper_bound)} are possible."
    return said + "; no bound is known."


def headline(found: Facts, refined: RefinedPlan | None = None) -> str:
    """The headline figures, including those of a refined plan."""
    taken = f"of {number(found.budgets_m_s, 0)} m/s"
    if refined is not None and not refined.missing:
        taken += f"; refined {number(refined.flown_delta_v_m_s, 0)}"
    bound, gap = NOTHING, NOTHING
    if found.upper_bound is not None:
        bound = _figure(found.upper_bound)
    if found.gap is not None:
        gap = f"{100.0 * found.gap:.1f}\u202f%"
    days = found.used_s / DAY_S
    cards = [
        ("targets visited", number(found.visits), f"of {number(found.targets)}"),
        ("upper bound", bound, "proven of the model" if bound != NOTHING else "none given"),
        ("gap", gap, "of the upper bound" if gap != NOTHING else "needs a bound"),
        ("ΔV used", number(found.delta_v_m_s, 0), taken),
        (
            "duration used",
            number(days, 2 if days < LONG_DAYS else 1),
            f"of {in_days(found.duration_s)}",
        ),
    ]
    if found.stations:
        where = "the station" if found.stations == 1 else counted(found.stations, "station")
        cards.insert(-1, ("refuellings", number(found.refuellings), f"at {where}"))
    if found.chasers > 1:
        cards.insert(0, ("chasers that fly", number(found.flying), f"of {found.chasers}"))
    if not found.counts_visits:
        cards.insert(
            1 + (found.chasers > 1),
            ("prize collected", _figure(found.prize), f"of {_figure(found.total_prize)}"),
        )
    return "".join(
        f"<div><dt>{title}</dt><dd><b{' class=long' if len(value) > ROOM else ''}>{value}</b> "
        f"<span>{note}</span></dd></div>"
        for title, value, note in cards
    )


def _figure(value: float) -> str:
    """A prize as shown in a tile: large ones without a fraction."""
    return number(value, 2 if abs(value) < 1e4 else 0)


def certificate(plan: Plan, found: Facts) -> str:
    """Bound and gap, as a sentence and as a bar."""
    collected, total = number(found.prize, 2), number(found.total_prize, 2)
    what = "visits" if found.counts_visits else "prize"
    if plan.upper_bound is None and plan.status == "optimal":
        said = f"The plan collects all prizes, {collected}: no plan can be better."
    elif plan.upper_bound is None:
        said = (
            "The plan states no upper bound, so how much better another plan could be is unknown. "
            "<code>bound --start</code> proves one of the model."
        )
    elif plan.status == "optimal":
        said = (
            f"Optimal prize, as the plan states: it collects {collected}, and no plan can collect "
            f"more than {number(plan.upper_bound, 2)}. <code>verify</code> judges the certificate."
        )
    else:
        said = (
            f"The plan collects {collected}, and states that no plan can collect more than "
            f"{number(plan.upper_bound, 2)}, of which <code>verify</code> judges the certificate. "
            "Whether a plan in between exists is open."
        )
    rows = [("this plan", found.prize, "var(--good)", collected)]
    if plan.upper_bound is not None:
        rows.append(("upper bound", plan.upper_bound, "var(--accent)", number(plan.upper_bound, 2)))
    rows.append(("all targets", found.total_prize, "var(--line-strong)", total))
    most = max([value for _, value, _, _ in rows]) or 1.0
    bars = "".join(
        f'<div><dt>{title}</dt><dd><i style="width:{max(0.0, 100.0 * value / most):.2f}%;'
        f'background:{colour}"></i></dd><dd class="n">{text}</dd></div>'
        for title, value, colour, text in rows
    )
    gap = ""
    if found.gap is not None:
        gap = (
            f"<p>Gap: <b>{100.0 * found.gap:.2f}\u202f%</b>, that is (upper bound − collected) / "
            "upper bound.</p>"
        )
    if found.cost_gap is not None and found.cost_bound is not None:
        cost = "Optimal cost" if plan.cost_status == "optimal" else "Cost"
        gap += (
            f"<p>{cost} among plans that collect as much, as the plan states: "
            f"{number(found.cost, 2)} of at least {number(found.cost_bound, 2)}, a gap of "
            f"<b>{100.0 * found.cost_gap:.2f}\u202f%</b>.</p>"
        )
    elif plan.status == "optimal":
        gap += "<p>Whether another plan that collects as much costs less is unproven.</p>"
    course = ""
    if plan.course:
        course = drawn(course_chart(plan.course, plan.runtime_s), RUN, from_zero=False)
    return f'<p>{said}</p>{gap}<dl class="bars" aria-label="{what}">{bars}</dl>{course}'


def origin(instance: Instance, plan: Plan) -> str:
    """Origin of instance and plan, with caveats."""
    settings, limits = instance.transfer, instance.mission
    rows = [
        ("instance", f"{escape(instance.name)}, SHA-256 <code>{instance.sha256[:16]}…</code>"),
        ("epoch", f"{instance.epoch.astimezone(UTC):%Y-%m-%d %H:%M:%S} UTC"),
        (
            "limits",
            f"{in_days(limits.duration_s)}, {_tanks(instance)} m/s from one refuelling to the "
            "next, " + counted(len(instance.keep_out_zones), "keep-out zone"),
        ),
        ("transfers", _transfers(instance)),
        *([("motion", MOTION[instance.dynamics])] if settings.given is None else []),
        (
            "plan",
            f"{escape(plan.method)}, seed {plan.seed}, "
            f"{proof_words(plan.status, plan.cost_status)}, {plan.runtime_s:.2f} s",
        ),
    ]
    rules = _rules_in_words(instance)
    if rules:
        rows.insert(3, ("rules", escape("; ".join(rules))))
    if plan.versions:
        versions = ", ".join(f"{name} {version}" for name, version in plan.versions.items())
        rows.append(("made with", escape(versions)))
    rows += [("note", escape(note)) for note in plan.notes]
    return "".join(f"<div><dt>{title}</dt><dd>{text}</dd></div>" for title, text in rows)


MOTION = {
    "two-body": "two bodies and circles; planes stay; altitudes are radii less 6378.137 km",
    "j2": "circles that drift at the secular rates of J2, without short-period variations; "
    "altitudes are radii less 6378.137 km",
}
"""Descriptions of the motion of bodies."""


def _tanks(instance: Instance) -> str:
    """Tanks of the chasers, each size once [m/s]."""
    sizes = dict.fromkeys(chaser.tank.delta_v_m_s for chaser in instance.chasers)
    return " or ".join(number(size, 1) for size in sizes)


def _transfers(instance: Instance) -> str:
    """Description of the transfers used in planning."""
    settings = instance.transfer
    if settings.given is not None:
        files = (
            ("connections", settings.given.file, settings.given.sha256),
            ("functions of time", settings.given.functions, settings.given.functions_sha256),
        )
        return "; ".join(
            f"{what} given in {escape(file)}, SHA-256 <code>{(digest or '')[:16]}…</code>"
            for what, file, digest in files
            if file is not None
        )
    if instance.has_low_thrust and all(each.thrust_n is not None for each in instance.chasers):
        return (
            "low thrust, drift and thrust again, with drift orbits between "
            f"{number(settings.min_altitude_m / 1000.0)} and "
            f"{number(settings.max_altitude_m / 1000.0)} km, of up to "
            f"{in_days(settings.max_drift_s)}, on a grid of {in_days(settings.drift_step_s)}"
        )
    said = (
        "co-elliptic sequences that wait for the line of nodes, phasing circles between "
        f"{number(settings.min_altitude_m / 1000.0)} and "
        f"{number(settings.max_altitude_m / 1000.0)} km"
    )
    if settings.max_drift_s > 0.0:
        said += (
            f"; drifts of up to {in_days(settings.max_drift_s)}, planned on a grid of "
            f"{in_days(settings.drift_step_s)}"
        )
    return said


def _disposals(instance: Instance) -> set[str]:
    """Orbits of disposal of towed targets, in words."""
    return {
        f"a circle of {number(disposal.circle_m / 1e3, 1)} km"
        if isinstance(disposal, DisposalCircle)
        else f"a perigee of {number(disposal.perigee_m / 1e3, 1)} km"
        for disposal in map(instance.disposal_of, instance.targets)
        if disposal is not None
    }


def _rules_in_words(instance: Instance) -> list[str]:
    """Unusual requirements of an instance: times, ends, numbers."""
    windows = sum(instance.is_limited(target) for target in instance.targets)
    required = sum(target.required for target in instance.targets)
    rules = [said for chaser in instance.chasers for said in _rules_of(instance, chaser)]
    if required:
        rules.append(f"{counted(required, 'target')} required")
    if windows:
        rules.append(f"{counted(windows, 'target')} with a window of time")
    towed = sum(target.service.is_flown for target in instance.targets)
    if towed:
        down = " or ".join(sorted(_disposals(instance)))
        rules.append(f"{counted(towed, 'target')} to be towed to {down}")
    if instance.mission.service_s is not None:
        rules.append(f"service takes {number(instance.mission.service_s, 1)} s")
    if instance.objective.cost == "duration":
        rules.append("of plans that collect as much the one that ends first is best")
    if instance.objective.cost == "expense":
        rules.append("of plans that collect as much the one of the least expense is best")
    if instance.objective.time_m_s_per_day is not None:
        price = number(instance.objective.time_m_s_per_day, 3)
        rules.append(f"each day of a chaser that is used costs {price} m/s")
    apart_s = instance.mission.launch_separation_s
    if apart_s is not None:
        rules.append(f"launches follow one another, {in_days(apart_s)} apart at least")
    if instance.mission.mission_separation_s is not None:
        rest = in_days(instance.mission.mission_separation_s)
        rules.append(f"a mission ends {rest} or more before the next is launched")
    if instance.transfer.max_leg_s is not None:
        most = in_days(instance.transfer.max_leg_s)
        rules.append(f"from one arrival to the next at most {most} pass")
    for station in instance.stations:
        if station.max_refuellings is not None:
            rules.append(f"{station.name} refuels {counted(station.max_refuellings, 'time')}")
        if station.max_propellant_kg is not None:
            rules.append(f"{station.name} has {number(station.max_propellant_kg, 1)} kg to refuel")
    return rules


def _rules_of(instance: Instance, chaser: Chaser) -> Iterator[str]:
    """Unusual requirements of one chaser, named if there are several."""
    who, it = (chaser.name, chaser.name) if several(instance) else ("the chaser", "it")
    since, until = chaser.available_s
    if since > 0.0:
        yield f"{who} may fly from {clock(since)} on"
    if until is not None:
        yield f"{who} may fly until {clock(until)}"
    if isinstance(chaser.start, InOrbit):
        yield f"{it} starts in an orbit of its own"
    if chaser.is_launched:
        yield f"{it} is launched onto its first target, which costs nothing here"
    if chaser.launch is not None:
        into = chaser.launch
        yield (
            f"{it} is launched into a circle of {number(into.altitude_m / 1e3, 1)} km and "
            f"{number(into.inclination_deg, 2)}°, in the plane of its first target's node"
        )
        if into.launcher is not None:
            yield f"the launcher lifts {number(into.most_kg, 1)} kg there"
    if chaser.kits is not None:
        yield f"{it} may carry {counted(chaser.kits, 'kit')}"
    if isinstance(chaser.tank, TankByMass):
        tank = chaser.tank
        yield (
            f"{it} has {number(tank.propellant_kg, 1)} kg of propellant at most, "
            f"{number(tank.isp_s, 1)} s of specific impulse and {number(tank.dry_mass_kg, 1)} kg "
            "without both"
        )
    if chaser.expense is not None:
        yield f"{it} takes {_prices(chaser.expense)}"
    if isinstance(chaser.end, AtStation):
        yield f"{it} has to end at {chaser.end.station}"
    if chaser.max_targets is not None:
        yield f"{it} may service {counted(chaser.max_targets, 'target')}"
    if chaser.max_visits_between_refuels is not None:
        most = counted(chaser.max_visits_between_refuels, "target")
        yield f"{it} may service {most} between refuellings"
    if chaser.end_of_life_m_s is not None:
        yield f"{it} keeps {number(chaser.end_of_life_m_s)} m/s for its own disposal"


def _prices(expense: Expense) -> str:
    """Components of an expense."""
    parts = [
        number(expense.fixed, 6),
        *([f"{expense.per_kg:g} a kg"] if expense.per_kg else []),
        *([f"{expense.per_kg_squared:g} a kg²"] if expense.per_kg_squared else []),
    ]
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if parts[1:] else parts) + " if used"
