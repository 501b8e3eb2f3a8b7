"""On a system that lacks what runs need, they are refused with the reason; what needs nothing works."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

GRAPH = Path(__file__).parents[3] / "graphs/glowballs.yaml"
AS_MACOS = """
import os, sys, fcntl, pathlib
for name in ("memfd_create", "eventfd", "sched_setaffinity", "sched_getaffinity"):
    delattr(os, name)
for name in [name for name in vars(fcntl) if name.startswith("F_SEAL") or name.endswith("_SEALS")]:
    delattr(fcntl, name)
exists = pathlib.Path.exists
pathlib.Path.exists = lambda self: str(self) != "/proc/net/unix" and exists(self)
"""
AS_WINDOWS = (
    AS_MACOS
    + """
import socket
for name in ("fcntl", "pwd", "grp", "resource"):
    sys.modules[name] = None
del socket.AF_UNIX, os.fork
"""
)
EACH = """
import contextlib, io, json
from followspot.cli.main import main

def said(words):
    errors = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        try:
            code = main(words)
        except SystemExit as end:
            code = end.code or 0
    return code, errors.getvalue()

print(json.dumps([said(words) for words in json.loads(sys.argv[1])]))
"""
"""Runs commands one after the other, and prints the exit code and the errors of each."""
RUNS = {
    "run": ["run", str(GRAPH), "--frames", "1", "--out", "out"],
    "top": ["top"],
    "agent": ["agent", "--name", "a"],
}
STARTS_NOTHING = {
    "check": ["check", str(GRAPH)],
    "graph": ["graph", str(GRAPH)],
    "plugins": ["plugins", "balls.mean"],
    "version": ["--version"],
}


@pytest.fixture(scope="module", params=[AS_MACOS, AS_WINDOWS], ids=["macos", "windows"])
def system(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, dict[str, tuple[int, str]]]:
    """A folder, and what the commands say there where `AS_...` has removed what the system does not have."""
    folder, commands = tmp_path_factory.mktemp("system"), RUNS | STARTS_NOTHING
    words = [sys.executable, "-c", request.param + EACH, json.dumps(list(commands.values()))]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder, dict(zip(commands, map(tuple, json.loads(done.stdout)), strict=True))


@pytest.mark.parametrize("command", RUNS)
def test_a_run_is_refused_with_the_reason(
    system: tuple[Path, dict[str, tuple[int, str]]], command: str
) -> None:
    folder, said = system
    code, errors = said[command]
    assert code == 1
    assert "runs need Linux; this system has no\n    memfd_create" in errors
    assert "Traceback" not in errors
    assert not (folder / "out").exists()


@pytest.mark.parametrize("command", STARTS_NOTHING)
def test_what_starts_nothing_works(system: tuple[Path, dict[str, tuple[int, str]]], command: str) -> None:
    code, errors = system[1][command]
    assert code == 0, errors
