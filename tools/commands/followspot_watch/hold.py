"""`followspot pause`, `resume` and `step`: hold a replay, and let it go on by capture times."""

from __future__ import annotations

import argparse

from followspot.cli.wait_notice import run_with_notices
from followspot.frame_times import to_seconds


def pause(args: argparse.Namespace) -> int:
    """Pause the run that is meant."""
    with run_with_notices(args) as run:
        run.pause()
        print(f"{run.label} is paused; followspot step and followspot resume let it go on")
    return 0


def resume(args: argparse.Namespace) -> int:
    """Let the run that is meant go on."""
    with run_with_notices(args) as run:
        run.resume()
        print(f"{run.label} goes on")
    return 0


def step(args: argparse.Namespace) -> int:
    """Let the run that is meant go on for some capture times."""
    with run_with_notices(args) as run:
        reached = run.step(args.number, source=args.source)
        print(f"{run.label} is paused at the capture time {to_seconds(reached):.6f} s")
    return 0
