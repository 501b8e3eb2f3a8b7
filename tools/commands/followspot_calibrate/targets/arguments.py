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
    parser.add_argument("--room", type=Path, required=True, help="room file; is updated")
    parser.add_argument("--clips", type=Path, required=True, help="folder with one folder per target")
    parser.add_argument(
        "--radius",
        type=float,
        help=f"radius of the targets, m; else as in the room file, else {RADIUS} (a 6-inch ball)",
    )
    parser.add_argument(
        "--keep-cameras",
        action="store_true",
        help="cameras and planes stay, also where they are slightly off",
    )
    add_output_options(parser, "targets")


def run(args: argparse.Namespace) -> int:
    """Learn the targets' templates from clips and write them into the room file.

    Each target moves through the dark room in a clip of its own, and people may carry it: CLIPS/<target>/
    <camera>.mkv, any video or a folder of pictures. What glows is learnt, not what is lit: the brightest
    compact spot that is alike in all frames. Colour cameras learn hue and size, infrared cameras grey level
    and size. Targets that the room has already and that have no clips stay as they are.

    All cameras see a target at once: where they contradict each other about it, for they are slightly off,
    cameras and planes are corrected as `calibrate refine` does, in the frame of reference of the given ones.

    The table at the end says how well the colours are told apart; two targets that look alike are warned
    about.

    Examples:
      followspot calibrate targets --room room.yaml --clips templates
      followspot calibrate targets --room room.yaml --clips templates --radius 0.05 --json
    """
    from followspot_calibrate.targets.command import calibrate_targets

    return calibrate_targets(args, RADIUS)


COMMAND = Command("targets", configure, run, parent="calibrate")
