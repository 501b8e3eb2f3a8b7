"""Cost of hops, links, starts and faults on one host and on several: medians of rounds, as tables.

    python tools/bench/runtime/hosts.py                                  everything, three rounds
    python tools/bench/runtime/hosts.py --rounds 5 --json
    python tools/bench/runtime/hosts.py --only "two hosts, jpeg" "100 Mbit/s, raw"
    python tools/bench/runtime/hosts.py --only faults

Hosts are network namespaces on this machine, joined by a bridge, so root is needed; links are slowed down
with tc (tbf). All cases run in turn, in each round, and medians are given: ratios within one run count.
A camera sends 320 x 240 pictures (230 kB) at 60 Hz for 1.5 s, or as many as the link takes (flat out).
Faults are those of tools/soak.py, each kind once a round.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benching.hosts_cases import CASES, FAR, HOPS, STAGES, STARTS, THROUGHPUTS, Hosts, play
from scripting import options_of
from soaking.show import FAULTS as KINDS

FAULTS = "faults"
Figures = dict[str, dict[str, float]]


def played(names: Sequence[str], rounds: int) -> Figures:
    """Medians of the figures of each case."""
    seen: dict[str, list[dict[str, float]]] = {name: [] for name in names}
    with tempfile.TemporaryDirectory() as made, Hosts(Path(made), ["desk", *FAR]) as hosts:
        for host in sorted({host for name in names for host in CASES[name].hosts}):
            hosts.agent(host, "--plugin", STAGES)
        for number in range(rounds):
            for name in names:
                seen[name].append(play(hosts, CASES[name], Path(made)))
                one = ", ".join(f"{key} {value:.2f}" for key, value in seen[name][-1].items())
                print(f"round {number + 1}: {name}: {one}", file=sys.stderr, flush=True)
    return {
        name: {key: round(statistics.median(one[key] for one in found), 3) for key in found[0]}
        for name, found in seen.items()
    }


def inflicted(rounds: int) -> Figures:
    """Cost of each kind of fault, as tools/soak.py reports it."""
    soak = [sys.executable, str(Path(__file__).parents[2] / "soak.py"), "--json"]
    done = subprocess.run(
        [*soak, "--faults", str(rounds * len(KINDS))], stdout=subprocess.PIPE, text=True, check=False
    )
    if not done.stdout.strip():
        raise SystemExit("tools/soak.py has not reported")
    kinds: Figures = json.loads(done.stdout.splitlines()[-1])["kinds"]
    return kinds


def tables(found: Figures, faults: Figures) -> str:
    """Everything that was measured, in Markdown."""
    near = found.get("same worker", {}).get("p50_ms")
    columns = tuple(dict.fromkeys(key for f in faults.values() for key in f))
    kinds = [(name, *(str(f.get(key, "")) for key in columns)) for name, f in faults.items()]
    parts = [
        _table(
            ("from camera to reader", "p50, ms", "added by the hop, ms", "p95, ms", "arrived"),
            [(name, *_hop(found[name], near)) for name in HOPS if name in found],
        ),
        _table(
            ("as many pictures as it takes", "pictures a second", "Mbit/s", "age p50, ms"),
            [(name, *_throughput(found[name])) for name in THROUGHPUTS if name in found],
        ),
        _table(
            ("start", "until the first result, s"),
            [(name, f"{found[name]['start_s']:.1f}") for name in ("same worker", *STARTS) if name in found],
        ),
        _table(("fault", *columns), kinds),
    ]
    return "\n\n".join(part for part in parts if part)


def _hop(f: dict[str, float], near: float | None) -> tuple[str, ...]:
    """near: p50, ms, of a hop that is a call."""
    added = "" if near is None else f"{f['p50_ms'] - near:.2f}"
    return f"{f['p50_ms']:.2f}", added, f"{f['p95_ms']:.2f}", f"{f['share']:.0%}"


def _throughput(f: dict[str, float]) -> tuple[str, ...]:
    return f"{f['pictures']:.0f}", f"{f['mbit']:.0f}", f"{f['p50_ms']:.1f}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Empty if there are no rows."""
    lines = ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
    return "\n".join(lines) if rows else ""


def main() -> int:
    """Entry."""
    parser = options_of(__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    names = [*CASES, FAULTS]
    parser.add_argument("--only", nargs="+", action="extend", choices=names, metavar="CASE")
    args = parser.parse_args()
    chosen = args.only or names
    found = played([name for name in chosen if name != FAULTS], args.rounds)
    faults = inflicted(args.rounds) if FAULTS in chosen else {}
    print(json.dumps({"cases": found, "faults": faults}) if args.json else tables(found, faults))
    return 0


if __name__ == "__main__":
    sys.exit(main())
