"""`followspot mark`: save the last seconds of a run."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from followspot.cli.wait_notice import run_with_notices
from followspot.library.keep_options import seconds_of


def mark_command(args: argparse.Namespace) -> int:
    """Mark, wait for the file and name it. Returns the exit code."""
    after = 0.0 if args.after.strip() in ("0", "0s") else seconds_of(args.after, "--after")
    with run_with_notices(args) as run:
        moment = run.mark(after=after, note=args.note, wait=True)
    if args.json:
        print(json.dumps(asdict(moment)))
    else:
        print(f"{moment.file}: {moment.seconds:.1f} s, {moment.messages} messages, {moment.lost} missing")
    return 0
