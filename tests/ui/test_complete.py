"""What a shell offers at a tab, and that it does not wait for what planning needs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import Cli

from adr_opt.run.methods import BOUNDS, names
from adr_opt.sources.generator import FAMILIES
from adr_opt.ui.cli import complete
from adr_opt.ui.cli.entry import VERBS

ROOT = Path(__file__).parents[2]

FILES, FOLDERS = [("file", "")], [("dir", "")]


@pytest.fixture
def offered(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> object:
    """Kind and text of all that is offered at the end of a line."""

    def ask(line: str) -> list[tuple[str, str]]:
        words = line.split()
        monkeypatch.setenv(complete.VARIABLE, "bash_complete")
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(len(words) - (not line.endswith(" "))))
        outcome = cli()
        assert (outcome.status, outcome.err) == (0, "")
        found = [row.partition(",") for row in outcome.out.splitlines()]
        return [(kind, text) for kind, _, text in found]

    return ask


def plain(*texts: str) -> list[tuple[str, str]]:
    return [("plain", text) for text in texts]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("adr-opt ", plain(*VERBS)),
        ("adr-opt so", plain("solve")),
        ("adr-opt generate ", plain(*FAMILIES)),
        ("adr-opt generate reduced-", plain("reduced-time", "reduced-fuel")),
        ("adr-opt solve --method ", plain(*names())),
        ("adr-opt solve my.json --method gr", plain("greedy", "greedy-guarded")),
        ("adr-opt solve my.json --bound ", plain(*names(BOUNDS))),
        ("adr-opt bound --method la", plain("lagrangian")),
        ("adr-opt replan --method au", plain("auto")),
        ("adr-opt tradeoff --method au", plain("auto")),
        ("adr-opt warm-up auto la", plain("lagrangian")),
        ("adr-opt methods ex", plain("exact")),
        ("adr-opt train --config po", plain("policy")),
        ("adr-opt train --out ", FOLDERS),
        ("adr-opt rehearse --bound-method la", plain("lagrangian")),
        ("adr-opt schema c", plain("certificate")),
        ("adr-opt solve ", FILES),
        ("adr-opt solve my.json --start ", FILES),
        ("adr-opt check my.json ", FILES),
        ("adr-opt verify my.json ", FILES),
        ("adr-opt compare my.json one.json ", FILES),
        ("adr-opt import ", FILES),
        ("adr-opt serve my.json ", FILES),
        ("adr-opt report my.json plan.json --out ", FILES),
        ("adr-opt check --j", plain("--json")),
        ("adr-opt nonsense ", plain(*VERBS)),
    ],
)
def test_what_is_offered(offered, line: str, expected: list[tuple[str, str]]) -> None:
    """Verbs, options, families, methods, files and folders, each where it belongs."""
    assert sorted(offered(line)) == sorted(expected)


def test_a_shell_does_not_wait_for_numba() -> None:
    """Verbs, families, methods and configurations are offered without numpy, numba and pydantic."""
    lines = (
        "adr-opt ",
        "adr-opt generate ",
        "adr-opt solve --method ",
        "adr-opt methods ",
        "adr-opt train --config ",
        "adr-opt solve ",
    )
    program = f"""
import os, sys
from adr_opt.ui.cli.entry import main
os.environ["{complete.VARIABLE}"] = "bash_complete"
for line in {lines!r}:
    os.environ["COMP_WORDS"], os.environ["COMP_CWORD"] = line, str(len(line.split()))
    assert main([]) == 0
print(*sorted({{"numba", "numpy", "pydantic", "ortools"}} & sys.modules.keys()))
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT
    )
    *listed, imported = done.stdout.splitlines()
    assert imported == ""
    assert {f"plain,{name}" for name in (*VERBS, *FAMILIES, *names(), "policy")} <= set(listed)


def test_bash_completes(tmp_path: Path) -> None:
    """What the documented line sets up in bash fills in a verb and a method."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("needs bash")
    (program := tmp_path / "adr-opt").write_text(
        f'#!/bin/sh\nPYTHONPATH={ROOT} exec {sys.executable} -m adr_opt "$@"\n'
    )
    program.chmod(0o755)
    script = """
eval "$(_ADR_OPT_COMPLETE=bash_source adr-opt)"
complete -p adr-opt
for last in so gr; do
    COMP_WORDS=(adr-opt $([ $last = gr ] && echo solve --method) $last)
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMPREPLY=()
    _adr_opt_completion adr-opt
    echo "${COMPREPLY[@]}"
done
"""
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    done = subprocess.run(
        [bash, "-c", script], capture_output=True, text=True, env=environment, cwd=tmp_path
    )
    if "not supported for Bash" in done.stderr:
        pytest.skip("needs bash 4.4")
    assert done.stdout.splitlines() == [
        "complete -o nosort -F _adr_opt_completion adr-opt",
        "solve",
        "greedy greedy-guarded",
    ]
