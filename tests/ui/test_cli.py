"""The command line as a whole, and its quick verbs."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli, refused
from plans import with_legs

import adr_opt
from adr_opt.plan.plan import load_plan
from adr_opt.run import methods
from adr_opt.sources import generator
from adr_opt.ui.cli.entry import VERBS

PYTHON = [sys.executable, "-m", "adr_opt"]


def test_help_lists_every_verb(cli: Cli) -> None:
    """`--help` shows all verbs and ends well."""
    outcome = cli("--help")
    assert outcome.status == 0
    for verb in VERBS:
        assert f"\n  {verb} " in outcome.out


def test_verbs_are_listed_as_a_mission_goes(cli: Cli) -> None:
    """`--help` lists them in the order of `VERBS`: make an instance, plan, look at it, the rest."""
    listed = re.findall(r"(?m)^  ([a-z-]+) ", cli("--help").out.partition("Commands:")[2])
    assert tuple(listed) == VERBS
    assert set(VERBS) == {
        "generate",
        "worth",
        "import",
        "windows",
        "solve",
        "bound",
        "check",
        "verify",
        "price",
        "compare",
        "tradeoff",
        "replan",
        "rehearse",
        "scenario",
        "fly",
        "refine",
        "screen",
        "dispose",
        "matrix",
        "export",
        "report",
        "serve",
        "train",
        "methods",
        "warm-up",
        "doctor",
        "schema",
    }


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help_and_json(cli: Cli, verb: str) -> None:
    """Each verb explains itself and has a machine-readable output."""
    outcome = cli(verb, "--help")
    assert outcome.status == 0
    assert "--json" in outcome.out


def test_version(cli: Cli) -> None:
    """`--version` names the program and the version of the package."""
    assert cli("--version").out == f"adr-opt {adr_opt.__version__}\n"


def test_help_does_not_wait_for_numba() -> None:
    """Help and version import nothing that takes longer than they do, such as numba or torch."""
    heavy = "{'numba', 'pydantic', 'rich', 'ortools', 'torch', 'plotly', 'sgp4'}"
    code = (
        "import sys; from adr_opt.ui.cli.entry import VERBS, main; main(['--version']); "
        "[main([*verb, '--help']) for verb in ((), *((each,) for each in VERBS))]; "
        f"sys.exit(' '.join({heavy} & set(sys.modules)) or 0)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr


def test_solve_and_check_do_not_wait_for_integrators(tiny_file: Path) -> None:
    """Planning and checking a small field import none of SciPy's integrators and optimisers."""
    heavy = "{'scipy.integrate', 'scipy.optimize'}"
    code = (
        "import sys; from adr_opt.ui.cli.entry import main; "
        "main(['solve', 'tiny.json', '--method', 'greedy', '--out', 'plan.json']); "
        f"sys.exit(main(['check', 'tiny.json', 'plan.json']) or len({heavy} & set(sys.modules)))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=tiny_file.parent, capture_output=True, check=False
    )
    assert ran.returncode == 0, ran.stderr


def test_verb_imports_only_its_own_module() -> None:
    """Calling one verb leaves the modules of the others unimported."""
    code = (
        "import sys; from adr_opt.ui.cli.entry import main; main(['schema', 'plan']); "
        "cli = 'adr_opt.ui.cli'; "
        "sys.exit(f'{cli}.solve' in sys.modules or f'{cli}.schema' not in sys.modules)"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ([], "missing command"),
        (["frobnicate"], "verb 'frobnicate' is unknown; use one of: generate, worth, import"),
        (["--frobnicate"], "'--frobnicate'"),
        (["solve"], "missing argument 'INSTANCE'"),
        (["solve", "x.json", "--methd", "greedy"], "'--methd' (did you mean"),
        (["solve", "x.json", "--seed", "many"], "'--seed': 'many' is not a valid integer"),
        (["solve", "x.json", "--time-limit", "soon"], "'--time-limit': 'soon' is not a valid"),
        (["solve", "x.json", "--seed"], "'--seed' requires an argument"),
        (["check", "x.json"], "missing argument 'PLAN'"),
        (["check", "x.json", "y.json", "z.json"], "extra argument (z.json)"),
        (["bound"], "missing argument 'INSTANCE'"),
        (["matrix", "x.json", "--at", "0"], "missing option '--out'"),
        (["import", "--out", "my.json"], "missing argument 'FILE...'"),
        (["import", "x.tle"], "missing option '--out'"),
        (["export", "x.json"], "missing argument 'PLAN'"),
        (
            ["export", "x.json", "y.json", "--out", "z.oem", "--format", "xml"],
            "'xml' is not one of",
        ),
        (["report", "x.json", "y.json"], "missing option '--out'"),
        (["train"], "missing option '--out'"),
        (["train", "--out", "run", "--steps", "many"], "'--steps': 'many'"),
        (["refine", "x.json", "y.json"], "missing option '--out'"),
        (["schema", "result"], "'result' is not one of 'instance', 'plan'"),
    ],
)
def test_wrong_call_is_one_sentence(cli: Cli, arguments: list[str], named: str) -> None:
    """A wrong call says what is wrong in one line, without a usage block, and ends with 2."""
    outcome = cli(*arguments)
    assert outcome.status == 2
    assert outcome.out == ""
    assert named in outcome.err
    assert outcome.err.startswith("adr-opt: ")
    assert outcome.err.count("\n") == 1


