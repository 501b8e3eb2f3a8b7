"""Joins looking at runs to the command line: run --dashboard, and the commands dashboard, top, echo."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from followspot.cli.agent_options import add_network_options
from followspot.plugins.hooks import Command, PlanOptions, hookimpl

if TYPE_CHECKING:
    from followspot.graph.plan import Plan

_RUN = "the graph, the beginning of the run's name, or its process, where several run"
HOST, PORT = "127.0.0.1", 8777
DASHBOARD = """show a graph that runs in a browser, until it ends; the same as run --dashboard

The room in 3D, the pictures of all cameras with what was found in them, and the graph with what each stage is
doing, its rates and its ledger. Ctrl-C ends the page and nothing else.

  followspot dashboard
  followspot dashboard glowballs --dashboard-at 127.0.0.1:9000
"""
TOP = """what each stage and edge of a run is doing: state, on whom it waits, rate, ledger, latency, errors

On a terminal it renews itself until the run ends or Ctrl-C; elsewhere, and with --json, it prints once.

  followspot top
  followspot top glowballs --json
  followspot top glowballs --connect tls/pc-left:7450 --certificates certs
"""
ECHO = """print the messages of a port of a graph that runs on this machine

Messages that come faster than they are printed are left out, for the run waits for nobody. Of pictures only
the size is told.

  followspot echo track.tracks
  followspot echo color/cam0 -n 3
  followspot echo infrared --run glowballs --json
"""


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands dashboard, top, echo."""
    return [
        Command("dashboard", DASHBOARD, _configure_dashboard, _dashboard),
        Command("top", TOP, _configure_top, _top),
        Command("echo", ECHO, _configure_echo, _echo),
    ]


@hookimpl
def followspot_plan_options() -> Sequence[PlanOptions]:
    """--dashboard and what belongs to it."""
    return [PlanOptions(configure, checked, watched)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Options of run, check and graph."""
    group = parser.add_argument_group("operator's page")
    group.add_argument(
        "--dashboard", action="store_true", help=f"show the run in a browser, at http://{HOST}:{PORT}/"
    )
    _add_address(group)


def checked(plan: Plan, args: argparse.Namespace) -> Plan:
    """The plan as it is. Raises InputError where a page is asked for that cannot be."""
    if _asked(args):
        from followspot_page.asked import order_of

        order_of(args)
    return plan


@contextmanager
def watched(args: argparse.Namespace) -> Iterator[None]:
    """The page while the run lasts, where it is asked for. Raises FollowspotError."""
    if not _asked(args):
        yield
        return
    from followspot_page.asked import order_of
    from followspot_page.showing import shown

    with shown(order_of(args)) as page:
        print(f"the page is at {page.url}", file=sys.stderr, flush=True)
        yield


def _configure_dashboard(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", nargs="?", metavar="GRAPH", help=_RUN)
    _add_address(parser)


def _configure_top(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", nargs="?", metavar="GRAPH", help=_RUN)
    parser.add_argument("--json", action="store_true", help="print one JSON object and end")
    parser.add_argument(
        "--every", type=float, default=1.0, metavar="S", help="seconds between two tables (default 1)"
    )
    add_network_options(parser)


def _configure_echo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", metavar="STAGE[.PORT]", help="which port; of all cameras where none is named")
    parser.add_argument("--run", metavar="GRAPH", help=_RUN)
    parser.add_argument("-n", dest="number", type=_count, default=0, metavar="N", help="end after N messages")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")


def _dashboard(args: argparse.Namespace) -> int:
    from followspot_page.asked import order_of
    from followspot_page.runs import run_here
    from followspot_page.showing import shown

    with shown(order_of(args, run_here(args.run).pid)) as page:
        print(f"the page is at {page.url}", file=sys.stderr, flush=True)
        try:
            return page.wait()
        except KeyboardInterrupt:
            return 0


def _top(args: argparse.Namespace) -> int:
    from followspot_page.top import top

    return top(args)


def _echo(args: argparse.Namespace) -> int:
    from followspot_page.echo import echo

    return echo(args)


def _count(text: str) -> int:
    """A number of messages. Raises argparse.ArgumentTypeError."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return number


def _add_address(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    parser.add_argument(
        "--dashboard-at", metavar="HOST:PORT", help="show it there instead; port 0 for any that is free"
    )
    parser.add_argument(
        "--dashboard-rate", type=float, default=10.0, metavar="N", help="pictures a second (default 10)"
    )
    parser.add_argument(
        "--dashboard-open",
        action="store_true",
        help="let other computers look, without a password: whoever reaches the address sees the cameras",
    )


def _asked(args: argparse.Namespace) -> bool:
    return getattr(args, "dashboard", False) or getattr(args, "dashboard_at", None) is not None
