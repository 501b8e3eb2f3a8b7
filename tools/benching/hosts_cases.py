"""Cases of tools/bench/runtime/hosts.py: graphs, placements and link speeds; runs one of them."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

from tests.integration.hosts import Hosts  # noqa: E402

__all__ = ["CASES", "FAR", "HOPS", "STAGES", "STARTS", "THROUGHPUTS", "Case", "Hosts", "play"]

STAGES = Path(__file__).with_name("film_stages.py")
FAR = ("pc-1", "pc-2", "pc-3", "pc-4")
PICTURE = 320 * 240 * 3
"""Bytes of a picture."""
_PER_HOST = 4


@dataclass(frozen=True)
class Case:
    """One run.

    graph, placement: text of the files, or the path of a graph; mbit: of each link, 0 for no limit;
    hosts: remote ones; sink: file below the output folder with the first result in its second line.
    """

    graph: str
    placement: str = ""
    mbit: int = 0
    hosts: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    sink: str = "first"


def _one(
    codec: str = "raw", worker: str = "", mbit: int = 0, rate: float = 60.0, seconds: float = 1.5
) -> Case:
    """One camera and one reader; worker: of the camera."""
    film = json.dumps({"rate": rate, "count": round(rate * seconds)})
    graph = f"""graph: hop
stages:
  film: {{uses: film_stages.film, with: {film}}}
  look: {{uses: film_stages.look, in: {{frame: {{from: film, codec: {codec}}}}}}}
"""
    placement = f"placement: p\nworkers:\n  far: {{{worker}stages: [film]}}\n" if worker else ""
    return Case(graph, placement, mbit, FAR[:1] if "host" in worker else ())


def _many(workers: int, hosts: tuple[str, ...] = (), cameras: int = 1) -> Case:
    """So many workers with so many cameras each, in turn on these hosts, and a reader of all at the desk."""
    film = json.dumps({"rate": 30.0, "count": 45})
    names = [f"film{number}" for number in range(workers * cameras)]
    stages = [f"  {name}: {{uses: film_stages.film, with: {film}}}" for name in names]
    feeds = ", ".join(f"{{from: {name}, codec: jpeg}}" for name in names)
    of = f"in: {{frames: [{feeds}]}}, with: {{cameras: {len(names)}}}"
    look = f"  look: {{uses: film_stages.look_at_all, {of}, tolerance: 0.016}}"
    places = []
    for number in range(workers):
        host = f"host: {hosts[number % len(hosts)]}, " if hosts else ""
        mine = ", ".join(names[number * cameras : (number + 1) * cameras])
        places.append(f"  w{number}: {{{host}stages: [{mine}]}}")
    graph = "graph: many\nstages:\n" + "\n".join([*stages, look]) + "\n"
    return Case(graph, "placement: p\nworkers:\n" + "\n".join(places) + "\n", 0, hosts)


_CAMERAS = "".join(f"  w{n}: {{cameras: [cam{n}]}}\n" for n in range(4)) + "  w4: {cameras: [cam4, cam5]}\n"
_TRACKER = Case(
    str(ROOT / "graphs" / "glowballs.yaml"),
    f"placement: p\nworkers:\n{_CAMERAS}",
    options=("--frames", "20"),
    sink="tracks.csv",
)
_FAR = "host: pc-1, "
_FLAT_OUT = 2000.0
HOPS: dict[str, Case] = {
    "same worker": _one(),
    "same host, ring": _one(worker=" "),
    "two hosts, raw": _one("raw", _FAR),
    "two hosts, lossless": _one("lossless", _FAR),
    "two hosts, jpeg": _one("jpeg", _FAR),
    "1 Gbit/s, raw": _one("raw", _FAR, 1000),
    "1 Gbit/s, jpeg": _one("jpeg", _FAR, 1000),
    "100 Mbit/s, raw": _one("raw", _FAR, 100),
    "100 Mbit/s, jpeg": _one("jpeg", _FAR, 100),
    "16 cameras on 4 hosts, jpeg, 30 Hz": _many(4, FAR, _PER_HOST),
}
THROUGHPUTS: dict[str, Case] = {
    "flat out, two hosts, raw": _one("raw", _FAR, 0, _FLAT_OUT),
    "flat out, 1 Gbit/s, raw": _one("raw", _FAR, 1000, _FLAT_OUT),
    "flat out, 100 Mbit/s, raw": _one("raw", _FAR, 100, _FLAT_OUT),
    "flat out, 100 Mbit/s, jpeg": _one("jpeg", _FAR, 100, _FLAT_OUT),
}
STARTS: dict[str, Case] = {
    "6 workers, cameras that only pass on": _many(5),
    "6 workers on 4 hosts, the same": _many(5, FAR),
    "6 workers, graphs/glowballs.yaml": _TRACKER,
}
CASES: dict[str, Case] = HOPS | THROUGHPUTS | STARTS


def play(hosts: Hosts, case: Case, folder: Path) -> dict[str, float]:
    """One run of a case at the desk; agents are there."""
    named = case.graph.endswith(".yaml")
    graph = Path(case.graph) if named else folder / "graph.yaml"
    if not named:
        graph.write_text(case.graph)
    (folder / "placement.yaml").write_text(case.placement)
    where = ["--placement", "placement.yaml"] if case.placement else []
    there = [word for name in case.hosts for word in ("--connect", hosts.endpoint(name))]
    safe = ["--insecure"] if there else []
    for name in case.hosts:
        _limit(hosts, name, case.mbit)
    first = folder / "out" / case.sink
    first.unlink(missing_ok=True)
    words: list[str | Path] = [
        "run",
        graph,
        "--plugin",
        STAGES,
        "--out",
        "out",
        "--json",
        "--quiet",
        *case.options,
    ]
    begun = time.monotonic()
    process = hosts.start("desk", *words, *where, *there, *safe)
    started = _first_result(process, first) - begun
    stdout, stderr = process.communicate(timeout=120)
    if process.returncode:
        raise SystemExit(stderr + stdout)
    return {"start_s": started, **_figures(json.loads(stdout.splitlines()[-1]))}


def _figures(summary: dict[str, Any]) -> dict[str, float]:
    got = sum(edge["delivered"] for edge in summary["edges"])
    lost = sum(edge["dropped"] + edge["late"] for edge in summary["edges"])
    paths = summary["paths"]
    return {
        "p50_ms": statistics.median(path["p50_ms"] for path in paths),
        "p95_ms": max(path["p95_ms"] for path in paths),
        "share": got / max(1, got + lost),
        "pictures": got / summary["seconds"],
        "mbit": got * PICTURE * 8 / 1e6 / summary["seconds"],
    }


def _first_result(process: subprocess.Popen[str], path: Path) -> float:
    """When the second line of a file was there, s of the monotonic clock; the first is a heading."""
    while process.poll() is None:
        if path.exists() and path.read_bytes().count(b"\n") > 1:
            break
        time.sleep(0.01)
    return time.monotonic()


def _limit(hosts: Hosts, name: str, mbit: int) -> None:
    """Slow down what a host sends."""
    space = ["tc", "-n", hosts.space(name), "qdisc"]
    subprocess.run([*space, "del", "dev", "eth0", "root"], capture_output=True, check=False)
    if mbit:
        filter_ = ["tbf", "rate", f"{mbit}mbit", "burst", "64kb", "latency", "50ms"]
        subprocess.run([*space, "add", "dev", "eth0", "root", *filter_], check=True)