def test_no_traceback_as_a_process(tmp_path: Path) -> None:
    """A real process says one sentence on standard error and exits with 2."""
    ran = subprocess.run(
        [*PYTHON, "check", "missing.json", "plan.json"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert ran.returncode == 2
    assert ran.stdout == ""
    assert ran.stderr == "adr-opt: missing.json: no such file; check the path\n"


@pytest.mark.parametrize("arguments", [["generate", "nominal"], ["--help"], ["schema", "plan"]])
def test_closed_pipe_is_no_error_message(arguments: list[str]) -> None:
    """A reader that goes away, as in `| head`, ends the program without a word."""
    reading, writing = os.pipe()
    os.close(reading)
    try:
        ran = subprocess.run(
            [*PYTHON, *arguments], stdout=writing, stderr=subprocess.PIPE, text=True, check=False
        )
    finally:
        os.close(writing)
    assert ran.stderr == ""
    assert ran.returncode == 141


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_full_disk_behind_standard_output_is_one_sentence() -> None:
    """Output that cannot be written is an error with a sentence, not a silent success."""
    with open("/dev/full", "w") as full:
        ran = subprocess.run(
            [*PYTHON, "schema", "plan"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert ran.returncode == 2
    assert ran.stderr.startswith("adr-opt: standard output: ")
    assert ran.stderr.count("\n") == 1


def test_output_is_utf_8_whatever_the_locale(tiny_file: Path) -> None:
    """The arrows and deltas of the timeline do not break in an ASCII environment."""
    ran = subprocess.run(
        [*PYTHON, "solve", str(tiny_file), "--method", "greedy"],
        capture_output=True,
        check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )
    assert ran.returncode == 0
    assert "→" in ran.stdout.decode("utf-8")


def test_generate_prints_or_writes_the_same_file(cli: Cli, tmp_path: Path) -> None:
    """Without --out the file goes to standard output, byte for byte what --out writes."""
    printed = cli("generate", "tiny", "--seed", "3")
    written = cli("generate", "tiny", "--seed", "3", "--out", "my.json")
    assert printed.status == written.status == 0
    assert written.out == ""
    assert "my.json" in written.err
    assert (tmp_path / "my.json").read_text(encoding="utf-8") == printed.out
    assert adr_opt.load(tmp_path / "my.json") == adr_opt.generate("tiny", 3)


def test_generate_passes_targets_and_zones(cli: Cli) -> None:
    """--targets and --zones reach the generator."""
    content = json.loads(cli("generate", "nominal", "--targets", "4", "--zones", "2").out)
    assert len(content["targets"]) == 4
    assert len(content["keep_out_zones"]) == 2


MASSES = ("--dry-mass", "300", "--propellant", "600", "--isp", "300")


def test_generate_fits_chasers_with_kits_and_tows(cli: Cli) -> None:
    """The field stays as it is; tanks, kits and tows are those that are asked for, and planned."""
    drawn = adr_opt.generate("tiny", 0)
    for options, removal, kits in (
        (("--delta-v", "700"), "visit", None),
        (("--kits", "2", "--kit-mass", "9", *MASSES), "kit", 2),
        (("--tow", "250", "--disposal-altitude", "450", *MASSES), "tow", None),
        (("--tow", "250", "--disposal-perigee", "350", *MASSES), "tow", None),
    ):
        outcome = cli("generate", "tiny", *options, "--out", "i.json", "--quiet")
        assert outcome.status == 0, outcome.err
        made = adr_opt.load("i.json")
        assert made.name == "tiny-000-fitted"
        assert [each.orbit for each in made.targets] == [each.orbit for each in drawn.targets]
        assert {each.removal for each in made.targets} == {removal}
        assert made.chaser.kits == kits
        assert made.chaser.tank.delta_v_m_s == pytest.approx(
            700.0 if removal == "visit" else 3232.0, abs=1.0
        )
        plan = adr_opt.solve(made, "greedy-guarded").plan
        assert adr_opt.check(made, plan) == ()
        assert len(plan.legs) > 0
    own = adr_opt.generate("removal", 0, targets=4, towed_kg=900.0, disposal={"circle_m": 4e5})
    assert own.chasers[0].kits is None
    assert own.chasers[0].tank == adr_opt.generate("removal", 0).chasers[0].tank
    assert adr_opt.generate("tiny", 0) == drawn


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("tiny", "--kits", "0"), "--kits = 0"),
        (("tiny", "--kits", "2", "--kit-mass", "9"), "without masses"),
        (("tiny", "--kit-mass", "9"), "--kit-mass: there are no kits"),
        (("tiny", "--tow", "9"), "--tow: no disposal orbit"),
        (("tiny", "--disposal-altitude", "9"), "nothing is towed"),
        (("tiny", "--keep-out", "9"), "keep_out_m = 9.0: half laps have none"),
        (("tiny", "--tow", "9", "--disposal-altitude", "500"), "without masses"),
        (("tiny", "--isp", "9"), "give all three"),
        (("removal", "--delta-v", "900"), "kit_mass_kg"),
        (("removal", "--tow", "9", "--disposal-altitude", "500", "--kit-mass", "3"), "kit"),
    ],
)
def test_generate_refuses_what_cannot_be_fitted(cli: Cli, options, named: str) -> None:
    """In one sentence, and nothing is written."""
    refused(cli("generate", *options, "--out", "i.json"), named)
    assert not Path("i.json").exists()


def test_generate_json_prints_even_with_out(cli: Cli) -> None:
    """--json prints the instance also where --out writes it."""
    outcome = cli("generate", "tiny", "--out", "my.json", "--json", "--quiet")
    assert json.loads(outcome.out)["name"] == "tiny-000"
    assert outcome.err == ""


def test_generate_help_lists_the_families(cli: Cli) -> None:
    """The help names every family there is."""
    said = cli("generate", "--help").out
    assert all(name in said for name in generator.FAMILIES)


def test_methods_lists_planners_and_options(cli: Cli) -> None:
    """Every installed planner is listed with its summary and the defaults of its options."""
    found = {entry["name"]: entry for entry in json.loads(cli("methods", "--json").out)["planners"]}
    assert set(found) == set(methods.names())
    assert found["greedy"]["summary"].startswith("The published greedy")
    assert found["greedy"]["options"][0] == {
        "name": "alpha",
        "type": "float",
        "default": 1.0,
        "unit": "per m/s",
        "allowed": "at least 0 and finite",
        "meaning": "Weight of ΔV in the cost of a move.",
    }
    said = cli("methods").out
    assert "greedy-guarded" in said
    assert "--option alpha=1.0" in said


def test_methods_explains_one(cli: Cli) -> None:
    """Of a method that is named, every option is listed with what it means and what it may be."""
    alone = json.loads(cli("methods", "exact", "--json").out)
    assert [entry["name"] for entry in alone["planners"] + alone["bounds"]] == ["exact", "exact"]
    said = " ".join(cli("methods", "exact").out.split())
    assert "greedy" not in said
    for option in alone["bounds"][0]["options"]:
        assert f"--option {option['name']}=" in said
        assert option["meaning"] in said
        assert option["allowed"] in said
    wrong = cli("methods", "magic")
    assert wrong.status == 2
    assert "method 'magic' is unknown; use one of: auto, beam" in wrong.err


def test_a_method_that_went_says_so(cli: Cli, tiny_file: Path) -> None:
    """A removed method is refused with the names of those that prove; its plans are still read."""
    for verb in ("solve", "bound"):
        gone = cli(verb, tiny_file, "--method", "cpsat")
        assert gone.status == 2
        assert "'cpsat' was removed in 2.0; use 'exact', or 'mip'" in gone.err
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = json.loads(Path("plan.json").read_text("utf-8")) | {"method": "cpsat"}
    Path("plan.json").write_text(json.dumps(plan), "utf-8")
    assert cli("check", tiny_file, "plan.json").status == 0


def test_check_lists_the_violations(cli: Cli, tiny_file: Path, tmp_path: Path) -> None:
    """A plan with violations ends with 1 and each of them, by leg and rule."""
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    plan = load_plan(tmp_path / "plan.json")
    legs = (plan.legs[0].replace(arrival_s=plan.legs[0].arrival_s + 5.0), *plan.legs[1:])
    with_legs(plan, legs, objective=99.0).save(tmp_path / "plan.json")
    outcome = cli("check", tiny_file, "plan.json", "--json")
    assert outcome.status == 1
    found = {(entry["leg"], entry["rule"]) for entry in json.loads(outcome.out)["violations"]}
    assert {(1, "arrival"), (None, "objective")} <= found
    text = cli("check", tiny_file, "plan.json")
    assert text.status == 1
    assert "leg 1: arrival" in text.out


def test_fly_reports_every_leg(cli: Cli, tiny_file: Path, tmp_path: Path) -> None:
    """`fly --json` gives the worst miss and one entry per leg, and the table as many lines."""
    pytest.importorskip("boinor")
    cli("solve", tiny_file, "--method", "greedy", "--out", "plan.json")
    legs = load_plan(tmp_path / "plan.json").legs
    outcome = cli("fly", tiny_file, "plan.json", "--json")
    assert outcome.status == 0
    content = json.loads(outcome.out)
    assert content["worst_miss_m"] < 1.0
    assert len(content["legs"]) == len(legs) > 0
    text = cli("fly", tiny_file, "plan.json").out
    assert all(f"{leg.origin} → {leg.destination}" in text for leg in legs)


def test_one_is_said_in_the_singular(cli: Cli) -> None:
    """No verb speaks of "1 legs" or "1 targets"."""
    cli("generate", "tiny", "--targets", "1", "--out", "one.json")
    said = cli("generate", "tiny", "--targets", "1", "--out", "one.json").err
    said += cli("solve", "one.json", "--method", "greedy", "--out", "plan.json").err
    assert len(load_plan("plan.json").legs) == 1
    said += cli("check", "one.json", "plan.json").out
    said += cli("matrix", "one.json", "--at", "0", "--out", "costs.npz").err
    said += cli("export", "one.json", "plan.json", "--out", "plan.oem").err
    if importlib.util.find_spec("boinor") is not None:
        said += cli("fly", "one.json", "plan.json").out
    if importlib.util.find_spec("plotly") is not None:
        said += cli("report", "one.json", "plan.json", "--out", "plan.html").err
        page = Path("plan.html").read_text(encoding="utf-8")
        said += page.partition("<main>")[2].partition('<div class="phases"')[0]
    assert said.count("1 leg") >= 3
    assert "1 target" in said
    assert re.findall(r"\b1 [a-z]+s\b(?! of)", said) == []


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ([], "either with --every S or with --at S"),
        (["--every", "60", "--at", "0"], "either with --every S or with --at S"),
        (["--every", "0"], "--every = 0: must be a positive number"),
        (["--every", "nan"], "--every = nan"),
        (["--at", "-1"], "--at = -1"),
        (["--at", "inf"], "--at = inf"),
        (["--at", "0", "--at", "1e12"], "--at = 1e+12: the mission ends at"),
        (["--every", "1e-6"], "--every = 1e-06: the matrices would take"),
        (["--at", "0", "--quantity", "fuel"], "'fuel' is not one of 'delta_v', 'duration'"),
        (["--at", "0", "--scale", "-1"], "scale"),
    ],
)
def test_matrix_refuses_wrong_times(
    cli: Cli, tiny_file: Path, arguments: list[str], named: str
) -> None:
    """Ready times that make no sense are refused before anything is written."""
    outcome = cli("matrix", tiny_file, "--out", "costs.npz", *arguments)
    assert outcome.status == 2
    assert named in outcome.err
    assert list(tiny_file.parent.iterdir()) == [tiny_file]


