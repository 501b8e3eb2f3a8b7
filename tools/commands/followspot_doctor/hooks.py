"""The command `followspot doctor`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.cli.graph_options import add_plugin_option
from followspot.errors import InputError
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `doctor`."""
    return [Command("doctor", _configure, _run)]


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--room", type=Path, metavar="ROOM.yaml", help="take a picture from each camera of this room"
    )
    watch = (
        "also watch its live cameras for 5 s, and name those that take pictures earlier or later than others"
    )
    parser.add_argument("--cameras", action="store_true", help=watch)
    parser.add_argument("--graph", metavar="GRAPH", help="also find every mistake in this graph")
    add_plugin_option(parser, "load the stages of a Python file that graph or room use; repeatable")
    parser.add_argument(
        "--out", type=Path, default=Path("runs"), help="folder of the outputs of runs (default: runs)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_network_options(parser)


def _run(args: argparse.Namespace) -> int:
    """Find what would keep a graph from running on this host, and say how to repair it.

    The command examines this host (memory, open files, shared memory, disk, clock), its network
    (loopback, multicast, ports), libraries and plugins. With --room it takes a picture from each camera;
    with --cameras it watches the live ones together and says how far apart they take their pictures.
    With --connect it asks the agents of other hosts for their clocks, with --certificates it examines the
    certificates. The exit code is 1 if there is a problem; warnings do not count.

    Examples:
      followspot doctor
      followspot doctor --room room.yaml
      followspot doctor --room room.yaml --cameras
      followspot doctor --graph graphs/glowballs.yaml --room room.yaml --json
      followspot doctor --connect tls/pc-left:7450 --certificates certs
    """
    from followspot.plugins.registry import use_plugin_files
    from followspot_doctor.examination import Subject, examine
    from followspot_doctor.report import as_json, as_text

    if args.cameras and args.room is None:
        raise InputError.of("--cameras needs the room whose cameras it watches", "add --room ROOM.yaml")
    use_plugin_files(args.plugin_files)
    network = network_of(args, connect=())
    subject = Subject(args.room, args.graph, args.cameras, args.out, network)
    findings = examine(subject)
    print(as_json(findings) if args.json else as_text(findings))
    return int(any(finding.state == "problem" for finding in findings))
