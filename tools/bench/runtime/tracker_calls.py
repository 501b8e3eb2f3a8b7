"""Where the calls of Python of a frame set go, tracked and searching: the functions that take most time.

    python tools/bench/runtime/tracker_calls.py --room room.yaml

As `bench_tracker.py`, under the profiler of Python: it slows calls down, and functions that make many of them
seem to cost more than they do. Calls are those of one frame set; shares are of the time in the functions
themselves. The first frame sets, in which the targets are sought, are not counted.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import cProfile
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType

import cv2

from benching.frames_in_memory import Shots, shots
from benching.stage_cost import measure
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from scripting import shown, table_options

ROOT = Path(__file__).parents[3]
SIDES = ("tracked", "searching")
LEAD = 10
"""Frame sets before the profile begins."""
ALL = "all"


@dataclass(frozen=True)
class Share:
    """What a function has of a frame set. time: of all, without the functions that it calls."""

    calls: float
    time: float


def main() -> None:
    """Profile both sides and print the table."""
    args = parser().parse_args()
    if args.frames <= LEAD:
        raise SystemExit(f"--frames: the first {LEAD} are not counted, so there must be more")
    cv2.setNumThreads(1)
    plan = compile_graph(args.graph, room=args.room)
    played = shots(plan, args.frames)
    with TemporaryDirectory() as folder:
        sides = {side: profiled(plan, played, Path(folder), side, args.frames) for side in SIDES}
    tracked = sides[SIDES[0]]
    most = sorted(tracked, key=lambda name: -tracked[name].time)[: args.functions + 1]
    if args.json:
        found = {
            side: {name: vars(sides[side][name]) for name in most if name in sides[side]} for side in SIDES
        }
        print(json.dumps(found))
        return
    print(text(args, sides, most))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--room", required=True, help="room file whose cameras play videos")
    options.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    options.add_argument("--frames", type=int, default=110, help="(default %(default)s)")
    options.add_argument("--functions", type=int, default=12, help="shown (default %(default)s)")
    return options


def profiled(plan: Plan, played: Shots, out: Path, side: str, frames: int) -> dict[str, Share]:
    """The share of each function, and of all."""
    profile = cProfile.Profile()
    searching = side == "searching"
    measure(plan, played, out, lead=LEAD, searching=searching, by_stage=False, began=profile.enable)
    profile.disable()
    rows = profile.getstats()
    sets = frames - LEAD
    whole = sum(row.inlinetime for row in rows)
    shares = {ALL: Share(sum(row.callcount for row in rows) / sets, 1.0)}
    for row in rows:
        name = named(row.code)
        before = shares.get(name, Share(0, 0))
        shares[name] = Share(before.calls + row.callcount / sets, before.time + row.inlinetime / whole)
    return shares


def named(code: CodeType | str) -> str:
    """A function as people call it: its file and name, or that of one in C."""
    if isinstance(code, CodeType):
        return f"{Path(code.co_filename).stem}.{code.co_qualname.replace('.<locals>', '')}"
    return code.strip("<>").removeprefix("built-in method ").removeprefix("method ")


def text(args: argparse.Namespace, sides: Mapping[str, Mapping[str, Share]], names: Sequence[str]) -> str:
    """The table."""
    none = Share(0, 0)
    rows = [
        (
            f"`{name}`" if name != ALL else name,
            *(
                cell
                for side in SIDES
                for share in [sides[side].get(name, none)]
                for cell in (f"{share.calls:.0f}", f"{share.time:.1%}")
            ),
        )
        for name in names
    ]
    heads = (cell for side in SIDES for cell in (f"calls, {side}", "share"))
    return shown(args, ("function", *heads), rows)


if __name__ == "__main__":
    main()
