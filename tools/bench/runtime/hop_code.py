"""How much code a hop between two processes is: calls, instructions, and what no compiled core could save.

    python tools/bench/runtime/hop_code.py
    python tools/bench/runtime/hop_code.py --messages 400 --json

At 60 messages a second the code of a hop is out of the caches whenever it runs, so its length decides. Both
ends stand in this process, one message is sent and read at a time, and nothing sleeps. Cases run in turns:
`system calls` only sends and receives a datagram; `and messages` also makes and seals what is sent, and makes
what is read: a compiled core of the ring that cost nothing would leave this; `bare ring` is the yardstick
(`tools/benching/bare_ring.py`); `ring` is the whole. Instructions are counted by valgrind, if it is
installed, and so are misses of the first caches, of instructions and of data (32 kB each, simulated): those
of a process with so many messages, less those of one with none.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

from benching.hop_cases import CASES, Hop
from scripting import shown, table_options

SIZES = {"1 kB": (18, 19, 3), "640x480": (480, 640, 3)}
CACHES = ("--cache-sim=yes", "--I1=32768,8,64", "--D1=32768,8,64")
"""The simulated caches: bytes, ways, and bytes of a line."""
EVENTS = {"instructions": ("Ir",), "I1 misses": ("I1mr",), "D1 misses": ("D1mr", "D1mw")}
"""Of callgrind, by what they are called here."""
MISSES = tuple(EVENTS)[1:]


def main() -> None:
    """Count, measure, and print the table."""
    options = parser().parse_args()
    if options.only:
        case, size = options.only
        run(CASES[case](SIZES[size]), options.messages)
        return
    rows = [row for size in SIZES for row in figures(size, options.messages, options.rounds)]
    print(json.dumps(rows) if options.json else text(options, rows))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--messages", type=int, default=3000, help="of a count (default %(default)s)")
    options.add_argument("--rounds", type=int, default=7, help="interleaved rounds (default %(default)s)")
    options.add_argument("--only", nargs=2, metavar=("CASE", "SIZE"), help="run one case, to be counted")
    return options


def run(hop: Hop, messages: int) -> None:
    """So many messages, one by one."""
    for number in range(messages):
        hop(number)


def figures(size: str, messages: int, rounds: int) -> list[dict[str, Any]]:
    """A row for each case."""
    hops = {case: build(SIZES[size]) for case, build in CASES.items()}
    for hop in hops.values():
        run(hop, 50)
    times = [{case: timed(hop, messages) for case, hop in hops.items()} for _ in range(rounds)]
    counted = counts(size, messages)
    rows = []
    for case, hop in hops.items():
        calls, bare = called(hop), counted["bare ring"]
        row: dict[str, Any] = {
            "size": size,
            "case": case,
            "python_calls": calls["call"],
            "c_calls": calls["c_call"],
        }
        row["hot_us"] = median(found[case] for found in times)
        row["hot_ratio"] = median(found[case] / found["bare ring"] for found in times)
        for kind in EVENTS:
            row[kind] = counted[case].get(kind)
        row["instructions_ratio"] = row["instructions"] / bare["instructions"] if bare else None
        rows.append(row)
    return rows


def timed(hop: Hop, messages: int) -> float:
    """Processor time of a message whose code is in the caches, us."""
    begun = time.process_time()
    run(hop, messages)
    return (time.process_time() - begun) * 1e6 / messages


def called(hop: Hop) -> Counter[str]:
    """Calls of one message, by kind; the hop itself and the end of the count are none of its."""
    events: list[str] = []
    sys.setprofile(lambda _frame, event, _argument: events.append(event))
    hop(0)
    sys.setprofile(None)
    found = Counter(events)
    found["call"] -= 1
    found["c_call"] -= 1
    return found


def counts(size: str, messages: int) -> dict[str, dict[str, int]]:
    """What valgrind counts of one message in each case; empty without it. The kernel does not count."""
    valgrind = shutil.which("valgrind")
    if not valgrind:
        return {case: {} for case in CASES}
    start = executed(valgrind, "ring", size, 0)
    found = {case: executed(valgrind, case, size, messages) for case in CASES}
    return {
        case: {kind: round((count - start[kind]) / messages) for kind, count in counted.items()}
        for case, counted in found.items()
    }


def executed(valgrind: str, case: str, size: str, messages: int) -> dict[str, int]:
    """Instructions and misses of a process that runs one case."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "counts"
        command = [valgrind, "--tool=callgrind", f"--callgrind-out-file={out}", *CACHES]
        command += [sys.executable, __file__]
        command += ["--only", case, size, "--messages", str(messages)]
        same = {**os.environ, "PYTHONHASHSEED": "0"}  # so that all start alike
        subprocess.run(command, check=True, capture_output=True, env=same)
        told = dict(re.findall(r"^(events|totals): (.+)$", out.read_text(encoding="utf-8"), re.MULTILINE))
        totals = dict(zip(told["events"].split(), map(int, told["totals"].split()), strict=True))
        return {kind: sum(totals[event] for event in events) for kind, events in EVENTS.items()}


def text(options: argparse.Namespace, rows: list[dict[str, Any]]) -> str:
    """The table for people."""
    heads = (
        "size and case",
        "Python calls",
        "C calls",
        "hot us",
        "x bare",
        "instructions",
        "x bare",
        *MISSES,
    )
    cells = []
    for row in rows:
        counts = row["instructions"], row["instructions_ratio"]
        known = (f"{counts[0]}", f"{counts[1]:.2f}") if counts[0] is not None else ("", "")
        misses = ("" if row[kind] is None else f"{row[kind]}" for kind in MISSES)
        hot = f"{row['hot_us']:.1f}", f"{row['hot_ratio']:.2f}"
        cells.append(
            (
                f"{row['size']} {row['case']}",
                str(row["python_calls"]),
                str(row["c_calls"]),
                *hot,
                *known,
                *misses,
            )
        )
    return shown(options, heads, cells)


if __name__ == "__main__":
    main()
