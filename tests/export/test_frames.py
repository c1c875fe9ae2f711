"""The frame of an instance: kept in its file, and true in every export of its plans."""

from __future__ import annotations

import json
import math
import os
import re
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from conftest import Cli
from gmat_script import fly_script

import adr_opt
from adr_opt.export.flights import FlightFile, write_plan
from adr_opt.fly.trajectory import body_states, sample
from adr_opt.fly.trajectory.axes import axes_of, rotation
from adr_opt.plan.plan import Plan
from adr_opt.problem.frame import FRAMES, Frame
from adr_opt.problem.instance import Instance

pytest.importorskip("astropy")

ROOT = Path(__file__).parents[2]
EXTERNAL = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", ROOT / "../shared/data")) / "ccsds"

Array = np.ndarray
ARCSECOND = math.radians(1.0 / 3600.0)
EPOCH = datetime(2025, 2, 27, 6, 30, 15, 250_000, tzinfo=UTC)
TEME = Frame(name="TEME", axes_epoch=EPOCH)
GCRF, EME2000, ICRF = (Frame(name=name) for name in ("GCRF", "EME2000", "ICRF"))


def in_teme(instance: Instance) -> Instance:
    """The instance with its elements in TEME of its epoch."""
    return instance.replace(epoch=EPOCH, frame=TEME)


@pytest.fixture(scope="module")
def tiny() -> Instance:
    return in_teme(adr_opt.generate("tiny", 0))


@pytest.fixture(scope="module")
def plan(tiny: Instance) -> Plan:
    made = adr_opt.solve(tiny, "greedy-guarded").plan
    assert made is not None
    return made


def angle(one: Array, other: Array) -> float:
    """The angle of the rotation from one matrix to another."""
    skew = one @ other.T
    return float(np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]]))


def test_published_vectors_in_teme() -> None:
    """Vallado's two examples come out: to a centimetre in GCRF, and to 3 m by models of 1976."""
    time = datetime(2004, 4, 6, 7, 51, 28, 386_009, tzinfo=UTC)
    matrix = rotation(Frame(name="TEME", axes_epoch=time), GCRF)
    position = matrix @ [5094.18016210, 6127.64465950, 6380.34453270]
    velocity = matrix @ [-4.7461314870, 0.7858180410, 5.5319312880]
    assert 1e3 * np.linalg.norm(position - [5102.50895790, 6123.01140070, 6378.13692820]) < 0.01
    assert 1e3 * np.linalg.norm(velocity - [-4.7432201570, 0.7905364970, 5.5337557270]) < 1e-5

    # The satellite 00005 after three days; its EME2000 is that of 1976, without corrections.
    time = datetime(2000, 6, 30, 18, 50, 19, 733_568, tzinfo=UTC)
    matrix = rotation(Frame(name="TEME", axes_epoch=time), EME2000)
    position = matrix @ [-9060.47373569, 4658.70952502, 813.68673153]
    velocity = matrix @ [-2.232832783, -4.110453490, -3.157345433]
    assert 1e3 * np.linalg.norm(position - [-9059.9413786, 4659.6972000, 813.9588875]) < 3.0
    assert 1e3 * np.linalg.norm(velocity - [-2.233348094, -4.110136162, -3.157394074]) < 1e-3


@pytest.mark.parametrize("year", [2000, 2010, 2020, 2025])
def test_astropy_turns_teme_to_the_same_gcrf(year: int) -> None:
    """Its own way through the rotating Earth ends within a millimetre in low orbit."""
    from astropy import units
    from astropy.coordinates import GCRS, TEME, CartesianRepresentation
    from astropy.time import Time

    time = datetime(year, 2, 27, 6, 30, tzinfo=UTC)
    when = Time(time.replace(tzinfo=None), scale="utc")
    stated = CartesianRepresentation(7.1e6 * np.eye(3), unit=units.m)
    there = TEME(stated, obstime=when).transform_to(GCRS(obstime=when)).cartesian.xyz.value
    assert np.abs(there - 7.1e6 * rotation(Frame(name="TEME", axes_epoch=time), GCRF)).max() < 1e-3


def test_axes_of_teme_move_as_the_model_says() -> None:
    """They are 0.35° from GCRF in 2025, and move 34 m a week and 1.8 km a year in low orbit."""
    assert math.degrees(angle(rotation(TEME, GCRF), np.eye(3))) == pytest.approx(0.35, abs=0.01)
    start = datetime(2025, 2, 1, tzinfo=UTC)
    for days, moved_m in ((7.0, 34.0), (365.25, 1_800.0)):
        later = datetime.fromtimestamp(start.timestamp() + 86400.0 * days, tz=UTC)
        between = rotation(
            Frame(name="TEME", axes_epoch=start), Frame(name="TEME", axes_epoch=later)
        )
        assert 7.1e6 * angle(between, np.eye(3)) == pytest.approx(moved_m, rel=0.3)


