"""Results in SQLite: every row is kept as it is finished, and none is ever kept twice."""

from __future__ import annotations

import json
import math
import os
import socket
import sqlite3
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from adr_opt.common.errors import InputError

from .schema import APPLICATION_ID, BOUND_COLUMNS, FORMAT, NEWER, ROW_COLUMNS, SCHEMA
from .trials import Protocol, Task, Trial

FILE = "results.sqlite"
SILENCE_S = 30.0
"""A run on another host that gave no sign of life for so long is taken for dead."""

TRIAL = "suite = ? AND field = ? AND iteration = ? AND zones = ?"


def now() -> str:
    """Date and time in UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


class Store:
    """The file of results of a folder; only the coordinating process holds one.

    Several runs may write to one file at a time: each claims the trials that it works on, and the
    key of a row holds whatever the claims are worth.

    Parameters
    ----------
    folder : Path
    create : bool
        Make folder and file if they are not there.

    Raises
    ------
    InputError
        The folder cannot be written to, there is no file, or it is not one of this format.
    """

    def __init__(self, folder: Path, *, create: bool = True) -> None:
        self.path = folder / FILE
        self._environments: dict[tuple[Any, ...], int] = {}
        if not create and not self.path.exists():
            raise InputError(f"{self.path}: no such file; run once without --report-only first")
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK | os.X_OK):
                raise PermissionError(13, "Permission denied")
            self._base = sqlite3.connect(self.path, timeout=60.0, isolation_level=None)
            self._base.row_factory = sqlite3.Row
            self._open()
        except OSError as error:
            raise InputError(
                f"{folder}: cannot be written to ({error.strerror or error}); "
                "give another folder with --out"
            ) from None
        except sqlite3.Error as error:
            raise InputError(
                f"{self.path}: cannot be used as a file of results ({error}); "
                "give another folder with --out"
            ) from None

    def _open(self) -> None:
        self._base.execute("PRAGMA journal_mode = WAL")
        # A row that was said to be kept survives a power cut too.
        self._base.execute("PRAGMA synchronous = FULL")
        with self._transaction():
            (format_,) = self._base.execute("PRAGMA user_version").fetchone()
            (application,) = self._base.execute("PRAGMA application_id").fetchone()
            (tables,) = self._base.execute("SELECT count(*) FROM sqlite_master").fetchone()
            if tables == 0:
                for statement in _statements(SCHEMA):
                    self._base.execute(statement)
                self._base.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                self._base.execute(f"PRAGMA user_version = {FORMAT}")
                return
            if application == APPLICATION_ID and format_ == 1:
                for statement in NEWER:
                    self._base.execute(statement)
                self._base.execute(f"PRAGMA user_version = {FORMAT}")
                return
        if application != APPLICATION_ID:
            raise InputError(
                f"{self.path}: is no file of this benchmark's results; "
                "give another folder with --out"
            )
        if format_ != FORMAT:
            raise InputError(
                f"{self.path}: has format {format_}, but this version reads and writes format "
                f"{FORMAT}; give another folder with --out, or use the version that wrote it"
            )

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._base.execute("ROLLBACK")
            self._environments.clear()
            raise
        self._base.execute("COMMIT")

    def close(self) -> None:
        """Close the file; what the log holds is moved into it."""
        self._base.close()

    # --- runs -------------------------------------------------------------------------------------

    def begin_run(self, command: str, protocol: Protocol, workers: int) -> int:
        """Note that a run begins; its number."""
        cursor = self._base.execute(
            "INSERT INTO run (command, methods, host, pid, workers, begun, alive) "
            "VALUES (?, ?, ?, ?, ?, ?, ?)",
            (
                command,
                " ".join(method.key for method in protocol.methods),
                socket.gethostname(),
                os.getpid(),
                workers,
                now(),
                time.time(),
            ),
        )
        assert cursor.lastrowid is not None
        return cursor.lastrowid

    def sign_of_life(self, run: int) -> None:
        """Record that a run continues."""
        self._base.execute("UPDATE run SET alive = ? WHERE id = ?", (time.time(), run))

    def end_run(self, run: int, wall_s: float, spent: dict[str, float]) -> None:
        """Note that a run has ended, and let its claims go."""
        with self._transaction():
            self._base.execute("DELETE FROM claim WHERE run = ?", (run,))
            self._base.execute(
                "UPDATE run SET ended = ?, wall_s = ?, spent = ? WHERE id = ?",
                (now(), wall_s, json.dumps(spent), run),
            )

    def _dead_runs(self) -> list[int]:
        dead = []
        for run in self._base.execute(
            "SELECT id, host, pid, alive, ended FROM run WHERE id IN (SELECT run FROM claim)"
        ):
            gone = run["host"] == socket.gethostname() and not _lives(run["pid"])
            if run["ended"] or gone or time.time() - run["alive"] > SILENCE_S:
                dead.append(run["id"])
        return dead

    # --- work -------------------------------------------------------------------------------------

    def missing(self, protocol: Protocol) -> dict[Trial, set[str]]:
        """The trials that lack something, with the methods that they lack; bounds count too."""
        done: dict[Trial, set[str]] = {}
        for row in self._base.execute(
            "SELECT suite, field, iteration, zones, method FROM row WHERE seed = ?",
            (protocol.seed,),
        ):
            done.setdefault(Trial(*row[:4]), set()).add(row["method"])
        bounded = set()
        if protocol.bound is not None:
            rows = self._base.execute(
                "SELECT suite, field, iteration, zones FROM bound WHERE method = ? AND limit_s = ?",
                (protocol.bound.name, protocol.bound.limit_s),
            )
            bounded = {Trial(*row) for row in rows}
        lacking = {}
        for trial in protocol.trials():
            wanted = {method.key for method in protocol.methods_for(trial.suite)}
            lacks = wanted - done.get(trial, set())
            bound = protocol.bound_for(trial.suite)
            if lacks or (bound is not None and trial not in bounded):
                lacking[trial] = lacks
        return lacking

    def claim(self, trial: Trial, protocol: Protocol, run: int) -> Task | None:
        """Take a trial for a run; None if another run works on it.

        Returns
        -------
        Task or None
            With what is missing at this moment, perhaps nothing: then nothing was claimed.
        """
        key = (trial.suite, trial.field, trial.iteration, trial.zones)
        with self._transaction():
            for dead in self._dead_runs():
                if dead != run:
                    self._base.execute("DELETE FROM claim WHERE run = ?", (dead,))
            task = self._task(trial, protocol)
            if not task.methods and task.bound is None:
                return task
            self._base.execute(
                "INSERT INTO claim VALUES (?, ?, ?, ?, ?) ON CONFLICT DO NOTHING", (*key, run)
            )
            (owner,) = self._base.execute(f"SELECT run FROM claim WHERE {TRIAL}", key).fetchone()
            return task if owner == run else None

    def _task(self, trial: Trial, protocol: Protocol) -> Task:
        key = (trial.suite, trial.field, trial.iteration, trial.zones)
        rows = self._base.execute(
            f"SELECT method, seed, outcome, objective FROM row WHERE {TRIAL}", key
        ).fetchall()
        done = {row["method"] for row in rows if row["seed"] == protocol.seed}
        legal = [row["objective"] for row in rows if row["outcome"] == "legal"]
        bound = protocol.bound_for(trial.suite)
        if bound is not None:
            found = self._base.execute(
                f"SELECT 1 FROM bound WHERE {TRIAL} AND method = ? AND limit_s = ?",
                (*key, bound.name, bound.limit_s),
            ).fetchone()
            bound = None if found else bound
        return Task(
            trial,
            tuple(method for method in protocol.methods_for(trial.suite) if method.key not in done),
            protocol.seed,
            bound,
            max(legal, default=-math.inf),
        )

    def release(self, trial: Trial, run: int) -> None:
        """Let a trial go."""
        self._base.execute(
            f"DELETE FROM claim WHERE {TRIAL} AND run = ?",
            (trial.suite, trial.field, trial.iteration, trial.zones, run),
        )

    def keep(self, messages: Iterable[tuple[str, dict[str, Any]]], run: int) -> list[dict]:
        """Keep rows and bounds, in one transaction; those that were new, in order."""
        new = []
        with self._transaction():
            for table, facts in messages:
                columns = ROW_COLUMNS if table == "row" else BOUND_COLUMNS
                stated = {
                    **facts,
                    "environment": self._environment(facts["environment"]),
                    "run": run,
                    "finished": now(),
                }
                cursor = self._base.execute(
                    f"INSERT INTO {table} ({', '.join(columns)}) "
                    f"VALUES ({', '.join('?' * len(columns))}) ON CONFLICT DO NOTHING",
                    [stated.get(column) for column in columns],
                )
                if cursor.rowcount == 1:
                    new.append(facts)
        return new

    def _environment(self, facts: dict[str, Any]) -> int:
        columns = ("host", "processor", "cores", "python", "versions")
        values = tuple(facts[column] for column in columns)
        if values not in self._environments:
            self._base.execute(
                f"INSERT INTO environment ({', '.join(columns)}) VALUES (?, ?, ?, ?, ?) "
                "ON CONFLICT DO NOTHING",
                values,
            )
            (self._environments[values],) = self._base.execute(
                "SELECT id FROM environment WHERE "
                + " AND ".join(f"{column} = ?" for column in columns),
                values,
            ).fetchone()
        return self._environments[values]

    def forget_failures(self) -> int:
        """Drop the rows without a legal plan, so that they are tried again; how many."""
        with self._transaction():
            rows = self._base.execute("DELETE FROM row WHERE outcome <> 'legal'").rowcount
            bounds = self._base.execute("DELETE FROM bound WHERE message IS NOT NULL").rowcount
        return rows + bounds

    # --- reading ----------------------------------------------------------------------------------

    def results(self) -> list[dict[str, Any]]:
        """Every row with its bound, gap and machine, in the order of the key."""
        return [dict(row) for row in self._base.execute("SELECT * FROM result")]

    def bounds(self) -> list[dict[str, Any]]:
        """Every bound that was asked for."""
        return [dict(row) for row in self._base.execute("SELECT * FROM bound")]

    def runs(self) -> list[dict[str, Any]]:
        """Every run, the first first."""
        return [dict(row) for row in self._base.execute("SELECT * FROM run ORDER BY id")]

    def mean_seconds(self) -> dict[tuple[str, str], float]:
        """Mean seconds of planning and checking by suite and method."""
        return {
            (row[0], row[1]): row[2]
            for row in self._base.execute(
                "SELECT suite, method, avg(coalesce(planning_s, 0) + coalesce(check_s, 0)) "
                "FROM row GROUP BY suite, method"
            )
        }


def _statements(script: str) -> list[str]:
    """The statements of a script: ``executescript`` would end the transaction."""
    return [statement for statement in script.split(";\n") if statement.strip()]


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True
