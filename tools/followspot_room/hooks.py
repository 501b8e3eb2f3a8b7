"""Joins `followspot room import` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl

HELP = """Make a room file from a calibration and a folder with one video per camera.

The format of the calibration is told by its content. Recordings are named like the cameras: VIDEOS/cam0.mkv
(any video) or a folder VIDEOS/cam0 of pictures; VIDEOS/truth.csv, where it exists, becomes the room's truth.

  followspot room import calibration.json --videos recordings -o room.yaml
"""


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `room import`."""
    return [Command("import", HELP, configure, run, parent="room")]


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("calibration", type=Path, metavar="CALIBRATION", help="file with calibrated cameras")
    parser.add_argument(
        "--videos", type=Path, required=True, metavar="DIR", help="folder with the recordings"
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="ROOM.yaml",
        help="room file to write; replaced if there",
    )
    parser.add_argument(
        "--allow-missing", action="store_true", help="leave cameras without a recording without a source"
    )
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object that says what was imported"
    )


def run(args: argparse.Namespace) -> int:
    """Read, match, write, report."""
    from followspot_room.command import import_room

    return import_room(
        args.calibration, args.videos, args.output, allow_missing=args.allow_missing, as_json=args.json
    )
