"""`followspot save`: the changes of a run, as an overlay."""

from __future__ import annotations

import argparse

from followspot.library.handle import run_here
from followspot.library.overlay import save_overlay


def save(args: argparse.Namespace) -> int:
    """Save an overlay of the run that is meant."""
    stages = save_overlay(run_here(args.run), args.file)
    print(f"{args.file} changes {', '.join(stages)}; followspot run {args.file} begins so")
    return 0
