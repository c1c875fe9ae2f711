"""``price``: time a given order; if it breaks, report where, with remedies."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import click

from ...common.errors import InputError
from ...common.wording import counted
from . import param
from .output import emit, emit_json, emit_rich, say, terminal_width
from .parameters import check_out

if TYPE_CHECKING:
    from ...analysis import PricedOrder, PricedRoute
    from ...analysis.remedies import Remedy, Shortfall


@click.command("price", short_help="Time an order of bodies, and suggest repairs.")
@param.instance
@click.argument("names", nargs=-1, metavar="NAME...")
@param.file("--file", "File with the order, one name per line.", name="file_path")
@param.word("--out", "PLAN", "Plan file to write if the order can be flown.")
@param.spoken
def command(
    instance_path: str,
    names: tuple[str, ...],
    file_path: str | None,
    out: str | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Time the bodies NAME... of INSTANCE in this order, given by name or catalogue number.

    With several chasers, CHASER: precedes the names of each. Exit status 1: the order cannot be
    flown as it is.
    """
    from ...analysis import orders_of, price, read_orders
    from ...problem.instance import load

    if bool(names) == (file_path is not None):
        raise InputError("give the order as NAME... or with --file, one of the two")
    instance = load(instance_path)
    check_out(out, instance_path, file_path)
    orders = orders_of(instance, names) if file_path is None else read_orders(instance, file_path)
    priced = price(instance, orders)
    if out is not None and priced.holds:
        plan = priced.plan()
        plan.save(out)
        say(f"wrote {out}: objective {plan.objective:g}", unless=quiet)
    elif out is not None and not quiet:
        say(f"{out} is not written: the order cannot be flown as given")
    if as_json:
        emit_json(priced.to_dict())
    else:
        _tell(priced)
    return 0 if priced.holds else 1


def _tell(priced: PricedOrder) -> None:
    from .timeline import clock, timeline

    instance, number = priced.instance, 1
    for route in priced.routes:
        if route.legs:
            title = f"{instance.name}: {route.chaser}, {_made(route)}"
            legs = list(enumerate(route.legs, start=number))
            emit_rich(timeline(instance, legs, terminal_width(), title))
        number += len(route.legs)
        for line in _verdict(route, several=len(priced.routes) > 1):
            emit(line)
    if priced.lacking:
        emit(f"required, but in no order: {', '.join(priced.lacking)}")
    for chaser in priced.unended:
        emit(f"{chaser}: the order ends where its mission may not end")
    delta_v = sum(leg.spent_m_s for route in priced.routes for leg in route.legs)
    end_s = max((leg.done_s for route in priced.routes for leg in route.legs), default=0.0)
    emit(f"prize {priced.objective:g}, ΔV {delta_v:.1f} m/s, done {clock(end_s)}")


def _made(route: PricedRoute) -> str:
    legs = counted(len(route.order), "leg")
    return f"all {legs}" if route.holds else f"{len(route.legs)} of {legs}"


def _verdict(route: PricedRoute, *, several: bool) -> Iterator[str]:
    """The obstacle to an order, and its remedies, as lines."""
    if route.holds:
        return
    whose = f"{route.chaser}: " if several else ""
    at = len(route.legs)
    to = route.order[at]
    reason = route.reason.removeprefix(f"to {to!r} ")
    yield f"{whose}breaks at leg {at + 1}, to {to}: it {reason}"
    best = {remedy.kind: remedy for remedy in reversed(route.remedies)}
    told = [remedy for remedy in route.remedies if best[remedy.kind] is remedy]
    lines = [*_lacking(route.missing), *map(_told, told)]
    yield from (f"{whose}would suffice: {line}" for line in lines)
    more = len(route.remedies) - len(told)
    if more > 0:
        yield f"{whose}and {counted(more, 'other single change')}; --json lists all"
    if not lines:
        yield f"{whose}no larger tank, longer mission or single change would suffice"


def _lacking(missing: Shortfall) -> Iterator[str]:
    from .timeline import span

    found = []
    if missing.delta_v_m_s is not None:
        found.append(f"{missing.delta_v_m_s:.1f} m/s more in each full tank")
    if missing.time_s is not None:
        found.append(f"a mission that is {span(missing.time_s)} longer")
    if missing.both:
        yield f"{found[0]}, and {found[1]}, together"
    else:
        yield from found
    if missing.window_s is not None:
        yield f"a window there that is open {span(missing.window_s)} longer"


def _told(remedy: Remedy) -> str:
    from .timeline import clock

    what = {
        "leave-out": f"leave out {remedy.body}",
        "refuel": f"refuel before {remedy.body}",
        "swap": f"change {remedy.body} and the one after it",
    }[remedy.kind]
    return (
        f"{what}: prize {remedy.prize:g}, ΔV {remedy.delta_v_m_s:.1f} m/s, done "
        f"{clock(remedy.end_s)}"
    )
