"""`followspot swap` and `followspot set`: replace stages and change parameters while the graph runs."""

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
    parser.add_argument(
        "words",
        nargs="+",
        metavar="STAGE=USES|STAGE.PARAMETER=VALUE",
        help="the changes, one word each",
    )
    add_run_option(parser)
    parser.add_argument(
        "--fresh", action="store_true", help="start the new stages without the state of the old ones"
    )
    parser.add_argument("--json", action="store_true", help="print the changes as one JSON object")
    add_plugin_option(parser, "a file that agents have loaded, for runs under agents; repeatable")
    add_network_options(parser)


def _change(args: argparse.Namespace) -> int:
    from followspot.cli.wait_notice import run_with_notices
    from followspot.errors import InputError
    from followspot.plugins.registry import use_plugin_files

    use_plugin_files([str(Path(file).absolute()) for file in args.plugin_files])
    if unclear := [word for word in args.words if "=" not in word]:
        remedy = f"say STAGE=..., for example fuse=balls.mean; a run is named by --run {unclear[0]}"
        raise InputError.of(f'"{unclear[0]}" says no change', remedy)
    with run_with_notices(args) as run:
        changed = run.change(args.words, fresh=args.fresh)
    if args.json:
        print(json.dumps(asdict(changed)))
        return 0
    lines = [f"  {stage.text}" for stage in changed.stages] or [
        "  no change: the run has these values already"
    ]
    print("\n".join([f"run {changed.run[:8]} of {changed.graph}", *lines]))
    return 0


def _swap(args: argparse.Namespace) -> int:
    """Replace stages of a run by others while it goes on.

    The run builds a new stage beside the old one. The new stage takes over between two messages, with the
    state of the old one if both stages support that; no message is lost. If a new stage cannot be built, the
    old stages go on, and the command says why. A sub-graph is replaced by another file that offers the
    outputs that are read. If it has other stages or edges than the old file, the sources wait until the old
    stages have processed everything; no worker restarts.

    Examples:
      followspot swap fuse=balls.mean --run glowballs
      followspot swap fuse=balls.mean_shift fuse.maximum_iterations=50
      followspot swap hall=quick_tracker.yaml
    """
    return _change(args)


def _set(args: argparse.Namespace) -> int:
    """Set parameters of stages of a run while it goes on.

    The run builds a stage with the new values beside the old one. The new stage takes over between two
    messages, with the state of the old one; no message is lost. If the new stage cannot be built, the old one
    goes on, and the command says why.

    Examples:
      followspot set color.similarity=0.7 --run glowballs
      followspot set color/cam0.similarity=0.7       of one camera
      followspot set hall.similarity=0.7             a parameter in the interface of a sub-graph
    """
    return _change(args)


COMMANDS = (Command("set", _configure, _set), Command("swap", _configure, _swap))
