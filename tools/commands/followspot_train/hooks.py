"""The command `followspot train`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands `train hog` and `train whole`."""
    return [
        Command("hog", configure, run, parent="train"),
        Command("whole", configure_whole, run_whole, parent="train"),
    ]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `train hog`."""
    _configure_both(parser)
    parser.add_argument(
        "--above",
        action="store_true",
        help="learn windows that reach above the picture",
    )
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object")


def configure_whole(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `train whole`."""
    _configure_both(parser)
    parser.add_argument(
        "--weights",
        type=Path,
        metavar="FILE.npz",
        help="weights of persons.hog whose proposals are learnt from (default: those that it ships with)",
    )


def _configure_both(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", nargs="+", type=Path, metavar="PICTURES", help="folder to learn from")
    parser.add_argument(
        "-o", "--out", type=Path, required=True, metavar="FILE.npz", help="weights file to write"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of all random numbers (default: 0)")


def run(args: argparse.Namespace) -> int:
    """Train the detector of upper bodies, persons.hog.

    A folder holds boxes.csv, with crops of people and their body, room and headings, and neg_ROOM, with
    pictures without people; or pos/ and neg/ as in the INRIA Person data set. The printed figures come from
    four trials, each with people and places that its model never saw. The written weights are trained on
    all pictures.

    Examples:
      followspot train hog data/persons-dev/hog data/person-crops-inria -o hog_weights.npz
      followspot run graphs/person_room.yaml --set hog.weights=hog_weights.npz
    """
    from followspot_train.command import train_hog

    return train_hog(args)


def run_whole(args: argparse.Namespace) -> int:
    """Train the weights by which persons.hog knows whole people.

    Folders are as for `train hog`; pictures of people count if they have room for legs. Takes a few minutes.

    Examples:
      followspot train whole data/persons-dev/hog data/person-crops-inria -o whole.npz
      followspot run graphs/person_room.yaml --set hog.weights_whole=whole.npz
    """
    from followspot_train.whole import train_whole

    return train_whole(args)
