"""`followspot graph`: show the planned graph as text, Mermaid or SVG."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from followspot.cli.graph_options import add_graph_options, checked_of, plan_of
from followspot.errors import writing
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    add_graph_options(parser)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--mermaid", action="store_true", help="print a Mermaid flow chart")
    form.add_argument("--svg", type=Path, metavar="FILE", help="write an SVG picture")
    form.add_argument("--flat", action="store_true", help="print it as one file without sub-graphs")
    form.add_argument("--origin", action="store_true", help="print where each stage and value is written")
    parser.add_argument("--unfold", action="store_true", help="show the stages of sub-graphs one by one")
    form.add_argument(
        "--parameters",
        action="store_true",
        help="print each parameter that differs from its default",
    )
    form.add_argument("--json", action="store_true", help="print the plan as JSON")


def _run(args: argparse.Namespace) -> int:
    """Show the planned graph: stages, workers, hosts, and the kind of each edge.

    Examples:
      followspot graph graphs/glowballs.yaml --placement camera
      followspot graph graphs/glowballs.yaml --svg glowballs.svg
      followspot graph graphs/show.yaml --flat > flat.yaml     without sub-graphs and overlays
      followspot graph graphs/show.yaml --origin               which file says what
      followspot graph graphs/show.yaml --parameters           what graph, room and --set change
    """
    from followspot.graph.compose.flat import flat_text
    from followspot.graph.compose.origin import origin_text
    from followspot.graph.drawing.svg import svg
    from followspot.graph.drawing.text import mermaid, text
    from followspot.graph.load import composed_graph
    from followspot.graph.parameter_origin import given_text
    from followspot.graph.plan_data import plan_to_data

    if args.parameters:
        print(given_text(checked_of(args)), end="")
        return 0
    plan = plan_of(args)
    if args.svg:
        with writing(args.svg):
            args.svg.write_text(svg(plan, fold=not args.unfold), encoding="utf-8")
    elif args.json:
        print(json.dumps(plan_to_data(plan)))
    elif args.flat or args.origin:
        composed = composed_graph(args.graph, room=args.room, cameras=args.cameras, overrides=args.overrides)
        print(origin_text(composed) if args.origin else flat_text(composed, plan, args.room), end="")
        if args.flat and args.cameras:
            chosen = ",".join(args.cameras)
            print(f"note: a graph file chooses no cameras: run it with --cameras {chosen}", file=sys.stderr)
    else:
        shown = mermaid if args.mermaid else text
        print(shown(plan, fold=not args.unfold))
    return 0


COMMAND = Command("graph", _configure, _run)
