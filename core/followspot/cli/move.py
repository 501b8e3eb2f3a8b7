"""`followspot move`: move a stage to another worker or host while the graph runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from followspot.cli.agent_options import add_network_options
from followspot.cli.graph_options import add_plugin_option
from followspot.cli.run_option import add_run_option
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stage", metavar="STAGE", help="a stage of the graph file, or one of its instances")
    parser.add_argument("place", metavar="PLACE", help="a worker of the run, or a host with an agent")
    add_run_option(parser)
    parser.add_argument("--json", action="store_true", help="print the move as one JSON object")
    add_plugin_option(parser, "a file that agents have loaded, for runs under agents; repeatable")
    add_network_options(parser)


def _run(args: argparse.Namespace) -> int:
    """Move a stage of a live run to another worker of the run, or to a host with an agent.

    The old and the new worker of the stage restart, and so do workers whose edges to the stage change their
    kind. Their stages keep their state. Meanwhile joins go on without them, and the ledger counts messages
    in flight as lost. If the stage cannot start at its new place, it returns to its old one, and the command
    says why.

    Examples:
      followspot move fuse main
      followspot move camera/cam3 pc-right --run glowballs
    """
    from followspot.cli.wait_notice import run_with_notices
    from followspot.plugins.registry import use_plugin_files

    use_plugin_files([str(Path(file).absolute()) for file in args.plugin_files])
    with run_with_notices(args) as run:
        moved = run.move([args.stage], args.place)
    if args.json:
        print(json.dumps(asdict(moved)))
    else:
        change = moved.text if moved.stages else "the stage is there already"
        print(f"run {moved.run[:8]} of {moved.graph}\n  {change}")
    return 0


COMMAND = Command("move", _configure, _run)
