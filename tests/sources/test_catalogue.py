"""Catalogue files: the five spellings, and what SGP4 makes of them."""

from __future__ import annotations

import dataclasses
import json
import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from catalogue_files import (
    SPELLINGS,
    as_json,
    as_space_track_json,
    as_tle,
    field,
    omm_fields,
    one,
    tle_lines,
)
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from adr_opt.common.constants import EARTH_RADIUS_M, MU_M3_S2
from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue import Catalogue, ElementSet, to_instance
from adr_opt.sources.catalogue.propagation import mean_elements, satellite_of, state, true_anomaly
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.catalogue.tle import catalogue_number, checksum

sgp4_api = pytest.importorskip("sgp4.api")
sgp4_alpha5 = pytest.importorskip("sgp4.alpha5")
sgp4_io = pytest.importorskip("sgp4.io")
sgp4_omm = pytest.importorskip("sgp4.omm")


def digits(decimals: int, most: float) -> st.SearchStrategy[float]:
    """Numbers that a column with this number of decimals can hold."""
    scale = 10**decimals
    return st.integers(0, int(most * scale)).map(
        lambda n: float(f"{n // scale}.{n % scale:0{decimals}d}")
    )


def powers() -> st.SearchStrategy[float]:
    return st.one_of(
        st.just(0.0),
        st.builds(
            lambda sign, digits, exponent: float(f"{sign}0.{digits}e{exponent}"),
            st.sampled_from(["", "-"]),
            st.integers(10_000, 99_999),
            st.integers(-9, 0),
        ),
    )


RECORDS = st.builds(
    ElementSet,
    name=st.from_regex(r"[A-Z][A-Z0-9()/+-]{0,8}( [A-Z0-9]{1,5})?", fullmatch=True),
    object_id=st.builds(
        lambda year, launch, piece: f"{year}-{launch:03d}{piece}",
        st.integers(1957, 2056),
        st.integers(1, 999),
        st.from_regex(r"[A-Z]{1,3}", fullmatch=True),
    ),
    number=st.integers(1, 339_999),
    epoch=st.integers(0, 99 * 365 * 10**8).map(
        lambda ticks: datetime(1957, 1, 1, tzinfo=UTC) + timedelta(microseconds=864 * ticks)
    ),
    mean_motion_rev_day=digits(8, 17.0).filter(lambda value: value > 0.01),
    eccentricity=digits(7, 0.9999999),
    inclination_deg=digits(4, 180.0),
    raan_deg=digits(4, 360.0),
    argument_of_perigee_deg=digits(4, 360.0),
    mean_anomaly_deg=digits(4, 360.0),
    bstar=powers(),
    mean_motion_dot_rev_day2=st.builds(
        lambda sign, value: sign * value, st.sampled_from([1.0, -1.0]), digits(8, 0.99)
    ),
    mean_motion_ddot_rev_day3=powers(),
    element_set=st.integers(0, 9999),
    revolution=st.integers(0, 99_999),
)


@given(RECORDS)
@settings(max_examples=150, deadline=None)
@pytest.mark.slow
def test_five_spellings_of_one_record_are_equal(record: ElementSet) -> None:
    """A record written as TLE, XML, KVN, JSON and CSV is read as itself, bit by bit."""
    for spelling, write in SPELLINGS.items():
        assert one(write([record])) == record, spelling
    assert one(as_space_track_json([record])) == record
    assert one(as_tle([record], space_track=True)) == record


@given(RECORDS)
@settings(max_examples=100, deadline=None)
def test_states_are_those_of_the_readers_of_sgp4(record: ElementSet) -> None:
    """SGP4 gives the same state as through its own TLE and OMM readers, or the same error."""
    # nearly straight orbits turn the last bit of an epoch into kilometres
    assume(record.eccentricity < 0.9)
    by_tle = sgp4_api.Satrec.twoline2rv(*tle_lines(record))
    by_omm = sgp4_api.Satrec()
    fields = {key: str(value) for key, value in omm_fields(record).items()}
    sgp4_omm.initialize(by_omm, fields | {"NORAD_CAT_ID": "1"})
    mine = satellite_of(record)
    for minutes in (0.0, 700.0):
        code, position, _ = mine.sgp4_tsince(minutes)
        for theirs in (by_tle, by_omm):
            other_code, other, _ = theirs.sgp4_tsince(minutes)
            assert code == other_code
            if code == 0:
                assert position == pytest.approx(other, abs=1e-3, rel=1e-6)


@given(st.text(st.characters(codec="ascii"), min_size=68, max_size=69))
def test_checksum_is_that_of_sgp4(line: str) -> None:
    """The sum over a line is the one that the package sgp4 forms."""
    assert checksum(line) == sgp4_io.compute_checksum(line)


@given(st.integers(0, 339_999))
def test_alpha_5_is_that_of_sgp4(number: int) -> None:
    """Every number that Alpha-5 can write is read back."""
    assert catalogue_number(sgp4_alpha5.to_alpha5(number)) == number