@pytest.mark.parametrize("arguments", [["--every", "7200"], ["--at", "0", "--at", "5000.5"]])
def test_matrix_writes_what_the_timetable_says(
    cli: Cli, tiny_file: Path, arguments: list[str]
) -> None:
    """`matrix` writes the timetable's matrices at the ready times asked for."""
    outcome = cli("matrix", tiny_file, "--out", "costs.npz", "--json", *arguments)
    assert outcome.status == 0
    instance = adr_opt.load(tiny_file)
    if arguments[0] == "--every":
        times = np.arange(0.0, instance.mission.duration_s, 7200.0)
    else:
        times = np.array([0.0, 5000.5])
    assert json.loads(outcome.out)["departures_s"] == times.tolist()
    expected = adr_opt.Timetable(instance).matrices(times)
    with np.load("costs.npz") as written:
        np.testing.assert_array_equal(written["delta_v_m_s"], expected.delta_v)
        np.testing.assert_array_equal(written["duration_s"], expected.duration)


def test_matrix_of_one_epoch_formats(cli: Cli, tiny_file: Path) -> None:
    """A .tsp holds one ready time, and a suffix that means nothing is refused."""
    assert cli("matrix", tiny_file, "--at", "0", "--out", "c.tsp").status == 0
    assert Path("c.tsp").exists()
    several = cli("matrix", tiny_file, "--every", "3600", "--out", "d.tsp")
    assert several.status == 2
    assert "d.tsp: a .tsp file holds one departure" in several.err
    unknown = cli("matrix", tiny_file, "--at", "0", "--out", "c.csv")
    assert unknown.status == 2
    assert "use one of .npz, .nc, .tsp, .vrp, .oplib" in unknown.err
    assert sorted(path.name for path in tiny_file.parent.iterdir()) == ["c.tsp", "tiny.json"]
