"""Frame sets per second of the six-camera tracker beside a plain OpenCV script doing the same work.

    python tools/bench_tracker.py --room room.yaml

The room's cameras play videos, decoded into memory before the clock starts. Both sides run tracked, and
searching: then no target is ever confirmed, so that all are sought in whole images. The first frames, in
which the tracker still searches the targets, are played before the clock starts. Rounds are
interleaved, time is CPU time of one process, and the ratio of each pair of one round is what counts on a
noisy machine.
What shares the caches of a core makes rounds slower, never faster: the fastest is that of a quiet machine.
With --placement the graph also runs in several processes, by the clock of the wall, for they work at once.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import statistics
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2

from benching import plain_tracker
from benching.frames_in_memory import Shots, shots
from benching.stage_cost import Cost, measure
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.operator.launch import run_plan
from followspot.plugins.registry import use_plugin_files
from followspot.worker.wiring import RunOptions
from scripting import shown, table_options

ROOT = Path(__file__).parent.parent
SIDES = ("tracked", "searching")
LEAD = 10
"""Frame sets before the clock starts."""
PRELOADED = str(ROOT / "tools/benching/preloaded.py")


def main() -> None:
    """Measure in interleaved rounds; print medians, ratios and the cost of each stage."""
    args = parser().parse_args()
    if args.frames <= LEAD:
        raise SystemExit(f"--frames: the first {LEAD} are not measured, so there must be more")
    cv2.setNumThreads(1)
    with TemporaryDirectory() as folder:
        result = _measured(args, Path(folder))
    print(json.dumps(result) if args.json else _text(args, result))


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--room", required=True, help="room file whose cameras play videos")
    options.add_argument("--graph", default=str(ROOT / "graphs/glowballs.yaml"))
    options.add_argument(
        "--placement", help="run in several processes as well, for example graphs/placements/two.yaml"
    )
    options.add_argument("--targets", help="track only these, for example red,green; default: all")
    options.add_argument("--frames", type=int, default=150)
    options.add_argument("--rounds", type=int, default=5)
    return options


def _measured(args: argparse.Namespace, out: Path) -> dict[str, Any]:
    """All rounds of all sides."""
    use_plugin_files([PRELOADED])
    plan = _compiled(args, None)
    played = shots(plan, args.frames)
    costs: dict[str, list[Cost]] = {side: [] for side in SIDES}
    plain: dict[str, list[float]] = {side: [] for side in SIDES}
    several: list[float] = []
    for number in range(args.rounds):
        for side in SIDES:
            searching = side == "searching"
            whole = measure(plan, played, out, lead=LEAD, searching=searching, by_stage=False)
            parts = measure(plan, played, out, lead=LEAD, searching=searching)
            costs[side].append(replace(parts, total=whole.total))
            plain[side].append(_plain(plan, played, searching=searching))
            rates = (
                f"graph {1e3 / costs[side][-1].total:.0f}, plain script {1e3 / plain[side][-1]:.0f} sets/s"
            )
            print(f"round {number + 1}, {side}: {rates}", file=sys.stderr)
        if args.placement:
            several.append(_several(_compiled(args, args.placement), args.frames, out))
    result: dict[str, Any] = {side: _summary(costs[side], plain[side]) for side in SIDES}
    if several:
        ratios = [rate * ms / 1e3 for rate, ms in zip(several, plain["tracked"], strict=True)]
        rate, ratio = statistics.median(several), statistics.median(ratios)
        result["processes"] = {"sets_per_second": rate, "ratio": ratio}
    return result


def _compiled(args: argparse.Namespace, placement: str | None) -> Plan:
    """The plan, with the wanted targets only."""
    wanted = args.targets.split(",") if args.targets else None
    plan = compile_graph(args.graph, room=args.room, placement=placement, plugin_files=[PRELOADED])
    targets = {n: t for n, t in plan.room.targets.items() if wanted is None or n in wanted}
    if not targets:
        raise SystemExit(f"{args.room} has no targets to track: followspot calibrate targets ...")
    return replace(plan, room=replace(plan.room, targets=targets))


def _plain(plan: Plan, played: Shots, *, searching: bool) -> float:
    """CPU time of the plain script for one frame set, ms."""
    pictures = {camera: [frame.pixels for frame in frames] for camera, frames in played.items()}
    sets = plain_tracker.run(plan.room, pictures, searching=searching)
    for _ in range(LEAD):
        next(sets)
    started = time.process_time()
    count = sum(1 for _ in sets)
    return (time.process_time() - started) * 1e3 / count


def _several(plan: Plan, frames: int, out: Path) -> float:
    """Frame sets per second of a run in several processes."""
    stages = tuple(
        replace(s, uses="preloaded.preloaded", params={"path": s.params["path"], "frames": frames})
        if s.uses == "cameras.video"
        else s
        for s in plan.stages
    )
    report = run_plan(replace(plan, stages=stages), RunOptions(out))
    if not report.ok:
        raise SystemExit("\n".join(report.errors))
    return report.frames / report.seconds


def _summary(costs: Sequence[Cost], plain: Sequence[float]) -> dict[str, Any]:
    """Sets/s of the median and the fastest round, ratio to the plain script, and ms of each stage."""
    stages = {name: statistics.median(c.stages[name] for c in costs) for name in costs[0].stages}
    total = statistics.median(c.total for c in costs)
    return {
        "sets_per_second": 1e3 / total,
        "fastest_sets_per_second": 1e3 / min(c.total for c in costs),
        "plain_sets_per_second": 1e3 / statistics.median(plain),
        "ratio": statistics.median(p / c.total for p, c in zip(plain, costs, strict=True)),
        "targets_tracked": costs[0].tracked,
        "ms": {**stages, "runtime": total - sum(stages.values()), "total": total},
    }


def _text(args: argparse.Namespace, result: Mapping[str, Any]) -> str:
    """The tables as text."""
    rates = ("sets_per_second", "fastest_sets_per_second", "plain_sets_per_second")
    rows = [
        (side, *(f"{r[key]:.0f}" for key in rates), f"{r['ratio']:.2f}", f"{r['targets_tracked']:.1f}")
        for side, r in ((side, result[side]) for side in SIDES)
    ]
    if "processes" in result:  # tracked, in wall-clock time
        r = result["processes"]
        rows.append(("processes", f"{r['sets_per_second']:.0f}", "", "", f"{r['ratio']:.2f}", ""))
    stages = [[name, *_shares(result, name)] for name in result[SIDES[0]]["ms"]]
    heads = [text for side in SIDES for text in (f"{side}, ms", "share")]
    sides = shown(args, ("sets/s", "graph", "fastest", "plain script", "ratio", "targets tracked"), rows)
    return f"{sides}\n\n{shown(args, ('stage', *heads), stages)}"


def _shares(result: Mapping[str, Any], stage: str) -> Iterator[str]:
    for ms in (result[side]["ms"] for side in SIDES):
        yield f"{ms[stage]:.3f}"
        yield f"{ms[stage] / ms['total']:.0%}"


if __name__ == "__main__":
    main()