@pytest.mark.parametrize("text", ["I0001", "O0001", "a0001", "A00 1", "-0001", "A-001"])
def test_what_is_not_alpha_5(text: str) -> None:
    """I and O do not begin an Alpha-5 number, nor do small letters or signs."""
    lines = [line.replace("10000", text) for line in tle_lines(field(1)[0])]
    with pytest.raises(InputError, match="line 1"):
        read_bytes("\n".join(map(sgp4_io.fix_checksum, lines)).encode(), "file")


def test_numbers_of_nine_digits_and_alpha_5_in_omm() -> None:
    """OMM may carry longer numbers than a TLE, and Alpha-5."""
    fields = omm_fields(field(1)[0])
    assert one(json.dumps(fields | {"NORAD_CAT_ID": 799_500_123})).number == 799_500_123
    assert one(json.dumps(fields | {"NORAD_CAT_ID": "T0001"})).number == 270_001
    huge = one(json.dumps(fields | {"NORAD_CAT_ID": 799_500_123}))
    elements, failed = mean_elements([huge], huge.epoch)
    assert not failed
    assert np.isfinite(elements).all()


def test_spellings_of_epochs() -> None:
    """Day of the year, a final Z, few and many decimals, and a leap second are understood."""
    fields = omm_fields(field(1)[0])
    for text, there in (
        ("2007-064T10:34:41.4264", datetime(2007, 3, 5, 10, 34, 41, 426400, tzinfo=UTC)),
        ("2007-03-05T10:34:41Z", datetime(2007, 3, 5, 10, 34, 41, tzinfo=UTC)),
        ("2007-03-05 10:34:41.", datetime(2007, 3, 5, 10, 34, 41, tzinfo=UTC)),
        ("2016-12-31T23:59:60.5", datetime(2017, 1, 1, 0, 0, 0, 500000, tzinfo=UTC)),
        ("2007-03-05T10:34:41.9999996", datetime(2007, 3, 5, 10, 34, 42, tzinfo=UTC)),
    ):
        assert one(json.dumps(fields | {"EPOCH": text})).epoch == there


def test_byte_order_marks_and_line_ends() -> None:
    """What editors do to text files, a mark in front and other line ends, changes nothing."""
    records = tuple(field(3))
    for write in SPELLINGS.values():
        text = write(records).replace("\r\n", "\n").replace("\n", "\r\n")
        assert read_bytes(b"\xef\xbb\xbf" + text.encode(), "file").records == records
        assert read_bytes(b"\n\n" + text.encode(), "file").records == records


def test_text_behind_the_columns_of_a_tle() -> None:
    """Comments, and what stands behind column 69 after a blank, are passed over."""
    record = field(1)[0]
    first, second = tle_lines(record)
    text = f"# a comment\n{record.name}\n{first}\n\n{second}      0.0   1440.0   120.00\n"
    assert one(text) == record


def test_records_that_sgp4_must_not_propagate() -> None:
    """Other theories, frames and times are read, and named when they should be propagated."""
    fields = omm_fields(field(1)[0])
    for change, named in (
        ({"MEAN_ELEMENT_THEORY": "DSST"}, "MEAN_ELEMENT_THEORY is DSST, not SGP4"),
        ({"REF_FRAME": "TOD"}, "REF_FRAME is TOD, SGP4 needs TEME"),
        ({"TIME_SYSTEM": "TAI"}, "TIME_SYSTEM is TAI, SGP4 needs UTC"),
        ({"CENTER_NAME": "MARS"}, "CENTER_NAME is MARS, SGP4 needs EARTH"),
        ({"EPHEMERIS_TYPE": "4"}, "EPHEMERIS_TYPE 4 is SGP4-XP, not SGP4"),
        ({"MEAN_MOTION": None, "SEMI_MAJOR_AXIS": 7000.0}, "SEMI_MAJOR_AXIS stands for the"),
    ):
        record = one(json.dumps(fields | change))
        assert record.not_sgp4.startswith(named)
        with pytest.raises(InputError, match=f"{named}.*--skip-bad"):
            to_instance([record])


def test_mean_elements_are_moved_by_secular_rates_only() -> None:
    """At their epoch the angles are the given ones; later the node has moved by the J2 rate."""
    record = field(1)[0]
    (now,), _ = mean_elements([record], record.epoch)
    given_deg = (
        record.inclination_deg,
        record.raan_deg,
        record.argument_of_perigee_deg,
        record.mean_anomaly_deg,
    )
    assert now[1] == pytest.approx(record.eccentricity, abs=1e-12)
    assert np.degrees(now[2:]) % 360.0 == pytest.approx(given_deg, abs=1e-9)
    (later,), _ = mean_elements([record], record.epoch + timedelta(days=5))
    motion = math.sqrt(MU_M3_S2 / now[0] ** 3)
    parameter = now[0] * (1.0 - now[1] ** 2)
    rate = -1.5 * 1.08263e-3 * (EARTH_RADIUS_M / parameter) ** 2 * motion * math.cos(now[2])
    turned = (later[3] - now[3] + math.pi) % (2.0 * math.pi) - math.pi
    assert turned == pytest.approx(rate * 5 * 86400.0, rel=5e-3)
    assert later[2] == now[2]
    assert 0.0 < now[0] - later[0] < 2e3  # drag, in the right direction


