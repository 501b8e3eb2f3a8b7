"""Arguments of `followspot calibrate refine`."""

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
    add("--room", type=Path, required=True, help="room file; is updated")
    add(
        "--run",
        type=Path,
        metavar="DIR",
        help="a run's output with tracks.csv and blobs.csv (sinks.csv) instead of tracking now",
    )
    add(
        "--clips",
        type=Path,
        metavar="DIR",
        help="also use the clips DIR/TARGET/CAMERA.mkv of `calibrate targets`, if they are synchronised",
    )
    add("--graph", default=GRAPH, help=f"graph that tracks, with a stage sinks.csv (default: {GRAPH})")
    add("--frames", type=frame_count, metavar="N", help="track the first N frames only")
    add("--dry-run", action="store_true", help="show what would change, write no room")
    add_output_options(parser, "refine")


def run(args: argparse.Namespace) -> int:
    """Correct cameras that are slightly off with the targets of a tracking run.

    The command tracks the room's own recording (or reads a run that wrote its blobs: --run), and adjusts
    centres, directions and lenses of all cameras until they agree about the targets. Some positions are
    kept out of the adjustment: the command writes the new cameras only if they see these positions with a
    smaller error than the old ones do. If the recording has too few positions for this test, the command
    writes the cameras untested and says so. It leaves out clips that contradict the recording.
    Tracks do not determine the frame of reference and the scale: both stay those of the camera centres in
    the room file. Planes keep their places in the pictures. The targets must have been at many places of
    the common view.

    Examples:
      followspot calibrate refine --room room.yaml
      followspot calibrate refine --room room.yaml --clips templates
      followspot calibrate refine --room room.yaml --run runs/monday --dry-run --json
    """
    from followspot_calibrate.refine.command import refine_room

    return refine_room(args)


COMMAND = Command("refine", configure, run, parent="calibrate")
