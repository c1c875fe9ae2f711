"""Numbers in files that would size an array are bounded before memory is taken."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Cli, refused

import adr_opt
from adr_opt.judge.verify import completion
from adr_opt.learning.policy import load_policy


@pytest.mark.parametrize("field", ["delta_v_slot_m_s", "time_step_s"])
@pytest.mark.parametrize("size", [1e-9, 5e-324, 0.0])
def test_fine_steps_of_certificates_are_refused(
    cli: Cli, tiny_file: Path, field: str, size: float
) -> None:
    """Slots and steps of nothing would make tables of billions."""
    instance = adr_opt.load(tiny_file)
    certificate: dict[str, Any] = {
        "format": "adr-opt-certificate/1",
        "method": "exact",
        "upper_bound": 4.0,
        "instance": {"name": instance.name, "sha256": instance.sha256},
        field: size,
    }
    Path("certificate.json").write_text(json.dumps(certificate))
    outcome = cli("verify", tiny_file, "certificate.json")
    refused(outcome, f"field {field} = ", "must be greater than or equal to 0.00000001")


def test_slots_are_as_many_as_there_is_memory_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the certificate says, tables of what lies ahead keep to the free memory."""
    monkeypatch.setattr(completion, "available_bytes", lambda: 1e6)
    assert completion.most_slots(1e4) == 25.0
    monkeypatch.setattr(completion, "available_bytes", lambda: 1e15)
    assert completion.most_slots(1e5) == 1e4
    assert completion.most_slots(1.0) == completion.MOST_SLOTS


@pytest.mark.parametrize(
    ("place", "field"),
    [("chasers", "kits"), ("chasers", "max_targets"), ("stations", "max_refuellings")],
)
def test_counts_of_instances_are_bounded(cli: Cli, tiny_file: Path, place: str, field: str) -> None:
    """A number that no machine word holds is refused, in place of an error of the compiler."""
    content = json.loads(tiny_file.read_text())
    content[place][0][field] = 10**30
    tiny_file.write_text(json.dumps(content))
    refused(
        cli("solve", tiny_file), f"field {place}[0].{field}", "less than or equal to 2147483647"
    )


@pytest.mark.parametrize("shape", [(10**6, 10**6), (2**62,)])
def test_swollen_weights_are_refused(tmp_path: Path, shape: tuple[int, ...]) -> None:
    """An array that says it is larger than what is stored of it is not made."""
    load_policy().save(tmp_path / "weights.npz")
    with zipfile.ZipFile(tmp_path / "weights.npz") as packed:
        members = {each: packed.read(each) for each in packed.namelist()}
    swollen = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        swollen, {"descr": "<f8", "fortran_order": False, "shape": shape}
    )
    members["token.weight.npy"] = swollen.getvalue()
    with zipfile.ZipFile(tmp_path / "weights.npz", "w") as packed:
        for name, member in members.items():
            packed.writestr(name, member)
    with pytest.raises(adr_opt.InputError, match="is not a file of a policy"):
        load_policy(tmp_path / "weights.npz")