@pytest.mark.parametrize("there", FRAMES)
@pytest.mark.parametrize("here", FRAMES)
def test_frames_lead_there_and_back(here: str, there: str) -> None:
    """Every rotation is one, and its inverse is the way back; that of 1950 or 2100 is found too."""
    for year in (1950, 2026, 2100):
        epoch = datetime(year, 1, 1, tzinfo=UTC)
        one, other = (
            Frame(name=name, axes_epoch=epoch if name == "TEME" else None) for name in (here, there)
        )
        matrix, back = (
            np.eye(3) if found is None else found
            for found in (rotation(one, other), rotation(other, one))
        )
        assert np.abs(matrix @ matrix.T - np.eye(3)).max() < 1e-14
        assert np.abs(matrix @ back - np.eye(3)).max() < 1e-14
        assert np.linalg.det(matrix) == pytest.approx(1.0)
        assert (np.abs(matrix - np.eye(3)).max() > 1e-9) == (
            here != there and {here, there} != {"GCRF", "ICRF"}
        )


def test_the_bias_between_gcrf_and_eme2000_is_that_of_the_iers() -> None:
    """Its three angles are those of the conventions of 2010: 0.8 m in low orbit."""
    bias = rotation(GCRF, EME2000)
    milliarcseconds = 1e3 / ARCSECOND * np.array([bias[0, 1], bias[0, 2], bias[1, 2]])
    assert milliarcseconds == pytest.approx([-14.6, 16.617, 6.819], abs=0.01)


def test_no_network_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is loaded, also far beyond the tables of the Earth's rotation."""
    from astropy.utils import data

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("the network was asked")

    monkeypatch.setattr(data, "download_file", refuse)
    monkeypatch.setattr("astropy.utils.iers.iers.download_file", refuse, raising=False)
    assert rotation(Frame(name="TEME", axes_epoch=datetime(2060, 1, 1, tzinfo=UTC)), GCRF).any()


def test_a_frame_stands_in_the_file_only_where_it_is_set() -> None:
    """Files that name none are as they were, byte by byte; one that does is read back the same."""
    plain = adr_opt.generate("tiny", 0)
    assert plain.frame is None
    assert "frame" not in plain.to_json()
    assert plain.replace(frame=None).sha256 == plain.sha256
    for frame in (TEME, GCRF):
        named = plain.replace(frame=frame)
        assert Instance.from_json(named.to_json()) == named
        assert named.sha256 != plain.sha256
        assert named != plain
    assert '"frame": {"name": "GCRF"}' in plain.replace(frame=GCRF).to_json()
    assert "frame" in Instance.json_schema()["properties"]


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ({"name": "TEME"}, "axes_epoch is missing"),
        ({"name": "GCRF", "axes_epoch": "2025-01-01T00:00:00Z"}, "leave it out"),
        ({"name": "ITRF"}, 'frame.name = "ITRF"'),
        ({"name": "TEME", "axes_epoch": 5.0}, "frame.axes_epoch"),
        ("TEME", "frame"),
    ],
)
def test_frames_that_say_too_little_or_too_much_are_refused(frame: object, said: str) -> None:
    """TEME says of when its axes are, the others do not, and other frames are none."""
    content = json.loads(adr_opt.generate("tiny", 0).to_json()) | {"frame": frame}
    with pytest.raises(adr_opt.InputError, match=re.escape(said)):
        adr_opt.solve(content, "greedy")


def states_of(path: Path) -> tuple[list[str], Array]:
    """Frame lines of the first segment of an OEM, and all states of the file."""
    oem = pytest.importorskip("oem")
    read = oem.OrbitEphemerisMessage.open(path)
    states = [
        [*state.position, *state.velocity] for segment in read.segments for state in segment.states
    ]
    text = path.read_text(encoding="ascii").partition("META_STOP")[0]
    return re.findall(r"^REF_FRAME.*$", text, re.MULTILINE), np.array(states)


