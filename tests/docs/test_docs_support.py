"""Pages on the support of rules, compared with what methods declare."""

from __future__ import annotations

import re
from pathlib import Path

from adr_opt.problem.rules import CAMPAIGNS, RULES, TOURS
from adr_opt.run.methods import BOUNDS, PLANNERS, names, spec

ROOT = Path(__file__).parents[2]


def followers(word: str) -> list[str]:
    """Methods that follow a rule; bounds among them once."""
    found = [(name, group) for group in (PLANNERS, BOUNDS) for name in names(group)]
    return sorted({name for name, group in found if word in spec(name, group).follows})


def test_the_table_of_support_is_that_of_the_methods() -> None:
    """Each rule beyond those of one route has a row, with its field and the methods that follow."""
    text = (ROOT / "docs" / "rules.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([a-z ]+) \| `([^`]+)` \| (.+) \|$", text, re.M)
    table = {word: (field, re.findall(r"`([a-z-]+)`", who)) for word, field, who in rows}
    beyond = [
        word
        for word in RULES
        if word in CAMPAIGNS | TOURS | {"functions of time", "visits between refuellings"}
    ]
    assert {word: table.get(word) for word in beyond} == {
        word: (RULES[word].fields[0], followers(word)) for word in beyond
    }


def test_the_walk_of_a_rule_leads_where_it_stands() -> None:
    """Each file of the walk in CONTRIBUTING is there, and is about that rule."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    walk = text.partition("## Adding a rule")[2].partition("\nMoves, episodes")[0]
    files = re.findall(r"`((?:adr_opt|solvers|tests|docs)/[^`]+)`", walk.partition("| what |")[2])
    assert len(files) > 10
    for file in files:
        content = (ROOT / file).read_text(encoding="utf-8")
        assert re.search(r"visits.between.refuel|\bbetween\"?[:=]", content), file
