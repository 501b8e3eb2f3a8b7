"""The commands `followspot demo` and `followspot graphs`."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from followspot.cli.graph_options import add_plan_options, plan_of
from followspot.cli.run import add_run_options, execute
from followspot.plugins.hooks import Command, hookimpl


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands `demo` and `graphs`."""
    return [Command("demo", _configure_demo, _demo), Command("graphs", _configure_graphs, _graphs)]


def _configure_demo(parser: argparse.ArgumentParser) -> None:
    add_plan_options(parser)
    add_run_options(parser)


def _demo(args: argparse.Namespace) -> int:
    """Track glowing balls in a simulated room: six cameras, three balls, projections that look like balls.

    It is `followspot run` with the graph glowballs, from any folder, and takes the options of run.

    Examples:
      followspot demo
      followspot demo --frames 100 --placement camera
      followspot demo --dashboard --set camera.realtime=true --set camera.frames=0     live, without end
      followspot graphs glowballs                                     get the graph, to change it
    """
    from followspot_graphs.shipped import DEMO, graph_file

    args.graph = str(graph_file(DEMO))
    return execute(plan_of(args), args)


def _configure_graphs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="GRAPH", help="graphs to copy (default: list them)")
    parser.add_argument(
        "--to",
        type=Path,
        default=Path("graphs"),
        metavar="DIR",
        help="folder of the copies (default: graphs)",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _graphs(args: argparse.Namespace) -> int:
    """List the graphs that come with followspot, or copy some with their rooms, to run and change them.

    A file that exists is never replaced.

    Examples:
      followspot graphs
      followspot graphs glowballs                        graphs/glowballs.yaml and its room
      followspot run graphs/glowballs.yaml
      followspot graphs show building --to my_show
    """
    from followspot_graphs.copying import copy_graphs
    from followspot_graphs.shipped import shipped_graphs

    if args.names:
        new = [str(path) for path in copy_graphs(args.names, args.to)]
        print(json.dumps({"copied": new}) if args.json else "\n".join(new) or "they are there already")
        return 0
    graphs = shipped_graphs()
    if args.json:
        print(json.dumps({"graphs": [asdict(graph) for graph in graphs]}))
        return 0
    width = max(len(graph.name) for graph in graphs)
    for graph in graphs:
        print(f"{graph.name:{width}}  {graph.title}{'' if graph.room else ' Needs --room.'}")
    return 0
