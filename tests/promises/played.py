"""Plays a graph as a user does and keeps every byte that came of it; shares no code with what it judges."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from tests.commands import command

COUNTS = (
    "produced",
    "away",
    "sent",
    "delivered",
    "dropped",
    "late",
    "unmatched",
    "invalid",
    "lost",
    "in_flight",
)
"""Columns of the ledger, as the report names them."""
BURN = "while True: pass"


@dataclass(frozen=True)
class Played:
    """What a run left behind.

    files: digest of each output file; ports: of each recorded port the digests of its messages, one after the
    other; report: what the summary says that does not depend on time or on processes.
    """

    files: Mapping[str, str]
    ports: Mapping[str, Sequence[str]]
    report: Mapping[str, Any]

    @property
    def stages(self) -> list[str]:
        """Names of all instances but the recorder's."""
        return sorted(name for name in self.report["stages"] if not name.startswith("record-"))


def play(graph: Path, folder: Path, *options: str, record: bool) -> Played:
    """Run a graph that ends by itself; everything it writes is read, and then removed.

    record: whether to record every message of every port, too.
    """
    out, recording = folder / "out", folder / "all.mcap"
    taps = (
        ["--record", recording, "--record-compression", "none", "--record-pictures", "raw"] if record else []
    )
    done = command("run", graph, "--out", out, "--json", "--quiet", *taps, *options, timeout=1200)
    assert done.returncode == 0, f"{' '.join(map(str, options))}: {done.stderr}{done.stdout[-2000:]}"
    files = {}
    for path in sorted(out.rglob("*")):
        if path.is_file():
            files[str(path.relative_to(out))] = hashlib.sha256(path.read_bytes()).hexdigest()
            path.unlink()
    ports = recorded(recording) if record else {}
    recording.unlink(missing_ok=True)
    return Played(files, ports, told(json.loads(done.stdout.splitlines()[-1])))


def recorded(path: Path) -> dict[str, list[str]]:
    """Digests of the messages of each topic but the log, which tells of processes: number, times, payload."""
    found: dict[str, list[str]] = defaultdict(list)
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages(log_time_order=False):
            if channel.topic == "/log":
                continue
            head = repr((message.sequence, message.log_time, message.publish_time)).encode()
            found[channel.topic].append(hashlib.sha256(head + message.data).hexdigest())
    return dict(found)


def told(summary: Mapping[str, Any]) -> dict[str, Any]:
    """What of a summary must be the same in every placement: accuracy, what stages did, and the ledger."""
    edges: dict[str, list[tuple[int, ...]]] = defaultdict(list)
    for edge in summary["edges"]:
        edges[f"{edge['from']} -> {edge['to']}"].append(tuple(edge[name] for name in COUNTS))
    stages = {s["stage"]: (s["fired"], s["skipped"]) for w in summary["workers"] for s in w["stages"]}
    same = ("graph", "room", "frames", "stopped", "ok", "targets", "persons", "warnings", "errors")
    return {**{name: summary[name] for name in same}, "edges": dict(edges), "stages": stages}


def differences(expected: Played, found: Played) -> list[str]:
    """Differences of two runs: files, ports with the first message that differs, and output."""
    lines = [f"file {name}" for name in _unlike(expected.files, found.files)]
    for port in _unlike(expected.ports, found.ports):
        a, b = expected.ports.get(port, ()), found.ports.get(port, ())
        first = next((k for k, pair in enumerate(zip(a, b, strict=False)) if pair[0] != pair[1]), None)
        lines.append(f"port {port}: {len(a)} and {len(b)} messages, the first that differ: {first}")
    told_otherwise = _unlike(expected.report, found.report)
    return lines + [f"report {n}: {expected.report[n]} and {found.report[n]}" for n in told_otherwise]


def _unlike(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    return sorted(name for name in {*a, *b} if a.get(name) != b.get(name))


@contextmanager
def burners(count: int) -> Iterator[None]:
    """Processes that leave the others as little of the processors as they can."""
    processes = [subprocess.Popen([sys.executable, "-c", BURN]) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def one_each(stages: Sequence[str]) -> str:
    """A placement file with a worker for every instance."""
    lines = [f"  w{number}: {{stages: [{stage}]}}" for number, stage in enumerate(stages)]
    return "placement: each\nworkers:\n" + "\n".join(lines) + "\n"
