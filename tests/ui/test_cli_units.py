"""``import`` names options, and ``check`` and ``fly`` say why unrefined burns miss."""

from __future__ import annotations

from pathlib import Path

import pytest
from catalogue_files import as_csv, field
from conftest import Cli

import adr_opt


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
            assert ("as they are, burns miss by kilometres" in outcome.out) is told, outcome
