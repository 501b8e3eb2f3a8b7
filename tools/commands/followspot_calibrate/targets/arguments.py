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
    given = parser.add_mutually_exclusive_group(required=True)
    given.add_argument("--clips", type=Path, help="folder with one folder per target")
    given.add_argument(
        "--pick",
        action="append",
        metavar="NAME[=X,Y[,W,H]][@FRAME]",
        help="a target by a click or a rectangle in a picture of the camera's recording (default: the "
        "middle one); without a place: write that picture, to look at; repeatable",
    )
    add("--camera", metavar="NAME", help="the camera of --pick, if the room has several in colour")
    add(
        "--radius",
        type=float,
        help=f"radius of the targets, m; else as in the room file, else {RADIUS} (a 6-inch ball)",
    )
    add("--keep-cameras", action="store_true", help="keep cameras and planes, even if they are slightly off")
    add_output_options(parser, "targets")


def run(args: argparse.Namespace) -> int:
    """Learn the targets' templates from clips or single pictures, and write them into the room file.

    Each target moves through the dark room in a clip of its own, and people may carry it: CLIPS/<target>/
    <camera>.mkv, any video or a folder of pictures. The command learns the brightest compact spot that is
    alike in all frames: hue and size in colour cameras, grey level and size in infrared cameras. Targets of
    the room without clips stay as they are.

    All cameras see a target at once. If they contradict each other slightly, the command corrects cameras and
    planes as `calibrate refine` does, and keeps their frame of reference.

    The table at the end shows how well the colours can be told apart, and warns of targets that look alike.

    With --pick a target is learnt in a lit room, from one picture of a video: all that has the colour of a
    clicked pixel and touches it, or the ellipse in a rectangle. It is found at half to twice the distance.

    Examples:
      followspot calibrate targets --room room.yaml --pick red
      followspot calibrate targets --room room.yaml --pick red=320,240 --pick blue=410,300,40,40@120
      followspot calibrate targets --room room.yaml --clips templates
      followspot calibrate targets --room room.yaml --clips templates --radius 0.05 --json
    """
    if args.pick:
        from followspot_calibrate.targets.pick_command import pick_targets

        return pick_targets(args, RADIUS)
    from followspot_calibrate.targets.command import calibrate_targets

    return calibrate_targets(args, RADIUS)


COMMAND = Command("targets", configure, run, parent="calibrate")
