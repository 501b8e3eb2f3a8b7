"""Arguments of `followspot calibrate check`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.cli.graph_options import frame_count
from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options

GRAPH = "graphs/glowballs.yaml"


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file to check")
    add("--points", type=Path, metavar="FILE", help="points as `calibrate wand` reads them")
    add("--length", type=float, metavar="M", help="distance of the wand's points 0 and 1, m; needs --points")
    tracking = parser.add_mutually_exclusive_group()
    tracking.add_argument(
        "--run",
        type=Path,
        metavar="DIR",
        help="a run's output with tracks.csv and blobs.csv (sinks.csv)",
    )
    tracking.add_argument("--track", action="store_true", help="track the room's own recording now")
    add("--graph", default=GRAPH, help=f"graph for --track, with a stage sinks.csv (default: {GRAPH})")
    add("--frames", type=frame_count, metavar="N", help="track the first N frames only")
    add(
        "--against",
        type=Path,
        metavar="OTHER",
        help="room file or calibration in any format of `room import`",
    )
    add(
        "--limit",
        type=float,
        metavar="PX",
        help="largest error of a good camera, px (default: 0.3 %% of the picture's longer side); "
        "with it, differences from OTHER count too",
    )
    add_output_options(parser, "check")


def run(args: argparse.Namespace) -> int:
    """Check how accurate a room file is, and name the cameras that are not.

    The check uses any of these: points of a wand (--points), a tracking run that wrote its blobs (--run, or
    --track to make one now), another calibration of the same cameras (--against). It compares each camera
    with the points that the other cameras see; a camera that does not fit is left out, and the others are
    judged without it. The room file is not changed.

    The exit code is 1 if a camera is beyond the limit, or if a known length is off by more than 1 %.

    Examples:
      followspot calibrate check --room room.yaml --points wand.csv --length 0.5
      followspot calibrate check --room room.yaml --track
      followspot calibrate check --room room.yaml --run runs/monday --json
      followspot calibrate check --room room.yaml --against Calib.qca.txt
    """
    from followspot_calibrate.check.command import check_calibration

    return check_calibration(args)


COMMAND = Command("check", configure, run, parent="calibrate")
