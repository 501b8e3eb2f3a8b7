"""What a hop costs, on one host and between hosts: age of pictures at their reader, and how many arrive.

    python tools/bench_hosts.py
    python tools/bench_hosts.py --rounds 5 --json
    python tools/bench_hosts.py --only "two hosts, jpeg" "100 Mbit/s, raw"

Hosts are network namespaces on this machine, joined by a bridge, so root is needed; links are slowed down
with tc (tbf). All cases run in turn, in each round, and medians are given: ratios within one run count.
A camera sends 320 x 240 pictures (230 kB) at 60 Hz for two seconds.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from soak_show import Hosts

ROOT = Path(__file__).parent.parent
STAGES = ROOT / "tools" / "bench_hosts_stages.py"
FAR = ("pc-1", "pc-2", "pc-3", "pc-4")
_ONE = """graph: hop
stages:
  film: {uses: bench_hosts_stages.film}
  look: {uses: bench_hosts_stages.look, in: {frame: {from: film, codec: CODEC}}}
"""
_PER_HOST = 4
_SLOW = {"rate": 30.0, "count": 60}


@dataclass(frozen=True)
class Case:
    """graph, placement: as files hold them; mbit: of each link, 0 for as fast as can be; hosts: far ones."""

    graph: str
    placement: str = ""
    mbit: int = 0
    hosts: tuple[str, ...] = ()


def _one(codec: str = "raw", worker: str = "", mbit: int = 0) -> Case:
    placement = f"placement: p\nworkers:\n  far: {{{worker}stages: [film]}}\n" if worker else ""
    hosts = FAR[:1] if "host" in worker else ()
    return Case(_ONE.replace("CODEC", codec), placement, mbit, hosts)


def _sixteen() -> Case:
    names = [f"film{number}" for number in range(_PER_HOST * len(FAR))]
    stages = [f"  {name}: {{uses: bench_hosts_stages.film, with: {json.dumps(_SLOW)}}}" for name in names]
    feeds = ", ".join(f"{{from: {name}, codec: jpeg}}" for name in names)
    look = f"  look: {{uses: bench_hosts_stages.look_at_all, in: {{frames: [{feeds}]}}, tolerance: 0.016}}"
    workers = [
        f"  {host}: {{host: {host}, stages: [{', '.join(names[i * _PER_HOST : (i + 1) * _PER_HOST])}]}}"
        for i, host in enumerate(FAR)
    ]
    graph = "graph: sixteen\nstages:\n" + "\n".join([*stages, look]) + "\n"
    return Case(graph, "placement: p\nworkers:\n" + "\n".join(workers) + "\n", 0, FAR)


_FAR = "host: pc-1, "
CASES: dict[str, Case] = {
    "same worker": _one(),
    "same host, ring": _one(worker=" "),
    "two hosts, raw": _one("raw", _FAR),
    "two hosts, lossless": _one("lossless", _FAR),
    "two hosts, jpeg": _one("jpeg", _FAR),
    "1 Gbit/s, raw": _one("raw", _FAR, 1000),
    "1 Gbit/s, jpeg": _one("jpeg", _FAR, 1000),
    "100 Mbit/s, raw": _one("raw", _FAR, 100),
    "100 Mbit/s, jpeg": _one("jpeg", _FAR, 100),
    "16 cameras on 4 hosts, jpeg, 30 Hz": _sixteen(),
}


def play(hosts: Hosts, case: Case, folder: Path) -> dict[str, float]:
    """One run of a case."""
    (folder / "graph.yaml").write_text(case.graph)
    (folder / "placement.yaml").write_text(case.placement)
    where = ["--placement", "placement.yaml"] if case.placement else []
    there = [word for name in case.hosts for word in ("--connect", hosts.endpoint(name))]
    safe = ["--insecure"] if there else []
    for name in case.hosts:
        _limit(hosts, name, case.mbit)
    words = ["run", "graph.yaml", "--plugin", STAGES, "--out", "out", "--json", "--quiet"]
    begun = time.monotonic()
    process = hosts.start("desk", *words, *where, *there, *safe)
    stdout, stderr = process.communicate(timeout=120)
    if process.returncode:
        raise SystemExit(stderr + stdout)
    summary = json.loads(stdout.splitlines()[-1])
    got = sum(edge["delivered"] for edge in summary["edges"])
    lost = sum(edge["dropped"] + edge["late"] for edge in summary["edges"])
    paths = summary["paths"]
    return {
        "p50_ms": statistics.median(path["p50_ms"] for path in paths),
        "p95_ms": max(path["p95_ms"] for path in paths),
        "share": got / max(1, got + lost),
        "whole_s": time.monotonic() - begun,
        "run_s": summary["seconds"],
    }


def _limit(hosts: Hosts, name: str, mbit: int) -> None:
    """Slow down what a host sends."""
    space = ["tc", "-n", hosts.space(name), "qdisc"]
    subprocess.run([*space, "del", "dev", "eth0", "root"], capture_output=True, check=False)
    if mbit:
        filter_ = ["tbf", "rate", f"{mbit}mbit", "burst", "64kb", "latency", "50ms"]
        subprocess.run([*space, "add", "dev", "eth0", "root", *filter_], check=True)


def main() -> int:
    """Entry."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", nargs="+", choices=list(CASES), default=list(CASES), metavar="CASE")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    args = parser.parse_args()
    seen: dict[str, list[dict[str, float]]] = {name: [] for name in args.only}
    with tempfile.TemporaryDirectory() as made, Hosts(Path(made), ["desk", *FAR]) as hosts:
        for name in {host for case in args.only for host in CASES[case].hosts}:
            hosts.agent(name, "--plugin", STAGES)
        for number in range(args.rounds):
            for name in args.only:
                seen[name].append(play(hosts, CASES[name], Path(made)))
                one = ", ".join(f"{key} {value:.2f}" for key, value in seen[name][-1].items())
                print(f"round {number + 1}: {name}: {one}", file=sys.stderr, flush=True)
    found: dict[str, Any] = {
        name: {key: round(statistics.median(one[key] for one in rounds), 3) for key in rounds[0]}
        for name, rounds in seen.items()
    }
    if args.json:
        print(json.dumps(found))
        return 0
    print("| pictures | age p50, ms | age p95, ms | arrived | start and end, s |\n|---|---|---|---|---|")
    for name, one in found.items():
        ends = one["whole_s"] - one["run_s"]
        print(f"| {name} | {one['p50_ms']:.2f} | {one['p95_ms']:.2f} | {one['share']:.0%} | {ends:.1f} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
