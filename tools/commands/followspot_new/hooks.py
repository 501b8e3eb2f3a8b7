"""The commands `followspot new plugin` and `followspot new stage`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands `new plugin` and `new stage`."""
    return [
        Command("plugin", _configure_plugin, _plugin, parent="new"),
        Command("stage", _configure_stage, _stage, parent="new"),
    ]


def _configure_plugin(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="one lower-case word; stages are called NAME.STAGE")
    parser.add_argument(
        "--dir",
        type=Path,
        default=Path(),
        metavar="DIR",
        help="parent of the new folder (default: this folder)",
    )


def _configure_stage(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", metavar="NAME", help="lower-case words joined by _")
    parser.add_argument(
        "--dir", type=Path, default=Path(), metavar="DIR", help="folder of the package (default: this folder)"
    )
    parser.add_argument(
        "--takes", action="append", default=[], metavar="TYPE", help="type of an input, as Blobs; repeatable"
    )
    parser.add_argument("--gives", metavar="TYPE", help="type of the output; without --takes, of a source")


def _plugin(args: argparse.Namespace) -> int:
    """Make a package for your own stages, with tests that pass.

    Examples:
      followspot new plugin studio              a folder followspot-studio, with one stage to change
      cd followspot-studio
      pip install -e '.[dev]'
      pytest
      followspot plugins studio.low
    """
    from followspot_new.package import new_plugin

    folder = new_plugin(args.name, args.dir)
    print(f"{folder} is a plugin; next:\n\n  cd {folder}\n  pip install -e '.[dev]'\n  pytest")
    return 0


def _stage(args: argparse.Namespace) -> int:
    """Add a stage to the plugin package in this folder: module, entry point and test.

    Examples:
      cd followspot-studio
      followspot new stage shout                a stage studio.shout in followspot_studio/shout.py
      followspot new stage small --takes Blobs --gives Blobs
      followspot new stage lift --takes Boxes --takes Points2D --gives Skeletons
      followspot new stage radar --gives Positions                 a source
    """
    from followspot_new.package import new_stage

    module, stage = new_stage(args.name, args.dir, args.takes, args.gives)
    print(f"{module} holds the stage {stage}; next:\n\n  pip install -e '.[dev]'\n  pytest")
    return 0
