"""Joins `followspot score` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl

HELP = """Score tracks against ground truth, per target.

Coverage, RMSE, median and 95th percentile (mm), identity switches, false positions while hidden, frames
until recovery, jerk cost; with a room also the reprojection error (px). Rows are matched by time.

  followspot score runs/latest/tracks.csv recordings/truth.csv
  followspot score tracks.csv truth.csv --room room.yaml --json
"""


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `score`."""
    return [Command("score", HELP, configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument(
        "tracks", type=Path, metavar="TRACKS.csv", help="tracks as the stage sinks.csv writes them"
    )
    parser.add_argument(
        "truth",
        type=Path,
        metavar="TRUTH.csv",
        help="columns frame, time (s), object, x, y, z (m), hidden, trackable, pair (0 or 1)",
    )
    parser.add_argument("--room", type=Path, help="room file, for the reprojection error")
    parser.add_argument("--json", action="store_true", help="print one JSON object: target -> figures")


def run(args: argparse.Namespace) -> int:
    """Read, score, print."""
    from followspot_score.command import score_files

    print(score_files(args.tracks, args.truth, args.room, as_json=args.json))
    return 0
