"""What objects show of themselves at a prompt and in a notebook."""

from __future__ import annotations

import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hand_made import hand_made
from two_chasers import campaign, planned

import adr_opt
from adr_opt.analysis import Axis, compare, price, rehearse, replan, tradeoff
from adr_opt.common.card import MOST_NAMES, MOST_ROWS, CardTable, order_words
from adr_opt.mission.certify import certificate_of
from adr_opt.mission.problem import Problem
from adr_opt.problem.uncertainty import Uncertainty

NASTY = "<script>alert('x')</script> & co"


KINDS = (
    "instance",
    "mission",
    "campaign",
    "result",
    "bound",
    "plan",
    "plan of two",
    "route",
    "leg",
    "timetable",
    "matrices",
    "connections",
    "order",
    "route of it",
    "comparison",
    "replanned",
    "rehearsals",
    "tradeoff",
    "certificate",
)


@cache
def shown() -> dict[str, Any]:
    """One of everything that shows itself."""
    instance = hand_made()
    mission = adr_opt.Mission(instance)
    result = adr_opt.solve(mission, "exact", time_limit=30.0)
    plan = result.plan
    guarded = adr_opt.solve(mission, "greedy-guarded").plan
    return {
        "instance": instance,
        "mission": mission,
        "campaign": Problem(campaign()),
        "result": result,
        "bound": adr_opt.bound(mission, "routing-bound", time_limit=60.0),
        "plan": plan,
        "plan of two": planned(),
        "route": plan.routes[0],
        "leg": plan.legs[0],
        "timetable": mission.timetable,
        "matrices": mission.timetable.matrices([0.0, 600.0]),
        "connections": mission.timetable.connections(0, 1),
        "order": price(instance, [plan.destinations[0], plan.destinations[0]]),
        "route of it": price(instance, plan).routes[0],
        "comparison": compare(instance, {"one": plan, "two": guarded}),
        "replanned": replan(instance, plan, plan.legs[0].end_s, method="greedy"),
        "rehearsals": rehearse(instance, plan, Uncertainty(gone=0.5), samples=3),
        "tradeoff": tradeoff(instance, [Axis("delta-v", (200.0, 300.0))], time_limit=60.0),
        "certificate": certificate_of(instance, result),
    }


class Tags(HTMLParser):
    """Sees that all that is opened is closed, and keeps what is said."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Remember that it is open, but for those that are never closed."""
        self.seen.append(tag)
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        """See that it is the last one that was opened."""
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Keep what is said."""
        self.words.append(data)


@pytest.mark.parametrize("which", KINDS)
def test_a_line_is_short_and_a_page_is_whole(which: str) -> None:
    """The line says what it is, of what, in at most 300 letters; the page is a piece of HTML."""
    one = shown()[which]
    line = repr(one)
    assert line == str(one)
    assert line.startswith(f"<{type(one).__name__}")
    assert line.endswith(">")
    assert len(line) <= 300
    assert "\n" not in line
    page = Tags(one._repr_html_())
    assert page.open == []
    assert {"script", "style", "link", "img"}.isdisjoint(page.seen)
    assert page.words[0].startswith(type(one).__name__)


def test_there_is_one_of_each_kind() -> None:
    """The kinds that are looked at are those that there are."""
    assert tuple(shown()) == KINDS


def test_results_and_plans_tell_the_order_by_names() -> None:
    """Sequences are told by names: in the line, on the page, and as attributes."""
    result, instance = shown()["result"], shown()["instance"]
    names = tuple(instance.names[body] for body in result.sequence)
    assert result.destinations == result.plan.destinations == names
    assert result.orders == result.plan.orders == {instance.chaser.name: names}
    assert order_words(names) in repr(result)
    assert order_words(names) in "".join(Tags(result._repr_html_()).words)
    assert (shown()["bound"].destinations, shown()["bound"].orders) == ((), {})
    many = [f"debris-{number}" for number in range(40)]
    assert order_words(many).count("→") == MOST_NAMES
    assert order_words(many).endswith("debris-39")


def test_names_of_others_are_no_code() -> None:
    """What a file calls its bodies is text on a page, whatever it looks like."""
    field = adr_opt.generate("tiny", 0)
    instance = field.replace(
        name=NASTY,
        targets=tuple(
            target.replace(name=f"{NASTY} {number}") for number, target in enumerate(field.targets)
        ),
    )
    mission = adr_opt.Mission(instance)
    result = adr_opt.solve(mission, "greedy-guarded")
    for one in (instance, mission, result, result.plan, mission.timetable.matrices([0.0])):
        page = one._repr_html_()
        assert "<script>" not in page
        assert "script" not in Tags(page).seen
    assert f"{NASTY} " in "".join(Tags(result.plan._repr_html_()).words)


def test_the_page_on_python_shows_what_is_shown() -> None:
    """What docs/api.md has a prompt say is what it says."""
    page = (Path(__file__).parents[2] / "docs" / "api.md").read_text(encoding="utf-8")
    pairs = re.findall(r"(?m)^>>> (.*)\n(<.*>)$", page)
    assert len(pairs) == 2
    for code, said in pairs:
        assert repr(eval(code, {"adr_opt": adr_opt})) == said


def test_long_tables_are_cut_and_say_so() -> None:
    """Of a long table the first rows are shown, and how many more there are."""
    rows = [(f"{number}",) for number in range(MOST_ROWS + 5)]
    words = Tags(CardTable(("number",), rows).html()).words
    assert words[1:-1] == [row[0] for row in rows[:MOST_ROWS]]
    assert words[-1] == "and 5 more"


def test_matrices_are_equal_to_the_last_digit_or_close() -> None:
    """Equality is exact and no more; closeness has tolerances with units, and infinities agree."""
    timetable = shown()["timetable"]
    one, other = timetable.matrices([0.0, 600.0]), timetable.matrices([0.0, 600.0])
    assert one == other
    assert one.allclose(other)
    assert one != timetable.matrices([0.0, 601.0])
    assert one != timetable.matrices([0.0])
    assert not one.allclose(timetable.matrices([0.0]))
    assert one != "matrices"
    with pytest.raises(TypeError, match="unhashable"):
        hash(one)
    other.delta_v[np.isfinite(other.delta_v)] += 1e-3
    assert one != other
    assert not one.allclose(other)
    assert one.allclose(other, delta_v_m_s=2e-3)
    other.delta_v[0, 0, 1] = np.inf if np.isfinite(one.delta_v[0, 0, 1]) else 1.0
    assert not one.allclose(other, delta_v_m_s=1e9)
    chosen = timetable.matrices([0.0, 600.0], choose="cheapest")
    assert chosen != type(chosen)(*(vars(chosen) | {"choice": "another"}).values())
    assert chosen.allclose(type(chosen)(*(vars(chosen) | {"choice": "another"}).values()))
