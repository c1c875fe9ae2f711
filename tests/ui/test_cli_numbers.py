"""Numbers at the edge of what can be written, in every option that takes one, and likely slips."""

from __future__ import annotations

from pathlib import Path

import click
import pytest
from catalogue_files import as_csv, field
from conftest import Cli

import adr_opt
from adr_opt.ui.cli.entry import command

CLOUD = str(Path(__file__).parents[2] / "examples/catalogue/cloud.tle")
NUMBERS = ("1e308", "-1e308", "1e-320", "nan", "inf", "-0.0", "99999999999999999999")
CALLS = {
    "generate": ("tiny",),
    "import": (CLOUD, "--max-targets", "5", "--out", "x.json"),
    "solve": ("tiny.json", "--method", "greedy-guarded", "--time-limit", "1"),
    "bound": ("tiny.json", "--method", "lagrangian", "--time-limit", "1"),
    "verify": ("tiny.json", "p.json", "c.json"),
    "replan": ("tiny.json", "p.json", "--at", "0.1", "--time-limit", "1"),
    "rehearse": ("tiny.json", "p.json", "--uncertainty", "u.json", "--samples", "2"),
    "tradeoff": ("tiny.json", "--vary", "delta-v=500", "--time-limit", "1"),
    "fly": ("tiny.json", "p.json"),
    "matrix": ("tiny.json", "--at", "0", "--out", "m.npz"),
    "export": ("tiny.json", "p.json", "--out", "x.oem"),
}
"""A call of each verb that has options with numbers and ends soon."""

SLOW = ("solve", "bound", "verify", "replan", "rehearse", "tradeoff", "fly", "matrix", "export")
ON_CORES = ("--jobs",)
"""Options that would start this number of processes."""


def options_of(verb: str) -> list[click.Option]:
    """The options of a verb that take a number."""
    context = click.Context(command)
    found = command.get_command(context, verb)
    assert found is not None
    kinds = (click.types.FloatParamType, click.types.IntParamType)
    return [
        option
        for option in found.params
        if isinstance(option, click.Option)
        and isinstance(option.type, kinds)
        and option.opts[0] not in ON_CORES
    ]


@pytest.mark.parametrize(
    "verb", [pytest.param(verb, marks=pytest.mark.slow if verb in SLOW else []) for verb in CALLS]
)
def test_numbers_at_the_edge(cli: Cli, tiny_file: Path, verb: str) -> None:
    """Whatever number an option has, the verb does its work or says one sentence."""
    Path("u.json").write_text('{"capture": {"success": 0.5}}', encoding="utf-8")
    if verb == "import":
        pytest.importorskip("sgp4")
    if verb in SLOW:
        call = ("solve", "tiny.json", "--method", "exact", "--certificate", "c.json")
        assert cli(*call, "--out", "p.json").status == 0
    assert cli(verb, *CALLS[verb]).status in (0, 1)
    options = options_of(verb)
    assert options
    for option in options:
        for number in NUMBERS:
            outcome = cli(verb, *CALLS[verb], option.opts[0], number)
            assert outcome.status in (0, 1, 2), (option.opts, number)
            if outcome.status == 2:
                assert outcome.err.startswith("adr-opt: "), outcome.err
                assert "Traceback" not in outcome.err


@pytest.mark.parametrize(
    ("more", "status", "said"),
    [
        (("--delta-v", 3), 0, "note: --delta-v (delta_v_m_s = 3): "),
        (("--station", "0.8,98,0"), 0, "note: --station (semi_major_axis_m = 6.37894e+06): "),
        (("--delta-v", 1e12), 2, "--delta-v (delta_v_m_s = 1000000000000.0): must be"),
        (("--altitude", "700000:900000"), 2, "in the catalogue altitudes are "),
        (("--inclination", "1.2:1.3"), 2, "in the catalogue inclinations are "),
        (("--name", "NOBODY"), 2, "in the catalogue names are "),
    ],
)
def test_import_names_the_option_and_the_likely_slip(
    more: tuple[object, ...], status: int, said: str, cli: Cli
) -> None:
    """A value out of range is named by its option, and an empty choice by what there is."""
    Path("a.csv").write_text(as_csv(field(12)), encoding="utf-8")
    outcome = cli("import", "a.csv", "--out", "i.json", *more)
    assert outcome.status == status, outcome
    assert said in outcome.err


def test_check_and_fly_say_why_unrefined_burns_miss(cli: Cli, tmp_path: Path) -> None:
    """Kilometres away from circles are told by both; metres are not."""
    instance = adr_opt.generate("tiny", 0)
    for eccentricity, told in ((0.01, True), (1e-6, False)):
        targets = tuple(
            target.replace(orbit=target.orbit.replace(eccentricity=eccentricity))
            for target in instance.targets
            if target.orbit is not None
        )
        path, plan = str(tmp_path / "i.json"), str(tmp_path / "p.json")
        instance.replace(targets=targets).save(path)
        assert cli("solve", path, "--method", "greedy", "--out", plan, "--no-fly").status == 0
        for verb in (("check", path, plan, "--no-fly"), ("fly", path, plan)):
            outcome = cli(*verb)
            assert ("unrefined burns miss by kilometres" in outcome.out) is told, outcome
