"""``import`` told what is wanted: tables of prizes, objects in and out, prizes by criticality."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import as_kvn, as_space_track_json, as_xml, field

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.sources import catalogue
from adr_opt.sources.catalogue.criticality import HIGHEST_M, SIZE_KG, lasting

pytest.importorskip("sgp4.io")

RECORDS = field(12)


def test_falling_prizes_reach_the_targets(imported) -> None:
    """Days and prizes become times and prizes; what is no pair, or rises, is one sentence."""
    number = RECORDS[3].number
    Path("p.csv").write_text(f"object,prize,prize_until\n{number},1,2:5 3.5:4\n", encoding="utf-8")
    assert imported("--prizes", "p.csv").status == 0
    targets = adr_opt.load("out.json").targets
    levels = [each.prize_until for each in targets if each.prize_until]
    assert levels == [((2.0 * DAY_S, 5.0), (3.5 * DAY_S, 4.0))]
    for cell, said in (("2:5 3", "must be days and a prize"), ("2:4 3:5", "may only fall")):
        Path("p.csv").write_text(f"object,prize,prize_until\n{number},1,{cell}\n")
        refused = imported("--prizes", "p.csv")
        assert refused.status == 2
        assert said in refused.err
        assert refused.err.count("\n") == 1


def test_a_table_of_prizes_reaches_the_targets(imported) -> None:
    """Each row changes its object, named as one likes; empty cells and other objects stay."""
    first, second, third = RECORDS[3], RECORDS[7], RECORDS[5]
    Path("p.csv").write_text(
        "\ufeffObject, prize, required, window, mass, removal\n"
        f"{first.number}, 2.5, yes, 1:4, 800, kit\n"
        f'"{second.label}",,no,:3,,\n'
        "\n"
        f"{third.object_id}, 0, , 2:, ,\n",
        encoding="utf-8",
    )
    outcome = imported("--prizes", "p.csv")
    assert outcome.status == 0, outcome
    targets = {target.name: target for target in adr_opt.load("out.json").targets}
    one, two, three = (targets.pop(record.label) for record in (first, second, third))
    assert (one.prize, one.required, one.mass_kg, one.removal) == (2.5, True, 800.0, "kit")
    assert one.window_s == (DAY_S, 4.0 * DAY_S)
    assert (two.prize, two.required, two.window_s) == (1.0, False, (0.0, 3.0 * DAY_S))
    assert (three.prize, three.window_s, three.mass_kg) == (0.0, (2.0 * DAY_S, None), None)
    assert {(t.prize, t.required, t.window_s, t.removal) for t in targets.values()} == {
        (1.0, False, (0.0, None), "visit")
    }


NUMBER = RECORDS[3].number
HEAD = "object,prize\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "p.csv: empty"),
        ("object,prise\n", "line 1: column 'prise' is unknown; use object, prize"),
        ("prize\n1\n", "line 1: exactly one column must name the objects"),
        ("object,number\n", "line 1: exactly one column must name the objects"),
        ("object,prize,prize\n", "line 1: two columns prize; keep one"),
        (f"{HEAD}{NUMBER},1,2\n", "line 2: 3 values under 2 columns"),
        (f"{HEAD}{NUMBER},much\n", "line 2: prize = 'much': must be a number"),
        (f"{HEAD}{NUMBER},-1\n", "line 2: field prize = -1.0: must"),
        (f"{HEAD}{NUMBER},nan\n", "line 2: field prize"),
        (f"{HEAD},1\n", "line 2: no object is named"),
        (f"{HEAD}99999,1\n", "line 2: object '99999': no object has this number or name"),
        (f"{HEAD}{NUMBER},1\n{RECORDS[3].label},2\n", "already has a row, p.csv: line 2; keep"),
        (f"object,required\n{NUMBER},perhaps\n", "required = 'perhaps': must be yes or no"),
        (f"object,window\n{NUMBER},3\n", "window = '3': give two numbers as LO:HI"),
        (f"object,window\n{NUMBER},3:2\n", "must not close before it opens"),
        (f"object,removal\n{NUMBER},burn\n", "field removal"),
        (f'{HEAD}"{NUMBER},1\n', "not a line of CSV"),
    ],
)
def test_a_wrong_table_is_one_sentence(imported, text: str, said: str) -> None:
    """Whatever is wrong with a table is said with its line, and nothing is written."""
    Path("p.csv").write_text(text, encoding="utf-8")
    outcome = imported("--prizes", "p.csv")
    assert outcome.status == 2
    assert said in outcome.err, outcome.err
    assert outcome.err.count("\n") == 1
    assert not Path("out.json").exists()


def test_a_table_may_speak_of_objects_that_are_left_out(imported) -> None:
    """Such rows are counted in a warning; but an object that is required has to be a target."""
    Path("p.csv").write_text(f"name,prize\n{NUMBER},4\n", encoding="utf-8")
    outcome = imported("--prizes", "p.csv", "--exclude", str(NUMBER))
    assert outcome.status == 0
    assert "1 row of --prizes: their objects are not among the targets" in outcome.err
    Path("p.csv").write_text(f"name,required\n{NUMBER},yes\n", encoding="utf-8")
    outcome = imported("--prizes", "p.csv", "--exclude", str(NUMBER))
    assert outcome.status == 2
    assert "is required, but is not a target" in outcome.err


def test_excluded_objects_are_no_targets(imported) -> None:
    """By number or name, one by one or with commas, and they are listed with the reason."""
    out = RECORDS[0], RECORDS[4], RECORDS[9]
    outcome = imported(
        "--exclude", f"{out[0].number}, {out[1].label}", "--exclude", out[2].object_id, "--json"
    )
    assert outcome.status == 0, outcome
    account = json.loads(outcome.out)
    assert account["dropped_counts"] == {"exclude": 3}
    names = {target.name for target in adr_opt.load("out.json").targets}
    assert names == {record.label for record in RECORDS if record not in out}


def test_musts_pass_the_filters_and_are_required(imported) -> None:
    """An object that must be a target is one whatever filters say, and counts to the most."""
    must = RECORDS[6]
    others = [record for record in RECORDS if record.name != must.name]
    outcome = imported("--name", others[0].name, "--altitude", ":1", "--must", str(must.number))
    assert outcome.status == 0, outcome
    assert [(t.name, t.required) for t in adr_opt.load("out.json").targets] == [(must.label, True)]
    away = "500,20,10"
    assert imported("--station", away, "--max-targets", "3").status == 0
    near = [target.name for target in adr_opt.load("out.json").targets]
    far = next(record for record in RECORDS if record.label not in near)
    assert imported("--station", away, "--max-targets", "3", "--must", str(far.number)).status == 0
    targets = adr_opt.load("out.json").targets
    assert len(targets) == 3
    assert [target.name for target in targets if target.required] == [far.label]
    assert len(set(near) & {target.name for target in targets}) == 2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--must", "nobody"), "--must 'nobody': no object has this number or name"),
        (("--must", f"{NUMBER},nobody"), "--must 'nobody'"),
        (("--exclude", ""), "--exclude '': give one of the catalogue"),
        (("--must", str(NUMBER), "--exclude", RECORDS[3].label), "--exclude leaves it out"),
        (("--must", str(NUMBER), "--station", str(NUMBER)), "it is the station"),
        (("--must", f"{NUMBER},{RECORDS[4].number}", "--max-targets", "1"), "--must keeps 2"),
        (("--exclude", ",".join(str(record.number) for record in RECORDS)), "no object is left"),
        (("--prizes", "none.csv"), "none.csv: no such file"),
    ],
)
def test_a_wish_that_cannot_be_met_is_one_sentence(imported, options, said: str) -> None:
    """Unknown objects and contradictions are refused, and nothing is written."""
    outcome = imported(*options)
    assert outcome.status == 2
    assert said in outcome.err, outcome.err
    assert not Path("out.json").exists()


def test_sizes_and_masses_are_read_in_every_spelling_that_has_them() -> None:
    """The class of the cross-section and the mass reach the records, in every format."""
    from adr_opt.sources.catalogue.reading import read_bytes

    record = RECORDS[:1]
    kvn = as_kvn(record) + "MASS = 120 [kg]\nUSER_DEFINED_RCS_SIZE = LARGE\n"
    xml = as_xml(record).replace(
        "</data>",
        '<spacecraftParameters><MASS units="kg">120</MASS></spacecraftParameters>'
        '<userDefinedParameters><USER_DEFINED parameter="RCS_SIZE">LARGE</USER_DEFINED>'
        '<USER_DEFINED parameter="EPOCH">never</USER_DEFINED></userDefinedParameters></data>',
    )
    for text in (kvn, xml):
        (found,) = read_bytes(text.encode(), "x", skip_bad=False).records
        assert (found.size, found.mass_kg) == ("LARGE", 120.0)
        assert found == record[0]
    (found,) = read_bytes(as_space_track_json(record).encode(), "x", skip_bad=False).records
    assert (found.size, found.mass_kg) == ("SMALL", None)


def test_criticality_ranks_by_mass_altitude_and_crowding() -> None:
    """Heavier, higher and more crowded objects are worth more, all else alike; from 1 to 100."""
    one = replace(RECORDS[0], mean_motion_rev_day=14.3, inclination_deg=82.9)
    heavy = replace(one, number=2, mass_kg=4000.0)
    light = replace(one, number=3, mass_kg=1000.0)
    prizes = catalogue.criticality([heavy, light], [heavy, light])
    np.testing.assert_array_equal(prizes, [100.0, 25.0])
    high = replace(one, number=4, mean_motion_rev_day=14.0)
    prizes = catalogue.criticality([one, high], [one, high])
    assert prizes[1] == 100.0 > prizes[0]
    lonely = replace(one, number=5, inclination_deg=30.0)
    crowd = [replace(one, number=10 + n) for n in range(3)]
    prizes = catalogue.criticality([one, lonely], [one, lonely, *crowd])
    np.testing.assert_array_equal(prizes, [100.0, 25.0])
    small, large = (replace(one, size=size) for size in ("SMALL", "LARGE"))
    prizes = catalogue.criticality([small, large], [one])
    np.testing.assert_array_equal(prizes, [1.0, 100.0])
    # One of unknown mass counts as the median of the others; what a table says goes first.
    np.testing.assert_array_equal(
        catalogue.criticality([one, small, large], [one], {1: SIZE_KG["LARGE"]}), [100.0] * 3
    )


def test_fragments_stay_longer_higher_up() -> None:
    """What altitude counts grows without a jump, to 1 at a thousand kilometres and above."""
    altitudes = np.arange(150e3, 1100e3, 500.0)
    counts = np.array([lasting(altitude) for altitude in altitudes])
    steps = counts[1:] / counts[:-1]
    assert (steps >= 1.0).all()
    assert steps.max() < 1.02
    assert counts[-1] == lasting(HIGHEST_M) == 1.0
    assert lasting(200e3) == pytest.approx(3.019e-15 / 2.789e-10)


def test_prizes_by_criticality_are_said_to_be_a_ranking(imported) -> None:
    """The option sets all prizes but those that a table sets, and says what they stand on."""
    Path("p.csv").write_text(f"object,prize,mass\n{NUMBER},777,\n", encoding="utf-8")
    outcome = imported("--criticality", "--prizes", "p.csv")
    assert outcome.status == 0, outcome
    assert "prizes are by criticality, a ranking, not a probability" in outcome.err
    prizes = {target.name: target.prize for target in adr_opt.load("out.json").targets}
    assert prizes.pop(RECORDS[3].label) == 777.0
    others = [record for record in RECORDS if record.number != NUMBER]
    every = catalogue.criticality(RECORDS, RECORDS)
    assert prizes == {record.label: every[RECORDS.index(record)] for record in others}
    assert max(every) == 100.0
    assert min(every) >= 1.0
    assert len(set(prizes.values())) > 3
