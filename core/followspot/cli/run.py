"""`followspot run`: check, plan, run; progress while it runs, accuracy, latency and the ledger at the end."""

from __future__ import annotations

import argparse
import json
import time
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.cli.graph_options import add_graph_options, plan_of
from followspot.errors import FollowspotError
from followspot.plugins.hooks import Command

if TYPE_CHECKING:
    from followspot.accuracy import TargetScore
    from followspot.graph.plan import Plan

TRACKS = "tracks.csv"
"""The tracks within a run's output folder, by the default of `sinks.csv`."""


def _configure(parser: argparse.ArgumentParser) -> None:
    add_graph_options(parser)
    parser.add_argument("--out", metavar="DIR", help="folder for outputs (default: runs/GRAPH-DATE-TIME)")
    parser.add_argument("--frames", type=_positive, metavar="N", help="stop after N frames of each source")
    parser.add_argument("--json", action="store_true", help="end with one JSON object instead of tables")
    parser.add_argument("--quiet", action="store_true", help="no progress")


def _run(args: argparse.Namespace) -> int:
    from followspot.cli import summary
    from followspot.cli.progress import ProgressBar
    from followspot.deploy.launch import run_plan
    from followspot.runtime.wiring import RunOptions

    plan = plan_of(args)
    out = _output_folder(args.out, plan.graph)
    bar = ProgressBar()
    try:
        report = run_plan(plan, RunOptions(out, args.frames), None if args.quiet else bar.show)
    finally:
        bar.close()
    scores = _accuracy(plan, out, report.frames)
    if args.json:
        from followspot.accuracy import to_json

        print(json.dumps(summary.data(report, to_json(scores) if scores else {})))
    else:
        print(summary.text(report, _accuracy_table(scores)))
        print(f"\noutputs: {out}")
    return 0 if report.ok else 1


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return number


def _output_folder(asked: str | None, graph: str) -> Path:
    out = Path(asked) if asked else Path("runs") / f"{graph}-{time.strftime('%Y%m%d-%H%M%S')}"
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FollowspotError(
            f"cannot make the output folder {out}: {error.strerror}; choose one with --out"
        ) from error
    return out


def _accuracy(plan: Plan, out: Path, frames: int) -> dict[str, TargetScore]:
    """Scores of the tracks against the truth that the room declares; empty where there is none of either."""
    if plan.room.truth is None or not (out / TRACKS).exists():
        return {}
    from followspot.accuracy import read_tracks_csv, score, truth_of
    from followspot.plugins.registry import load_stage
    from followspot.stage import Context

    use = plan.room.truth
    source = load_stage(use.uses)(Context(name="truth", room=plan.room, seed=plan.seed), **use.params)
    source.setup()
    try:
        truth = truth_of(islice(source.process(), frames))
    finally:
        source.close()
    return score(read_tracks_csv(out / TRACKS), truth, plan.room)


def _accuracy_table(scores: dict[str, TargetScore]) -> str:
    from followspot.accuracy import table

    return table(scores) if scores else ""


COMMAND = Command(
    "run",
    """run a graph: check, plan, run; then accuracy (where there is truth), latency and the ledger

  followspot run graphs/glowballs.yaml
  followspot run graphs/glowballs.yaml --room room.yaml --placement camera
  followspot run graphs/glowballs.yaml --set fuse.uses=balls.mean --set color.similarity=0.9

Ctrl-C ends the sources; what is in flight is finished and all outputs are complete.
""",
    _configure,
    _run,
)
