"""Ephemerides in other formats than OEM: STK's and Modified ITC."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from catalogue_files import as_json, field
from conftest import Cli
from messages import oem

import adr_opt
from adr_opt.common.constants import DAY_S
from adr_opt.common.errors import InputError
from adr_opt.problem.frame import Frame
from adr_opt.problem.frame_rotation import from_gcrf, teme_axes
from adr_opt.sources.catalogue.propagation import state as sgp4_state
from adr_opt.sources.catalogue.reading import read_bytes
from adr_opt.sources.ephemerides import ephemeris_of
from adr_opt.sources.ephemerides.oem import read_oem
from adr_opt.ui.serve.objects.recognise import recognised

pytest.importorskip("sgp4.api")
pytest.importorskip("erfa")

RECORD = field(1)[0]
EPOCH = RECORD.epoch
TIMES = np.arange(-600.0, DAY_S + 600.0, 60.0)


def states(times: Any) -> Any:
    """SGP4's states in EME2000."""
    found = 1e3 * np.array([np.concatenate(sgp4_state(RECORD, float(t) / 60.0)) for t in times])
    axes = teme_axes([EPOCH + timedelta(seconds=float(t)) for t in times])
    turns = from_gcrf(Frame(name="EME2000")) @ np.swapaxes(axes, 1, 2)
    return np.einsum("tij,tkj->tki", turns, found.reshape(-1, 2, 3)).reshape(-1, 6)


def itc() -> str:
    ends = [EPOCH + timedelta(seconds=float(TIMES[at])) for at in (0, -1)]
    lines = [
        "created:2026-04-26 18:52:05 UTC",
        f"ephemeris_start:{ends[0]:%Y-%m-%d %H:%M:%S.%f} UTC "
        f"ephemeris_stop:{ends[1]:%Y-%m-%d %H:%M:%S.%f} UTC step_size:60",
        "ephemeris_source:blend",
        "UVW",
    ]
    for time, row in zip(TIMES, states(TIMES), strict=True):
        at = EPOCH + timedelta(seconds=float(time))
        lines.append(f"{at:%Y%j%H%M%S.%f} " + " ".join(f"{value / 1e3:.10f}" for value in row))
        lines += ["4.5e-07 -3.8e-07 7.7e-07 -1.4e-10 -5.6e-11 1.2e-06 7.9e-10"] * 3
    return "\n".join(lines) + "\n"


def stk(unit: str | None = "Kilometers", system: str = "J2000", more: str = "") -> str:
    factor = 1e-3 if unit == "Kilometers" else 1.0
    text = (
        "stk.v.11.0\n\n# WrittenBy    STK_v11.3.0\nBEGIN Ephemeris\n\n"
        f"NumberOfEphemerisPoints {TIMES.size}\nScenarioEpoch {EPOCH:%d %b %Y %H:%M:%S.%f}000\n"
        f"InterpolationMethod Lagrange\nInterpolationSamplesM1 7\nCentralBody Earth\n"
        f"CoordinateSystem {system}\n{more}"
    )
    text += f"DistanceUnit {unit}\n" if unit else ""
    text += "EphemerisTimePosVel\n\n"
    for time, row in zip(TIMES, states(TIMES), strict=True):
        text += f"{time:.12e} " + " ".join(f"{factor * value:.14e}" for value in row) + "\n"
    return text + "\nEND Ephemeris\n"


def plain() -> str:
    return oem(
        RECORD.label,
        RECORD.object_id,
        EPOCH,
        states,
        span_s=(TIMES[0], TIMES[-2]),
        step_s=60.0,
        REF_FRAME="EME2000",
    )


ITC_NAME = f"MEME_{RECORD.number}_{RECORD.name}_0581823_Operational_1353879600_UNCLASSIFIED.txt"
FORMATS: dict[str, tuple[str, Any]] = {
    "Modified ITC": (ITC_NAME, itc),
    "STK in km": (f"{RECORD.label}.e", stk),
    "STK in m, by designator": (f"{RECORD.object_id}.e", lambda: stk(unit=None)),
}


@pytest.mark.parametrize("kind", FORMATS)
def test_other_formats_say_what_an_oem_says(cli: Cli, kind: str) -> None:
    """An import onto another format has the states of the same ephemeris as OEM, to centimetres."""
    name, write = FORMATS[kind]
    Path("all.json").write_text(as_json([RECORD]), encoding="utf-8")
    Path(name).write_text(write(), encoding="utf-8")
    Path("plain.oem").write_text(plain(), encoding="utf-8")
    found = []
    for message, folder in ((name, "other"), ("plain.oem", "oem")):
        Path(folder).mkdir()
        made = cli(
            "import all.json --epoch",
            EPOCH.isoformat(),
            "--duration-days",
            "1",
            "--oem",
            message,
            "--out",
            f"{folder}/out.json",
            "--quiet",
        )
        assert made.status == 0, made.err
        instance = adr_opt.load(f"{folder}/out.json")
        found.append(ephemeris_of(instance, RECORD.label).state(np.linspace(0.0, DAY_S, 500)))
    assert np.abs(found[0] - found[1])[:, :3].max() < 0.02
    assert recognised(Path(name), name).what == "ephemerides"
    with pytest.raises(InputError, match=r"(STK|Modified ITC) ephemeris, not mean elements"):
        read_bytes(Path(name).read_bytes(), name)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.txt", itc, "whose object only the file name states"),
        (ITC_NAME, lambda: itc().replace("UVW\n", "UVW\n1 2 3\n"), "line 5: '1 2 3' is neither"),
        ("a.e", lambda: stk(system="Fixed"), "CoordinateSystem Fixed, not J2000"),
        ("a.e", lambda: stk(unit="NauticalMiles"), "DistanceUnit NauticalMiles"),
        ("a.e", lambda: stk(more="TimeFormat EpSec\n"), "'TimeFormat EpSec', not supported"),
        ("a.e", lambda: stk().replace("PosVel", "Pos"), "'EphemerisTimePos', not supported"),
        ("a.e", lambda: stk().replace("ScenarioEpoch", "# "), "the epoch ''"),
        ("a.e", lambda: "stk.v.11.0\nCoordinateSystem J2000\n", "without states"),
    ],
)
def test_what_is_not_understood_is_one_sentence(name: str, text: Any, said: str) -> None:
    """The sentence names the format, and what of it is not understood."""
    with pytest.raises(InputError, match=r"STK|Modified ITC") as found:
        read_oem(text().encode(), name)
    assert said in str(found.value)
    assert "\n" not in str(found.value)
