"""The instance: a mission over a field of debris objects, as data and as a file.

What the file says stands in :mod:`.instance_file`, of which the published JSON Schema is made
(:meth:`Record.json_schema`). All is frozen; :meth:`Record.replace` makes variants.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import PrivateAttr, ValidationError

from ..common.card import Shown
from ..common.constants import OBLATENESS_M2
from ..common.errors import InputError
from ..common.files import check_writable, parse_content, read_model, write_text
from ..common.records import Window
from ..common.sentences import sentence
from ..kernels.legs.co_elliptic import TransferRule
from ..kernels.orbits.eccentricity import matchings
from ..kernels.orbits.ephemeris import EPOCH_S
from .bodies import Target
from .capture_windows import (
    Array,
    FileWindows,
    WindowFile,
    file_of,
    intervals_of,
    read_windows,
    windows_from,
)
from .chasers import Chaser, availability
from .ephemerides import EphemeridesFile
from .format_2 import FORMAT as FORMAT
from .given import Given, only
from .given_files import read_named, write_given
from .given_functions import read_functions, write_functions
from .instance_arrays import KeptRows, rule_of
from .instance_file import InstanceFile
from .numbering import Numbering
from .orbit import Orbit
from .settings import TIME_VALUE_M_S_PER_H, GivenFile, check_time_value, hurry_of


class Instance(Shown, InstanceFile):
    """A mission to plan.

    Its fields are those of :class:`.instance_file.InstanceFile`; docs/files.md has their ranges.
    Bodies are numbered: the stations in order, then the chasers' own start orbits, then the targets
    in order.
    """

    _time_value_m_s_per_h: float | None = PrivateAttr(default=None)
    _given: Given | None = PrivateAttr(default=None)
    _windows: FileWindows | None = PrivateAttr(default=None)
    _folder: Path | None = PrivateAttr(default=None)
    _rows: KeptRows = PrivateAttr(default_factory=KeptRows)
    _known_as: str | None = PrivateAttr(default=None)

    def replace(self, **changes: Any) -> Self:
        """A validated copy with some fields changed.

        Raises
        ------
        InputError
            A change is not valid; or connections are given, and one of their bodies is gone.
        """
        made = self._changed(changes)
        if made._given is not None:
            gone = sorted(set(made._given.bodies) - set(made.names))
            if gone:
                raise InputError(
                    f"given connections: {gone[0]!r} is one of their bodies; keep it, or first "
                    "give only those of the others (adr_opt.problem.given.among)"
                )
        return made

    def _changed(self, changes: dict[str, Any]) -> Self:
        """A validated copy that keeps data outside the file."""
        made = super().replace(**changes)
        made._time_value_m_s_per_h = self._time_value_m_s_per_h
        made._folder = self._folder
        if made.transfer.given == self.transfer.given:
            made._given = self._given
        if made.windows == self.windows:
            made._windows = self._windows
            return made._with_windows_of_targets()
        return made

    def _with_windows_of_targets(self) -> Self:
        """The same instance with a file of windows of its own targets only.

        A file that names others could not be read again beside it.
        """
        if self.windows is None or self._windows is None:
            return self
        names = {target.name for target in self.targets}
        every = self._windows.intervals
        if every.keys() <= names:
            return self
        left = file_of({name: every[name] for name in every if name in names})
        stem = Path(self.windows.file).stem
        return self.with_windows(left, f"{stem}-{left.sha256[:8]}.csv")

    def known_as(self, chasers: tuple[Chaser, ...]) -> Self:
        """The same mission with chasers that have been launched; it keeps its SHA-256."""
        made = self.replace(chasers=chasers)
        made._known_as = self.sha256
        return made

    def without_reserves(self) -> Self:
        """The same mission with reserves taken out of the tanks; it keeps its SHA-256.

        The reserve for a chaser's own disposal then counts as dry mass, as it does for planners.
        """
        if all(chaser.end_of_life_m_s is None for chaser in self.chasers):
            return self
        return self.known_as(
            tuple(each.replace(tank=each.usable, end_of_life_m_s=None) for each in self.chasers)
        )

    @property
    def sha256(self) -> str:
        """SHA-256 of the file written by :meth:`to_json`; plans carry it."""
        return self._known_as or super().sha256

    def with_given(
        self, given: Given, file: str | None = None, functions_file: str | None = None
    ) -> Self:
        """The same instance with given connections in place of the model's.

        Parameters
        ----------
        given : Given
        file : str, optional
            Name of the file to which :meth:`save` writes them, beside that of the instance; by
            default as the instance says, or "connections.parquet"; none where all is functions.
        functions_file : str, optional
            The same of its functions of time; by default as the instance says, or
            "functions.json".

        Raises
        ------
        InputError
            A connection has a body that is not in the instance, or a field contradicts given
            connections.
        """
        strange = sorted(set(given.bodies) - set(self.names))
        if strange:
            raise InputError(f"given connections: {strange[0]!r} is not a body of {self.name!r}")
        known, functions = self.transfer.given, given.functions
        if file is None:
            if given.names or functions is None:
                file = (known.file if known else None) or "connections.parquet"
        if functions is None:
            functions_file = None
        elif functions_file is None:
            functions_file = (known.functions if known else None) or "functions.json"
        try:
            reference = GivenFile(
                file=file,
                sha256=None if file is None else given.sha256,
                functions=functions_file,
                functions_sha256=None if functions is None else functions.sha256,
            )
        except ValidationError as error:
            raise InputError(sentence(error)) from None
        made = self.replace(transfer=self.transfer.replace(given=reference))
        made._given = given
        return made

    @property
    def given(self) -> Given | None:
        """The given connections; None if they are the model's.

        Raises
        ------
        InputError
            They are in a file that was not read.
        """
        reference = self.transfer.given
        if reference is not None and self._given is None:
            raise InputError(
                f"the connections of {self.name!r} are in "
                f"{reference.file or reference.functions!r}, which was not read; "
                "read the instance with adr_opt.load from a file beside it"
            )
        return self._given

    def with_windows(
        self,
        windows: FileWindows | Mapping[str, Array],
        file: str = "windows.csv",
        capture_s: float | None = None,
    ) -> Self:
        """The same instance with windows of all targets in a file, in place of their own.

        Parameters
        ----------
        windows : FileWindows or mapping of str to (intervals, 2) float64
            By target [s]; one that is not named may never be captured.
        file : str
            Name of the file to which :meth:`save` writes them, beside that of the instance.
        capture_s : float, optional
            Of every target; by default its own [s].

        Raises
        ------
        InputError
            A name is not that of a target, or captures last longer than services.
        """
        if not isinstance(windows, FileWindows):
            windows = file_of(windows)
        free: dict[str, Any] = {"window_s": (0.0, None), "windows_s": None}
        free |= {} if capture_s is None else {"capture_s": capture_s}
        targets = tuple(target.replace(**free) for target in self.targets)
        reference = WindowFile(file=file, sha256=windows.sha256)
        return self.replace(targets=targets, windows=reference)._reading(windows)

    def with_windows_of(self, other: Instance) -> Self:
        """The same instance with the windows and captures of another one of the same targets."""
        names = "window_s", "windows_s", "capture_s"
        own = {each.name: {name: getattr(each, name) for name in names} for each in other.targets}
        targets = tuple(target.replace(**own.get(target.name, {})) for target in self.targets)
        made = self.replace(targets=targets, windows=other.windows)
        made._windows = other._windows
        return made._with_windows_of_targets()

    def _reading(self, windows: FileWindows) -> Self:
        """Attach the file of windows that the instance names."""
        assert self.windows is not None
        strange = sorted(windows.intervals.keys() - {target.name for target in self.targets})
        if strange:
            raise InputError(
                f"{self.windows.file}: {strange[0]!r} is not a target of {self.name!r}"
            )
        self._windows = windows
        return self

    @property
    def windows_read(self) -> FileWindows | None:
        """The file of windows; None if windows stand at the targets.

        Raises
        ------
        InputError
            It was not read.
        """
        if self.windows is not None and self._windows is None:
            raise InputError(
                f"the windows of {self.name!r} are in {self.windows.file!r}, which was not read; "
                "read the instance with adr_opt.load from a file beside it"
            )
        return self._windows

    def is_limited(self, target: Target) -> bool:
        """Whether services of a target may begin at some times only."""
        return self.windows is not None or target.windows != ((0.0, None),)

    def intervals_of(self, target: Target) -> Array:
        """Windows of a target, shape (intervals, 2), +inf where the last never closes [s].

        Raises
        ------
        InputError
            They are in a file that was not read.
        """
        windows = self.windows_read
        if windows is None:
            return intervals_of(target.windows)
        return windows.intervals.get(target.name, np.empty((0, 2)))

    def with_own_windows(self, target: Target) -> Target:
        """A target whose windows stand in the file, with them as its own."""
        if self.windows is None:
            return target
        intervals = windows_from(self.intervals_of(target)) or ((0.0, 0.0),)
        return target.replace(window_s=(0.0, None), windows_s=intervals)

    def without_closings(self) -> Self:
        """The same instance with windows that open but never close."""
        opened = []
        for target in self.targets:
            opens_s = self.intervals_of(target)[:1, 0].tolist()  # of none in a file: at any time
            window = (*opens_s, 0.0)[0], None
            closes = (target.window_s, target.windows_s, target.capture_s) != (window, None, None)
            free = {"window_s": window, "windows_s": None, "capture_s": None}
            opened.append(target.replace(**free) if closes else target)
        return self.replace(targets=tuple(opened), windows=None)

    @property
    def is_all_in_file(self) -> bool:
        """Whether the instance file alone restores it: no files beside it, no own time value."""
        given, _, windows = self.files_beside
        return (given, windows, self._time_value_m_s_per_h) == (None, None, None)

    @property
    def files_beside(self) -> tuple[GivenFile | None, EphemeridesFile | None, WindowFile | None]:
        """Files beside the instance's own that it names: connections, ephemerides and windows."""
        return self.transfer.given, self.ephemerides, self.windows

    @property
    def nodes_drift(self) -> bool:
        """Whether planes drift during the mission: under J2, unless connections are given."""
        return self.dynamics == "j2" and self.transfer.given is None

    @property
    def has_low_thrust(self) -> bool:
        """Whether some chaser has low thrust."""
        return any(chaser.thrust_n is not None for chaser in self.chasers)

    @property
    def has_trajectories(self) -> bool:
        """Whether plans state how legs are flown: unless connections are given or thrust is low."""
        return self.transfer.given is None and not self.has_low_thrust

    @property
    def has_orbits(self) -> bool:
        """Whether all bodies have an orbit."""
        return all(orbit is not None for orbit in self.known_orbits)

    def with_time_value(self, time_value_m_s_per_h: float) -> Self:
        """The same instance with another value of an hour, see :attr:`time_value_m_s_per_h`.

        Raises
        ------
        InputError
            It is negative or not finite.
        """
        check_time_value(time_value_m_s_per_h)
        made = self.model_copy()
        made._time_value_m_s_per_h = time_value_m_s_per_h
        return made

    def same(self, other: Instance) -> bool:
        """Whether both instances are equal and have the same value of an hour."""
        return self == other and self.time_value_m_s_per_h == other.time_value_m_s_per_h

    @property
    def time_value_m_s_per_h(self) -> float:
        """Value of an hour when a single transfer is chosen without lookahead [m/s per h].

        No part of the file, of equality and of :attr:`sha256`: a default for methods.
        """
        if self._time_value_m_s_per_h is None:
            return TIME_VALUE_M_S_PER_H * self.hurry
        return self._time_value_m_s_per_h

    @property
    def hurry(self) -> float:
        """Value of time relative to a mission of days: 1, and less where planes drift.

        Where planes drift, time buys ΔV and is worth the mission's average expenditure; a chaser
        that can refuel spends more than one tank. The same holds for given connections.
        """
        is_given = self.transfer.given is not None
        return hurry_of(
            self.mission.duration_s,
            self.largest_tank_m_s,
            time_buys_delta_v=is_given or self.transfer.max_drift_s > 0.0,
            refuels=bool(self.stations),
            # The unit of given costs is unknown, so no usual value is a limit.
            usual_is_a_limit=not is_given,
        )

    @property
    def numbering(self) -> Numbering:
        """The bodies in order of their numbers, kept as long as they are the same."""
        bodies, kept = (self.stations, self.chasers, self.targets), self.__dict__.get("_numbering")
        # An unchecked copy takes what is kept along, whatever it changes.
        if kept is None or any(a is not b for a, b in zip(bodies, kept.bodies, strict=True)):
            kept = self.__dict__["_numbering"] = Numbering(*bodies)
        return kept

    @property
    def start_bodies(self) -> dict[str, Orbit]:
        """Chasers' own start orbits, by name of the chaser.

        See :attr:`.numbering.Numbering.start_bodies` for those that are launched.
        """
        return self.numbering.start_bodies

    @property
    def launches(self) -> dict[int, float]:
        """Launch windows of chasers that may start in any orbit, by their start body [s]."""
        every = zip(self.starts, self.chasers, self.available_s, strict=True)
        return {body: since for body, chaser, (since, _) in every if chaser.is_launched}

    @property
    def available_s(self) -> tuple[Window, ...]:
        """Time window of each chaser, with launches kept apart where the mission says so [s]."""
        return availability(self.chasers, self.mission.launch_separation_s)

    @property
    def spent_m_s(self) -> dict[int, float]:
        """ΔV charged to first legs for tanks that are not full at the start, by start body [m/s].

        Chasers whose missing ΔV depends on masses are excluded: see
        :class:`adr_opt.kernels.rules.loads.Loads`.
        """
        return {
            self.names.index(chaser.name): chaser.spent_m_s
            for chaser in self.chasers
            if chaser.spent_m_s > 0.0 and not chaser.lacks_by_mass
        }

    @property
    def start(self) -> int:
        """Number of the only chaser's start body."""
        return self.names.index(self.chaser.start_name)

    @property
    def starts(self) -> tuple[int, ...]:
        """Number of each chaser's start body."""
        return self.numbering.starts

    @property
    def first_target(self) -> int:
        """Number of the first target; stations and start orbits come before."""
        return self.numbering.first_target

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, in order of their numbers."""
        return self.numbering.names

    @property
    def known_orbits(self) -> tuple[Orbit | None, ...]:
        """Orbits of the bodies, in order of their numbers; None for bodies without one."""
        return self.numbering.orbits

    @property
    def body_orbits(self) -> tuple[Orbit, ...]:
        """Orbits of the bodies, in order of their numbers, if all have one.

        Raises
        ------
        InputError
            One has none.
        """
        found = []
        for name, orbit in zip(self.names, self.known_orbits, strict=True):
            if orbit is None:
                raise InputError(f"{name!r} has no orbit, which this needs; give it one")
            found.append(orbit)
        return tuple(found)

    @property
    def decays_m_per_day(self) -> tuple[float, ...]:
        """Daily decrease of the bodies' semi-major axes, in order of their numbers [m/day]."""
        return self.numbering.decays_m_per_day

    def decay_of(self, body: str) -> float:
        """Daily decrease of a body's semi-major axis [m/day]."""
        return self.decays_m_per_day[self.names.index(body)]

    @property
    def decays(self) -> bool:
        """Whether the orbit of any body decays."""
        return any(self.decays_m_per_day)

    @property
    def is_approximate(self) -> bool:
        """Whether any orbit is eccentric, so that the model is an approximation.

        Given connections are exact.
        """
        if self.transfer.given is not None:
            return False
        return any(orbit.eccentricity > 0.0 for orbit in self.body_orbits)

    def part(self, bodies: Collection[int | str]) -> Self:
        """The instance with a subset of its targets, in its own order; other bodies stay.

        Given connections stay as well, including those of targets left out.

        Parameters
        ----------
        bodies : collection of int or str
            By number or by name.

        Raises
        ------
        InputError
            A name is not that of a body.
        """
        first = self.first_target
        if any(isinstance(body, str) for body in bodies):
            number = {name: at for at, name in enumerate(self.names)}
            for body in bodies:
                if isinstance(body, str) and body not in number:
                    raise InputError(f"{body!r} is not a body of {self.name!r}")
            bodies = {number[body] if isinstance(body, str) else body for body in bodies}
        chosen = sorted(int(body) for body in bodies)
        return self._changed(
            {"targets": tuple(self.targets[j - first] for j in chosen if j >= first)}
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read an instance file, and beside it those of its connections and windows, if any.

        Raises
        ------
        InputError
            No such file, not JSON, or not a valid instance; or its connections are missing, do not
            match their digest, or cannot be planned on.
        MissingExtra
            The extra that reads the connections is not installed.
        """
        instance = read_model(path, cls)
        instance._folder = Path(path).parent
        if instance.windows is not None:
            beside = instance._folder / instance.windows.file
            windows = read_windows(beside)
            if windows.sha256 != instance.windows.sha256:
                raise InputError(
                    f"{beside}: not the windows that {path} names: their sha256 is "
                    f"{windows.sha256}; put the right file there, or make the instance anew"
                )
            instance._reading(windows)
        reference = instance.transfer.given
        if reference is None:
            return instance
        functions = read_functions(path, reference, instance.names)
        if reference.file is not None:
            given = read_named(path, reference, instance.names).with_functions(functions)
        else:
            assert functions is not None  # one of the two is named
            given = only(functions)
        return instance.with_given(given, reference.file, reference.functions)

    def folder(self) -> Path:
        """The folder of the file that the instance was read from, which has its ephemerides.

        Raises
        ------
        InputError
            It was not read from a file.
        """
        if self._folder is None:
            raise InputError(
                f"the ephemerides of {self.name!r} are in a file that is not known; read the "
                "instance with adr_opt.load from a file beside it"
            )
        return self._folder

    def beside(self, folder: str | os.PathLike[str]) -> Self:
        """The same instance with its ephemerides in a folder."""
        made = self.model_copy()
        made._folder = Path(folder)
        return made

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the instance file and, beside it, what it names: connections, windows, ephemerides.

        Raises
        ------
        InputError
            One of them cannot be written.
        """
        check_writable(path)
        reference, given = self.transfer.given, self.given
        if reference is not None and given is not None:
            folder = Path(path).parent
            if reference.functions == Path(path).name:
                raise InputError(f"{path}: its functions have the same name; choose another one")
            if reference.file is not None:
                write_given(folder / reference.file, given)
            if reference.functions is not None and given.functions is not None:
                write_functions(folder / reference.functions, given.functions)
        if self.windows is not None and self._windows is not None:
            self._windows.write(Path(path).parent / self.windows.file)
        if self.ephemerides is not None and self._folder is not None:
            self.ephemerides.copy_files(self._folder, Path(path).parent)
        write_text(path, self.to_json())

    @property
    def oblateness_m2(self) -> float:
        """J2 R² of the dynamics: 0 in two-body motion [m²]."""
        return OBLATENESS_M2 if self.dynamics == "j2" else 0.0

    def orbits(self) -> npt.NDArray[np.float64]:
        """Orbits as kernel arrays, shape (bodies, columns); NaN for bodies without an orbit.

        Columns are :data:`adr_opt.kernels.orbits.ephemeris.ORBIT_COLUMNS`.
        """
        return self._rows.of(self.known_orbits, self.oblateness_m2, self.decays_m_per_day)

    def eccentricity_delta_v(self) -> npt.NDArray[np.float64]:
        """Cost of matching eccentricity vectors alone, v·|Δe|/2.

        Returns
        -------
        (origin, destination) float64
            [m/s]; zero between circles (docs/model.md section 1), and where perigees drift, as it
            then depends on the departure. Given connections have none.
        """
        if self.dynamics == "j2" or not self.is_approximate:
            return np.zeros((len(self.names), len(self.names)))
        return np.asarray(matchings(self.orbits(), EPOCH_S))

    def transfer_rule(self, time_value_m_s_per_h: float | None = None) -> TransferRule:
        """Transfer settings and zones as kernels take them (radii, m/s per s).

        Parameters
        ----------
        time_value_m_s_per_h : float, optional
            What an hour is worth when one of several sequences is chosen; by default
            :attr:`time_value_m_s_per_h`.
        """
        worth = self.time_value_m_s_per_h if time_value_m_s_per_h is None else time_value_m_s_per_h
        return rule_of(self.transfer, self.keep_out_zones, self.oblateness_m2, worth)


AnyInstance = Instance | str | os.PathLike[str] | Mapping[str, Any]
"""An instance, the path of its file, or the file's content as a dictionary."""


def instance_of(given: AnyInstance) -> Instance:
    """Load an instance.

    Parameters
    ----------
    given : Instance, path or dict
        The path of an instance file, or its content; an instance is returned as it is.

    Raises
    ------
    InputError
        ``given`` is none of these, or as for :meth:`Instance.load`.
    """
    if isinstance(given, Instance):
        return given
    if isinstance(given, (str, os.PathLike)):
        return Instance.load(given)
    return parse_content(given, Instance, "instance")


load = instance_of
