"""Arguments of `followspot calibrate wand`."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    evidence = parser.add_mutually_exclusive_group(required=True)
    evidence.add_argument("--points", type=Path, help="file of points as the cameras saw them")
    evidence.add_argument(
        "--clips", type=Path, metavar="DIR", help="synchronised recordings, DIR/<camera>.mkv"
    )
    add("--targets", type=Path, metavar="DIR", help="clips of single targets, DIR/<target>/<camera>.mkv, too")
    add("--room", type=Path, help="room file with the cameras; is updated without -o")
    add("-o", "--output", type=Path, metavar="ROOM", help="room file to write; an old file is refused")
    add("--intrinsics", choices=("known", "free", "auto"), default="auto", help="default: auto")
    add("--length", type=float, metavar="M", help="distance of the wand's two bulbs, m")
    add(
        "--align",
        choices=("auto", "centers", "marker", "none"),
        default="auto",
        help="source of the frame of reference (default: the one available)",
    )
    add("--centers", type=Path, metavar="CSV", help="known centres: camera,x,y,z (m)")
    add("--marker", type=Path, metavar="CSV", help="known points: x,y,z,camera,u,v (m, px)")
    add("--size", metavar="WxH", help="of all pictures, px, if no file has it")
    add("--confidence", type=float, default=0.5, help="keypoints below it count as not seen (default: 0.5)")
    add("--frames", type=frame_range, metavar="A-B", help="use only these, as 0-349 or 350- (default: all)")
    add("--fps", type=float, help="frames a second, to report clock offsets in ms")
    add(
        "--clock-offsets",
        action="store_true",
        help="write clock_offset of all cameras into the room file; needs --fps",
    )
    add_output_options(parser, "wand")


def frame_range(text: str) -> tuple[int, int | None]:
    """First and last frame; no last one means all the rest. Raises argparse.ArgumentTypeError."""
    found = re.fullmatch(r"(\d{1,15})-(\d{1,15})?", text)
    if found is None or (found[2] is not None and int(found[2]) < int(found[1])):
        raise argparse.ArgumentTypeError(f"{text} are no frames; write 0-349 or 350-")
    return int(found[1]), None if found[2] is None else int(found[2])


def run(args: argparse.Namespace) -> int:
    """Find poses and intrinsics of all cameras from one bright point waved through the room.

    Points come from a CSV file frame,camera,u,v (camera: name or number; a column point tells the two bulbs
    of a wand apart, 0 and 1), a folder with points.dat, IdMat.dat and Res.dat (Svoboda et al. 2005), an NPZ
    file of keypoints with confidence, or recordings of a bulb in the dark room. Wave everywhere, near to and
    far from every camera, in the view of three at a time. --targets adds the synchronised clips of
    `calibrate targets`: few points, but far more exact ones.

    Intrinsics: known keeps those of the room, free finds them from the points, auto keeps those of the room
    unless others fit the points clearly better. The frame of reference: --centers camera,x,y,z, by default
    the centres in the room file; or --marker x,y,z,camera,u,v, three or more points with known places;
    --length sets the scale by a wand of two bulbs. New cameras become kind: color; edit the room file if one
    is infrared.

    The command finds cameras that are not synchronised by the motion and corrects for it; --clock-offsets
    writes the offsets into the room file. It names mirrored, exchanged and moved cameras; --frames leaves out
    the frames before a move.

    Examples:
      followspot calibrate wand --points wand.csv --room room.yaml
      followspot calibrate wand --points wand.csv --targets templates --room room.yaml
      followspot calibrate wand --clips recordings --room room.yaml
      followspot calibrate wand --points wand.csv --size 640x480 --length 0.5 -o room.yaml --json
      followspot calibrate wand --points wand.csv --room room.yaml --frames 350- --fps 60 --clock-offsets
    """
    from followspot_calibrate.wand.command import calibrate_wand

    return calibrate_wand(args)


COMMAND = Command("wand", configure, run, parent="calibrate")
