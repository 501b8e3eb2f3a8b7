"""Cameras of GigE Vision in network namespaces of their own, and a client on another host."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.integration.hosts import Hosts

ROOT = Path(__file__).parents[3]
HERE = Path(__file__).parent
SYSTEM = Path("/usr/lib/python3/dist-packages")
DESK = "desk"
"""The host of the client."""
NEEDS = {
    "viva-genicam": "import viva_genicam",
    "aravis": "import gi; gi.require_version('Aravis', '0.8'); from gi.repository import Aravis",
}
"""What each backend, and the camera that comes with it, needs."""


def environment(folder: Path) -> dict[str, str]:
    """One in which Python sees the tests and, by a folder, the system's `gi`."""
    if (SYSTEM / "gi").is_dir():
        (folder / "gi").symlink_to(SYSTEM / "gi")
    return {**os.environ, "PYTHONPATH": f"{folder}:{ROOT}"}


def missing(env: dict[str, str], *backends: str) -> str:
    """Why a test skips: the backends that are not installed; "" if all are."""
    there = {
        name: subprocess.run([sys.executable, "-c", NEEDS[name]], env=env, capture_output=True).returncode
        for name in backends
    }
    absent = [name for name, code in there.items() if code]
    return f"{', '.join(absent)} is not installed" if absent else ""


def start(hosts: Hosts, host: str, script: str, *words: str, env: dict[str, str]) -> subprocess.Popen[str]:
    command = ["ip", "netns", "exec", hosts.space(host), sys.executable, str(HERE / script), *words]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    process = subprocess.Popen(command, text=True, env=env, **pipes)
    hosts.processes.append(process)
    return process


def running(
    hosts: Hosts, host: str, script: str, *words: str, env: dict[str, str], says: str = "running"
) -> subprocess.Popen[str]:
    """A program once it says that it runs."""
    process = start(hosts, host, script, *words, env=env)
    assert process.stdout.readline() == f"{says}\n", process.stderr.read()
    return process


def client(hosts: Hosts, env: dict[str, str], cameras: list[str], **asked: Any) -> subprocess.Popen[str]:
    """A client on the desk once it takes pictures of all these cameras: see gev_client.py."""
    where = {name: hosts.address(name) for name in cameras}
    told = {"cameras": where, "interface": hosts.address(DESK), "sync": None, **asked}
    return running(hosts, DESK, "gev_client.py", json.dumps(told), env=env, says="taking")


def told_by(process: subprocess.Popen[str]) -> dict[str, Any]:
    """What a camera or a client tells at its end."""
    out, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    found: dict[str, Any] = json.loads(out)
    return found
