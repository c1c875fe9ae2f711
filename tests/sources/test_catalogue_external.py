"""Catalogue files from elsewhere."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from catalogue_files import one

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.sources.catalogue import read, to_instance
from adr_opt.sources.catalogue.propagation import mean_elements, state
from adr_opt.sources.catalogue.selection import plane_angles

pytest.importorskip("sgp4.api")
sgp4_io = pytest.importorskip("sgp4.io")


DATA = Path(os.environ.get("ADR_OPT_EXTERNAL_DATA", "../shared/data"))


external = [
    pytest.mark.external,
    pytest.mark.skipif(not DATA.is_dir(), reason=f"no folder {DATA} (ADR_OPT_EXTERNAL_DATA)"),
]


class TestExternal:
    """Catalogue files from elsewhere."""

    pytestmark = external

    def test_five_spellings_of_mario(self) -> None:
        """The record in five spellings gives five equal records and the published states."""
        first, *others = (
            read(DATA / "omm" / f"mario.{suffix}").records
            for suffix in ("tle", "xml", "kvn", "json", "csv")
        )
        assert len(first) == 1
        for other in others:
            assert other == first
        for minutes, published in (
            (0.0, (-5357.6986727762815, -3934.6109046434312, -0.00239536765505865)),
            (720.0, (-5490.038306922299, -3742.6513290039406, 96.22012243244025)),
        ):
            assert state(first[0], minutes)[0] == pytest.approx(published, abs=1e-8)

    def test_every_tle_and_omm_file_is_read(self) -> None:
        """Every file that is TLE or OMM is read, with the number of objects it has."""
        counts = {"celestrak_2025-04_iridium-33-debris.csv": 121} | {
            "celestrak_2025-02_iridium-33-debris.txt": 119
        }
        paths = [*DATA.glob("omm/*"), *DATA.glob("tle/*"), *DATA.glob("ccsds/OMM*")]
        assert len(paths) >= 19
        for path in paths:
            assert len(read(path)) == counts.get(path.name, 1), path.name

    def test_other_messages_are_refused_by_name(self) -> None:
        """OEM and OPM files are told from OMM in one sentence."""
        paths = [*DATA.glob("ccsds/OEM*.xml"), *DATA.glob("ccsds/OPM*")]
        assert len(paths) >= 10
        for path in paths:
            with pytest.raises(InputError, match=f"an {path.name[:3]}, not an OMM"):
                read(path)

    def test_published_states(self) -> None:
        """All 33 verification satellites have the published states, to the printed digits."""
        lines = (DATA / "sgp4/SGP4-VER.TLE").read_text().splitlines()
        pairs = [lines[n : n + 2] for n, line in enumerate(lines) if line.startswith("1 ")]
        blocks: list[list[list[str]]] = []
        for line in (DATA / "sgp4/tcppver.out").read_text().splitlines():
            if line.endswith("xx"):
                blocks.append([])
            elif line.strip():
                blocks[-1].append(line.split()[:7])
        assert len(pairs) == len(blocks) == 33
        compared = 0
        for pair, block in zip(pairs, blocks, strict=True):
            # three of them are made up to fail, and so are their checksums
            record = one("\n".join(sgp4_io.fix_checksum(line) for line in pair))
            for minutes, *published in block:
                if record.number == 33334:  # "try and check error code 2", and so it does
                    with pytest.raises(ArithmeticError, match="SGP4 error"):
                        state(record, float(minutes))
                    continue
                numbers = np.concatenate(state(record, float(minutes)))
                for number, text in zip(numbers, published, strict=True):
                    printed = 10.0 ** -len(text.partition(".")[2])
                    # half a unit of the last digit; one object 3.5 years after its epoch loses one
                    assert abs(number - float(text)) <= (
                        0.51 * printed if abs(float(minutes)) < 1e6 else 12.0 * printed
                    ), (record.number, minutes)
                    compared += 1
        assert compared == 3996

    def test_the_verification_file_says_which_rows_are_bad(self) -> None:
        """Its three wrong checksums and its repeated object are named by line; 29 are good."""
        with pytest.raises(InputError, match=r"line 100 \(33333\).*checksum 4, its digits give 2"):
            read(DATA / "sgp4/SGP4-VER.TLE")
        found = read(DATA / "sgp4/SGP4-VER.TLE", skip_bad=True)
        assert len(found) == 29
        assert [(drop.line, drop.reason) for drop in found.dropped] == [
            (100, "checksum"),
            (103, "checksum"),
            (106, "checksum"),
            (109, "duplicate"),
        ]

    def test_a_real_cloud_is_planned(self) -> None:
        """A real fragmentation cloud becomes an instance that is planned and checked."""
        found = read(DATA / "omm/celestrak_2025-04_iridium-33-debris.csv")
        assert len(to_instance(found).instance.targets) == 121
        instance = to_instance(found, max_targets=50).instance
        result = adr_opt.solve(instance, method="greedy-guarded")
        assert result.objective >= 8.0
        assert adr_opt.check(instance, result.plan) == ()

    def test_two_catalogues_of_a_cloud_six_weeks_apart_agree(self) -> None:
        """SGP4 brings the cloud of February near the elements published in April."""
        names = (
            "tle/celestrak_2025-02_iridium-33-debris.txt",
            "omm/celestrak_2025-04_iridium-33-debris.csv",
        )
        old, new = (read(DATA / name).records for name in names)
        now = {record.number: record for record in new}
        both = [record for record in old if record.number in now]
        assert len(both) > 100
        then, failed = mean_elements(both, new[0].epoch)
        there, _ = mean_elements([now[record.number] for record in both], new[0].epoch)
        assert failed == []
        apart = [
            float(plane_angles(row[None], other[2], other[3])[0])
            for row, other in zip(then, there, strict=True)
        ]
        assert np.degrees(np.median(apart)) < 0.05
        assert np.median(np.abs(then[:, 0] - there[:, 0])) < 2e3