def test_what_decays_on_the_way_stays_decayed() -> None:
    """SGP4 lets some orbits come out of the ground again, without an error; they are failures."""
    fields = omm_fields(field(1)[0]) | {"MEAN_MOTION": 16.0, "ECCENTRICITY": 0.001}
    came_out = 0
    for bstar in np.geomspace(1e-3, 1.0, 60):
        record = one(json.dumps(fields | {"BSTAR": float(bstar)}))
        for days in (1.0, 5.0, 30.0, 300.0):
            (elements,), failed = mean_elements([record], record.epoch + timedelta(days=days))
            code, *_ = satellite_of(record).sgp4_tsince(1440.0 * days)
            came_out += code == 0 and bool(failed)
            assert failed or elements[0] < 6.68e6
    assert came_out > 10


def test_the_mean_orbit_is_the_middle_of_the_osculating_one() -> None:
    """Over one revolution SGP4's radii average to the mean semi-major axis within 1 km."""
    record = field(1)[0]
    (mean,), _ = mean_elements([record], record.epoch)
    minutes = np.linspace(0.0, 1440.0 / record.mean_motion_rev_day, 400, endpoint=False)
    energy_axes = []
    for minute in minutes:
        position, velocity = (1e3 * vector for vector in state(record, minute))
        energy_axes.append(1.0 / (2.0 / np.linalg.norm(position) - velocity @ velocity / MU_M3_S2))
    assert np.ptp(energy_axes) > 5e3  # the wiggle that mean elements are without
    assert np.mean(energy_axes) == pytest.approx(mean[0], abs=1e3)


@given(st.floats(-10.0, 10.0), st.floats(0.0, 0.999))
def test_true_anomaly_solves_keplers_equation(mean: float, eccentricity: float) -> None:
    """The mean anomaly that the true one stands for is the given one, at every eccentricity."""
    (true,) = true_anomaly(np.array([mean]), np.array([eccentricity]))
    eccentric = 2.0 * math.atan(
        math.sqrt((1.0 - eccentricity) / (1.0 + eccentricity)) * math.tan(0.5 * true)
    )
    again = eccentric - eccentricity * math.sin(eccentric)
    assert math.remainder(again - mean, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_the_planned_circle_has_the_mean_phase() -> None:
    """What the planner takes from the instance is a, i, RAAN and ω + M of the mean elements."""
    records = field(20)
    epoch = max(record.epoch for record in records)
    elements, _ = mean_elements(records, epoch)
    instance = to_instance(records).instance
    assert instance.epoch == epoch
    for row, target in zip(elements, instance.targets, strict=True):
        a, i, o, u = target.orbit.circular_elements()
        assert a == pytest.approx(row[0], abs=1e-3)
        assert (i, math.cos(o)) == pytest.approx((row[2], math.cos(row[3])), abs=1e-8)
        assert math.remainder(u - row[4] - row[5], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-8)


def test_a_catalogue_is_a_sequence_of_records() -> None:
    """What is read can be counted and walked through."""
    found = read_bytes(as_json(field(3)).encode(), "x")
    assert isinstance(found, Catalogue)
    assert len(found) == 3
    assert [record.number for record in found] == [10_000, 10_001, 10_002]
    assert found.formats == {"x": "OMM JSON"}


@pytest.mark.parametrize(
    ("first", "second", "same"),
    [
        ({"number": 0, "object_id": "UNKNOWN"}, {"number": 0, "object_id": "UNKNOWN"}, False),
        ({"number": None, "object_id": ""}, {"number": None, "object_id": ""}, False),
        ({"number": 7}, {"number": 7}, True),
        ({"number": 0, "object_id": "1999-001A"}, {"number": 0, "object_id": "1999-001A"}, True),
        ({"number": 0, "object_id": "", "raan_deg": 10.0}, {"number": 0, "object_id": ""}, True),
    ],
)
def test_objects_are_the_same_by_number_or_designator(
    first: dict[str, object], second: dict[str, object], same: bool
) -> None:
    """Objects that are not catalogued yet are the same only if all of their elements are."""
    record = dataclasses.replace(field(1)[0], name="TBA", raan_deg=10.0)
    other = {"raan_deg": 40.0} if "raan_deg" not in first else {}
    one = dataclasses.replace(record, **first)
    two = dataclasses.replace(record, **second, **other)
    assert (one.key == two.key) is same
