"""The command `followspot shape`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `shape`."""
    return [Command("shape", configure, run)]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("what", choices=("fit", "colors"), help="which model to make")
    parser.add_argument("crops", type=Path, metavar="CROPS", help="folder with pictures and boxes.csv")
    parser.add_argument(
        "--shape", type=Path, metavar="FILE", help="colors: shape model (default: the shipped one)"
    )
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file to write")
    parser.add_argument("--json", action="store_true", help="print a JSON object instead of text")


def run(args: argparse.Namespace) -> int:
    """Make the models of pose tracking from crops of upper bodies with known poses.

      fit     the shape model: 19 features of the outline, 45 of the surface
      colors  how the colours of its surface features relate in people (the colour-difference model)

    CROPS is a folder with pictures of one size and a table boxes.csv with the columns file, body,
    torso_heading, head_pan, head_tilt (rad), y0, y1 (rows of head top and waist, px) and neck_u (column of
    the body's axis, px).

    Examples:
      followspot shape fit crops -o shape.yaml
      followspot shape colors crops --shape shape.yaml -o color_relations.yaml

    persons.appearance and persons.pose_tracker take both files; their defaults come with followspot.
    """
    from followspot_shape.command import make

    return make(args)
