"""The commands record, replay, verify, export and mark, and the options --record and --keep of run."""

from __future__ import annotations

import argparse
import importlib.util
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from followspot.cli.graph_options import (
    add_cameras_option,
    add_change_options,
    add_graph_options,
    add_plugin_option,
)
from followspot.cli.run import add_run_options
from followspot.errors import InputError
from followspot.plugins.hooks import Command, Keeper, PlanOptions, RecordingReader, hookimpl
from followspot.plugins.loaded_hooks import load_plan_options
from followspot_record.flight.options import checked, configure_keeping, configure_mark, kept

if TYPE_CHECKING:
    from followspot.graph.plan import Plan


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands of this package."""
    return [
        Command("record", configure_record, record),
        Command("replay", configure_replay, replay),
        Command("verify", configure_verify, verify),
        Command("export", configure_export, export),
        Command("mark", configure_mark, mark),
    ]


@hookimpl
def followspot_recording_readers() -> Sequence[RecordingReader]:
    """MCAP files."""
    return [RecordingReader(".mcap", _open)]


def _open(path: Path) -> Any:
    from followspot_record.recorded import RecordedRun

    return RecordedRun(path)


@hookimpl
def followspot_plan_options() -> Sequence[PlanOptions]:
    """--record, --keep and their options."""
    return [PlanOptions(configure_recording, recorded), PlanOptions(configure_keeping, checked, kept)]


@hookimpl
def followspot_keepers() -> Sequence[Keeper]:
    """The flight recorder."""
    return [Keeper(_check_keep, _keep)]


def _check_keep(plan: Any, keep: Any) -> None:
    from followspot_record.flight.keep_request import check

    check(plan, keep)


def _keep(plan: Any, keep: Any, run: str) -> AbstractContextManager[Any]:
    from followspot_record.flight.keep_request import kept_run

    return kept_run(keep, run)


def configure_recording(parser: argparse.ArgumentParser) -> None:
    """Add --record and its options to run, record, check and graph."""
    group = parser.add_argument_group("recording")
    group.add_argument("--record", metavar="FILE.mcap", help="record ports into this new file")
    group.add_argument("--record-ports", metavar="STAGE[.PORT],...", help="ports to record (default: all)")
    group.add_argument(
        "--record-pictures",
        choices=("jpeg", "png", "raw", "none"),
        default="jpeg",
        help="format of an extra copy of frames for viewers (default jpeg)",
    )
    group.add_argument(
        "--record-compression",
        choices=("lz4", "zstd", "none"),
        default="zstd",
        help="zstd is small, lz4 takes twice the bytes (default zstd)",
    )


def configure_record(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of run."""
    add_graph_options(parser)
    add_run_options(parser)


def configure_replay(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("recording", metavar="FILE.mcap", help="the recording")
    parser.add_argument("--graph", metavar="GRAPH", help="another graph file instead of the recorded graph")
    parser.add_argument("--room", metavar="FILE", help="room file for --graph")
    add_cameras_option(parser, "cameras of the room that take part in --graph (default: all)")
    parser.add_argument(
        "--ports", metavar="STAGE[.PORT],...", help="recorded ports to play, besides the sources"
    )
    parser.add_argument(
        "--speed",
        type=float,
        default=0.0,
        metavar="X",
        help="speed relative to the recording; 0 for the highest",
    )
    parser.add_argument(
        "--from",
        dest="start",
        type=float,
        default=0.0,
        metavar="S",
        help="begin S seconds after the start of the recording",
    )
    parser.add_argument(
        "--to", dest="stop", type=float, metavar="S", help="end S seconds after the start of the recording"
    )
    parser.add_argument("--loop", action="store_true", help="start again at the end, until Ctrl-C")
    add_change_options(parser)
    for options in load_plan_options():
        options.configure(parser)
    add_run_options(parser)


def configure_verify(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("recording", metavar="FILE.mcap", help="the recording")
    add_plugin_option(parser, "load the stages of a Python file that the recorded run had loaded; repeatable")
    parser.add_argument(
        "--up-to-damage",
        action="store_true",
        help="end with 0 although the file is damaged, if all that can be read is the same",
    )
    parser.add_argument("--json", action="store_true", help="end with one JSON object")


def configure_export(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("recording", metavar="FILE.mcap", help="the recording")
    parser.add_argument("folder", metavar="DIR", help="folder of the files; created if it is missing")
    parser.add_argument("--to", choices=("csv", "jsonl", "parquet", "rerun"), required=True, help="format")
    parser.add_argument("--ports", metavar="STAGE[.PORT],...", help="which ports (default: all but pictures)")
    parser.add_argument("--json", action="store_true", help="end with one JSON object")


def recorded(plan: Plan, args: argparse.Namespace) -> Plan:
    """The plan, with recording sinks if --record is given. Raises InputError."""
    if args.record is None:
        return plan
    _need_mcap()
    from followspot_record.record import recorded_as_asked

    return recorded_as_asked(plan, args)


def _need_mcap() -> None:
    """Raises InputError if mcap is not installed."""
    if importlib.util.find_spec("mcap") is None:
        raise InputError.of("recordings need mcap", 'pip install "followspot[recording]"')


def record(args: argparse.Namespace) -> int:
    """Run a graph and record its ports into one file, as run --record does.

    Examples:
      followspot record graphs/glowballs.yaml --record show.mcap
      followspot record graphs/glowballs.yaml --record show.mcap --record-ports camera,track
    """
    from followspot_record.record import record_command

    return record_command(args)


def replay(args: argparse.Namespace) -> int:
    """Run a recorded graph, or another one, on the ports of a recording.

    The run plays the recorded sources (the cameras) and the ports that --ports names, and computes every
    other stage that it needs. The summary and the outputs are those of a run.

    Examples:
      followspot replay show.mcap
      followspot replay show.mcap --graph graphs/glowballs.yaml --set fuse.uses=balls.mean
      followspot replay show.mcap --ports color,infrared --from 10 --to 20
      followspot replay show.mcap --speed 1 --loop --dashboard
    """
    _need_mcap()
    from followspot_record.replay import replay_command

    return replay_command(args)


def verify(args: argparse.Namespace) -> int:
    """Run a recorded graph again on its recorded sources and compare every recorded port, byte for byte.

    The exit code is 0 if the file is whole and all ports are equal, else 1; the command names the damage and
    the first difference.

    Examples:
      followspot verify show.mcap
      followspot verify show.mcap --up-to-damage     of a recorder that was killed
    """
    _need_mcap()
    from followspot_record.verify import verify_command

    return verify_command(args)


def export(args: argparse.Namespace) -> int:
    """Write each port of a recording to a file: a table, lines of JSON, or a file for the Rerun viewer.

    --to parquet needs pyarrow, --to rerun needs rerun-sdk.

    Examples:
      followspot export show.mcap --to csv tables
      followspot export show.mcap --to parquet tables
      followspot export show.mcap --to rerun views
      followspot export show.mcap --to jsonl lines --ports track.tracks
    """
    _need_mcap()
    from followspot_record.export import export_command

    return export_command(args)


def mark(args: argparse.Namespace) -> int:
    """Save the last seconds of a run that was started with --keep, and the next few, as a recording.

    Marks whose times overlap share a file. The run goes on; a full disk ends the file, not the run.

    Examples:
      followspot mark
      followspot mark --run glowballs --after 10s --note "blue jumped"
    """
    from followspot_record.flight.mark_command import mark_command

    return mark_command(args)
