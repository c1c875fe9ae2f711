"""Flights with errors: what plans need at 95 %, misses at stand-offs, linearity, and times."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ephemerides import nearest
from fields import external, planned
from tables import head, row, timed

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.dispersion import Dispersion, FlightErrors, sample_flights
from adr_opt.plan.refined_plan import RefinedPlan
from adr_opt.sources.uncertainty import compared

HEAD = (
    *("legs", "m/s", "95 % m/s", "its interval", "stand-off, median leg", "worst leg", "wait"),
    *("late", "off linear", "CPU"),
)


def _flown(
    name: str, instance: adr_opt.Instance, refined: RefinedPlan, flights: int, **how: Any
) -> None:
    """Fly with errors, and print a row."""
    found, _, taken = timed(lambda: sample_flights(instance, refined, flights, **how))
    need = found.delta_v_m_s
    misses = sorted(leg.standoff_miss_m.value for leg in found.legs)
    row(
        name,
        len(refined.legs),
        f"{found.refined_delta_v_m_s:.1f}",
        f"{need.value / found.refined_delta_v_m_s - 1.0:+.2%}",
        f"{need.low:.1f} to {need.high:.1f}",
        f"{misses[len(misses) // 2]:.0f} m",
        f"{misses[-1]:.0f} m",
        f"{found.waits_s.value:.0f} s",
        f"{found.late_share:.1%}",
        f"{found.linearity.delta_v_m_s:.2g} m/s, {found.linearity.standoff_m:.2g} m",
        f"{taken:.2f} s",
    )


def errors(seeds: int = 3, flights: int = 1000) -> None:
    """A thousand flights with the default errors, by number of burns for corrections alone.

    Nominal fields under J2 and a drawn cloud, planned by ``greedy-guarded`` and refined; then the
    first one with other errors.
    """
    fields = [adr_opt.generate("nominal", seed) for seed in range(seeds)]
    usual = FlightErrors()
    print(f"\n{flights} flights with {usual}")
    head("field, burns, corrections", *HEAD)
    kept: list[tuple[adr_opt.Instance, RefinedPlan]] = []
    for field in [*fields, adr_opt.generate("cloud", 0)]:
        instance = field.replace(dynamics="j2")
        plan = planned(instance)
        for freedom in ("planned", "free"):
            refined = adr_opt.refine(instance, plan, freedom=freedom)
            kept.append((instance, refined))
            sample_flights(instance, refined, 10)  # kernels are loaded
            for number in range(4) if len(kept) <= 2 else (2,):
                name = f"{instance.name}, {freedom}, {number}"
                _flown(name, instance, refined, flights, corrections=number)
    print(f"\n{kept[1][0].name}, free burns")
    head("errors", *HEAD)
    navigation = {"navigation_position_m": 1000.0, "navigation_velocity_m_s": 1.0}
    for name, changed in (
        ("burn magnitude 2 %", {"burn_magnitude": 0.02}),
        ("pointing 2°", {"burn_pointing_deg": 2.0}),
        ("navigation 1 km, 1 m/s", navigation),
        ("no errors of burns", {"burn_magnitude": 0.0, "burn_pointing_deg": 0.0}),
    ):
        _flown(name, *kept[1], flights, errors=replace(usual, **changed))


def target_errors(targets: int = 60, flights: int = 1000) -> None:
    """What errors of where targets are cost a refined plan at 95 %, and when it is known how much.

    Two catalogues of Iridium 33, of February and April 2025, give element sets of two epochs. The
    targets with the nearest planes of the first one, for a week, are planned by ``greedy-guarded``
    and refined onto SGP4; flights with the default errors follow: with every body where it is
    planned, and with errors that the two catalogues show, by the time before the stand-off from
    which it is known where the target is.
    """
    files = external("tle/*iridium-33*", "omm/*iridium-33*")
    with nearest(files[0], targets) as instance:
        refined = adr_opt.refine(instance, planned(instance), ephemerides=True)
        shown = compared(instance, files)
        print(
            f"{len(shown.differences)} objects compared, {shown.median_age_days:.1f} days apart in "
            f"the median; {len(shown.by_median)} by the median, {len(shown.by_largest)} by the "
            "largest"
        )
        head("1σ", "median", "90 %", "largest")
        growths = [shown.growths[body] for body in shown.differences]
        for field in growths[0]._fields:
            values = sorted(getattr(growth, field) for growth in growths)
            at = len(values) // 2, int(0.9 * (len(values) - 1)), -1
            row(field, *(f"{values[each]:.4g}" for each in at))
        head(
            *("known before the stand-off", "95 % m/s", "its interval", "over refined"),
            *("over planned places m/s", "worst leg m/s", "stand-off, worst leg m", "late"),
            "off linear",
        )
        sure = found = sample_flights(instance, refined, flights)
        _known("where they are planned", sure, sure)
        for before_s in (2.0 * DAY_S, DAY_S, 12000.0, None, 3000.0, 1500.0):
            found = sample_flights(
                instance, refined, flights, targets=shown.errors, known_before_s=before_s
            )
            _known("a revolution" if before_s is None else f"{before_s:g} s", found, sure)
    far = sorted(
        (leg.target_off_m.value / 1e3, leg.destination)
        for leg in found.legs
        if leg.target_off_m is not None
    )
    print(
        f"\n{len(refined.legs)} legs. At 95 % targets are {far[len(far) // 2][0]:.1f} km off in "
        f"the median, and at most {far[-1][0]:.0f} km ({far[-1][1]})."
    )


def _known(name: str, found: Dispersion, sure: Dispersion) -> None:
    """Print the row of a time from which targets are known."""
    need, linear = found.delta_v_m_s, found.linearity
    legs = zip(found.legs, sure.legs, strict=True)
    row(
        name,
        f"{need.value:.1f}",
        f"{need.low:.1f} to {need.high:.1f}",
        f"{need.value / found.refined_delta_v_m_s - 1.0:+.2%}",
        f"{need.value - sure.delta_v_m_s.value:.1f}",
        f"{max(leg.delta_v_m_s.value - one.delta_v_m_s.value for leg, one in legs):.1f}",
        f"{max(leg.standoff_miss_m.value for leg in found.legs):.0f}",
        f"{found.late_share:.1%}",
        f"{linear.delta_v_m_s:.2g} m/s, {linear.standoff_m:.2g} m",
    )
