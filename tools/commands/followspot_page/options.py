"""The options of the page, checked."""

from __future__ import annotations

import argparse
import importlib.util
import os
from dataclasses import replace
from pathlib import Path

from followspot.cli.agent_options import network_of
from followspot.errors import InputError
from followspot.library.handle import connected_run
from followspot_page.address import HOST, PORT, is_loopback, read_address
from followspot_page.bundle import check_bundle
from followspot_page.page_process import PageOrder

NEEDED = ("starlette", "uvicorn", "websockets")
MAX_RATE = 60.0


def order_of(args: argparse.Namespace, pid: int | None = None) -> PageOrder:
    """The page that the options describe. Raises InputError if it cannot be shown.

    pid: of the operator's process whose run is shown; this one unless given.
    """
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        raise InputError.of(f"the page needs {', '.join(missing)}", 'pip install "followspot[dashboard]"')
    check_bundle()
    if not 0 < args.dashboard_rate <= MAX_RATE:
        text = f"--dashboard-rate: {args.dashboard_rate:g} pictures a second cannot be"
        raise InputError.of(text, f"more than 0, at most {MAX_RATE:g}")
    host, port = (
        (HOST, PORT) if args.dashboard_at is None else read_address("--dashboard-at", args.dashboard_at)
    )
    if not (is_loopback(host) or args.dashboard_open):
        text = f"--dashboard-at: other hosts reach {host}, and the page has no password"
        raise InputError.of(text, "say --dashboard-open if everyone there may see the cameras")
    firm = args.dashboard_at is not None
    return PageOrder(os.getpid() if pid is None else pid, host, port, firm, args.dashboard_rate)


def order_of_run(args: argparse.Namespace) -> PageOrder:
    """The page of a recording, or of a run that goes on, here or under agents. Raises FollowspotError."""
    if args.recording is not None:
        if not args.recording.endswith(".mcap"):
            text = f"{args.recording} is no recording FILE.mcap"
            raise InputError.of(text, f"name a run with --run {args.recording}")
        files = tuple(str(Path(file).absolute()) for file in args.plugin_files)
        return replace(order_of(args, 0), recording=str(Path(args.recording).absolute()), plugin_files=files)
    network = network_of(args)
    with connected_run(args.run, network) as run:
        order = order_of(args, run.pid or 0)
        if run.pid is not None:
            return order
        return replace(order, run=run.run, network=network, plugin_files=tuple(args.plugin_files))
