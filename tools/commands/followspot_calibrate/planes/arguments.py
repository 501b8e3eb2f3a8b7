"""Arguments of `followspot calibrate planes`."""

from __future__ import annotations

import argparse
from pathlib import Path

from followspot.plugins.hooks import Command
from followspot_calibrate.output import add_output_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    add = parser.add_argument
    add("--room", type=Path, required=True, help="room file; is updated")
    evidence = parser.add_mutually_exclusive_group(required=True)
    evidence.add_argument("--points", type=Path, metavar="CSV", help="file plane,point,camera,u,v")
    evidence.add_argument("--clips", type=Path, metavar="DIR", help="folder with one folder per plane")
    add("--floor", metavar="PLANE", help="the plane that becomes z = 0 of the room")
    add_output_options(parser, "planes")


def run(args: argparse.Namespace) -> int:
    """Fit planes to points on them and write them into the room file.

    Points are real or projected dots that two or more calibrated cameras see: a CSV file with lines
    plane,point,camera,u,v (camera: name or number), or clips CLIPS/<plane>/<camera>.mkv that show one dot
    after the other, the same dot in the same frame of all cameras. Planes without points stay.

    With --floor that plane becomes z = 0, z up: cameras and planes move together. The new x axis is the
    projection of the old one on the floor, the origin is the point of the floor below the old origin.

    Examples:
      followspot calibrate planes --room room.yaml --points plane_points.csv
      followspot calibrate planes --room room.yaml --clips dots --floor ground --json
    """
    from followspot_calibrate.planes.command import calibrate_planes

    return calibrate_planes(args)


COMMAND = Command("planes", configure, run, parent="calibrate")
