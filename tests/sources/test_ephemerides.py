"""Ephemerides beside an instance: their frames, times, interpolation, files and fits."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue_files import as_json, field
from conftest import Cli
from messages import oem, oem_in_xml

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.judge.refined.as_reported import interpolated_states
from adr_opt.problem.frame import Frame
from adr_opt.problem.frame_rotation import from_gcrf, teme_axes
from adr_opt.problem.orbit import Fit
from adr_opt.sources.catalogue import ElementSet, read, to_instance
from adr_opt.sources.catalogue.propagation import state as sgp4_state
from adr_opt.sources.ephemerides import ephemerides_of, ephemeris_of
from adr_opt.sources.ephemerides.coverage import Coverage
from adr_opt.sources.ephemerides.elements_file import read_elements, to_text
from adr_opt.sources.ephemerides.ephemeris import TurningAxes
from adr_opt.sources.ephemerides.fit import fitted, j3_offset
from adr_opt.sources.ephemerides.imported import with_ephemerides
from adr_opt.sources.ephemerides.interpolation import interpolated
from adr_opt.sources.ephemerides.left_over import left_over, planned_states
from adr_opt.sources.ephemerides.oem import read_oem
from adr_opt.sources.ephemerides.of_instance import ByElements, of_contents

pytest.importorskip("sgp4.api")
pytest.importorskip("erfa")

RECORDS = field(6)
EPOCH = datetime(2025, 3, 2, 12, tzinfo=UTC)
TEME = Frame(name="TEME", axes_epoch=EPOCH)
FILES = ["--epoch", EPOCH.isoformat(), "--duration-days", "2"]


def by_elements(record: ElementSet) -> ByElements:
    return ByElements(record.label, record, EPOCH, TurningAxes(EPOCH, TEME))


def of_date(record: ElementSet) -> Any:
    """SGP4's own states of a record, in TEME of their dates [m, m/s]."""

    def states(times: Any) -> Any:
        since = (EPOCH - record.epoch).total_seconds()
        found = [np.concatenate(sgp4_state(record, (since + t) / 60.0)) for t in times]
        return 1e3 * np.array(found)

    return states


def turned_into(frame: Frame | None, record: ElementSet) -> Any:
    """The same in a fixed frame, turned date by date."""
    if frame is None:
        return of_date(record)

    def states(times: Any) -> Any:
        axes = teme_axes([EPOCH + timedelta(seconds=float(t)) for t in times])
        turn = from_gcrf(frame) @ np.swapaxes(axes, 1, 2)
        vectors = of_date(record)(times).reshape(-1, 2, 3)
        return np.einsum("tij,tkj->tki", turn, vectors).reshape(-1, 6)

    return states


def refused(outcome: Any, *named: str) -> None:
    """One line on standard error that names what it should, nothing written, exit 2."""
    assert outcome.status == 2, outcome
    assert outcome.err.count("\n") == 1, outcome.err
    for text in named:
        assert text in outcome.err
    assert not list(Path().glob("out*"))


def test_element_sets_are_run_in_the_frame_of_the_instance() -> None:
    """States are SGP4's, turned from TEME of their date into that of the epoch."""
    times = np.random.default_rng(1).uniform(-5.0 * DAY_S, 30.0 * DAY_S, 40)
    for record in RECORDS:
        expected = turned_into(TEME, record)(times)
        found = by_elements(record).state(times)
        assert np.abs(found - expected)[:, :3].max() < 1e-3
        assert np.abs(found - expected)[:, 3:].max() < 1e-6


def test_axes_of_date_turn_by_what_precession_says() -> None:
    """After a week a point on the equator has moved by some 34 m, after a year by 1.8 km."""
    point = np.array([[0.0, 7.0e6, 0.0, 0.0, 0.0, 0.0]])
    axes = TurningAxes(EPOCH, TEME)
    for days, low, high in ((0.0, 0.0, 1e-6), (7.0, 20.0, 50.0), (365.0, 1.4e3, 2.0e3)):
        moved = axes.turned(point, np.array([days * DAY_S])) - point
        assert low <= float(np.linalg.norm(moved)) <= high


