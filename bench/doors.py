"""Doors and defects: what each verb that reads a plan makes of what is wrong with it.

Each defect is an edit of a good file; each door a verb. A cell is ``refused`` (exit status 2, one
sentence), ``stated`` (the verb goes on and says that the file is not legal, or its answer is no),
``silent`` or ``traceback``; the last two are faults of ours::

    python bench/doors.py defects             # the tables of docs/judging.md
    python bench/doors.py defects --counts    # the counts alone
    python bench/doors.py cost       # what judging takes of a warm solve and of refine
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import statistics
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

from tables import experiment, head, row

import adr_opt
from adr_opt.judge.admit import admit
from adr_opt.plan.refined_plan import reference
from adr_opt.ui.cli.entry import main as command_line

Content = dict[str, Any]
Edit = Callable[[Content], None]


def _legs(plan: Content) -> list[Content]:
    return plan["routes"][0]["legs"] if "routes" in plan else plan["legs"]


def _halved(plan: Content) -> None:
    for leg in _legs(plan):
        leg["delta_v_m_s"] /= 2.0
        for burn in leg["burns"]:
            burn["delta_v_m_s"] = [value / 2.0 for value in burn["delta_v_m_s"]]


def _set(number: int, field: str, change: Callable[[Any], Any]) -> Edit:
    """Change a field of a leg."""

    def edit(plan: Content) -> None:
        leg = _legs(plan)[number]
        leg[field] = change(leg[field])

    return edit


def _top(field: str, change: Callable[[Any], Any]) -> Edit:
    """Change a field of the file."""

    def edit(plan: Content) -> None:
        plan[field] = change(plan.get(field))

    return edit


def _swap(one: int, other: int) -> Edit:
    def edit(plan: Content) -> None:
        legs = _legs(plan)
        legs[one], legs[other] = legs[other], legs[one]

    return edit


def _burn(number: int, which: int, change: Callable[[list[float]], list[float]]) -> Edit:
    """Change the ΔV of a burn."""

    def edit(plan: Content) -> None:
        burn = _legs(plan)[number]["burns"][which]
        burn["delta_v_m_s"] = change(burn["delta_v_m_s"])

    return edit


def _reversed(values: list[float]) -> list[float]:
    return [-value for value in values]


def _late(number: int, which: int, seconds: float) -> Edit:
    def edit(plan: Content) -> None:
        _legs(plan)[number]["burns"][which]["time_s"] += seconds

    return edit


def _stranger(plan: Content) -> None:
    plan["instance"]["sha256"] = "0" * 64


PLANS: dict[str, Edit] = {
    "all ΔV halved": _halved,
    "ΔV of a leg 1 m/s less": _set(0, "delta_v_m_s", lambda value: value - 1.0),
    "1 m/s more left": _set(1, "delta_v_left_m_s", lambda value: value + 1.0),
    "first leg lost": lambda plan: _legs(plan).pop(0) and None,
    "last leg lost": lambda plan: _legs(plan).pop() and None,
    "two legs exchanged": _swap(0, 1),
    "a leg twice": lambda plan: _legs(plan).insert(1, dict(_legs(plan)[0])),
    "departure 100 s earlier": _set(1, "departure_s", lambda value: value - 100.0),
    "arrival 100 s earlier": _set(1, "arrival_s", lambda value: value - 100.0),
    "service 100 s shorter": _set(1, "end_s", lambda value: value - 100.0),
    "ready 100 s earlier": _set(1, "ready_s", lambda value: value - 100.0),
    "a burn reversed": _burn(1, 0, _reversed),
    "a burn 10 s later": _late(1, 1, 10.0),
    "a burn missing": lambda plan: _legs(plan)[1]["burns"].pop(1) and None,
    "an unknown destination": _set(1, "destination", lambda _: "nowhere"),
    "one phasing revolution more": _set(1, "phasing_revolutions", lambda value: value + 1),
    "another prize": _top("objective", lambda value: value + 1.0),
    "another cost": _top("cost", lambda value: value - 10.0),
    "an invented gap": _top("gap", lambda _: 0.25),
    "an invented bound on cost": _top("cost_bound", lambda _: 1e9),
    "of another instance": _stranger,
    "an unknown chaser": lambda plan: plan["routes"][0].update(chaser="nobody"),
}
"""Edits of a plan file."""


def _state(number: int, which: int, field: str, change: Callable[[Any], Any]) -> Edit:
    def edit(refined: Content) -> None:
        state = refined["legs"][number]["states"][which]
        state[field] = change(state[field])

    return edit


def _bigger(refined: Content) -> None:
    """A burn 1 m/s larger, with the sum that the reader asks for."""
    leg = refined["legs"][0]
    leg["burns"][0]["delta_v_m_s"][0] += 1.0
    leg["flown_delta_v_m_s"] = sum(
        sum(value * value for value in burn["delta_v_m_s"]) ** 0.5 for burn in leg["burns"]
    )


def _kilometre(values: list[float]) -> list[float]:
    return [values[0] + 1e3, *values[1:]]


def _lost_from_both(refined: Content) -> None:
    """The second leg lost from the legs and from the plan, whose digest is written anew."""
    plan = refined["planned"]
    plan["routes"][0]["legs"].pop(1)
    legs = [leg for leg in refined["legs"] if leg["leg"] != 2]
    refined["legs"] = [leg | {"leg": number} for number, leg in enumerate(legs, start=1)]
    refined["plan"] = reference(adr_opt.Plan.from_json(json.dumps(plan))).model_dump(mode="json")


REFINED: dict[str, Edit] = {
    "a velocity reversed": _state(0, 0, "velocity_m_s", _reversed),
    "a later velocity reversed": _state(1, 2, "velocity_m_s", _reversed),
    "a position 1 km off": _state(0, 1, "position_m", _kilometre),
    "the arrival 1 km off": _state(0, -1, "position_m", _kilometre),
    "a state 10 s later": _state(0, 1, "time_s", lambda value: value + 10.0),
    "a state missing": lambda refined: refined["legs"][0]["states"].pop(1) and None,
    "a burn reversed": _burn(0, 0, _reversed),
    "a burn 1 m/s larger": _bigger,
    "a burn 10 s later": _late(0, 0, 10.0),
    "last leg lost": lambda refined: refined["legs"].pop() and None,
    "first leg lost": lambda refined: refined["legs"].pop(0) and None,
    "a leg lost from it and its plan": _lost_from_both,
    "a leg under another number": _set(-1, "leg", lambda value: value + 1),
    "of another instance": _stranger,
    "of another plan": lambda refined: refined["plan"].update(sha256="0" * 64),
    "the seed of another plan": lambda refined: refined["plan"].update(seed=77),
    "without its plan": lambda refined: refined.pop("planned") and None,
    "its plan with another ΔV": lambda refined: _set(0, "delta_v_m_s", lambda v: v - 1.0)(
        refined["planned"]
    ),
    "an unknown origin": _set(0, "origin", lambda _: "nowhere"),
    "another destination": lambda refined: refined["legs"][0].update(
        destination=refined["legs"][1]["destination"]
    ),
    "a body 1 km off": lambda refined: refined["bodies"][1].update(
        position_m=_kilometre(refined["bodies"][1]["position_m"])
    ),
    "another field of gravity": _top("gravity", lambda _: "two-body"),
    "another planned ΔV": _set(0, "planned_delta_v_m_s", lambda value: value + 1.0),
    "another time of readiness": _set(1, "ready_s", lambda value: value + 50.0),
    "another end of service": _set(0, "end_s", lambda value: value + 50.0),
    "propellant vented": lambda refined: refined["legs"][0].update(vented_kg=5.0),
}
"""Edits of a refined plan."""

CERTIFICATES: dict[str, Edit] = {
    "of another instance": _stranger,
    "a bound 1 lower": _top("upper_bound", lambda value: value - 1.0),
    "that there is no plan": _top("upper_bound", lambda _: None),
    "an unknown name": lambda made: made["multipliers"].update(nowhere=1.0),
    "an unknown chaser": lambda made: (
        [walks.update(chasers=["nobody"]) for walks in made["walks"]] and None
    ),
    "walks lost": _top("walks", lambda _: []),
    "walks that collect less": lambda made: (
        [walks.update(most=walks["most"] / 2.0) for walks in made["walks"]] and None
    ),
    "of another plan": _top("plan_sha256", lambda _: "0" * 64),
    "a wrong step of prizes": _top("prize_step", lambda _: 0.7),
    "multipliers that pay for all": lambda made: made.update(
        multipliers={name: 1e6 for name in made["multipliers"]} | {made["_first"]: 1e6}
    ),
}
"""Edits of a certificate."""

PLAN_DOORS = {
    "check": "check i.json x.json",
    "fly": "fly i.json x.json",
    "refine": "refine i.json x.json --out o.json --jobs 1",
    "export": "export i.json x.json --out o.oem",
    "report": "report i.json x.json --out o.html",
    "replan": "replan i.json x.json --at 0.4 --time-limit 0.3",
    "rehearse": "rehearse i.json x.json --uncertainty u.json --samples 2",
    "compare": "compare i.json p.json x.json",
    "verify": "verify i.json x.json c.json",
    "serve": "serve i.json x.json --no-open --folder served",
    "solve --start": "solve i.json --start x.json --method local-search --time-limit 0.3",
    "bound --start": "bound i.json --start x.json --method lagrangian --time-limit 0.3",
}
REFINED_DOORS = {
    "check": "check i.json x.json",
    "fly": "fly i.json x.json",
    "fly --samples": "fly i.json x.json --samples 3",
    "export .oem": "export i.json x.json --out o.oem",
    "export .ocm": "export i.json x.json --out o.ocm",
    "export .czml": "export i.json x.json --out o.czml",
    "report": "report i.json p.json --refined x.json --out o.html",
}
CERTIFICATE_DOORS = {
    "verify": "verify i.json p.json x.json",
    "verify the bound alone": "verify i.json x.json",
}

LEGAL = {("without its plan", "report")}
"""Cells that are no defect: with the plan beside it the file is judged as any other."""

NO = ("violation", "not legal", "unjudged", "refused:")
"""Words by which a verb that goes on says so."""


def outcome(arguments: str) -> str:
    """What a verb makes of a file: refused, stated, silent or traceback."""
    out, err = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = command_line(arguments.split())
    except Exception:
        return "traceback"
    said = (out.getvalue() + err.getvalue()).replace("no violations", "")
    if status == 2:
        return "refused" if len(err.getvalue().strip().splitlines()) == 1 else "silent"
    if status not in (0, 1) or "Traceback" in said:
        return "traceback"
    listed = status == 1 and any(line.startswith("x.json: ") for line in said.splitlines())
    return "stated" if listed or any(word in said for word in NO) else "silent"


def good_files(seed: int = 1) -> None:
    """Write a small mission and good files of it into the current folder."""
    instance = adr_opt.generate("tiny", seed).replace(dynamics="j2")
    instance.save("i.json")
    solve = "solve i.json --method exact --time-limit 60 --out p.json --certificate c.json --no-fly"
    refine = "refine i.json p.json --out r.json --jobs 1"
    for words in (solve, refine):
        assert command_line([*words.split(), "--quiet"]) == 0
    Path("u.json").write_text('{"format": "adr-opt-uncertainty/1"}', encoding="utf-8")


def edited(path: str, edit: Edit) -> None:
    """Write an edited copy of a file as x.json."""
    content = json.loads(Path(path).read_text(encoding="utf-8"))
    if path == "c.json":
        targets = json.loads(Path("i.json").read_text(encoding="utf-8"))["targets"]
        content["_first"] = targets[0]["name"]
    edit(content)
    content.pop("_first", None)
    Path("x.json").write_text(json.dumps(content), encoding="utf-8")


KINDS = {
    "plan": ("p.json", PLANS, PLAN_DOORS),
    "refined plan": ("r.json", REFINED, REFINED_DOORS),
    "certificate": ("c.json", CERTIFICATES, CERTIFICATE_DOORS),
}


def cells(kind: str, *, every: int = 1) -> Iterator[tuple[str, str, str]]:
    """Defect, door and outcome of each cell, or of some, over the files of :func:`good_files`."""
    path, edits, doors = KINDS[kind]
    for number, (defect, edit) in enumerate(edits.items()):
        edited(path, edit)
        for at, (door, arguments) in enumerate(doors.items()):
            if (number + at) % every == 0 and (defect, door) not in LEGAL:
                yield defect, door, outcome(arguments)


def print_table(kind: str, found: dict[tuple[str, str], str]) -> None:
    """Print the cells of a kind."""
    _, edits, doors = KINDS[kind]
    head(kind, *(f"`{door}`" for door in doors))
    for defect in edits:
        row(defect, *(found.get((defect, door), "legal") for door in doors))


FIELDS = (("nominal", "two-body"), ("nominal", "j2"))
"""Families and dynamics whose plans are judged for --cost."""

REPEATS = 3


def _timed(work: Callable[..., Any], *given: Any) -> tuple[float, Any]:
    """Median time of some calls after one that compiles [s], and what they give."""
    found, taken = work(*given), []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work(*given)
        taken.append(time.perf_counter() - began)
    return statistics.median(taken), found


def cost() -> None:
    """What judging takes of planning and of refining, one core, medians."""
    head("field", "legs", "solve s", "judging s", "share", "refine s", "judging s", "share")
    for family, dynamics in FIELDS:
        instance = adr_opt.generate(family, 0).replace(dynamics=dynamics)
        planning_s, result = _timed(adr_opt.solve, instance, "greedy-guarded")
        plan = result.plan
        judging_s, _ = _timed(admit, instance, plan)
        refining_s, refined = _timed(partial(adr_opt.refine, jobs=1), instance, plan)
        judged_s, _ = _timed(partial(admit, unjudged=True), instance, refined)
        row(
            f"{family}, {dynamics}",
            len(plan.legs),
            *(f"{planning_s:.3f}", f"{judging_s:.4f}", f"{judging_s / planning_s:.1%}"),
            *(f"{refining_s:.2f}", f"{judged_s:.3f}", f"{judged_s / refining_s:.1%}"),
        )


def defects(counts: bool = False) -> None:
    """What each verb makes of each defect, or the counts alone."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        good_files()
        for kind in KINDS:
            found = {(defect, door): said for defect, door, said in cells(kind)}
            if not counts:
                print_table(kind, found)
            counted = Counter(found.values())
            print(
                f"\n{kind}: {len(found)} cells: "
                + ", ".join(f"{count} {said}" for said, count in sorted(counted.items()))
            )
        os.chdir("/")


if __name__ == "__main__":
    sys.exit(experiment(__doc__, defects, cost))
