"""One point of the grid in one room: a run in its own process, with its summary kept in its folder."""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from followspot.errors import writing
from followspot.files import read_bytes
from followspot.operating_system.child_processes import module_command
from followspot_sweep.axes import Point
from followspot_sweep.figures import figures_of

SUMMARY = "summary.json"


@dataclass(frozen=True)
class Task:
    """A run to make.

    command: the arguments of `followspot` without those of the output; fingerprint: as
    `fingerprint_of` gives it, so that a sweep does not reuse results of another graph or room.
    """

    room: str
    point: Point
    command: tuple[str, ...]
    folder: Path
    fingerprint: str


@dataclass(frozen=True)
class Result:
    """The result of a task: figures by name; error is empty if the run succeeded."""

    task: Task
    figures: dict[str, float]
    error: str = ""


def folder_name(point: Point) -> str:
    """A short name that can be read, and never stands for two points."""
    words = "_".join(f"{name.rpartition('.')[2]}={value}" for name, value in point)
    digest = hashlib.sha256(repr(point).encode()).hexdigest()[:8]
    return f"{re.sub(r'[^A-Za-z0-9.=_-]', '-', words)[:60]}-{digest}"


def kept(task: Task) -> Result | None:
    """The result of an earlier sweep; None if there is no complete one."""
    try:
        found = json.loads(read_bytes(task.folder / SUMMARY))
        if (found["command"], found["fingerprint"]) == (list(task.command), task.fingerprint):
            return Result(task, figures_of(found["summary"]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return None


def run(task: Task, started: Callable[[subprocess.Popen[str]], None]) -> Result:
    """Run the task and keep its summary. started: receives the process, so that the caller can end it."""
    task.folder.mkdir(parents=True, exist_ok=True)
    command = [
        *module_command("followspot_sweep.child_process", str(os.getpid())),
        *task.command,
        "--out",
        str(task.folder),
    ]
    with subprocess.Popen(
        [*command, "--json", "--quiet"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        started(process)
        out, err = process.communicate()
    summary = _summary(out)
    if process.returncode or summary is None or summary.get("stopped"):
        reasons: Sequence[str] = summary.get("errors", ()) if summary else ()
        return Result(task, {}, "; ".join(reasons) or err.strip() or "it was stopped")
    whole = json.dumps({"command": task.command, "fingerprint": task.fingerprint, "summary": summary})
    waiting = task.folder / f".{SUMMARY}"
    with writing(task.folder / SUMMARY):
        waiting.write_text(whole, encoding="utf-8")
        waiting.replace(task.folder / SUMMARY)
    return Result(task, figures_of(summary))


def _summary(text: str) -> dict[str, Any] | None:
    try:
        found = json.loads(text)
    except ValueError:
        return None
    return found if isinstance(found, dict) else None
