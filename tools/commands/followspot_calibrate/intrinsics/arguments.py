"""Arguments of `followspot calibrate intrinsics`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file; is updated, or created")
    add("--board", required=True, help="the board, for example chessboard:9x6:0.025")
    add("--videos", type=Path, metavar="DIR", help="folder with a video or folder of pictures per camera")
    add("--clip", action="append", default=[], metavar="CAMERA=PATH", help="recording of one camera")
    add("--live", action="store_true", help="from the cameras' live sources; Ctrl-C ends one camera")
    add("--device", action="append", default=[], metavar="CAMERA=DEVICE", help="live, a number or path")
    add("--size", default="1280x720", metavar="WxH", help="of a device's pictures (default: 1280x720)")
    only = "only these cameras; repeatable"
    add("--camera", nargs="+", action="extend", default=[], metavar="NAME", help=only)
    add("--model", choices=("pinhole", "fisheye"), default="pinhole", help="of the lens (default: pinhole)")
    add("--pictures", type=int, default=300, metavar="N", help="most pictures to search (default: 300)")
    add_output_options(parser, "intrinsics")


def run(args: argparse.Namespace) -> int:
    """Calibrate lenses from views of a chessboard or ChArUco board and write them into the room file.

    Pictures come from DIR/<camera>.mp4 (any video) or folders DIR/<camera> of pictures, from --clip
    CAMERA=PATH, or live: from the cameras' sources in the room file (--live), or from a device (--device
    CAMERA=0), which becomes the camera's source. The command creates the room file if there
    is none. It replaces matrix, distortion, model and size of these cameras and nothing else.

    Boards: chessboard:9x6:0.025 (inner corners, square in m), charuco:4x5:0.054:DICT_4X4_1000 (squares);
    charuco:4x5:0.054/0.04:DICT_4X4_1000 gives the side of the markers too, :inverted is white on black.

    Examples:
      followspot calibrate intrinsics --room room.yaml --videos boards --board charuco:5x7:0.04:DICT_5X5_100
      followspot calibrate intrinsics --room room.yaml --clip cam0=pictures --board chessboard:9x6:0.025
      followspot calibrate intrinsics --room room.yaml --device cam0=0 --board chessboard:9x6:0.025
    """
    from followspot_calibrate.intrinsics.command import calibrate_intrinsics

    return calibrate_intrinsics(args)


COMMAND = Command("intrinsics", configure, run, parent="calibrate")
