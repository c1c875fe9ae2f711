"""Refined plans against their plans, field by field, and flight in mean motion against them."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from fields import eccentric, external, like, planned
from tables import head, row, timed

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.fly.flight import fly_refined
from adr_opt.fly.flight.mean_flight import fly_mean
from adr_opt.fly.flight.tanks import tanks_of
from adr_opt.fly.refine.bodies import mean_at, moved, state_at_epoch
from adr_opt.judge.refined.world import FreeMotion
from adr_opt.kernels.orbits import equinoctial
from adr_opt.kernels.orbits.gravity import FIELDS
from adr_opt.kernels.orbits.short_periods import osculating
from adr_opt.plan.refined_plan import Freedom
from adr_opt.problem.instance import Instance
from adr_opt.sources.catalogue import read, to_instance

Array = npt.NDArray[np.float64]

FREEDOMS: tuple[Freedom, ...] = "planned", "free"


def circles(seeds: int = 4, jobs: int = 2, bodies: int = 10) -> None:
    """Refined plans of nominal fields under J2: planned against flown ΔV, misses, and times.

    Fields are planned, refined with the plan's own burns and with free ones, and flown by ``fly``.
    Then how far bodies part from the mean model that was planned with, with the correction of their
    mean motions and without, and what propagation takes beside that of ``fly``.
    """
    head(
        *("field", "legs", "planned m/s", "own burns", "free", "worst miss", "at"),
        *("refined in, wall", "for 30 legs", "flown in, CPU"),
    )
    totals = np.zeros(3)
    for seed in range(seeds):
        instance = adr_opt.generate("nominal", seed).replace(dynamics="j2")
        plan = planned(instance)
        adr_opt.refine(instance, plan, freedom="planned", jobs=1)  # kernels are loaded
        own, free = (adr_opt.refine(instance, plan, freedom=one, jobs=jobs) for one in FREEDOMS)
        flights, _, taken = timed(lambda: [fly_refined(instance, one) for one in (own, free)])  # noqa: B023
        burns = own.planned_delta_v_m_s, own.flown_delta_v_m_s, free.flown_delta_v_m_s
        totals += burns
        assert own.status == free.status == "complete"
        row(
            instance.name,
            len(plan.legs),
            f"{burns[0]:.1f}",
            *(f"{each / burns[0] - 1.0:+.2%}" for each in burns[1:]),
            f"{1e3 * max(flight.worst_miss_m for flight in flights):.2g} mm",
            f"{1e6 * max(flight.worst_miss_m_s for flight in flights):.2g} µm/s",
            f"{free.runtime_s:.1f} s",
            f"{30.0 / len(plan.legs) * free.runtime_s:.1f} s",
            f"{0.5 * taken:.1f} s",
        )
    shares = (f"{each / totals[0] - 1.0:+.2%}" for each in totals[1:])
    row("all", "", f"{totals[0]:.1f}", *shares, *[""] * 5)
    head("bodies against their mean model, worst", "radially", "along", "across")
    _bodies("nominal", 7.0, bodies)
    _bodies("rocket-bodies", 365.0, bodies)
    head("one body in the field J4", "collocation", "`fly`", "apart")
    for days in (7.0, 60.0, 730.0):
        _propagation(days)


def _bodies(family: str, days: float, bodies: int) -> None:
    """Print how far bodies part from their mean model, corrected and not."""
    worst = {True: np.zeros(3), False: np.zeros(3)}
    for orbit in adr_opt.generate(family, 0).body_orbits[1 : 1 + bodies]:
        for corrected in worst:
            state = state_at_epoch(orbit, "j2", days * DAY_S if corrected else 0.0)
            now = 0.0
            for when in np.linspace(0.0, days * DAY_S, 200):
                state, now = moved(state, when - now, "j2"), when
                model = osculating(*mean_at(orbit, "j2", when), FIELDS["j2"])
                frame = equinoctial.own_frame(model)
                angle = math.atan2(frame[1] @ state[:3], frame[0] @ state[:3])
                radius = math.hypot(*model[:3])
                across = (frame @ (state[:3] - model[:3]))[2]
                found = [math.hypot(*state[:3]) - radius, angle * radius, across]
                worst[corrected] = np.maximum(worst[corrected], np.abs(found))
    for corrected, name in ((True, "corrected"), (False, "as they are")):
        row(f"{family}, {days:g} days, {name}", *(f"{each:.0f} m" for each in worst[corrected]))


def _propagation(days: float) -> None:
    """Print what propagation takes, and how far two integrators part."""
    orbit = adr_opt.generate("nominal", 0).body_orbits[1]
    state, world = state_at_epoch(orbit, "j4", 0.0), FreeMotion("j4")
    moved(state, DAY_S, "j4")
    world.coast(state[:, None], 0.0, DAY_S)
    there, _, own = timed(lambda: moved(state, days * DAY_S, "j4"))
    other, _, judge = timed(lambda: world.coast(state[:, None], 0.0, days * DAY_S)[:, 0])
    apart = 1e3 * math.dist(there[:3], other[:3])
    row(f"{days:g} days", f"{1e3 * own:.1f} ms", f"{1e3 * judge:.1f} ms", f"{apart:.2g} mm")


def _fields(catalogues: tuple[Path, ...], seeds: int, cuts: int) -> Iterator[tuple[str, Instance]]:
    """Kind of field, and the field, under J2: drawn ones, and parts of catalogues."""
    for seed in range(seeds):
        for what in ("Cosmos 2251", "SL-8"):
            yield f"{what}-like", like(what, seed)
        yield "clouds as drawn", adr_opt.generate("cloud", seed).replace(dynamics="j2")
    for seed in range(seeds):
        instance = eccentric(adr_opt.generate("nominal", seed), 0.02, seed).replace(dynamics="j2")
        yield "nominal, eccentric", instance.replace(name=f"{instance.name}, e to 0.02")
    for path in catalogues or external("tle/*.txt", "omm/cele*.csv"):
        found = read(path, skip_bad=True)
        for cut in range(cuts):
            part = replace(found, records=found.records[cut::cuts])
            instance = to_instance(part, skip_bad=True).instance
            yield "catalogues", instance.replace(name=f"{path.stem}, part {cut + 1}")


def _against_flown(said: Array, flown: Array) -> list[str]:
    """Said over flown in total; how many legs are within 10 % of it, and the extremes."""
    off = said / flown - 1.0
    total = f"{said.sum() / flown.sum() - 1.0:+.1%}"
    return [total, f"{np.mean(np.abs(off) <= 0.1):.0%}", f"{off.min():+.0%} to {off.max():+.0%}"]


def clouds(
    *catalogues: Path, seeds: int = 3, cuts: int = 3, jobs: int = 2, out: Path | None = None
) -> None:
    """What legs between eccentric orbits are said to take, and what they take flown.

    Drawn clouds like those of Iridium 33 and Cosmos 2251, stages like SL-8, nominal fields with
    eccentricities up to 0.02, and parts of catalogue files, all under J2, planned twice: priced by
    the burns of the sequence, and by free burns. Each plan is refined with free burns, the first
    one also with its own. Errors are those of what was said, as shares of what is flown; a tank is
    broken if what is flown exceeds it by more than 1 %. Legs are written to the file ``--out``.
    """
    kept = ["field,priced_by,said_m_s,flown_m_s"]
    head(
        *("field", "priced by", "legs", "said m/s", "flown m/s", "said over flown, total"),
        *("legs within 10 %", "a leg", "with own burns, total", "missing", "tanks broken"),
    )
    sums = defaultdict[tuple[str, str], list[tuple[Array, int]]](list)
    for kind, instance in _fields(catalogues, seeds, cuts):
        for burns in ("sequence", "free"):
            field = instance.replace(transfer=instance.transfer.replace(burns=burns))
            plan = planned(field)
            free = adr_opt.refine(field, plan, freedom="free", jobs=jobs)
            own = ""
            if burns == "sequence":
                told = adr_opt.refine(field, plan, freedom="planned", jobs=jobs)
                own = f"{told.planned_delta_v_m_s / told.flown_delta_v_m_s - 1.0:+.1%}"
            broken = sum(
                tank.flown_delta_v_m_s > 1.01 * tank.budget_m_s
                for tank in tanks_of(field, free)
                if tank.flown_delta_v_m_s is not None
            )
            both = np.array([(x.planned_delta_v_m_s, x.flown_delta_v_m_s) for x in free.legs]).T
            row(
                instance.name,
                burns,
                len(plan.legs),
                *(f"{each:.1f}" for each in both.sum(axis=1)),
                *_against_flown(*both),
                own,
                len(free.missing),
                broken,
            )
            sums[kind, burns].append((both, broken))
            name = instance.name.replace(",", "")
            kept += [f"{name},{burns},{x:.2f},{y:.2f}" for x, y in both.T]
    if out is not None:
        out.write_text("\n".join([*kept, ""]), encoding="utf-8")
    for (kind, burns), found in sums.items():
        both = np.concatenate([legs for legs, _ in found], axis=1)
        broken = sum(tanks > 0 for _, tanks in found)
        told = (f"{each:.1f}" for each in both.sum(axis=1))
        cells = [both.shape[1], *told, *_against_flown(*both)]
        row(f"**{kind}**", burns, *cells, "", "", f"in {broken} of {len(found)}")


def mean_motion(seeds: int = 2) -> None:
    """Accuracy of flight in mean motion against integrated motion, and its speed.

    Fields whose nodes drift, with eccentric orbits: what legs are planned with, what ``solve`` says
    that they take on the true orbits, and what the plan's own burns take when they are refined in
    the field J2, by an integrator that shares nothing with mean motion but the way in which burns
    are chosen.
    """
    fields = [
        (f"cloud-{seed:03d}", adr_opt.generate("cloud", seed).replace(dynamics="j2"))
        for seed in range(seeds)
    ]
    for family, most in (("nominal", 0.02), ("rocket-bodies", 0.015)):
        for seed in range(seeds):
            instance = eccentric(adr_opt.generate(family, seed), most, seed).replace(dynamics="j2")
            fields.append((f"{family}-{seed:03d}, e to {most:g}", instance))
    fly_mean(fields[0][1], planned(fields[0][1]))  # compiles
    head(
        *("field", "legs", "drifts", "planned", "mean motion", "integrated"),
        *("apart: total, a leg", "not led: mean, integrated", "a leg takes"),
    )
    for name, instance in fields:
        plan = planned(instance)
        flight, _, took = timed(lambda: fly_mean(instance, plan))  # noqa: B023
        assert flight is not None
        refined, _, refining = timed(
            lambda: adr_opt.refine(instance, plan, gravity="j2", freedom="planned", jobs=1)  # noqa: B023
        )
        both = [
            (flown, leg.flown_delta_v_m_s)
            for leg in refined.legs
            if (flown := flight.flown[leg.leg]) is not None
        ]
        legs = [leg for leg in plan.legs if leg.kind != "launch"]
        mean, true = np.array(both).T
        off = f"{100.0 * (mean.sum() / true.sum() - 1.0):+.2f} %"
        row(
            name,
            len(legs),
            sum(leg.kind == "drift" for leg in legs),
            f"{math.fsum(leg.delta_v_m_s for leg in legs):.1f} m/s",
            f"{mean.sum():.1f} m/s",
            f"{true.sum():.1f} m/s",
            f"{off}, {100.0 * np.abs(mean / true - 1.0).mean():.2f} %",
            f"{len(flight.problems)}, {len(refined.missing)}",
            f"{took / len(legs):.3f} s, {refining / len(legs):.2f} s",
        )
