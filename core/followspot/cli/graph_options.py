"""Options of every command that plans a graph."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.errors import FollowspotError
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.plugins.loaded_hooks import load_plan_options

if TYPE_CHECKING:
    from followspot.graph.check import CheckedGraph
    from followspot.graph.plan import Plan


def add_graph_options(parser: argparse.ArgumentParser) -> None:
    """Add GRAPH, and the options of `add_plan_options`."""
    parser.add_argument("graph", metavar="GRAPH", help="graph file, for example graphs/glowballs.yaml")
    add_plan_options(parser)


def add_plan_options(parser: argparse.ArgumentParser) -> None:
    """Add --room, --placement, --set, --plugin, --edges, --seed, and the plan options of plugins."""
    parser.add_argument("--room", metavar="FILE", help="room file instead of the graph's own")
    add_cameras_option(parser, "cameras of the room that take part (default: all)")
    parser.add_argument(
        "--placement",
        metavar="FILE|camera|stage|auto:REPORT",
        help="which worker runs which stage: a placement file; one worker per camera or per stage; or"
        " auto:REPORT, the fastest workers for the work that the report (--json) of an earlier run has"
        " measured (auto-latency:REPORT: those with the least latency)",
    )
    parser.add_argument(
        "--edges",
        choices=("auto", "reference", "ring", "zenoh"),
        default="auto",
        help="force the kind of every edge (default: auto, the fastest kind that works)",
    )
    add_change_options(parser)
    for options in load_plan_options():
        options.configure(parser)


def add_cameras_option(parser: argparse.ArgumentParser, meaning: str) -> None:
    """Add --cameras. meaning: its help in this command."""
    parser.add_argument("--cameras", type=_names, default=(), metavar="NAME,...", help=meaning)


def add_plugin_option(
    parser: argparse.ArgumentParser, meaning: str = "load the stages of a Python file; repeatable"
) -> None:
    """Add --plugin. meaning: its help in this command."""
    parser.add_argument(
        "--plugin", dest="plugin_files", action="append", default=[], metavar="FILE.py", help=meaning
    )


def add_change_options(
    parser: argparse.ArgumentParser,
    value: str = "VALUE",
    meaning: str = "override a parameter, or the plugin of a stage: --set fuse.uses=balls.mean; repeatable",
) -> None:
    """Add --set, --plugin and --seed. value, meaning: metavar and help of --set."""
    parser.add_argument(
        "--set",
        dest="overrides",
        action="append",
        default=[],
        metavar=f"STAGE.KEY={value}",
        help=meaning,
    )
    add_plugin_option(parser)
    parser.add_argument(
        "--seed",
        type=seed_number,
        metavar="N",
        help="seed of all random numbers (default: the graph's, or 0)",
    )


def plan_of(args: argparse.Namespace, *, strict: bool = False) -> Plan:
    """Load, expand, check and plan the graph that the options describe. Raises InputError with every mistake.

    strict: whether causes of different results in two runs are mistakes.
    """
    from followspot.graph.compile import compile_graph

    with printed_to_stderr(getattr(args, "json", False)):  # the modules of stages may print
        plan = compile_graph(
            args.graph,
            room=args.room,
            cameras=args.cameras,
            placement=args.placement,
            overrides=args.overrides,
            plugin_files=args.plugin_files,
            edges=args.edges,
            seed=args.seed,
            strict=strict,
        )
        for options in load_plan_options():
            plan = options.change(plan, args)
    return plan


def checked_of(args: argparse.Namespace) -> CheckedGraph:
    """The checked graph that the options describe, with places in its files; see `plan_of`."""
    from followspot.graph.compile import checked_graph

    return checked_graph(
        args.graph,
        room=args.room,
        cameras=args.cameras,
        placement=args.placement,
        overrides=args.overrides,
        plugin_files=args.plugin_files,
    )[0]


def frame_count(text: str) -> int:
    """Parse --frames. Raises argparse.ArgumentTypeError."""
    from followspot.valid_values.numbers import MAX_EXACT

    return _whole(text, 1, MAX_EXACT)


def _names(text: str) -> tuple[str, ...]:
    if not (names := tuple(name for name in map(str.strip, text.split(",")) if name)):
        raise argparse.ArgumentTypeError("name at least one camera")
    return names


def seed_number(text: str) -> int:
    """Parse --seed. Raises argparse.ArgumentTypeError."""
    from followspot.graph.plan import MAX_SEED

    return _whole(text, 0, MAX_SEED)


def _whole(text: str, least: int, most: int) -> int:
    try:
        number = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number") from None
    if not least <= number <= most:
        raise argparse.ArgumentTypeError(f"from {least} to {most}")
    return number


def output_folder(asked: str | None, name: str) -> Path:
    """Make the folder `asked`, or one named after the graph and the time. Raises FollowspotError."""
    out = Path(asked) if asked else Path("runs") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FollowspotError(
            f"cannot make the output folder {out}: {error.strerror}; choose one with --out"
        ) from error
    return out
