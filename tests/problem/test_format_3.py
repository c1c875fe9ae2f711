"""Files of the newest format and of the one before: the same mission, digest and words."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from every_record import PLACES, rich

import adr_opt
from adr_opt.common.errors import InputError
from adr_opt.problem.disposal import DisposalCircle, DisposalPerigee
from adr_opt.problem.format_2 import FORMAT, FORMER, written
from adr_opt.problem.instance import Instance
from adr_opt.problem.settings import TransferSettings

ROOT = Path(__file__).parents[2]
SHIPPED = sorted((ROOT / "instances").glob("[nt]*/*-00[0-3].json"))


def towed() -> Instance:
    """A mission of tows."""
    return adr_opt.generate("electric", 3, targets=4)


def content(instance: Instance) -> Any:
    """The content of its file."""
    return json.loads(instance.to_json())


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_files_of_the_format_before_keep_their_bytes(path: Path) -> None:
    """A shipped instance is read in new words and written as it was."""
    text = path.read_text("utf-8")
    instance = Instance.from_json(text)
    assert instance.to_json() == text
    assert (instance.format, instance.transfer.approach) == (FORMAT, "half-lap")


def test_a_disposal_altitude_is_a_circle() -> None:
    """The field of the former format becomes the disposal of the mission, and is written back."""
    instance = towed()
    stated = content(instance)
    assert (stated["format"], stated["mission"]["disposal_altitude_m"]) == (FORMER, 500e3)
    assert instance.mission.disposal == DisposalCircle(circle_m=500e3)
    assert adr_opt.load(stated) == instance
    jsonschema.validate(stated, Instance.json_schema())
    nothing = adr_opt.generate("tiny", 0)
    stated = content(nothing)
    stated["mission"]["disposal_altitude_m"] = None
    del stated["format"]
    assert adr_opt.load(stated) == nothing


NEWER: dict[str, Any] = {
    "approach": {"approach": "safety-ellipse", "keep_out_m": 250.0, "inspection_revolutions": 3},
    "burns": {"burns": "free"},
}


@pytest.mark.parametrize("name", [*NEWER, "own circle", "perigee"])
def test_a_newer_field_makes_a_newer_file(name: str) -> None:
    """What the former format cannot say is written in the newer one, with another digest."""
    instance = adr_opt.generate("tiny", 3) if name == "approach" else towed()
    if name in NEWER:
        changed = instance.replace(transfer=instance.transfer.replace(**NEWER[name]))
    elif name == "perigee":
        disposal = DisposalPerigee(perigee_m=60e3)
        burning = tuple(chaser.replace(thrust_n=None) for chaser in instance.chasers)
        mission = instance.mission.replace(disposal=disposal)
        changed = instance.replace(mission=mission, chasers=burning)
    else:
        first, *others = instance.targets
        own = first.replace(disposal={"circle_m": 450e3})
        changed = instance.replace(targets=(own, *others))
        assert [changed.circle_m(each) for each in changed.targets[:2]] == [450e3, 500e3]
    stated = content(changed)
    assert stated["format"] == FORMAT
    assert not {"safety_ellipse_revolutions"} & stated["transfer"].keys()
    assert changed.sha256 != instance.sha256
    again = adr_opt.load(stated)
    assert (again, again.sha256) == (changed, changed.sha256)
    jsonschema.validate(stated, Instance.json_schema())
    with pytest.raises(InputError, match=rf'field \S+: not in the format "{FORMER}"; leave it out'):
        adr_opt.load(stated | {"format": FORMER})


@pytest.mark.parametrize("place", PLACES)
def test_no_field_can_be_newer_unnoticed(place: str) -> None:
    """At every depth of a file a field that the former format lacks is never written in it."""
    stated = rich().model_dump(mode="json")
    assert written(stated)["format"] == FORMER
    inner = stated
    for part in place.replace("[]", ".0").split(".") if place else ():
        inner = inner[int(part)] if part.isdigit() else inner[part]
    inner["novel"] = 1
    assert written(stated) == stated


@pytest.mark.parametrize("laps", [1.5, 0.7, None, "0.5"])
def test_laps_through_the_target_are_refused(laps: Any) -> None:
    """A file of the former format with inspection laps names the field that replaces them."""
    stated = content(adr_opt.generate("tiny", 0))
    stated["transfer"]["safety_ellipse_revolutions"] = laps
    with pytest.raises(InputError, match=r"target at each half lap; .* transfer\.approach"):
        adr_opt.load(stated)


@pytest.mark.parametrize(
    ("part", "field", "value"),
    [("transfer", "safety_ellipse_revolutions", 0.5), ("mission", "disposal_altitude_m", 5e5)],
)
def test_the_newer_format_has_no_older_words(part: str, field: str, value: float) -> None:
    """A field of the former format is unknown in the newer one."""
    stated = towed().model_dump(mode="json")
    stated[part][field] = value
    with pytest.raises(InputError, match=f"field {part}.{field}: unknown"):
        adr_opt.load(stated)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"keep_out_m": 300.0}, "keep_out_m = 300.0: half laps have none"),
        ({"inspection_revolutions": 1}, "inspection_revolutions = 1: half laps have none"),
        ({"approach": "v-bar"}, "field approach"),
        ({"approach": "safety-ellipse", "approach_revolutions": 0}, "approach_revolutions = 0"),
    ],
)
def test_what_an_approach_cannot_be_is_refused(changes: dict[str, Any], said: str) -> None:
    """Settings of the ellipse need one, and each has its range."""
    with pytest.raises(InputError, match=said):
        TransferSettings().replace(**changes)


def test_the_stand_off_bounds_what_is_kept_out() -> None:
    """The radius is at most three quarters of the least distance at the stand-off."""
    instance = adr_opt.generate("tiny", 0)
    orbit = instance.targets[0].orbit
    assert orbit is not None
    eccentric = instance.targets[0].replace(orbit=orbit.replace(eccentricity=0.02))
    instance = instance.replace(targets=(eccentric, *instance.targets[1:]))
    ellipse = instance.transfer.replace(approach="safety-ellipse", keep_out_m=720.0)
    assert instance.replace(transfer=ellipse).transfer == ellipse
    with pytest.raises(InputError, match=r"keep_out_m = 721.0: must be at most 721 m"):
        instance.replace(transfer=ellipse.replace(keep_out_m=721.0))


def test_disposal_is_one_of_two_kinds() -> None:
    """Anything else is refused in a sentence that says both."""
    mission = towed().mission
    for disposal in ({"altitude_m": 5e5}, {}, {"circle_m": 5e5, "perigee_m": 5e4}, 5e5):
        with pytest.raises(InputError, match=r'disposal.*must be {"circle_m": ALTITUDE} or'):
            mission.replace(disposal=disposal)
    with pytest.raises(InputError, match=r"disposal.circle_m = -1.0"):
        mission.replace(disposal={"circle_m": -1.0})
