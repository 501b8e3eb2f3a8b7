"""Arguments of `followspot calibrate board`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file with calibrated lenses; is updated")
    add("--board", required=True, help="the board, for example charuco:5x7:0.04:DICT_5X5_100")
    add("--videos", type=Path, metavar="DIR", help="folder with a recording per camera")
    add("--clip", action="append", default=[], metavar="CAMERA=PATH", help="recording of one camera")
    add(
        "--timestamps", type=Path, metavar="CSV", help="frames of equal moments (default: DIR/timestamps.csv)"
    )
    add("--floor", type=int, metavar="FRAME", help="moment at which the board lies on the floor")
    add("--pictures", type=int, default=300, metavar="N", help="most moments to search (default: 300)")
    add_output_options(parser, "board")


def run(args: argparse.Namespace) -> int:
    """Calibrate camera poses from a board that somebody carries through the room.

    The lenses must be known (calibrate intrinsics). Each camera must share views of the board with another
    camera; no view needs to be shared by all. The squares of the board set the scale. Recordings must be
    synchronised: DIR/<camera>.mp4 or folders of pictures with equal numbers for equal moments, or with
    DIR/timestamps.csv (sync_index,cam_id,frame_index,frame_time, as caliscope writes it). The first camera
    keeps its pose. With --floor the board lies on the floor at that moment: its first corner becomes the
    origin, z points up.

    Examples:
      followspot calibrate board --room room.yaml --videos boards --board charuco:5x7:0.04:DICT_5X5_100
      followspot calibrate board --room room.yaml --videos boards --board chessboard:9x6:0.025 --floor 120
    """
    from followspot_calibrate.board.command import calibrate_board

    return calibrate_board(args)


COMMAND = Command("board", configure, run, parent="calibrate")
