"""Joins `followspot doctor` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `doctor`."""
    return [Command("doctor", _configure, _run)]


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--room", type=Path, metavar="ROOM.yaml", help="take a picture from each of its cameras"
    )
    parser.add_argument("--graph", metavar="GRAPH", help="find every mistake in this graph, too")
    parser.add_argument(
        "--out", type=Path, default=Path("runs"), help="where runs are written (default: runs)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_network_options(parser)


def _run(args: argparse.Namespace) -> int:
    """Look for what would keep a graph from running here, and say how to mend it

    Looks at this computer (memory, open files, shared memory, disk, clock), its network (loopback, multicast,
    ports), libraries, plugins, and with a room at every camera: a picture is taken from each. With --connect
    agents of other hosts are asked whether they are there and what their clocks say; with --certificates
    those are looked at. Exit code 1 where there is a problem; warnings alone do not count.

    Examples:
      followspot doctor
      followspot doctor --room room.yaml
      followspot doctor --graph graphs/glowballs.yaml --room room.yaml --json
      followspot doctor --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_doctor.examination import Subject, examine
    from followspot_doctor.report import as_json, as_text

    network = network_of(args, connect=())
    findings = examine(Subject(room=args.room, graph=args.graph, out=args.out, network=network))
    print(as_json(findings) if args.json else as_text(findings))
    return int(any(finding.state == "problem" for finding in findings))
