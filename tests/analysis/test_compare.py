"""``compare``: plans side by side, and leg by leg."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import pytest
from conftest import Cli, refused
from hand_made import hand_made
from two_chasers import campaign, planned

import adr_opt
from adr_opt.analysis import compare, price
from adr_opt.ui.report.charts import ticks
from adr_opt.ui.report.compared import compared_page


def by_hand(*names, instance=None):
    return price(instance or hand_made(), {"chaser": names}).plan()


BEST = ("south", "station", "north", "beyond")


@pytest.fixture(scope="module")
def plans():
    return {"best": by_hand(*BEST), "other": by_hand("north", "beyond"), "again": by_hand(*BEST)}


def test_figures_are_those_of_the_plans(plans) -> None:
    """Each side has the prize, the visits and the ΔV of its plan, and what `check` says."""
    comparison = compare(hand_made(), plans)
    best, other, _ = comparison.sides
    assert (best.objective, best.visits, best.refuellings, best.violations) == (3.0, 3, 1, 0)
    assert (other.objective, other.visits, other.refuellings) == (2.0, 2, 0)
    assert best.delta_v_m_s == plans["best"].delta_v_m_s
    assert best.end_s == plans["best"].legs[-1].end_s


def test_legs_are_aligned(plans) -> None:
    """A run of bodies that both plans have is paired, the rest stands alone, and all is there."""
    comparison = compare(hand_made(), plans)
    other, again = comparison.differences
    assert again.same
    assert other.lost == ("south",)
    assert other.gained == ()
    assert [(pair.destination, pair.what) for pair in other.pairs] == [
        ("south", "only"),
        ("station", "only"),
        ("north", "retimed"),
        ("beyond", "retimed"),
    ]
    for difference in comparison.differences:
        firsts = [pair.first for pair in difference.pairs if pair.first]
        others = [pair.other for pair in difference.pairs if pair.other]
        assert firsts == list(enumerate(plans["best"].legs, start=1))
        assert others == list(enumerate(plans[difference.name].legs, start=1))


def test_a_target_at_another_place_is_moved() -> None:
    """Two orders of the same targets differ in places, and nothing is gained or lost."""
    instance = hand_made(delta_v_m_s=900.0, periods=20.0)
    plans = {
        "one": by_hand("north", "beyond", "south", instance=instance),
        "two": by_hand("south", "north", "beyond", instance=instance),
    }
    (difference,) = compare(instance, plans).differences
    assert difference.gained == difference.lost == ()
    assert [pair.what for pair in difference.pairs if pair.destination == "south"] == ["moved"] * 2


def test_the_verb_tells_and_writes(cli: Cli, plans) -> None:
    """Tables, JSON and page have the same figures; the page runs no script and loads nothing."""
    hand_made().save("h.json")
    plans["best"].save("best.json")
    plans["other"].save("other.json")
    outcome = cli("compare", "h.json", "best.json", "other.json", "--page", "c.html")
    assert outcome.status == 0, outcome
    assert "other.json loses 1: south" in outcome.out
    assert "only in the first" in outcome.out
    page = Path("c.html").read_text(encoding="utf-8")
    HTMLParser().feed(page)
    assert "<script" not in page
    assert "http" not in page.replace("http-equiv", "")
    assert page.count('<figure class="drawn">') == 2
    for plan in plans.values():
        assert f"{plan.delta_v_m_s:.1f}" in page
    content = json.loads(cli("compare", "h.json", "best.json", "other.json", "--json").out)
    assert [side["objective"] for side in content["plans"]] == [3.0, 2.0]
    assert content["differences"][0]["lost"] == ["south"]
    outcome = cli("compare", "h.json", "best.json", "other.json", "--all")
    assert outcome.status == 0


def test_a_plan_with_violations_is_the_answer_no(cli: Cli, plans) -> None:
    """Exit status 1 if a plan breaks the rules; it is compared all the same."""
    hand_made().save("h.json")
    plans["best"].save("best.json")
    wrong = plans["other"].replace(objective=5.0)
    wrong.save("wrong.json")
    outcome = cli("compare", "h.json", "best.json", "wrong.json", "--json")
    assert outcome.status == 1
    assert json.loads(outcome.out)["plans"][1]["violations"] >= 1


def test_names_with_signs_do_no_harm(plans) -> None:
    """What a name has in it is text in the page, and nothing else."""
    evil = "<script>alert(1)</script>"
    renamed = {evil: plans["best"], "other": plans["other"]}
    page = compared_page(compare(hand_made(), renamed))
    assert evil not in page
    assert "&lt;script&gt;" in page


def test_campaigns_are_compared_by_chaser(cli: Cli) -> None:
    """Legs are paired chaser by chaser."""
    campaign().save("c.json")
    planned().save("a.json")
    adr_opt.solve(campaign(), "greedy-guarded").plan.save("b.json")
    outcome = cli("compare", "c.json", "a.json", "b.json", "--page", "c.html", "--json")
    assert outcome.status == 0, outcome
    pairs = json.loads(outcome.out)["differences"][0]["legs"]
    assert {pair["chaser"] for pair in pairs} == {route.chaser for route in planned().routes}
    assert "chaser" in Path("c.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("best.json",), "give two or more"),
        (("best.json", "best.json"), "a plan is given twice"),
        (("best.json", "none.json"), "none.json: no such file"),
        (("best.json", "foreign.json"), "foreign.json: "),
        (("best.json", "other.json", "--page", "c.txt"), "give a file that ends in .html"),
        (("best.json", "other.json", "--page", "no/c.html"), "does not exist"),
    ],
)
def test_a_wrong_call_is_one_sentence(cli: Cli, plans, arguments, named: str) -> None:
    """Exit status 2 and a sentence, and no page is written."""
    hand_made().save("h.json")
    plans["best"].save("best.json")
    plans["other"].save("other.json")
    longer = hand_made(periods=20.0)
    by_hand("north", instance=longer).save("foreign.json")
    refused(cli("compare", "h.json", *arguments), named)
    assert not Path("c.html").exists()


def test_ticks_are_round_and_cover_the_range() -> None:
    """From at most the least to at least the largest value, in steps of 1, 2 or 5."""
    assert ticks(0.0, 30.0) == [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0]
    assert ticks(0.0, 1.0)[-1] >= 1.0
    for high in (0.003, 7.0, 123.0, 99_999.0):
        found = ticks(0.0, high)
        assert found[0] <= 0.0
        assert found[-1] >= high
        assert 4 <= len(found) <= 9
