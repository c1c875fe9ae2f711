"""Scripts of tables: their command line, and rows that are kept."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal

import pytest
import tables

from adr_opt.common.errors import InputError


def test_arguments_of_a_table_are_words_and_options(capsys) -> None:
    """Words, several values, flags, choices and paths come as a table states them."""
    seen = []

    def one(
        family: str,
        *methods: str,
        count: int = 2,
        limits: tuple[float, ...] = (1.0,),
        kind: Literal["a", "b"] = "a",
        time_limit: float | None = None,
        dense: bool = False,
        out: Path | None = None,
    ) -> None:
        """A table."""
        seen.append((family, methods, count, limits, kind, time_limit, dense, out))

    words = "tiny x y --count 3 --limits 1 2 --kind b --time-limit 5 --dense --out f"
    assert tables.experiment("text", one, argv=words.split()) == 0
    assert tables.experiment("text", one, test_rows_are_made_once, argv=["one", "tiny"]) == 0
    assert seen == [
        ("tiny", ("x", "y"), 3, [1.0, 2.0], "b", 5.0, True, Path("f")),
        ("tiny", (), 2, (1.0,), "a", None, False, None),
    ]
    for wrong in (["tiny", "--kind", "c"], ["tiny", "--count", "many"], []):
        with pytest.raises(SystemExit):
            tables.experiment("text", one, argv=wrong)


def test_help_says_what_tables_say(capsys) -> None:
    """A per cent sign in what a script, a table or a default says is printed as it stands."""

    def one(kind: str = "5 %,") -> None:
        """Within 95 %, mostly."""

    with pytest.raises(SystemExit) as ended:
        tables.experiment("Total 3 %, at least.", one, test_rows_are_made_once, argv=["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    with pytest.raises(SystemExit):
        tables.experiment("", one, argv=["--help"])
    said += capsys.readouterr().out
    for each in ("Total 3 %, at least.", "Within 95 %, mostly.", "[5 %,]"):
        assert each in said


def test_wrong_input_is_a_sentence(capsys) -> None:
    """What a table refuses is printed, with exit status 2; its own status is handed on."""

    def refusing() -> None:
        raise InputError("no such folder; name that of the data")

    assert tables.experiment("text", refusing, argv=[]) == 2
    assert capsys.readouterr().err == "no such folder; name that of the data\n"
    assert tables.experiment("text", lambda: 1, argv=[]) == 1


def test_rows_are_made_once(tmp_path) -> None:
    """A row that the file has is not made again; others are added."""
    file, made = tmp_path / "rows.jsonl", []

    def row(value: int) -> dict[str, int]:
        made.append(value)
        return {"value": value}

    for seed in (1, 2, 1, 2):
        found = tables.kept(file, {"seed": seed, "names": ["a"]}, lambda seed=seed: row(seed))
        assert found == {"seed": seed, "names": ["a"], "value": seed}
    assert made == [1, 2]
    assert tables.kept(None, {"seed": 1}, lambda: row(7)) == {"seed": 1, "value": 7}


def test_tables_are_markdown(capsys) -> None:
    """A head and a row have as many cells as they are given."""
    tables.head("a", "b")
    tables.row(1, "x")
    assert capsys.readouterr().out == "\n| a | b |\n|---|---|\n| 1 | x |\n"


def test_every_experiment_is_listed() -> None:
    """The page for contributors names each script of the bench, and no other."""
    root = Path(__file__).parents[2]
    page = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = page.partition("| script | asks |")[2].partition("\n\n")[0]
    listed = set(re.findall(r"`([a-z_/]+\.py)`", rows))
    scripts = {
        str(path.relative_to(root / "bench"))
        for path in (root / "bench").rglob("*.py")
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8")
    }
    assert listed == scripts
