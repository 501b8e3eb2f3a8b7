"""Joins `followspot train` to the command line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The command `train hog`."""
    return [Command("hog", configure, run, parent="train")]


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("folders", nargs="+", type=Path, metavar="PICTURES", help="folder to learn from")
    parser.add_argument(
        "-o", "--out", type=Path, required=True, metavar="FILE.npz", help="weights file to write"
    )
    parser.add_argument("--seed", type=int, default=0, help="of all that is random (default: 0)")
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object")


def run(args: argparse.Namespace) -> int:
    """Train the detector of upper bodies, persons.hog.

    Each folder holds boxes.csv with crops of people whose body, room and headings are named, and neg_ROOM
    pictures without people; or pos/ and neg/ as the INRIA Person data set has them. The figures are of people
    and places that the model of a trial never saw (four trials); the weights that are written learnt from
    all. On the machine of its making it takes about ten minutes and 2 GB of memory.

    Examples:
      followspot train hog data/persons-dev/hog data/person-crops-inria -o hog_weights.npz
      followspot run graphs/person_room.yaml --set hog.weights=hog_weights.npz
    """
    from followspot_train.command import train_hog

    return train_hog(args)
