"""Options of commands that run a graph many times: `followspot compare` and `sweep`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.cli.graph_options import frame_count
from followspot.errors import InputError, Mistake
from followspot.operating_system.standard_output import printed_to_stderr

if TYPE_CHECKING:
    from followspot.graph.plan import Plan


def add_trial_options(parser: argparse.ArgumentParser, out: str) -> None:
    """Add --room, --frames, --out and --json. out: help of --out."""
    parser.add_argument(
        "--room",
        dest="rooms",
        action="append",
        default=[],
        metavar="FILE",
        help="room file instead of the graph's own; repeatable: every run is made in every room",
    )
    parser.add_argument(
        "--frames",
        type=frame_count,
        metavar="N",
        help="stop after N frames of each camera; sensors end with the last of them",
    )
    parser.add_argument("-o", "--out", metavar="DIR", help=out)
    parser.add_argument("--json", action="store_true", help="end with one JSON object instead of tables")


def trial_plan(
    graph: str,
    room: str | None,
    overrides: Sequence[str],
    args: argparse.Namespace,
    mistakes: list[Mistake],
) -> Plan | None:
    """The plan of one run. If it has mistakes, add them to `mistakes` and return None."""
    from followspot.graph.compile import compile_graph

    try:
        with printed_to_stderr(args.json):  # the modules of stages may print
            return compile_graph(
                graph, room=room, overrides=overrides, plugin_files=args.plugin_files, seed=args.seed
            )
    except InputError as error:
        mistakes += error.mistakes
        return None


def check_rooms(rooms: Sequence[str]) -> list[Mistake]:
    """Mistakes for rooms with the same name, which a table could not distinguish."""
    names = [Path(room).stem for room in rooms]
    twice = dict.fromkeys(name for name in names if names.count(name) > 1)
    return [Mistake(None, f'several rooms are named "{name}"', "rename a file") for name in twice]
