"""Output of all calibrations: their options, and the printing of the result."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path


def add_output_options(parser: argparse.ArgumentParser, command: str) -> None:
    """--report and --json."""
    parser.add_argument(
        "--report", type=Path, metavar="FILE.html", help=f"page to look at (default: ROOM.{command}.html)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def print_result(
    args: argparse.Namespace,
    as_json: str,
    text: str,
    report: Path,
    warnings: Sequence[str] = (),
    room_file: Path | None = None,
) -> None:
    """Print warnings, then the result as JSON, or as text with the files that were written."""
    for warning in warnings:
        print(f"warning: {warning}", file=sys.stderr)
    written = "" if room_file is None else f"written to {room_file}; "
    print(as_json if args.json else f"{text}\n{written}the page to look at: {report}")
