"""Errors of where targets are: tables of them, and what successive element sets show."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import as_json, field
from messages import oem

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.frame import Frame
from adr_opt.problem.frame_rotation import from_gcrf
from adr_opt.sources.catalogue import MissionOutline, read, to_instance
from adr_opt.sources.catalogue.propagation import mean_elements
from adr_opt.sources.uncertainty import TargetError, compared, read_target_errors
from adr_opt.sources.uncertainty.successive import ErrorGrowth, SetDifference, error_of, growth_of
from adr_opt.sources.uncertainty.table import TRIANGLE, read_table

pytest.importorskip("sgp4.api")
pytest.importorskip("erfa")

BODIES = ("station", "a", "b")
EPOCH = datetime(2025, 3, 2, 12, tzinfo=UTC)
TEME = Frame(name="TEME", axes_epoch=EPOCH - timedelta(days=200))
REV_DAY = 14.4


def table(text: str) -> Path:
    path = Path("errors.csv")
    path.write_text(text, encoding="utf-8")
    return path


def singular() -> np.ndarray:
    """A covariance of rank three with entries of very different sizes."""
    wide = np.random.default_rng(1).standard_normal((6, 3))
    scaled = wide * np.array([100.0, 5000.0, 80.0, 5.0, 0.1, 0.08])[:, None]
    return np.asarray(scaled @ scaled.T)


@pytest.mark.usefixtures("cli")
def test_tables_say_the_same_in_csv_and_json() -> None:
    """Standard deviations and covariances are read alike from both spellings, and back as given."""
    sigma = read_table(
        table(
            "target,sigma_radial_m,sigma_along_m,sigma_across_m_s,sigma_decay_m_per_day\n"
            "a,10,200,0.5,3\n\nb,,,,\n"
        ),
        BODIES,
    )
    assert sigma["a"].covariance.diagonal().tolist() == [100.0, 4e4, 0.0, 0.0, 0.0, 0.25, 9.0]
    assert not sigma["b"]
    matrix = singular()
    names = ",".join(name for name, _, _ in TRIANGLE)
    cells = ",".join(repr(float(matrix[row, column])) for _, row, column in TRIANGLE)
    in_csv = read_table(table(f"target,{names}\na,{cells}\n"), BODIES)["a"]
    Path("errors.json").write_text(
        json.dumps(
            {
                "format": "adr-opt-target-errors/1",
                "targets": [{"target": "a", "covariance_rtn": matrix.tolist()}],
            }
        ),
        encoding="utf-8",
    )
    in_json = read_table("errors.json", BODIES)["a"]
    assert np.array_equal(in_csv.covariance, in_json.covariance)
    assert np.array_equal(in_json.covariance[:6, :6], matrix)
    assert (in_csv.coordinates, TRIANGLE[0][0], TRIANGLE[-1][0]) == (
        "rtn",
        "cr_r_m2",
        "cndot_ndot_m2_s2",
    )


def test_a_factor_gives_the_covariance() -> None:
    """F Fᵀ is the covariance, also where it is singular and of mixed units.

    A change in the last digits changes it as little, also where eigenvalues are equal.
    """
    whole = np.zeros((7, 7))
    whole[:6, :6] = singular()
    factor = TargetError(whole).factor()
    sizes = np.sqrt(np.outer(whole.diagonal(), whole.diagonal()))
    assert (np.abs(factor @ factor.T - whole) <= 1e-9 * sizes).all()
    plain = np.diag([4.0, 9.0, 9.0, 1.0, 1.0, 25.0, 0.0])
    plain[0, 5] = plain[5, 0] = -3.0
    near = plain * (1.0 + 1e-13 * np.random.default_rng(3).standard_normal())
    near[1, 2] = near[2, 1] = 1e-12
    off = TargetError(near).factor() - TargetError(plain).factor()
    assert np.abs(off).max() < 1e-10


@pytest.mark.usefixtures("cli")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("sigma_radial_m\n1\n", "no column names the bodies"),
        ("target,sigma_up_m\na,1\n", "column 'sigma_up_m' is unknown"),
        ("target,target\na,a\n", "two columns target"),
        ("target,sigma_radial_m\na\n", "line 2: 1 values under 2 columns"),
        ("target,sigma_radial_m\nc,1\n", "target 'c': no such body"),
        ("target,sigma_radial_m\na,1\na,1\n", "line 3: target 'a' already has a row"),
        ("target,sigma_radial_m\na,x\n", "sigma_radial_m = 'x': must be a number"),
        ("target,sigma_radial_m\na,-1\n", "sigma_radial_m"),
        ("target,sigma_radial_m\na,nan\n", "sigma_radial_m"),
        ("target,cr_r_m2\na,1\n", "a covariance needs the column ct_r_m2, too"),
        ('{"format": "adr-opt-target-errors/2", "targets": []}', "format"),
        (
            '{"format": "adr-opt-target-errors/1", "targets": [{"target": "a", "sigma": 1}]}',
            "sigma",
        ),
        (
            '{"format": "adr-opt-target-errors/1", "targets": [{"target": "a", '
            '"sigma_radial_m": 1, "covariance_rtn": [[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],'
            "[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0]]}]}",
            "field sigma_radial_m: the row has a covariance, too",
        ),
        (
            '{"format": "adr-opt-target-errors/1", "targets": [{"target": "a", '
            '"covariance_rtn": [[1,2,0,0,0,0],[2,1,0,0,0,0],[0,0,0,0,0,0],'
            "[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0]]}]}",
            "some combination of its coordinates has a negative variance",
        ),
        (
            '{"format": "adr-opt-target-errors/1", "targets": [{"target": "a", '
            '"covariance_rtn": [[1,0.5,0,0,0,0],[0,1,0,0,0,0],[0,0,0,0,0,0],'
            "[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0]]}]}",
            "not symmetric",
        ),
    ],
)
def test_bad_tables_are_one_sentence(text: str, said: str) -> None:
    """Whatever is wrong with a table is said in one sentence that names the file."""
    with pytest.raises(InputError) as error:
        read_table(table(text), BODIES)
    assert said in str(error.value)
    assert str(error.value).startswith("errors.csv: ")
    assert "\n" not in str(error.value)


def message(matrix: np.ndarray, *said: str, last: int = 6) -> str:
    """A message about target a with a covariance [m², m²/s, m²/s²] at three times."""
    rows = [" ".join(f"{1e-6 * matrix[at, to]:.17e}" for to in range(at + 1)) for at in range(last)]
    text = oem("a", "2020-001A", EPOCH, lambda times: np.ones((times.size, 6)))
    lines = ["COVARIANCE_START"]
    for hours in (-1, 0, 1):
        at = (EPOCH + timedelta(hours=hours)).replace(tzinfo=None).isoformat()
        lines += [f"EPOCH = {at}", *said, *rows]
    return text + "\n".join([*lines, "COVARIANCE_STOP"]) + "\n"


def with_target() -> adr_opt.Instance:
    instance = adr_opt.generate("tiny", 0).replace(epoch=EPOCH, frame=TEME)
    first = instance.targets[0].replace(name="a")
    return instance.replace(targets=(first, *instance.targets[1:]))


@pytest.mark.usefixtures("cli")
@pytest.mark.parametrize("said", ["RTN", "RSW", "EME2000", ""])
def test_messages_state_covariances(said: str) -> None:
    """The last covariance that is not of later is taken, turned into the frame of the instance."""
    matrix, instance = singular(), with_target()
    path = table(message(matrix, *([f"COV_REF_FRAME = {said}"] if said else [])))
    (found,) = read_target_errors(instance, path).values()
    turn = np.eye(3)
    if said == "EME2000":
        turn = from_gcrf(TEME) @ from_gcrf(Frame(name="EME2000")).T
    elif not said:  # TEME of date, which is that of the epoch here
        turn = from_gcrf(TEME) @ from_gcrf(Frame(name="TEME", axes_epoch=EPOCH)).T
    both = np.kron(np.eye(2), turn)
    wanted = both @ matrix @ both.T
    sizes = np.sqrt(np.outer(wanted.diagonal(), wanted.diagonal()))
    assert (np.abs(found.covariance[:6, :6] - wanted) <= 1e-9 * sizes).all()
    assert found.coordinates == ("rtn" if said in ("RTN", "RSW") else "inertial")
    assert found.since_s == 0.0


@pytest.mark.usefixtures("cli")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (message(np.eye(6), "COV_REF_FRAME = TNW"), "REF_FRAME = TNW: must be"),
        (message(np.eye(6), last=5), "a covariance has 5 rows; it must have six"),
        (message(-np.eye(6), "COV_REF_FRAME = RTN"), "has a negative variance"),
        (message(np.eye(6), "SIGMA = 2"), "SIGMA is no covariance keyword"),
        (message(np.eye(6)).replace("= a", "= other"), "no covariance of a body of"),
        (message(np.full((6, 6), np.nan)), "is not a row of 1 numbers of a covariance"),
    ],
)
def test_bad_covariances_are_one_sentence(text: str, said: str) -> None:
    """What a message gets wrong about covariances is said in a sentence with its file."""
    with pytest.raises(InputError) as error:
        read_target_errors(with_target(), table(text))
    assert said in str(error.value)
    assert str(error.value).startswith("errors.csv: ")
    assert "\n" not in str(error.value)


def test_growth_is_found_again() -> None:
    """Differences with a constant and a decay give both back; of one age, all is the decay."""
    rng = np.random.default_rng(0)
    pairs = []
    for age in rng.uniform(0.5, 12.0, 4000):
        grown = 0.75 * math.tau * REV_DAY * age**2
        along = 300.0 * rng.standard_normal() + 4.0 * grown * rng.standard_normal()
        radial, across = 50.0 * rng.standard_normal(), 20.0 * rng.standard_normal()
        pairs.append(SetDifference(float(age), radial, along, across))
    found = growth_of(pairs, REV_DAY)
    assert tuple(found) == pytest.approx((50.0, 300.0, 20.0, 4.0), rel=0.05)
    one = growth_of([SetDifference(10.0, 0.0, -5000.0, 0.0)], REV_DAY)
    assert one.along_m == 0.0
    assert 0.75 * math.tau * REV_DAY * 100.0 * one.decay_m_per_day == pytest.approx(5000.0)


def test_an_aged_error_has_grown() -> None:
    """The decay since the element set is in the axis and the longitude at the epoch."""
    covariance = error_of(ErrorGrowth(0.0, 0.0, 0.0, 2.0), REV_DAY, 3.0).covariance
    sigmas = np.sqrt(covariance.diagonal())
    assert sigmas[0] == pytest.approx(6.0)
    assert sigmas[5] == pytest.approx(0.75 * math.tau * REV_DAY * 9.0 * 2.0)
    assert sigmas[6] == pytest.approx(2.0)
    assert covariance[0, 5] == pytest.approx(-sigmas[0] * sigmas[5])


@pytest.mark.usefixtures("cli")
def test_element_sets_are_compared_by_object() -> None:
    """A shift of the newer set is found along and across the track; who has one set is counted."""
    records = field(5)
    later = timedelta(days=2)
    Path("old.json").write_text(as_json(records), encoding="utf-8")
    instance = to_instance(read("old.json"), mission=MissionOutline(epoch=EPOCH)).instance
    names = [target.name for target in instance.targets]

    def newer(**shifts: float) -> list[SetDifference]:
        moved = []
        for record in records[:4]:
            at = record.epoch + later
            mean = np.degrees(mean_elements([record], at)[0][0, 3:]) % 360.0
            there = replace(
                record,
                epoch=at,
                raan_deg=mean[0],
                argument_of_perigee_deg=mean[1],
                mean_anomaly_deg=mean[2],
            )
            moved.append(
                replace(there, **{name: getattr(there, name) + by for name, by in shifts.items()})
            )
        Path("new.json").write_text(as_json(moved), encoding="utf-8")
        found = compared(instance, ["old.json", "new.json"])
        assert found.by_median == (records[4].label,)
        assert set(found.errors) == set(names)
        assert found.growths[records[4].label].across_m == pytest.approx(
            np.median([found.growths[one.label].across_m for one in records[:4]])
        )
        assert found.to_dict()["pairs"] == len(found.differences) == 4
        return [found.differences[record.label][0] for record in records[:4]]

    plain = newer()
    assert max(abs(one.along_m) for one in plain) < 20e3
    along, turned = newer(mean_anomaly_deg=0.01), newer(inclination_deg=0.01)
    for before, ahead, across, record in zip(plain, along, turned, records, strict=False):
        arc = math.radians(0.01) * 42241.1e3 / record.mean_motion_rev_day ** (2.0 / 3.0)
        assert ahead.age_days == pytest.approx(2.0)
        assert before.along_m - ahead.along_m == pytest.approx(arc, rel=0.01)
        u = mean_elements([record], record.epoch + later)[0][0, 4:].sum()
        wanted = arc * math.sin(u)
        assert before.across_m - across.across_m == pytest.approx(wanted, abs=0.02 * arc)


@pytest.mark.usefixtures("cli")
def test_sets_that_cannot_be_compared_are_refused() -> None:
    """One epoch alone, and a target without an element set, are a sentence each."""
    records = field(3)
    Path("old.json").write_text(as_json(records), encoding="utf-8")
    Path("part.json").write_text(as_json(records[:1]), encoding="utf-8")
    instance = to_instance(read("old.json"), mission=MissionOutline(epoch=EPOCH)).instance
    with pytest.raises(InputError, match="no target has element sets of two epochs"):
        compared(instance, ["old.json"])
    with pytest.raises(InputError, match=r"no element set of .* and 1 more targets"):
        compared(instance, ["part.json"])
    with pytest.raises(InputError, match="no element set of"):
        compared(adr_opt.generate("tiny", 0), ["old.json"])
