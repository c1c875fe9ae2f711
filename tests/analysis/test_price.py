"""``price``: orders that people write, timed exactly, and what would mend those that break."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from conftest import Cli, refused
from hand_made import PERIOD_S, hand_made
from two_chasers import HOME, OWN, campaign, planned

import adr_opt
from adr_opt.analysis import orders_of, price, read_orders
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.mission.mission import Mission
from adr_opt.mission.relaxed import PRECISION_M_S
from adr_opt.problem.chasers import InOrbit, TankByMass
from adr_opt.problem.settings import MissionSettings
from adr_opt.ui.cli.timeline import clock

OPTIMAL = ("south", "station", "north", "beyond")


def priced(instance, *names, **options):
    return price(instance, {instance.chasers[0].name: names}, **options)


def test_an_order_that_holds_is_the_plan_of_the_scheduler() -> None:
    """Its legs are those that the exact planner gives the same order, and the check accepts it."""
    instance = hand_made()
    made = priced(instance, *OPTIMAL)
    assert made.holds
    assert made.objective == 3.0
    plan = made.plan()
    assert adr_opt.check(instance, plan) == ()
    best = adr_opt.solve(instance, "exact").plan
    assert [leg.model_dump() for leg in plan.legs] == [leg.model_dump() for leg in best.legs]
    assert plan.method == "by-hand"


def test_pricing_a_part_gives_the_times_of_the_whole() -> None:
    """Bodies that an order does not name make no difference to its legs."""
    instance = adr_opt.generate("tiny", 4)
    mission = Mission(instance, threads=1)
    order = instance.names[3], instance.names[1], instance.names[5]
    timing = mission.time(order)
    (route,) = priced(instance, *order).routes
    assert len(route.legs) == timing.made
    assert [leg.departure_s for leg in route.legs] == pytest.approx(timing.departures, abs=0.01)
    assert [leg.arrival_s for leg in route.legs] == list(timing.arrivals)
    assert [leg.delta_v_m_s for leg in route.legs] == list(timing.delta_vs)


@pytest.mark.parametrize("by_mass", [False, True])
def test_the_tank_that_is_missing_is_the_least(by_mass: bool) -> None:
    """With what is said to be missing an order can be flown, and with a little less it cannot."""
    instance = hand_made()
    if by_mass:
        tank = TankByMass(dry_mass_kg=500.0, propellant_kg=54.0, isp_s=300.0)
        instance = instance.replace(chasers=(instance.chaser.replace(tank=tank),))
    order = ("north", "south", "station", "beyond")
    (route,) = priced(instance, *order).routes
    assert not route.holds
    assert len(route.legs) == 1
    added = route.missing.delta_v_m_s
    # 132 and 263 to north and south, 132 back, against 300 or as much as that propellant is worth.
    full = instance.chaser.tank.delta_v_m_s
    assert added == pytest.approx(132.0 + 263.0 + 132.0 - full, abs=3.0)
    assert route.missing.time_s is None
    assert priced(instance.with_limits(delta_v_m_s=full + added), *order).holds
    less = full + added - 2.0 * PRECISION_M_S
    assert not priced(instance.with_limits(delta_v_m_s=less), *order).holds


def test_the_time_that_is_missing_is_the_least() -> None:
    """A mission that is longer by what is said to be missing is long enough, and just so."""
    instance = hand_made(periods=10.0)
    made = priced(instance, *OPTIMAL)
    (route,) = made.routes
    assert not made.holds
    assert len(route.legs) == 3
    longer = route.missing.time_s
    assert longer == pytest.approx(3.5 * PERIOD_S, abs=0.1 * PERIOD_S)
    assert route.missing.delta_v_m_s is None
    long = instance.mission.duration_s + longer
    assert priced(instance.with_limits(duration_s=long + 0.01), *OPTIMAL).holds
    assert not priced(instance.with_limits(duration_s=long - 1.0), *OPTIMAL).holds


def test_both_may_be_missing() -> None:
    """Where neither ΔV nor time alone would do, both figures are given, and both together do."""
    instance = hand_made(periods=8.0, delta_v_m_s=250.0)
    order = ("north", "beyond", "station")
    (route,) = priced(instance, *order).routes
    missing = route.missing
    assert missing.both
    enough = instance.with_limits(
        instance.mission.duration_s + missing.time_s + 0.01, 250.0 + missing.delta_v_m_s
    )
    assert priced(enough, *order).holds
    less = enough.with_limits(delta_v_m_s=250.0 + missing.delta_v_m_s - 2.0 * PRECISION_M_S)
    assert not priced(less, *order).holds


def test_a_window_that_closes_too_early_is_named() -> None:
    """Where a window is what breaks an order, it is said for how much longer it had to be open."""
    instance = hand_made()
    targets = [
        target.replace(window_s=(0.0, 3.1 * PERIOD_S)) if target.name == "beyond" else target
        for target in instance.targets
    ]
    closing = instance.replace(targets=tuple(targets))
    (route,) = priced(closing, "north", "beyond").routes
    assert len(route.legs) == 1
    longer = route.missing.window_s
    assert longer == pytest.approx(3.4 * PERIOD_S, abs=0.05 * PERIOD_S)

    def holds(closes_s: float) -> bool:
        moved = [
            target.replace(window_s=(0.0, closes_s)) if target.name == "beyond" else target
            for target in instance.targets
        ]
        return priced(instance.replace(targets=tuple(moved)), "north", "beyond").holds

    assert holds(3.1 * PERIOD_S + longer + 0.01)
    assert not holds(3.1 * PERIOD_S + longer - 1.0)


def test_every_single_change_that_mends_is_found() -> None:
    """Each remedy can be flown, the best comes first, and none that works is left out."""
    instance = hand_made()
    order = ("south", "north", "beyond")
    (route,) = priced(instance, *order).routes
    assert not route.holds
    found = {(each.kind, each.order) for each in route.remedies}
    for _, changed in found:
        assert priced(instance, *changed, mend=False).holds
    assert ("leave-out", ("north", "beyond")) in found
    assert ("refuel", OPTIMAL) in found
    assert route.remedies[0].order == OPTIMAL
    assert [each.prize for each in route.remedies] == sorted(
        (each.prize for each in route.remedies), reverse=True
    )
    tried = {order[:at] + order[at + 1 :] for at in range(3)}
    tried |= {(*order[:at], "station", *order[at:]) for at in (1, 2)}
    tried |= {("north", "south", "beyond"), ("south", "beyond", "north")}
    good = {each for each in tried if priced(instance, *each, mend=False).holds}
    assert good == {changed for _, changed in found}


def test_what_is_required_is_not_left_out() -> None:
    """No change leaves out a required target, and an order without it is no plan."""
    instance = hand_made()
    targets = tuple(target.replace(required=target.name == "south") for target in instance.targets)
    instance = instance.replace(targets=targets)
    made = priced(instance, "north", "beyond")
    assert made.lacking == ("south",)
    assert not made.holds
    with pytest.raises(InputError, match="repair it first"):
        made.plan()
    (route,) = priced(instance, "south", "north", "beyond").routes
    assert route.remedies
    assert all("south" in each.order for each in route.remedies)


def test_an_order_against_the_rules_says_which() -> None:
    """A target twice breaks where it comes again, and leaving one of the two out mends it."""
    made = priced(hand_made(), "north", "beyond", "north")
    (route,) = made.routes
    assert "which was visited before" in route.reason
    assert route.missing.delta_v_m_s is None
    assert {each.order for each in route.remedies} >= {("north", "beyond")}


def test_orders_are_read_from_words_and_files(tmp_path: Path) -> None:
    """Names, catalogue numbers, chasers with a colon; lines with comments; and plans."""
    instance = campaign()
    one, two, three = (target.name for target in instance.targets[:3])
    expected = {HOME: (one, two), OWN: (three,)}
    assert orders_of(instance, [f"{HOME}:", one, two, f"{OWN}:{three}"]) == expected
    path = tmp_path / "order.txt"
    path.write_text(f"# mine\n{HOME}:\n{one}  # first\n\n{two}\n{OWN}: {three}\n")
    assert read_orders(instance, path) == expected
    plan = planned()
    plan.save(path)
    flown = {route.chaser: tuple(leg.destination for leg in route.legs) for route in plan.routes}
    assert read_orders(instance, path) == flown
    field = adr_opt.generate("tiny", 0)
    named = field.replace(targets=(field.targets[0].replace(name="SL-16 R/B 22220"),))
    assert orders_of(named, ["22220"]) == {"chaser": ("SL-16 R/B 22220",)}


def test_orders_of_several_chasers_are_priced_like_their_plan(cli: Cli) -> None:
    """The order of a plan, written by hand, gives that plan again."""
    campaign().save("c.json")
    planned().save("p.json")
    outcome = cli("price", "c.json", "--file", "p.json", "--out", "again.json", "--quiet")
    assert outcome.status == 0, outcome
    again = adr_opt.load_plan("again.json")
    assert again.objective == planned().objective
    assert [leg.destination for leg in again.legs] == [leg.destination for leg in planned().legs]
    assert adr_opt.check(campaign(), again) == ()


def test_the_verb_tells_what_breaks_and_what_mends(cli: Cli) -> None:
    """Exit status 1 with leg and remedies, nothing written; 0 with a plan that `check` accepts."""
    hand_made().save("h.json")
    outcome = cli("price", "h.json", "south", "north", "beyond", "--out", "p.json")
    assert outcome.status == 1
    assert "breaks at leg 2, to north" in outcome.out
    assert "m/s more in each full tank" in outcome.out
    assert "would suffice: refuel before north: prize 3" in outcome.out
    assert "would suffice: leave out south: prize 2" in outcome.out
    assert "is not written" in outcome.err
    assert not Path("p.json").exists()
    outcome = cli("price", "h.json", *OPTIMAL, "--out", "p.json", "--json")
    assert outcome.status == 0
    content = json.loads(outcome.out)
    assert content["holds"]
    assert [leg["destination"] for leg in content["routes"][0]["legs"]] == list(OPTIMAL)
    assert cli("check", "h.json", "p.json").status == 0


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((), "give the order as NAME... or with --file"),
        (("north", "--file", "x.txt"), "one of the two"),
        (("nowhere",), "'nowhere' is not a body of 'hand-made'"),
        (("--file", "x.txt"), "x.txt: no such file"),
        (("--file", "bad.txt"), "bad.txt: line 2: 'nowhere' is not a body"),
    ],
)
def test_a_wrong_call_is_one_sentence(cli: Cli, arguments, named: str) -> None:
    """Exit status 2 and a sentence for whatever is no order."""
    hand_made().save("h.json")
    Path("bad.txt").write_text("north\nnowhere\n")
    refused(cli("price", "h.json", *arguments), named)


def test_several_chasers_have_to_be_told_apart(cli: Cli) -> None:
    """Without a chaser, with one twice, or a target for two, it is refused."""
    campaign().save("c.json")
    one = campaign().targets[0].name
    refused(cli("price", "c.json", one), "there are several chasers; begin with one")
    refused(cli("price", "c.json", f"{HOME}:{one}", f"{HOME}:"), "already has an order")
    refused(cli("price", "c.json", f"{HOME}:{one}", f"{OWN}:{one}"), "is visited by")


def test_drifting_orders_are_priced_too() -> None:
    """Under J2 with long transfers the tank that is missing is the least one, too."""
    instance = adr_opt.generate("rocket-bodies", 0, targets=4)
    instance = instance.replace(
        mission=MissionSettings(duration_s=120.0 * 86400.0, service_s=86400.0)
    ).with_limits(delta_v_m_s=150.0)
    order = instance.names[instance.first_target :][:3]
    (route,) = price(instance, {instance.chasers[0].name: order}).routes
    if route.holds:
        pytest.fail("the tank is too large for this test")
    added = route.missing.delta_v_m_s
    if added is not None:
        assert priced(instance.with_limits(delta_v_m_s=150.0 + added), *order).holds
    else:
        assert not priced(instance.with_limits(delta_v_m_s=600.0), *order).holds


def test_the_total_counts_tows(cli: Cli) -> None:
    """What is said of an order is what the plan of it comes to: ΔV and end with all tows."""
    field = adr_opt.generate("tiny", 1, targets=3).with_limits(duration_s=200_000.0)
    instance = field.replace(
        stations=(),
        chasers=(
            field.chaser.replace(
                start=InOrbit(orbit=field.stations[0].orbit),
                tank=TankByMass(dry_mass_kg=500.0, propellant_kg=600.0, isp_s=310.0),
            ),
        ),
        targets=tuple(target.replace(removal="tow", mass_kg=250.0) for target in field.targets),
        mission=field.mission.replace(disposal={"circle_m": 450e3}),
    )
    order = ("debris-001", "debris-003")
    plan = priced(instance, *order).plan()
    towing_m_s = sum(leg.tow.delta_v_m_s for leg in plan.legs)
    assert towing_m_s > 100.0
    instance.save("t.json")
    outcome = cli("price", "t.json", *order)
    assert outcome.status == 0, outcome
    said = f"ΔV {plan.delta_v_m_s:.1f} m/s, done {clock(plan.legs[-1].tow.end_s)}"
    assert outcome.out.splitlines()[-1] == f"prize 2, {said}"


def test_what_mends_counts_prizes_alone(cli: Cli) -> None:
    """A required target is worth its prize in a suggestion, without the weight for planners."""
    instance = hand_made()
    targets = tuple(
        target.replace(required=target.name != "far", prize=prize)
        for target, prize in zip(instance.targets, (2.0, 3.0, 1.0, 1.0), strict=True)
    )
    instance.replace(targets=targets).save("h.json")
    outcome = cli("price", "h.json", "south", "north", "beyond", "--json")
    (route,) = json.loads(outcome.out)["routes"]
    assert {tuple(each["order"]): each["prize"] for each in route["mendings"]}[OPTIMAL] == 6.0
    assert (
        "would suffice: refuel before north: prize 6,"
        in cli("price", "h.json", "south", "north", "beyond").out
    )


def window_of(instance, name: str, closes_s: float):
    return instance.replace(
        targets=tuple(
            target.replace(window_s=(0.0, closes_s)) if target.name == name else target
            for target in instance.targets
        )
    )


def leaving_at(instance, end_s: float):
    return instance.replace(chasers=(instance.chaser.replace(available_s=(0.0, end_s)),))


@pytest.mark.parametrize(
    ("instance", "order", "named", "others"),
    [
        (hand_made(), ("south", "north"), "it needs 262.488 m/s, but only 168", ("day", "window")),
        (
            window_of(hand_made(), "beyond", 3.1 * PERIOD_S),
            ("north", "beyond"),
            "after its window closes",
            ("m/s", "mission", "gone"),
        ),
        (
            leaving_at(hand_made(), 5.0 * PERIOD_S),
            ("north", "beyond"),
            "after its chaser is gone",
            ("m/s", "mission", "window"),
        ),
        (
            hand_made(periods=6.3),
            ("north", "beyond"),
            "min after the mission",
            ("m/s", "window", "gone"),
        ),
    ],
)
def test_the_one_true_reason_is_told_in_days(
    cli: Cli, instance, order: tuple[str, ...], named: str, others: tuple[str, ...]
) -> None:
    """Of ΔV, window, mission and the time of the chaser that is named which breaks the order."""
    instance.save("h.json")
    outcome = cli("price", "h.json", *order)
    assert outcome.status == 1, outcome
    (line,) = [line for line in outcome.out.splitlines() if "breaks at leg 2" in line]
    assert named in line
    reason = line.partition(": it ")[2]
    assert not any(other in reason for other in others), reason
    if "m/s" in others:
        day = float(re.search(r"ends on day ([0-9.]+) at the earliest", reason)[1])
        assert day == pytest.approx(6.5 * PERIOD_S / DAY_S, abs=1e-3)
        assert " s " not in reason


def test_where_either_would_do_both_reasons_are_told() -> None:
    """What is cheap enough ends too late, and what ends in time is too dear: so it is said."""
    found = 0
    for seed in range(6):
        instance = adr_opt.generate("tiny", seed, targets=4)
        first, second = instance.names[instance.first_target :][:2]
        connections = adr_opt.Timetable(instance).connections(first, second)
        least_m_s, dear_m_s = connections.delta_v.min(), connections.delta_v.max()
        if dear_m_s < least_m_s + 1.0:
            continue
        (route,) = priced(instance, first, second, mend=False).routes
        last_s = float(connections.arrival[connections.delta_v.argmin()])
        spent_m_s = route.legs[0].delta_v_m_s
        enough = spent_m_s + float(least_m_s) + 0.01
        limited = window_of(instance, second, last_s - 1.0).with_limits(delta_v_m_s=enough)
        (broken,) = priced(limited, first, second, mend=False).routes
        if broken.holds or len(broken.legs) != 1:
            continue
        if "to end in time, but only" in broken.reason:
            assert "an affordable leg ends on day" in broken.reason
            assert "its window closes" in broken.reason
            found += 1
    assert found > 0