@pytest.mark.parametrize("own", [TEME, GCRF, EME2000, ICRF])
@pytest.mark.parametrize("suffix", ["oem", "opm", "script"])
def test_by_default_a_known_frame_is_written_as_gcrf(
    own: Frame, suffix: str, tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """Whatever frame an instance names, a file without further words is in GCRF."""
    instance = tiny.replace(frame=own)
    plan = plan.replace(instance=plan.instance.replace(sha256=instance.sha256))
    named = {}
    for frame in (None, "GCRF"):
        path = tmp_path / f"{frame}.{suffix}"
        write_plan(instance, plan, path, file=FlightFile(frame=frame))
        text = path.read_text(encoding="ascii")
        named[frame] = re.sub("CREATION_DATE.*", "", text)
    assert named[None] == named["GCRF"]
    assert re.search("REF_FRAME = GCRF$|CoordinateSystem = EarthICRF;", text, re.MULTILINE)


def test_a_message_in_teme_says_of_when_its_axes_are(
    tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """Elements in TEME are written so where asked for, with its epoch, and are not turned."""
    asked = FlightFile(frame="TEME")
    flight = write_plan(tiny, plan, tmp_path / "a.oem", file=asked)
    said, states = states_of(tmp_path / "a.oem")
    assert said == ["REF_FRAME = TEME", "REF_FRAME_EPOCH = 2025-02-27T06:30:15.250000"]
    first = next(arc for _, arc in flight.arcs())
    assert 1e3 * states[0, :3] == pytest.approx(first.positions_m[0], abs=0.01)
    write_plan(tiny, plan, tmp_path / "a.opm", file=asked)
    text = (tmp_path / "a.opm").read_text(encoding="ascii")
    assert re.findall(r"^(?:MAN_)?REF_FRAME(?:_EPOCH)? = .*$", text, re.MULTILINE)[:2] == said
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io")
    for name in ("a.opm", "a.oem"):
        segment = ndm_io.NdmIo().from_path(tmp_path / name).body.segment
        for one in segment if isinstance(segment, list) else [segment]:
            assert one.metadata.ref_frame == "TEME"
            assert one.metadata.ref_frame_epoch == "2025-02-27T06:30:15.250000"


@pytest.mark.parametrize("frame", ["EME2000", "GCRF", "ICRF"])
def test_a_frame_turns_states_and_burns(
    tiny: Instance, plan: Plan, tmp_path: Path, frame: str
) -> None:
    """What is written in another frame is what TEME holds, turned: 44 km off, and back the same."""
    write_plan(tiny, plan, tmp_path / "own.oem", file=FlightFile(frame="TEME"))
    write_plan(tiny, plan, tmp_path / "other.oem", file=FlightFile(frame=frame))
    _, own = states_of(tmp_path / "own.oem")
    said, other = states_of(tmp_path / "other.oem")
    assert said == [f"REF_FRAME = {frame}"]
    matrix = rotation(TEME, Frame(name=frame))
    assert np.abs(other[:, :3] - own[:, :3] @ matrix.T).max() < 1e-8
    assert np.abs(other[:, 3:] - own[:, 3:] @ matrix.T).max() < 1e-11
    assert 20.0 < np.linalg.norm(other[:, :3] - own[:, :3], axis=1).max() < 50.0

    found = {}
    for name, asked in (("own", "TEME"), ("other", frame)):
        write_plan(tiny, plan, tmp_path / f"{name}.opm", file=FlightFile(frame=asked))
        text = (tmp_path / f"{name}.opm").read_text(encoding="ascii")
        numbers = re.findall(r"^(?:[XYZ]|[XYZ]_DOT|MAN_DV_\d) = (\S+)", text, re.MULTILINE)
        found[name] = np.array(numbers, dtype=float).reshape(-1, 3)
        assert text.count(f"MAN_REF_FRAME = {asked}\n") == len(found[name]) - 2
    assert np.abs(found["other"] - found["own"] @ matrix.T).max() < 1e-8


def test_cesium_gets_the_icrf(tiny: Instance, plan: Plan, tmp_path: Path) -> None:
    """Chaser and bodies are turned to the frame that Cesium calls inertial."""
    matrix = rotation(TEME, ICRF)
    write_plan(tiny, plan, tmp_path / "a.czml")
    packets = {packet["id"]: packet for packet in json.loads((tmp_path / "a.czml").read_text())}
    assert "turned from the frame of the elements, TEME" in packets["document"]["description"]
    for name in tiny.names:
        samples = np.array(packets[f"body/{name}"]["position"]["cartesian"]).reshape(-1, 4)
        true = body_states(tiny, name, samples[:, 0])[0] @ matrix.T
        assert np.abs(samples[:, 1:] - true).max() < 1.0
    arcs = [arc for _, arc in sample(tiny, plan).arcs()]
    for piece, arc in zip(packets["chaser"]["position"], arcs, strict=True):
        samples = np.array(piece["cartesian"]).reshape(-1, 4)
        assert np.abs(samples[:, 1:] - arc.positions_m @ matrix.T).max() < 0.01


@pytest.mark.parametrize("dynamics", ["two-body", "j2"])
def test_gmat_gets_axes_that_it_has(dynamics: str, tiny: Instance, tmp_path: Path) -> None:
    """A script of elements in TEME is in GCRF, and its states and mean orbits are turned."""
    instance = tiny.replace(dynamics=dynamics)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    write_plan(instance, plan, tmp_path / "a.script", leg=1)
    text = (tmp_path / "a.script").read_text(encoding="ascii")
    assert "GMAT Chaser.CoordinateSystem = EarthICRF;" in text
    matrix = rotation(TEME, GCRF)
    start = plan.legs[0].ready_s
    if dynamics == "two-body":
        reports, _ = fly_script(text)
        assert np.linalg.norm(reports[0][0] - reports[0][1]) < 0.1
        stated = re.findall(r"GMAT Chaser\.V?[XYZ] = (\S+);", text)
        position, velocity = np.array(stated, dtype=float).reshape(2, 3) * 1e3
    else:
        found = {}

        def stand(*circle: float) -> Array:
            from gmat_script import on_circle

            found.setdefault("chaser", on_circle(*circle))
            return found["chaser"].copy()

        fly_script(text, mean=stand)
        position, velocity = found["chaser"][:3], found["chaser"][3:]
    true = [state[0] for state in body_states(instance, plan.legs[0].origin, start)]
    assert np.linalg.norm(position - matrix @ true[0]) < 10.0  # begins at a whole millisecond
    assert np.linalg.norm(velocity - matrix @ true[1]) < 0.01
    with pytest.raises(adr_opt.InputError, match="GMAT has no such axes"):
        write_plan(instance, plan, tmp_path / "a.script", file=FlightFile(frame="TEME"))


def test_without_a_frame_the_flag_is_a_name(tmp_path: Path) -> None:
    """States stay as they are, whatever they are called, and the file says that it is a name."""
    instance = adr_opt.generate("tiny", 0)
    plan = adr_opt.solve(instance, "greedy-guarded").plan
    assert plan is not None
    found = []
    for frame in (None, *FRAMES):
        write_plan(instance, plan, tmp_path / "a.oem", file=FlightFile(frame=frame))
        said, states = states_of(tmp_path / "a.oem")
        assert said[0] == f"REF_FRAME = {frame or 'EME2000'}"
        assert (len(said) > 1) == (frame == "TEME")
        found.append(states)
        text = (tmp_path / "a.oem").read_text(encoding="ascii").replace("\nCOMMENT ", " ")
        assert "was named on export" in text
        assert "nothing was transformed" in text
    assert all(np.array_equal(found[0], states) for states in found)
    assert axes_of(instance).matrix is None


def test_export_says_which_frame_it_wrote(
    cli: Cli, tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """In words and in --json: the frame, what it was turned from, or that none is known."""
    instance, plain = tmp_path / "my.json", tmp_path / "plain.json"
    plan_file, other = tmp_path / "plan.json", tmp_path / "other.json"
    tiny.save(instance)
    plan.save(plan_file)
    adr_opt.generate("tiny", 0).save(plain)
    made = adr_opt.solve(adr_opt.load(plain), "greedy-guarded").plan
    assert made is not None
    made.save(other)
    for arguments, said, told in (
        (
            (instance, plan_file, "--frame", "TEME"),
            "in TEME of 2025-02-27T06:30:15Z\n",
            ("TEME", "TEME"),
        ),
        (
            (instance, plan_file),
            "in GCRF, turned from TEME of 2025-02-27T06:30:15Z\n",
            ("GCRF", "TEME"),
        ),
        ((plain, other), "called EME2000: the instance names no frame\n", ("EME2000", None)),
        ((plain, other, "--frame", "ICRF"), "called ICRF: the instance names", ("ICRF", None)),
    ):
        done = cli("export", *arguments, "--out", tmp_path / "a.oem", "--json")
        assert done.status == 0
        assert said in done.err
        content = json.loads(done.out)
        assert (content["frame"], content["instance_frame"]) == told
        assert ("axes_epoch" in content) == (told[0] == "TEME")


def test_import_sets_teme_of_the_epoch(cli: Cli, tmp_path: Path) -> None:
    """An instance made of element sets names TEME with axes of its own epoch, whatever it is."""
    pytest.importorskip("sgp4")
    cloud = ROOT / "examples" / "catalogue" / "cloud.tle"
    for options in ((), ("--epoch", "2025-03-09T01:02:03Z")):
        out = tmp_path / "my.json"
        assert cli("import", cloud, "--max-targets", 3, *options, "--out", out).status == 0
        instance = adr_opt.load(out)
        assert instance.frame == Frame(name="TEME", axes_epoch=instance.epoch)


def test_planes_of_imported_objects_are_those_of_sgp4_in_gcrf() -> None:
    """What is exported in GCRF lies in the plane that SGP4's state has there, and not in TEME's."""
    pytest.importorskip("sgp4")
    from astropy import units
    from astropy.coordinates import GCRS, TEME, CartesianRepresentation
    from astropy.time import Time

    from adr_opt.sources.catalogue import read, to_instance
    from adr_opt.sources.catalogue.propagation import state

    found = read(ROOT / "examples" / "catalogue" / "cloud.tle")
    instance = to_instance(found, max_targets=6).instance
    axes, when = axes_of(instance, "GCRF"), Time(instance.epoch.replace(tzinfo=None), scale="utc")
    records = {record.label: record for record in found}
    for target in instance.targets:
        record = records[target.name]
        minutes = (instance.epoch - record.epoch).total_seconds() / 60.0
        normal = np.cross(*state(record, minutes))
        stated = CartesianRepresentation(normal / np.linalg.norm(normal), unit=units.one)
        true = TEME(stated, obstime=when).transform_to(GCRS(obstime=when)).cartesian.xyz.value
        own = np.cross(*(one[0] for one in body_states(instance, target.name, 0.0)))
        own /= np.linalg.norm(own)
        assert np.degrees(np.arccos(min(1.0, axes.turned(own) @ true))) < 0.03
        assert np.degrees(np.arccos(min(1.0, own @ true))) > 0.1


def test_labelled_matrices_name_the_frame(tiny: Instance) -> None:
    """The attributes of NetCDF and Parquet files have the frame, and those without one do not."""
    from adr_opt.export.tables.arrays import attributes

    found = attributes(tiny)
    assert found["frame_name"] == "TEME"
    assert found["frame_axes_epoch"] == "2025-02-27T06:30:15.250000Z"
    assert not any(key.startswith("frame") for key in attributes(adr_opt.generate("tiny", 0)))


def test_variants_of_an_instance_keep_its_frame(tiny: Instance) -> None:
    """Parts, other limits and replacements are in the frame that the whole is in."""
    shorter, fewer = tiny.with_limits(duration_s=86400.0), tiny.part(tiny.names[-2:])
    assert shorter.frame == fewer.frame == tiny.replace(name="other").frame == TEME
    assert tiny.replace(frame={"name": "GCRF"}).frame == GCRF
    assert "TEME of 2025-02-27T06:30:15Z" in tiny._repr_html_()


def test_what_has_to_be_turned_needs_the_library(
    tiny: Instance, plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without astropy a file in the instance's own frame is written, one in another refused."""
    monkeypatch.setitem(sys.modules, "erfa", None)
    write_plan(tiny, plan, tmp_path / "a.oem", file=FlightFile(frame="TEME"))
    for name, frame in (
        ("b.oem", None),
        ("c.oem", "EME2000"),
        ("b.script", None),
        ("b.czml", None),
    ):
        with pytest.raises(adr_opt.MissingExtra, match=r"astropy.*\[astro\]"):
            write_plan(tiny, plan, tmp_path / name, file=FlightFile(frame=frame))
        assert not (tmp_path / name).exists()


@pytest.mark.external
@pytest.mark.skipif(not EXTERNAL.is_dir(), reason=f"there is no folder {EXTERNAL}")
def test_keywords_stand_in_the_order_of_messages_of_others(
    tiny: Instance, plan: Plan, tmp_path: Path
) -> None:
    """Wherever an example has two of the keywords of our messages, they stand in the same order."""
    pattern = re.compile(r"^\s*([A-Z_0-9]+)\s*=", re.MULTILINE)
    compared = 0
    for kind in ("opm", "oem"):
        write_plan(tiny, plan, tmp_path / f"a.{kind}", file=FlightFile(frame="TEME"), leg=1)
        text = (tmp_path / f"a.{kind}").read_text(encoding="ascii")
        ours = list(dict.fromkeys(pattern.findall(text)))
        assert "REF_FRAME_EPOCH" in ours
        for path in EXTERNAL.glob(f"{kind.upper()}Example*.txt"):
            theirs = dict.fromkeys(pattern.findall(path.read_text(encoding="utf-8")))
            both = [keyword for keyword in theirs if keyword in ours]
            assert both == [keyword for keyword in ours if keyword in theirs], path.name
            compared += "REF_FRAME_EPOCH" in both
    assert compared >= 2
