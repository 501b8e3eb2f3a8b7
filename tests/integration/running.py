"""Runs graphs of the test stages as a user does, by the command in a separate process."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.commands import Process, Started, command, launch

STAGES = Path(__file__).parent.parent / "stages" / "ticks.py"


@dataclass(frozen=True)
class Finished:
    """An ended run."""

    code: int
    summary: dict[str, Any]
    errors: str
    out: Path

    def lines(self, name: str = "ticks.csv") -> list[str]:
        return (self.out / name).read_text().splitlines()

    def values(self, name: str = "ticks.csv") -> list[int]:
        return [int(line.split(",")[2]) for line in self.lines(name)]

    def edge(self, start: str, end: str) -> dict[str, Any]:
        """The sums of the counts of all edges between two stages or ports."""
        found = [e for e in self.summary["edges"] if e["from"].startswith(start) and e["to"].startswith(end)]
        assert found, f"no edge {start} -> {end}"
        numbers = [key for key in found[0] if isinstance(found[0][key], int)]
        return {key: sum(edge[key] for edge in found) for key in numbers}


def balanced(summary: dict[str, Any]) -> bool:
    """True if every message of every edge is accounted for."""
    parts = ("delivered", "dropped", "late", "unmatched", "invalid", "lost", "in_flight")
    edges = summary["edges"]
    sums = all(e["sent"] == sum(e[p] for p in parts) for e in edges)
    made = all(e["produced"] == e["sent"] + e["away"] for e in edges)
    whole = all(e[p] >= 0 for e in edges for p in (*parts, "produced", "away", "sent"))
    return sums and made and whole and all(e["in_flight"] == 0 for e in edges)


def write_graph(folder: Path, stages: str, name: str = "graph") -> Path:
    """Write a graph file with these stages, given as YAML lines."""
    path = folder / f"{name}.yaml"
    indented = "\n".join(f"  {line}" for line in stages.strip().splitlines())
    path.write_text(f"graph: {name}\nstages:\n{indented}\n")
    return path


def start(graph: Path, out: Path, *options: str) -> Started:
    """Start `followspot run`."""
    return launch(*words_of(graph, out, *options))


def words_of(graph: Path, out: Path, *options: str) -> list[str]:
    return ["run", str(graph), "--plugin", str(STAGES), "--out", str(out), "--json", *options]


def finish(process: Process, out: Path) -> Finished:
    """Wait for the end of a started run; one that does not come is made. Raises subprocess.TimeoutExpired."""
    try:
        stdout, stderr = process.communicate(timeout=90)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    return finished(process.wait(), stdout, stderr, out)


def finished(code: int, stdout: str, stderr: str, out: Path) -> Finished:
    summary = json.loads(stdout.splitlines()[-1]) if stdout.strip() else {}
    return Finished(code, summary, stderr, out)


def run(graph: Path, *options: str, out: str = "out") -> Finished:
    """Run `followspot run` to its end."""
    folder = graph.parent / out
    done = command(*words_of(graph, folder, *options), timeout=90)
    return finished(done.returncode, done.stdout, done.stderr, folder)


def children(pid: int) -> list[int]:
    """Child processes of `pid`, in the order of their start times, because process ids may wrap around."""
    try:
        texts = [path.read_text() for path in Path(f"/proc/{pid}/task").glob("*/children")]
    except OSError:
        return []
    return [int(word) for text in texts for word in text.split()]


def descendants(pid: int) -> list[int]:
    """Child processes of `pid`, and theirs."""
    return [found for child in children(pid) for found in (child, *descendants(child))]


def command_of(pid: int) -> str:
    """The command line of a process; empty if it has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode()
    except OSError:
        return ""


def workers(pid: int) -> list[int]:
    """Worker processes of the host `pid`, in the order of their start; a fork server may be their parent."""
    found: list[int] = []
    for child in children(pid):
        command = command_of(child)
        if "followspot.host.fork_server" in command:
            found += children(child)
        elif "followspot.worker.main" in command:
            found.append(child)
    return found


def wait_until(condition: Any, seconds: float = 60.0) -> bool:
    """True once the condition holds, False after `seconds`, which only bound a failure."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.01)
    return bool(condition())


def alive(pid: int) -> bool:
    """True if a process still runs."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def unused_memory() -> set[str]:
    """Named shared memory that no process of this machine uses: a run could have left it behind."""
    used = set()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):  # it has ended
            used.update(re.findall("/dev/shm/.*", maps.read_text()))
    return {str(path) for path in Path("/dev/shm").iterdir()} - used
