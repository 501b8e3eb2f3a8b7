"""The command `followspot train`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands `train hog`, `train headings` and `train whole`."""
    return [
        Command("hog", configure, run, parent="train"),
        Command("headings", configure_headings, run_headings, parent="train"),
        Command("whole", configure_whole, run_whole, parent="train"),
    ]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `train hog`."""
    _configure_all(parser)
    _configure_upper(parser)


def configure_headings(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `train headings`."""
    _configure_all(parser)
    _configure_upper(parser)
    _add_weights(parser, "to which the network of headings is added")


def configure_whole(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `train whole`."""
    _configure_all(parser)
    _add_weights(parser, "whose proposals are learnt from")


def _configure_upper(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--above", action="store_true", help="learn windows that reach above the picture")
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON object")


def _add_weights(parser: argparse.ArgumentParser, purpose: str) -> None:
    parser.add_argument(
        "--weights",
        type=Path,
        metavar="FILE.npz",
        help=f"weights of persons.hog {purpose} (default: those that it ships with)",
    )


def _configure_all(parser: argparse.ArgumentParser) -> None:
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


def run_headings(args: argparse.Namespace) -> int:
    """Train the network by which persons.hog tells the directions of torso and head.

    Folders hold boxes.csv, as for `train hog`; people without headings do not count. Writes the given
    weights with a new network of headings in them. The printed figures come from four trials, each with
    people and places that its network never saw. Takes a few minutes.

    Examples:
      followspot train headings data/persons-dev/hog runs/crops -o hog_weights.npz
      followspot run graphs/person_room.yaml --set hog.weights=hog_weights.npz
    """
    from followspot_train.headings import train_headings

    return train_headings(args)


def run_whole(args: argparse.Namespace) -> int:
    """Train the weights by which persons.hog knows whole people.

    Folders are as for `train hog`; pictures of people count if they have room for legs. Takes a few minutes.

    Examples:
      followspot train whole data/persons-dev/hog data/person-crops-inria -o whole.npz
      followspot run graphs/person_room.yaml --set hog.weights_whole=whole.npz
    """
    from followspot_train.whole import train_whole

    return train_whole(args)
