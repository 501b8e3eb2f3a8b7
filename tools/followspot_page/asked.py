"""What the options of the page ask for, checked."""

from __future__ import annotations

import argparse
import importlib.util

from followspot.errors import InputError, Mistake
from followspot.graph.plan import Plan
from followspot_page.access import is_loopback
from followspot_page.hooks import HOST, PORT
from followspot_page.showing import Address, folder
from followspot_page.taps import with_taps

NEEDED = ("starlette", "uvicorn", "websockets")
MAX_RATE = 60.0


def tapped_as_asked(plan: Plan, args: argparse.Namespace) -> Plan:
    """The plan with taps for the page. Raises InputError where it cannot be shown as asked."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        remedy = 'pip install "followspot[dashboard]"'
        raise InputError([Mistake(None, f"the page needs {', '.join(missing)}", remedy)])
    if not 0 < args.dashboard_rate <= MAX_RATE:
        text = f"--dashboard-rate: {args.dashboard_rate:g} pictures a second cannot be"
        raise InputError([Mistake(None, text, f"more than 0, at most {MAX_RATE:g}")])
    where = address(args)
    if not (is_loopback(where.host) or args.dashboard_open):
        text = f"--dashboard-at: other computers reach {where.host}, and the page asks nobody for a password"
        remedy = "say --dashboard-open if whoever reaches that address may see the cameras"
        raise InputError([Mistake(None, text, remedy)])
    return with_taps(plan, folder(), args.dashboard_rate)


def address(args: argparse.Namespace) -> Address:
    """Where the page is to be served. Raises InputError."""
    if args.dashboard_at is None:
        return Address(HOST, PORT, firm=False)
    host, colon, port = args.dashboard_at.rpartition(":")
    host = host.strip("[]")
    if not (colon and host and port.isdecimal() and int(port) < 1 << 16):
        text = f"--dashboard-at: {args.dashboard_at!r} is no HOST:PORT"
        raise InputError([Mistake(None, text, f"for example {HOST}:{PORT}, or 0.0.0.0:{PORT}")])
    return Address(host, int(port), firm=True)
