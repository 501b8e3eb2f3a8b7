"""Arguments of `followspot calibrate clocks`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.cli.graph_options import add_change_options, frame_count
from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options

GRAPH = "graphs/glowballs.yaml"
ROUNDS = 4
LIMIT = 2.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file; is updated")
    add("--graph", default=GRAPH, help=f"graph that tracks the targets (default: {GRAPH})")
    add("--reference", metavar="CAMERA", help="camera whose offset is 0 (default: the mean)")
    add("--frames", type=frame_count, metavar="N", help="use the first N frames only")
    add("--rounds", type=frame_count, default=ROUNDS, help=f"most runs of the graph (default: {ROUNDS})")
    add(
        "--limit",
        type=float,
        default=LIMIT,
        metavar="MS",
        help=f"largest standard deviation of an offset, ms (default: {LIMIT:g})",
    )
    add("--dry-run", action="store_true", help="show the offsets, write nothing")
    add_output_options(parser, "clocks")
    add_change_options(parser)


def run(args: argparse.Namespace) -> int:
    """Estimate the clock offsets of the cameras, and write them into the room file.

    The command tracks the room's own recording and compares how far each camera sees moving targets ahead of
    or behind the others. Targets must move through the common view, the faster the better: at 2 m/s and 4 m
    from a camera of 320x240, a target moves by 0.1 px a millisecond. Cameras keep their time stamps;
    `balls.verify_pairs` corrects for `clock_offset` when it pairs their blobs.

    The offsets are relative to their mean, or to --reference CAMERA. +- is one standard deviation.

    Examples:
      followspot calibrate clocks --room room.yaml
      followspot calibrate clocks --room room.yaml --reference cam0 --dry-run --json
    """
    from followspot_calibrate.clocks.command import calibrate_clocks

    return calibrate_clocks(args)


COMMAND = Command("clocks", configure, run, parent="calibrate")
