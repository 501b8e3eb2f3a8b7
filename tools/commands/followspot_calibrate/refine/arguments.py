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
    parser.add_argument("--room", type=Path, required=True, help="room file; is updated")
    parser.add_argument(
        "--run",
        type=Path,
        metavar="DIR",
        help="a run's output with tracks.csv and blobs.csv (sinks.csv_blobs) instead of tracking now",
    )
    parser.add_argument(
        "--clips",
        type=Path,
        metavar="DIR",
        help="the clips DIR/TARGET/CAMERA.mkv that `calibrate targets` learns from, where they are "
        "synchronised: more places, and better ones",
    )
    parser.add_argument(
        "--graph", default=GRAPH, help=f"graph that tracks, with a stage sinks.csv (default: {GRAPH})"
    )
    parser.add_argument("--frames", type=frame_count, metavar="N", help="track the first N frames only")
    parser.add_argument("--dry-run", action="store_true", help="show what would change, write no room")
    add_output_options(parser, "refine")


def run(args: argparse.Namespace) -> int:
    """Correct cameras that are slightly off, by what an ordinary tracking run saw.

    Tracks the room's own recording (or takes a run that wrote down its blobs: --run), and adjusts places,
    directions and lenses of all cameras until they agree about the targets. Where the cameras stand together,
    and how far they are apart, no tracker can see: that stays as the camera centres of the room file say.
    Planes move with what the cameras see. Targets must have been carried through the common view, at many
    places.

    Examples:
      followspot calibrate refine --room room.yaml
      followspot calibrate refine --room room.yaml --clips templates
      followspot calibrate refine --room room.yaml --run runs/monday --dry-run --json
    """
    from followspot_calibrate.refine.command import refine_room

    return refine_room(args)


COMMAND = Command("refine", configure, run, parent="calibrate")
