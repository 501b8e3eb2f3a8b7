"""`followspot check`: report every mistake at once, and start nothing."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace

from followspot.cli.graph_options import add_graph_options, plan_of
from followspot.errors import MOST_SHOWN, InputError, Mistake, Place, shown, warning_lines
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    add_graph_options(parser)
    parser.add_argument(
        "--strict",
        action="store_true",
        help="refuse causes of different results in two runs: live sources and edges that depend on timing, "
        "stages that go on after errors, random numbers without a seed, lossy codecs",
    )
    parser.add_argument("--json", action="store_true", help="print the mistakes as one JSON object")


def _run(args: argparse.Namespace) -> int:
    """Find every mistake in a graph, its room and its placement; start nothing.

    Stages and targets that can never give a result (a stage without a reader, a target without a template)
    are warnings.

    Examples:
      followspot check graphs/glowballs.yaml --room rooms/studio.yaml
      followspot check graphs/glowballs.yaml --strict       is the result reproducible?
    """
    try:
        plan = plan_of(args, strict=args.strict)
    except InputError as error:
        if not args.json:
            raise
        first = [_mistake(mistake) for mistake in error.mistakes[:MOST_SHOWN]]
        found = {"ok": False, "mistakes": first, "more": len(error.mistakes) - len(first)}
        print(json.dumps(found, indent=2))
        return 2
    counts = {"stages": len(plan.stages), "edges": len(plan.edges), "workers": len(plan.workers)}
    if args.json:
        warnings = [_mistake(mistake) for mistake in plan.warnings[:MOST_SHOWN]]
        found = {
            "graph": plan.graph,
            "room": plan.room.name,
            **counts,
            "notes": plan.notes,
            "warnings": warnings,
        }
        print(json.dumps({"ok": True, **found}))
    else:
        from followspot.graph.drawing.text import title

        print(title(plan))
        for note in plan.notes:
            print(f"note: {note}")
        for line in warning_lines(plan.warnings):
            print(line)
    return 0


def _mistake(mistake: Mistake) -> dict[str, object]:
    where = _where(mistake.place) if mistake.place else {}
    return {**where, "text": shown(mistake.text), "remedy": shown(mistake.remedy)}


def _where(place: Place) -> dict[str, object]:
    """The place in JSON types; outer: the places that brought it into the graph."""
    outer = [_where(replace(place, outer=None)) for place in place.outer_places]
    found = {"file": place.file, "line": place.line, "column": place.column}
    return {**found, "outer": outer} if outer else found


COMMAND = Command("check", _configure, _run)
