"""The option by which every command names the run that it means."""

from __future__ import annotations

import argparse

_RUN = "which run, if several go on: its graph, the beginning of its name, or its process id"


def add_run_option(parser: argparse.ArgumentParser, *, or_folder: bool = False) -> None:
    """Add --run. or_folder: whether the output folder of a run that has ended will do as well."""
    metavar, more = ("RUN|DIR", "; or the output folder of one that has ended") if or_folder else ("RUN", "")
    parser.add_argument("--run", metavar=metavar, help=_RUN + more)
