"""The command dashboard, and the option --dashboard of run: a page that shows a run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from followspot.cli.agent_options import add_network_options
from followspot.cli.graph_options import add_plugin_option
from followspot.cli.run_option import add_run_option
from followspot.plugins.hooks import Command, PlanOptions, hookimpl
from followspot_page.address import HOST, PORT

if TYPE_CHECKING:
    from followspot.graph.plan import Plan


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command dashboard."""
    return [Command("dashboard", _configure_dashboard, _dashboard)]


@hookimpl
def followspot_plan_options() -> Sequence[PlanOptions]:
    """--dashboard and its options."""
    return [PlanOptions(configure, checked, watched)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add --dashboard and its options to run, check and graph."""
    group = parser.add_argument_group("operator's page")
    group.add_argument(
        "--dashboard", action="store_true", help=f"show the run in a browser, at http://{HOST}:{PORT}/"
    )
    _add_address(group)


def checked(plan: Plan, args: argparse.Namespace) -> Plan:
    """The unchanged plan. Raises InputError if the page cannot be shown with these options."""
    if _asked(args):
        from followspot_page.options import order_of

        order_of(args)
    return plan


@contextmanager
def watched(args: argparse.Namespace) -> Iterator[None]:
    """Show the page during the run, if the options ask for it. Raises FollowspotError."""
    if not _asked(args):
        yield
        return
    from followspot_page.options import order_of
    from followspot_page.page_process import shown

    with shown(order_of(args)) as page:
        print(f"the page is at {page.url}", file=sys.stderr, flush=True)
        yield


def _configure_dashboard(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recording", nargs="?", metavar="FILE.mcap", help="a recording instead of a run")
    add_run_option(parser)
    _add_address(parser)
    add_plugin_option(parser, "load a Python file with stages that agents have loaded; repeatable")
    add_network_options(parser)


def _dashboard(args: argparse.Namespace) -> int:
    """Show a run in a browser until it ends, as run --dashboard does.

    The page shows the room in 3D, the pictures of all cameras with detections, and the graph with the state,
    rates and ledger of each stage. Ctrl-C ends the page, and the run goes on. A run that was left to its
    agents (--detach) has a page, too. A recording is shown in the same way, and its page goes to any moment.

    Examples:
      followspot dashboard
      followspot dashboard show.mcap
      followspot dashboard --run glowballs --dashboard-at 127.0.0.1:9000
      followspot dashboard --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_page.options import order_of_run
    from followspot_page.page_process import shown

    with shown(order_of_run(args)) as page:
        print(f"the page is at {page.url}", file=sys.stderr, flush=True)
        try:
            return page.wait()
        except KeyboardInterrupt:
            return 0


def _add_address(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    parser.add_argument(
        "--dashboard-at", metavar="HOST:PORT", help="address of the page; port 0 means any free port"
    )
    parser.add_argument(
        "--dashboard-rate", type=float, default=10.0, metavar="N", help="pictures a second (default 10)"
    )
    parser.add_argument(
        "--dashboard-open",
        action="store_true",
        help="let every host that reaches the address open the page, without a password",
    )


def _asked(args: argparse.Namespace) -> bool:
    return getattr(args, "dashboard", False) or getattr(args, "dashboard_at", None) is not None