def test_a_state_has_the_shape_of_its_times() -> None:
    """One time gives six numbers, an array of times as many rows in its shape."""
    ephemeris = by_elements(RECORDS[0])
    assert ephemeris.state(0.0).shape == (6,)
    assert ephemeris.state(np.zeros((2, 3))).shape == (2, 3, 6)
    assert ephemeris.state([]).shape == (0, 6)


def test_element_sets_are_read_as_they_were_written() -> None:
    """A file of element sets holds every number to its last digit."""
    records = {record.label: record for record in field(50, seed=3)}
    assert read_elements(to_text(records).encode(), "x.json") == records
    more = json.loads(to_text(records)) | {"newer": 1}
    with pytest.raises(InputError, match=r"x\.json: field newer: unknown"):
        read_elements(json.dumps(more).encode(), "x.json")


@pytest.mark.parametrize(("method", "degree"), [("LAGRANGE", 7), ("HERMITE", 7), ("LINEAR", 1)])
def test_polynomials_are_interpolated_exactly(method: str, degree: int) -> None:
    """Every polynomial of the degree is met, also near the ends and with uneven steps."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        knots = np.cumsum(rng.uniform(0.5, 1.5, 12))
        parts = rng.normal(size=(3, degree + 1))
        times = np.concatenate((rng.uniform(knots[0], knots[-1], 30), knots[[0, -1]]))

        def states(at: Any, parts: Any = parts) -> Any:
            scaled = (at - 6.0) / 6.0
            places = [np.polyval(part, scaled) for part in parts]
            rates = [np.polyval(np.polyder(part), scaled) / 6.0 for part in parts]
            return np.column_stack((*places, *rates))

        found = interpolated(knots, states(knots), times, method, degree)
        columns = slice(0, 3) if method == "LINEAR" else slice(0, 6)
        assert np.abs(found - states(times))[:, columns].max() < 1e-9


@pytest.mark.parametrize("system", [("UTC", 0.0), ("TAI", 37.0), ("TT", 69.184), ("GPS", 18.0)])
@pytest.mark.parametrize("name", ["TEME of date", "TEME", "EME2000", "J2000", "GCRF", "ICRF"])
def test_messages_in_every_frame_and_time_system_say_the_same(
    name: str, system: tuple[str, float]
) -> None:
    """One orbit in all frames and time systems has one ephemeris, to a centimetre."""
    record, fields = RECORDS[1], {"REF_FRAME": name, "TIME_SYSTEM": system[0]}
    frame: Frame | None
    if name == "TEME of date":
        frame, fields["REF_FRAME"] = None, "TEME"
    elif name == "TEME":
        date = EPOCH - timedelta(days=100)
        at = (date + timedelta(seconds=system[1])).replace(tzinfo=None).isoformat()
        frame, fields["REF_FRAME_EPOCH"] = Frame(name="TEME", axes_epoch=date), at
    else:
        frame = Frame(name="EME2000" if name == "J2000" else name)
    text = oem(
        record.label,
        record.object_id,
        EPOCH,
        turned_into(frame, record),
        span_s=(-1200.0, 7200.0),
        ahead_s=system[1],
        **fields,
    )
    known = of_contents(
        "oem", {"a.oem": text.encode()}, {record.label: None}, epoch=EPOCH, frame=TEME
    )
    times = np.linspace(0.0, 7200.0, 101)
    expected = by_elements(record).state(times)
    assert np.abs(known.of(record.label).state(times) - expected)[:, :3].max() < 0.01


@pytest.mark.parametrize(
    ("method", "degree", "frame"),
    [
        ("LAGRANGE", 7, None),
        ("LAGRANGE", 8, Frame(name="EME2000")),
        ("HERMITE", 7, TEME),
        ("HERMITE", 3, Frame(name="GCRF")),
        ("LINEAR", 1, None),
    ],
)
def test_three_readers_interpolate_alike(
    method: str, degree: int, frame: Frame | None, tmp_path: Path
) -> None:
    """The judge's polynomials and those of the package `oem` agree with ours within a millimetre.

    By other polynomials, other turning of axes, and in `oem` another reading of text and times.
    """
    third = pytest.importorskip("oem")
    astropy_time = pytest.importorskip("astropy.time")
    record = RECORDS[1]
    fields = {"REF_FRAME": "TEME" if frame is None else frame.name}
    if frame == TEME:
        fields["REF_FRAME_EPOCH"] = EPOCH.replace(tzinfo=None).isoformat()
    text = oem(
        record.label,
        record.object_id,
        EPOCH,
        turned_into(frame, record),
        span_s=(-600.0, 1800.0),
        step_s=60.0,
        INTERPOLATION=method,
        INTERPOLATION_DEGREE=str(degree),
        **fields,
    )
    known = of_contents(
        "oem", {"a.oem": text.encode()}, {record.label: None}, epoch=EPOCH, frame=TEME
    )
    times = np.concatenate((np.linspace(-600.0, 1800.0, 97), [-599.9, 0.5, 1799.9]))
    ours = known.of(record.label).state(times)
    coverage = Coverage(record.label, read_oem(text.encode(), "a.oem"), EPOCH)
    judged = interpolated_states(coverage, times, EPOCH, TEME)
    assert np.abs(judged - ours)[:, :3].max() < 1e-3
    assert np.abs(judged - ours)[:, 3:].max() < 1e-5
    with pytest.raises(InputError, match=r"no state of .* after"):
        interpolated_states(coverage, times + 1.0, EPOCH, TEME)
    if method == "LINEAR":
        return
    (tmp_path / "a.oem").write_text(text.replace("= TEME\n", "= EME2000\n"), encoding="ascii")
    message = third.OrbitEphemerisMessage.open(tmp_path / "a.oem")
    begin = astropy_time.Time(EPOCH.replace(tzinfo=None), scale="utc")
    states = [message(begin + time * astropy_time.TimeDelta(1.0, format="sec")) for time in times]
    read = 1e3 * np.array([[*state.position, *state.velocity] for state in states])
    if frame is None:
        axes = teme_axes([EPOCH + timedelta(seconds=float(time)) for time in times])
        turns = from_gcrf(TEME) @ np.swapaxes(axes, 1, 2)
    else:
        turns = np.broadcast_to(from_gcrf(TEME) @ from_gcrf(frame).T, (times.size, 3, 3))
    turned = np.einsum("tij,tkj->tki", turns, read.reshape(-1, 2, 3)).reshape(-1, 6)
    assert np.abs(turned - judged)[:, :3].max() < 1e-3


def test_messages_go_round_through_an_instance(cli: Cli) -> None:
    """Messages become an instance, whose ephemerides are theirs to less than a metre."""
    Path("all.json").write_text(as_json(RECORDS), encoding="utf-8")
    files = []
    for number, record in enumerate(RECORDS):
        files.append(f"{number}.oem")
        text = oem(
            record.label,
            record.object_id,
            EPOCH,
            of_date(record),
            span_s=(-1200.0, 2.0 * DAY_S + 1200.0),
        )
        Path(files[-1]).write_text(text, encoding="utf-8")
    folder = Path("mission")
    folder.mkdir()
    options = [part for file in files for part in ("--oem", file)]
    cli("import", "all.json", *FILES, *options, "--out", "mission/out.json")
    instance = adr_opt.load("mission/out.json")
    assert instance.ephemerides is not None
    assert instance.ephemerides.files == tuple(files)
    assert instance.ephemerides.kind == "oem"
    times, known = np.linspace(0.0, 2.0 * DAY_S, 333), ephemerides_of(instance)
    for record in RECORDS:
        found = known.of(record.label).state(times)[:, :3]
        assert np.linalg.norm(found - by_elements(record).state(times)[:, :3], axis=1).max() < 1.0


def test_another_file_of_the_name_of_a_message_stays(cli: Cli) -> None:
    """A message is not copied over another file beside the instance."""
    record = RECORDS[0]
    Path("all.json").write_text(as_json([record]), encoding="utf-8")
    text = oem(
        record.label,
        record.object_id,
        EPOCH,
        of_date(record),
        span_s=(-1200.0, 2.0 * DAY_S + 1200.0),
    )
    Path("a.oem").write_text(text, encoding="utf-8")
    Path("mission").mkdir()
    Path("mission/a.oem").write_text("something else", encoding="utf-8")
    asked = ["import", "all.json", *FILES, "--oem", "a.oem", "--out", "mission/out.json", "--quiet"]
    refused(cli(*asked), "another file of this name exists")
    assert [path.name for path in Path("mission").iterdir()] == ["a.oem"]


def test_an_import_keeps_element_sets_beside_the_instance(cli: Cli) -> None:
    """States of an imported instance are SGP4's; a copy elsewhere takes the file along."""
    Path("all.json").write_text(as_json(RECORDS), encoding="utf-8")
    said = json.loads(
        cli("import", "all.json", *FILES, "--ephemerides", "--out", "out.json", "--json").out
    )
    assert said["ephemerides"]["file"] == "out.elements.json"
    assert said["left"]["bodies"] == len(RECORDS)
    instance = adr_opt.load("out.json")
    Path("copy").mkdir()
    instance.part(instance.names[-2:]).save("copy/part.json")
    other = adr_opt.load("copy/part.json")
    record = next(one for one in RECORDS if one.label == other.names[-1])
    expected = by_elements(record).state([0.0, 5e4])
    assert ephemeris_of(other, record.label).state([0.0, 5e4]) == pytest.approx(expected)
    assert instance.targets[0].fit is not None
    with pytest.raises(InputError, match="has no ephemeris"):
        ephemeris_of(other, "station")


