"""`followspot move`: stages go to another worker or host while the graph runs."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.cli.graph_options import add_plugin_option
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "words",
        nargs="+",
        metavar="[RUN] STAGE PLACE",
        help="the graph, or the beginning of the run's name, where several run; a stage of the graph file or "
        "one of its instances; a worker of the run, or a host in reach of it",
    )
    parser.add_argument("--json", action="store_true", help="print what was moved as one JSON object")
    add_plugin_option(parser, "a file that agents have loaded, for runs under agents; repeatable")
    add_network_options(parser)


def _run(args: argparse.Namespace) -> int:
    """Bring a stage of a live run to another worker of the run, or to a host with an agent in reach of it

    Examples:
      followspot move glowballs camera/cam3 pc-right
      followspot move fuse main                                  the only run there is

    The worker that it leaves, the one that takes it, and others whose edges to it change their kind begin
    anew, with the state of their stages. Joins go on without them for a moment; what was under way is counted
    as lost. Where the stage cannot begin at its new place, all go back to their old ones, and the command
    says why.
    """
    from followspot.errors import InputError, Mistake
    from followspot.library.handle import connected_run
    from followspot.plugins.registry import use_plugin_files

    if len(args.words) not in (2, 3):
        raise InputError([Mistake(None, "what is to go where?", "for example: camera/cam3 pc-right")])
    use_plugin_files([str(Path(file).absolute()) for file in args.plugin_files])
    *wanted, stage, place = args.words
    with connected_run(wanted[0] if wanted else None, network_of(args)) as run:
        moved = run.move([stage], place)
    if args.json:
        print(json.dumps(asdict(moved)))
    else:
        print(
            f"run {moved.run[:8]} of {moved.graph}\n  {moved.text if moved.stages else 'it is there already'}"
        )
    return 0


COMMAND = Command("move", _configure, _run)
