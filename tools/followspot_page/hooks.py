"""Joins the operator's page to the command line: run --dashboard."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from followspot.plugins.hooks import PlanOptions, hookimpl

if TYPE_CHECKING:
    from followspot.graph.plan import Plan

HOST, PORT = "127.0.0.1", 8777


@hookimpl
def followspot_plan_options() -> Sequence[PlanOptions]:
    """--dashboard and what belongs to it."""
    return [PlanOptions(configure, tapped, watched)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Options of run, check and graph."""
    group = parser.add_argument_group("operator's page")
    group.add_argument(
        "--dashboard", action="store_true", help=f"show the run in a browser, at http://{HOST}:{PORT}/"
    )
    group.add_argument(
        "--dashboard-at", metavar="HOST:PORT", help="show it there instead; port 0 for any that is free"
    )
    group.add_argument(
        "--dashboard-rate", type=float, default=10.0, metavar="N", help="pictures a second (default 10)"
    )
    group.add_argument(
        "--dashboard-open",
        action="store_true",
        help="let other computers look, without a password: whoever reaches the address sees the cameras",
    )


def tapped(plan: Plan, args: argparse.Namespace) -> Plan:
    """The plan with taps where a page is asked for. Raises InputError."""
    if not _asked(args):
        return plan
    from followspot_page.asked import tapped_as_asked

    return tapped_as_asked(plan, args)


@contextmanager
def watched(plan: Plan, args: argparse.Namespace) -> Iterator[Callable[[Any], None] | None]:
    """The page while the run lasts, where it is asked for. Raises FollowspotError."""
    if not _asked(args):
        yield None
        return
    from followspot_page.asked import address
    from followspot_page.showing import shown

    with shown(plan, address(args)) as (url, tell):
        print(f"the page is at {url}", file=sys.stderr, flush=True)
        yield tell


def _asked(args: argparse.Namespace) -> bool:
    return getattr(args, "dashboard", False) or getattr(args, "dashboard_at", None) is not None
