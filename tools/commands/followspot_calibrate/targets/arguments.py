"""Arguments of `followspot calibrate targets`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options

RADIUS = 0.0762
"""Radius of the 6-inch balls of Jin & Qian 2008, m."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file; is updated")
    add("--clips", type=Path, required=True, help="folder with one folder per target")
    add(
        "--radius",
        type=float,
        help=f"radius of the targets, m; else as in the room file, else {RADIUS} (a 6-inch ball)",
    )
    add("--keep-cameras", action="store_true", help="keep cameras and planes, even if they are slightly off")
    add_output_options(parser, "targets")


def run(args: argparse.Namespace) -> int:
    """Learn the targets' templates from clips and write them into the room file.

    Each target moves through the dark room in a clip of its own, and people may carry it: CLIPS/<target>/
    <camera>.mkv, any video or a folder of pictures. The command learns the brightest compact spot that is
    alike in all frames: hue and size in colour cameras, grey level and size in infrared cameras. Targets of
    the room without clips stay as they are.

    All cameras see a target at once. If they contradict each other slightly, the command corrects cameras and
    planes as `calibrate refine` does, and keeps their frame of reference.

    The table at the end shows how well the colours can be told apart, and warns of targets that look alike.

    Examples:
      followspot calibrate targets --room room.yaml --clips templates
      followspot calibrate targets --room room.yaml --clips templates --radius 0.05 --json
    """
    from followspot_calibrate.targets.command import calibrate_targets

    return calibrate_targets(args, RADIUS)


COMMAND = Command("targets", configure, run, parent="calibrate")
