"""The commands save and runs, as the command line offers them; they import little."""

from __future__ import annotations

import argparse

from followspot.cli.agent_options import add_network_options
from followspot.cli.run_option import add_run_option
from followspot.plugins.hooks import Command


def _configure_save(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="NAME.yaml", help="the new graph file")
    add_run_option(parser)


def _configure_runs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    add_network_options(parser)


def _save(args: argparse.Namespace) -> int:
    """Save the changes to a run of this machine as an overlay: a graph file that extends the run's own.

    The new file says only what `followspot set`, `swap`, `--set` and the page have changed. The graph file of
    the run stays as it is, and nothing of it is copied.

    Examples:
      followspot save show.yaml
      followspot save show.yaml --run glowballs
    """
    from followspot_watch.save import save

    return save(args)


def _runs(args: argparse.Namespace) -> int:
    """List runs: yours on this machine, and those under agents.

    Each has the word that names it in other commands, its graph, hosts, owner, frames, age and output folder.

    Examples:
      followspot runs
      followspot runs --connect tls/pc-left:7450 --certificates certs --json
    """
    from followspot_watch.runs import runs

    return runs(args)


RUN_COMMANDS = (Command("save", _configure_save, _save), Command("runs", _configure_runs, _runs))
