"""The options --keep of run and of what else plans a graph, and those of the command mark."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from followspot.cli.agent_options import add_network_options
from followspot.cli.run_option import add_run_option

if TYPE_CHECKING:
    from followspot.graph.plan import Plan


def configure_keeping(parser: argparse.ArgumentParser) -> None:
    """Add --keep and its options."""
    group = parser.add_argument_group("flight recorder")
    group.add_argument(
        "--keep", metavar="TIME", help="hold the last seconds (30s, 2min) in memory, for followspot mark"
    )
    group.add_argument("--keep-ports", metavar="STAGE[.PORT],...", help="ports to hold (default: all)")
    group.add_argument(
        "--keep-memory",
        metavar="SIZE",
        help="memory for messages (default 512MiB); pictures are held for a shorter time if they need more",
    )
    group.add_argument(
        "--mark-when",
        action="append",
        default=[],
        metavar="PORT:CONDITION",
        help="mark when this begins to hold, such as 'track.tracks: count(state == tracked) < 4'; repeatable",
    )


def configure_mark(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command mark."""
    add_run_option(parser)
    parser.add_argument(
        "--after", default="5s", metavar="TIME", help="time after now that is saved, too (default 5s)"
    )
    parser.add_argument("--note", default="", metavar="TEXT", help="text that the file and the log quote")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_network_options(parser)


def checked(plan: Plan, args: argparse.Namespace) -> Plan:
    """The unchanged plan. Raises InputError if it cannot be kept as the options say."""
    if args.keep or args.keep_ports or args.keep_memory or args.mark_when:
        from followspot_record.flight.keep_request import check_options

        check_options(plan, args)
    return plan


@contextmanager
def kept(args: argparse.Namespace) -> Iterator[None]:
    """Keep the last seconds of the run, if the options ask for it; at its end, name the files."""
    if getattr(args, "keep", None) is None:
        yield
        return
    from followspot_record.flight.keep_request import order_of
    from followspot_record.flight.running_recorder import running_recorder

    with running_recorder(order_of(args)) as recorder:
        yield
    for line in recorder.lines:
        print(line, file=sys.stderr)
