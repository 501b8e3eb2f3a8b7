"""Joins `followspot cameras` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `cameras`."""
    return [Command("cameras", configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    output = "room file that gets an entry for each camera it lacks; a new file is made"
    add("-o", "--output", type=Path, metavar="ROOM.yaml", help=output)
    add("--backend", choices=("any", "viva-genicam", "aravis"), default="any", help="program that searches")
    add(
        "--interface", default="", metavar="ADDRESS", help="own address that faces the cameras (default: all)"
    )
    add("--timeout", type=_seconds, default=1.0, metavar="S", help="time for answers (default: 1)")
    add("--json", action="store_true", help="print one JSON object")


def _seconds(text: str) -> float:
    """Parse a length of time, s. Raises argparse.ArgumentTypeError."""
    seconds = float(text)
    if not 0.001 <= seconds <= 3600:
        raise argparse.ArgumentTypeError("from 0.001 to 3600")
    return seconds


def run(args: argparse.Namespace) -> int:
    """List the GigE Vision and USB3 Vision cameras in sight, and write them into a room file.

    The list has serial number, name, address, size, pixel format, rate and clock of each camera: "readable"
    means that capture times are by the camera's own clock, and PTP shows its state if the camera takes part.
    With -o a room file gets the cameras that it lacks, with their sources; they stand at the origin with a
    lens of 60 degrees until they are calibrated. The exit code is 1 if no camera is in sight.

    Examples:
      followspot cameras
      followspot cameras --interface 192.168.0.2 -o studio.yaml
    """
    from followspot.errors import InputError

    try:
        from followspot_cameras.genicam.listing import cameras
    except ModuleNotFoundError as error:
        if error.name != "viva_genicam":
            raise
        raise InputError.of(
            "no program that speaks to cameras is installed", "pip install 'followspot[genicam]'"
        ) from None
    return cameras(args.backend, args.interface, args.timeout, args.output, as_json=args.json)
