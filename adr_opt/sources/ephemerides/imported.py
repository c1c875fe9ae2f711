"""Imported instances with ephemerides: their files, and orbits fitted to them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...common.errors import InputError
from ...common.files import check_writable, write_bytes, write_text
from ...problem.ephemerides import EphemeridesFile, EphemerisKind, digest_of
from ...problem.instance import Instance
from ..catalogue import Imported
from ..catalogue.drag import LEFT_OUT
from .by_table import ByTable
from .elements_file import to_text
from .fit import fitted
from .left_over import LeftOver, left_over, summary
from .of_instance import Ephemerides, of_contents


@dataclass(frozen=True)
class WithEphemerides:
    """An imported instance on orbits fitted to ephemerides.

    Attributes
    ----------
    imported : Imported
    contents : dict
        File beside that of the instance → its content.
    left : tuple of LeftOver
        By body, what the fit leaves.
    """

    imported: Imported
    contents: dict[str, bytes]
    left: tuple[LeftOver, ...]

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the instance file and the ephemerides beside it.

        Raises
        ------
        InputError
            One of them cannot be written; then none of them refers to another that is not there.
        """
        check_writable(path)
        folder = Path(path).parent
        reference = self.imported.instance.ephemerides
        assert reference is not None
        changed = {}
        for name, content in self.contents.items():
            there = folder / name
            check_writable(there)
            if there.is_file() and there.read_bytes() == content:
                continue
            if there.is_file() and reference.kind == "oem":
                raise InputError(f"{there}: another file of this name exists; rename the message")
            changed[there] = content
        for there, content in changed.items():
            write_bytes(there, content)
        write_text(path, self.imported.instance.to_json())

    def to_dict(self) -> dict[str, Any]:
        """The record of the import as JSON data."""
        reference = self.imported.instance.ephemerides
        assert reference is not None
        return {
            **self.imported.to_dict(),
            "elements": "mean elements fitted to the ephemerides, TEME of the epoch",
            "ephemerides": reference.model_dump(mode="json"),
            "left": summary(self.left) | {"by_body": [one._asdict() for one in self.left]},
        }


def with_ephemerides(
    made: Imported, out: str | os.PathLike[str], messages: Sequence[str | os.PathLike[str]] = ()
) -> WithEphemerides:
    """An imported instance with ephemerides, on orbits fitted to them.

    Parameters
    ----------
    made : Imported
        Under J2.
    out : path
        The instance file that is going to be written.
    messages : sequence of paths
        CCSDS OEM files with the ephemerides of all targets, and of the station if it is an object;
        without them element sets are kept and run by SGP4.

    Raises
    ------
    InputError
        A message is bad, one does not cover the mission or is missing, or an object decays in it.
    MissingExtra
        sgp4 or astropy is not installed.
    """
    instance = made.instance
    if instance.dynamics != "j2":
        raise InputError("ephemerides: orbits are fitted under J2; choose dynamics j2")
    kind: EphemerisKind = "oem" if messages else "elements"
    if messages:
        contents = _given(messages, Path(out).name)
    else:
        contents = {f"{Path(out).stem}.elements.json": to_text(made.records).encode()}
    files = tuple(contents)
    reference = EphemeridesFile(
        kind=kind, file=files[0] if len(files) == 1 else files, sha256=digest_of(contents.values())
    )
    assert instance.frame is not None  # catalogues are in TEME
    known = of_contents(
        kind,
        contents,
        {body: record.designator for body, record in made.records.items()},
        epoch=instance.epoch,
        frame=instance.frame,
        name=instance.name,
    )
    on_fits, left = _fitted(instance, made, known)
    on_fits = on_fits.replace(ephemerides=reference).beside(Path(out).parent)
    warnings = tuple(said for said in made.warnings if not said.startswith(LEFT_OUT))
    made = replace(made, instance=on_fits, warnings=warnings)
    return WithEphemerides(made, contents, left)


def _fitted(
    instance: Instance, made: Imported, known: Ephemerides
) -> tuple[Instance, tuple[LeftOver, ...]]:
    duration_s = instance.mission.duration_s
    missing = [body for body in made.records if body not in known.bodies]
    if missing:
        raise InputError(
            f"--oem: no ephemeris of {missing[0]!r}"
            + (f" and {len(missing) - 1} more bodies" if len(missing) > 1 else "")
            + "; give one for each target, or filter such objects out"
        )
    # Tows of decaying objects are not planned, and stations are planned without a decay.
    lasting = {target.name for target in instance.targets if target.service.is_flown}
    lasting |= set(instance.station_names)
    fits, left = {}, []
    for body in made.records:
        ephemeris = known.of(body)
        if isinstance(ephemeris, ByTable):
            ephemeris.check_covered(0.0, duration_s)
        fits[body] = fitted(ephemeris, duration_s, decays=body not in lasting)
        left.append(left_over(ephemeris, fits[body], duration_s))
    targets = tuple(
        target.replace(
            orbit=fits[target.name].orbit,
            decay_m_per_day=fits[target.name].decay_m_per_day,
            fit=fits[target.name].fit,
        )
        for target in instance.targets
    )
    stations = tuple(
        station.replace(orbit=fits[station.name].orbit) if station.name in fits else station
        for station in instance.stations
    )
    return instance.replace(targets=targets, stations=stations), tuple(left)


def _given(messages: Sequence[str | os.PathLike[str]], out: str) -> dict[str, bytes]:
    contents: dict[str, bytes] = {}
    for path in messages:
        name = Path(path).name
        if name in contents or name == out:
            raise InputError(
                f"--oem {path}: another file is also called {name!r}, and both go into one folder; "
                "rename one"
            )
        try:
            contents[name] = Path(path).read_bytes()
        except FileNotFoundError:
            raise InputError(f"--oem {path}: no such file; check the path") from None
        except OSError as error:
            raise InputError(f"--oem {path}: cannot be read ({error.strerror})") from None
    return contents
