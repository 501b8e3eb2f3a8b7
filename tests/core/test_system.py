"""On a system that lacks what runs need, they are refused with the reason; what needs nothing works."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

GRAPH = Path(__file__).parents[2] / "graphs/glowballs.yaml"
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
COMMAND = "\nfrom followspot.cli.main import main\nsys.exit(main(sys.argv[1:]))"


def followspot(system: str, *words: object) -> subprocess.CompletedProcess[str]:
    """A command where `system` has removed what it does not have."""
    return subprocess.run(
        [sys.executable, "-c", system + COMMAND, *map(str, words)], capture_output=True, text=True
    )


@pytest.mark.parametrize("system", [AS_MACOS, AS_WINDOWS], ids=["macos", "windows"])
@pytest.mark.parametrize("words", [("run", GRAPH, "--frames", "1"), ("top",), ("agent", "--name", "a")])
def test_a_run_is_refused_with_the_reason(system: str, words: tuple[object, ...], tmp_path: Path) -> None:
    out = ("--out", tmp_path / "out") if words[0] == "run" else ()
    done = followspot(system, *words, *out)
    assert done.returncode == 1
    assert "runs need Linux; this system has no\n    memfd_create" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("system", [AS_MACOS, AS_WINDOWS], ids=["macos", "windows"])
@pytest.mark.parametrize(
    "words", [("check", GRAPH), ("graph", GRAPH), ("plugins", "balls.mean"), ("--version",)]
)
def test_what_starts_nothing_works(system: str, words: tuple[object, ...]) -> None:
    done = followspot(system, *words)
    assert done.returncode == 0, done.stderr
