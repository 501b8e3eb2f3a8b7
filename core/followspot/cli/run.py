"""`followspot run`: check, plan, run; progress while it runs, accuracy, latency and the ledger at the end."""

from __future__ import annotations

import argparse
import json
import sys

from followspot.cli.graph_options import add_graph_options, frame_count, output_folder, plan_of
from followspot.errors import FollowspotError
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    add_graph_options(parser)
    parser.add_argument("--out", metavar="DIR", help="folder for outputs (default: runs/GRAPH-DATE-TIME)")
    parser.add_argument("--frames", type=frame_count, metavar="N", help="stop after N frames of each source")
    parser.add_argument("--json", action="store_true", help="end with one JSON object instead of tables")
    parser.add_argument("--quiet", action="store_true", help="no progress")


def _run(args: argparse.Namespace) -> int:
    from followspot.accuracy import persons_table, persons_to_json, table, to_json
    from followspot.cli import summary
    from followspot.cli.progress import ProgressBar
    from followspot.deploy.launch import run_plan
    from followspot.deploy.truth import run_person_scores, run_scores
    from followspot.runtime.wiring import RunOptions

    plan = plan_of(args)
    out = output_folder(args.out, plan.graph)
    bar = ProgressBar()
    try:
        report = run_plan(plan, RunOptions(out, args.frames), None if args.quiet else bar.show)
    finally:
        bar.close()
    try:
        targets = run_scores(plan, out, report.frames)
        persons = run_person_scores(plan, out, report.frames)
    except FollowspotError as error:  # the run itself is done; its summary must not be lost
        print(f"followspot: the accuracy cannot be told: {error}", file=sys.stderr)
        targets, persons = {}, None
    if args.json:
        figures = persons_to_json(persons) if persons else {}
        print(json.dumps(summary.data(report, to_json(targets), figures)))
    else:
        tables = [table(targets)] * bool(targets) + ([persons_table(persons)] if persons else [])
        print(summary.text(report, "\n\n".join(tables)))
        print(f"\noutputs: {out}")
    return 0 if report.ok else 1


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
