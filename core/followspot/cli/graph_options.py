"""The options that every command about a graph has."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from followspot.graph.plan import Plan


def add_graph_options(parser: argparse.ArgumentParser) -> None:
    """GRAPH, --room, --placement, --set, --plugin, --edges, --seed."""
    parser.add_argument("graph", metavar="GRAPH", help="graph file, for example graphs/glowballs.yaml")
    parser.add_argument("--room", metavar="FILE", help="room file instead of the graph's own")
    parser.add_argument(
        "--placement",
        metavar="FILE|camera|stage",
        help="which worker runs what: a placement file, or one worker per camera or per stage",
    )
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar="STAGE.KEY=VALUE",
        help="override a parameter, or what a stage uses: --set fuse.uses=balls.mean; repeatable",
    )
    parser.add_argument(
        "--plugin",
        dest="plugin_files",
        action="append",
        default=[],
        metavar="FILE.py",
        help="load the stages of a Python file; repeatable",
    )
    parser.add_argument(
        "--edges",
        choices=("auto", "reference", "ring", "zenoh"),
        default="auto",
        help="force the kind of every edge (default auto: call, ring or Zenoh as near as it can be)",
    )
    parser.add_argument("--seed", type=int, help="seed of all random numbers (default: the graph's, or 0)")


def plan_of(args: argparse.Namespace) -> Plan:
    """Load, expand, check and plan what the options say. Raises InputError with every mistake."""
    from followspot.graph.compile import compile_graph

    return compile_graph(
        args.graph,
        room=args.room,
        placement=args.placement,
        overrides=args.overrides,
        plugin_files=args.plugin_files,
        edges=args.edges,
        seed=args.seed,
    )