def test_other_ephemerides_than_stated_are_refused(cli: Cli) -> None:
    """A changed or missing file is one sentence when an ephemeris is asked for."""
    Path("all.json").write_text(as_json(RECORDS), encoding="utf-8")
    cli("import", "all.json", *FILES, "--ephemerides", "--out", "out.json")
    instance = adr_opt.load("out.json")
    path = Path("out.elements.json")
    path.write_text(path.read_text().replace('"BSTAR": 0.', '"BSTAR": 0.1'), encoding="utf-8")
    with pytest.raises(InputError, match="not the ephemerides that the instance names"):
        ephemerides_of(instance)
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        ephemerides_of(instance)
    plain = adr_opt.generate("tiny", 0)
    with pytest.raises(InputError, match="has no ephemerides"):
        ephemerides_of(plain)


SHORT = {"span_s": (-1200.0, 1.5 * DAY_S)}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (SHORT, "give an ephemeris of the whole mission"),
        ({"REF_FRAME": "ITRF2014"}, "REF_FRAME = ITRF2014: must be one of"),
        ({"TIME_SYSTEM": "UT1"}, "TIME_SYSTEM = UT1: must be one of"),
        ({"CENTER_NAME": "MARS"}, "CENTER_NAME = MARS: must be EARTH"),
        ({"INTERPOLATION": "SPLINE"}, "INTERPOLATION = SPLINE: must be one of"),
        ({"INTERPOLATION_DEGREE": "0"}, "INTERPOLATION_DEGREE = 0: must be from"),
        ({"START_TIME": "yesterday"}, "'yesterday' is not a time"),
        ({"OBJECT_NAME": "ANOTHER", "OBJECT_ID": "2000-001A"}, "no ephemeris of"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_bad_messages_are_one_sentence(cli: Cli, change: dict[str, Any], said: str) -> None:
    """What cannot be used is refused before anything is written."""
    record = RECORDS[0]
    Path("all.json").write_text(as_json([record]), encoding="utf-8")
    whole = {"span_s": (-1200.0, 2.0 * DAY_S + 1200.0)} | change
    text = oem(record.label, record.object_id, EPOCH, of_date(record), **whole)
    Path("a.oem").write_text(text, encoding="utf-8")
    asked = ["import", "all.json", *FILES, "--oem", "a.oem", "--out", "out.json", "--quiet"]
    refused(cli(*asked), said)


def test_two_ephemerides_of_a_body_are_one_sentence(cli: Cli) -> None:
    """A body has one ephemeris at a time, whichever files it is in."""
    record = RECORDS[0]
    Path("all.json").write_text(as_json([record]), encoding="utf-8")
    for name in ("a.oem", "b.oem"):
        text = oem(
            record.label,
            record.object_id,
            EPOCH,
            of_date(record),
            span_s=(-1200.0, 2.0 * DAY_S + 1200.0),
        )
        Path(name).write_text(text, encoding="utf-8")
    refused(
        cli(
            "import",
            "all.json",
            *FILES,
            "--oem",
            "a.oem",
            "--oem",
            "b.oem",
            "--out",
            "out.json",
            "--quiet",
        ),
        "two ephemerides at one time",
    )


def test_an_object_that_comes_down_is_one_sentence(cli: Cli) -> None:
    """An element set with which SGP4 fails during the mission is refused."""
    falling = replace(RECORDS[0], mean_motion_rev_day=16.2, eccentricity=0.0001, bstar=0.01)
    Path("all.json").write_text(as_json([falling]), encoding="utf-8")
    refused(
        cli(
            "import all.json --epoch",
            falling.epoch.isoformat(),
            "--duration-days",
            "30",
            "--ephemerides",
            "--out",
            "out.json",
            "--quiet",
        ),
        "SGP4 error",
    )


class Planned:
    """An ephemeris that follows fitted elements."""

    def __init__(self, orbit: Any, decay: float, fit: Fit) -> None:
        self.body, self._of = "drawn", (orbit, decay, fit)

    def state(self, times_s: Any) -> Any:
        """States at times."""
        return planned_states(*self._of, times_s)


def test_a_fit_finds_the_elements_that_made_the_states() -> None:
    """States of fitted elements give these elements back, over days or months."""
    rng, instance = np.random.default_rng(5), adr_opt.generate("tiny", 0)
    for days in (3.0, 7.0, 60.0):
        orbit = instance.targets[0].orbit
        assert orbit is not None
        orbit = orbit.replace(
            eccentricity=float(rng.uniform(0.001, 0.02)),
            argument_of_perigee_deg=float(rng.uniform(0.0, 360.0)),
        )
        decay = float(rng.uniform(-20.0, 300.0))
        offset = j3_offset(orbit.semi_major_axis_m, math.radians(orbit.inclination_deg))
        ephemeris = Planned(orbit, decay, Fit(eccentricity_offset=(0.0, offset)))
        found = fitted(ephemeris, days * DAY_S)
        assert found.orbit.semi_major_axis_m == pytest.approx(orbit.semi_major_axis_m, abs=1.0)
        assert found.decay_m_per_day == pytest.approx(decay, abs=0.2)
        assert found.fit.eccentricity_offset == pytest.approx((0.0, offset), abs=2e-6)
        left = left_over(ephemeris, found, days * DAY_S)
        assert left.epoch_m < 30.0
        assert left.along_m < 100.0
        assert left.across_m < 5.0


def test_fits_of_real_motion_are_near() -> None:
    """Fits to SGP4 leave less than a kilometre at the epoch and five along the track."""
    for record in RECORDS:
        ephemeris = by_elements(record)
        left = left_over(ephemeris, fitted(ephemeris, 3.0 * DAY_S), 3.0 * DAY_S)
        assert left.epoch_m < 1e3
        assert left.along_m < 5e3


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"dynamics": "two-body"}, "nothing decays in two-body motion"),
        ({"removal": "tow"}, "tows of decaying objects"),
        ({"orbit": None}, "there is no orbit; give one"),
        ({"decay_m_per_day": 1e6}, "decay_m_per_day"),
    ],
)
def test_decays_that_make_no_sense_are_refused(changes: dict[str, Any], said: str) -> None:
    """A decay needs an orbit under J2 that is not towed, and a sane size."""
    tiny = adr_opt.generate("tiny", 0).replace(dynamics=changes.pop("dynamics", "j2"))
    target = tiny.targets[0]
    with pytest.raises(InputError, match=said):
        tiny.replace(targets=(target.replace(**{"decay_m_per_day": 5.0, **changes}),))


DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))


@pytest.mark.external
@pytest.mark.slow
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA} (ADR_OPT_EXTERNAL_DATA)")
@pytest.mark.parametrize(
    "name",
    ["tle/celestrak_2025-02_iridium-33-debris.txt", "omm/celestrak_2025-04_iridium-33-debris.csv"],
)
def test_real_fragments_are_near_their_fits(name: str) -> None:
    """Of 60 fragments over a week, at most 1 km is left at the epoch and 5 km along the track."""
    found = read(DATA / name, skip_bad=True)
    made = with_ephemerides(to_instance(found, max_targets=60, skip_bad=True), "x.json")
    assert np.median([one.epoch_m for one in made.left]) < 1e3
    assert np.median([one.along_m for one in made.left]) < 5e3
    assert np.median([one.across_m for one in made.left]) < 1e3


@pytest.mark.external
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA} (ADR_OPT_EXTERNAL_DATA)")
def test_messages_of_others_are_read_or_refused() -> None:
    """Every example of an OEM gives its segments, or one sentence that says why not."""
    refused_ones = {
        "OEMExample7.txt.post": "not an OEM",
        "OEMExample7.txt.pre": "REF_FRAME is missing",
    }
    paths = sorted((DATA / "ccsds").glob("OEM*"))
    assert len(paths) >= 13
    for path in paths:
        if path.name in refused_ones:
            with pytest.raises(InputError, match=refused_ones[path.name]):
                read_oem(path.read_bytes(), path.name)
            continue
        for segment in read_oem(path.read_bytes(), path.name):
            times, states = segment.states()
            assert len(times) == len(states) >= 2


@pytest.mark.external
def test_a_message_of_others_is_interpolated_alike() -> None:
    """Of Orekit's example about the Earth `oem` reads the states that judge and product go through.

    Between them these two are at one place. It asks for Hermite's method of degree 1, which `oem`
    takes for a tangent at one state.
    """
    third, path = pytest.importorskip("oem"), DATA / "ccsds" / "OEMExample5.txt"
    astropy_time = pytest.importorskip("astropy.time")
    if not path.is_file():
        pytest.skip(f"no {path}")
    segments = read_oem(path.read_bytes(), path.name)
    fields, inertial = segments[0].fields, Frame(name="GCRF")
    begin = datetime.fromisoformat(fields["START_TIME"][:26]).replace(tzinfo=UTC)
    known = of_contents(
        "oem",
        {path.name: path.read_bytes()},
        {fields["OBJECT_NAME"]: None},
        epoch=begin,
        frame=inertial,
    )
    times = np.linspace(30.0, 86000.0, 60)
    ours = known.of(fields["OBJECT_NAME"]).state(times)
    coverage = Coverage(fields["OBJECT_NAME"], segments, begin)
    judged = interpolated_states(coverage, times, begin, inertial)
    assert np.abs(judged - ours)[:, :3].max() < 1e-3
    states = third.OrbitEphemerisMessage.open(path).states
    at = astropy_time.Time(begin.replace(tzinfo=None), scale="utc")
    since = np.array([(state.epoch - at).sec for state in states])
    within = (since >= 0.0) & (since <= 86400.0)
    read = 1e3 * np.array([state.position for state in states])[within]
    theirs = known.of(fields["OBJECT_NAME"]).state(since[within])
    assert np.abs(read - theirs[:, :3]).max() < 1e-2  # labels have microseconds


def test_messages_in_xml_say_what_those_in_lines_say() -> None:
    """The same metadata and states in both notations are the same segment."""
    record = RECORDS[2]
    text = oem(record.label, record.object_id, EPOCH, of_date(record))
    (plain,) = read_oem(text.encode(), "a.oem")
    xml = oem_in_xml(text)
    (other,) = read_oem(xml.encode(), "a.xml")
    assert (other.fields, other.rows) == (plain.fields, plain.rows)
    twice = "<TIME_SYSTEM>UTC</TIME_SYSTEM>"
    for bad in (
        xml[:-20],
        xml.replace("<X>", "<Z>", 1).replace("</X>", "</Z>", 1),
        xml.replace(twice, 2 * twice),
        xml.replace("<X>", '<X units="m">', 1),
        xml.replace("<oem", "<!DOCTYPE oem><oem", 1),
    ):
        with pytest.raises(InputError, match=r"a\.xml"):
            read_oem(bad.encode(), "a.xml")
