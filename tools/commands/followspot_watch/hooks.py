"""The commands that watch and hold runs from a terminal."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from followspot.cli.agent_options import add_network_options
from followspot.cli.graph_options import add_plugin_option
from followspot.cli.run_option import add_run_option
from followspot.plugins.hooks import Command, hookimpl
from followspot_watch.run_commands import RUN_COMMANDS


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands of this package."""
    return [
        Command("top", _configure_top, _top),
        Command("hz", _configure_hz, _hz),
        Command("echo", _configure_echo, _echo),
        Command("logs", _configure_logs, _logs),
        Command("pause", _configure_hold, _pause),
        Command("resume", _configure_hold, _resume),
        Command("step", _configure_step, _step),
        *RUN_COMMANDS,
    ]


def _configure_top(parser: argparse.ArgumentParser) -> None:
    add_run_option(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, and exit")
    parser.add_argument(
        "--every", type=_seconds, default=1.0, metavar="S", help="seconds between two tables (default 1)"
    )
    add_network_options(parser)


def _configure_hold(parser: argparse.ArgumentParser) -> None:
    add_run_option(parser)
    add_network_options(parser)


def _configure_step(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "number", nargs="?", type=_count, default=1, metavar="N", help="capture times (default 1)"
    )
    parser.add_argument(
        "--source", metavar="STAGE", help="source whose capture times count (default: first camera)"
    )
    add_run_option(parser)
    add_network_options(parser)


def _configure_hz(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", nargs="?", metavar="STAGE[.PORT]", help="which port (default: all)")
    parser.add_argument(
        "--seconds", type=_seconds, default=5.0, metavar="S", help="length of the measurement (default 5)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON list, and exit")
    _add_run(parser)


def _configure_echo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "port", metavar="STAGE[.PORT]", help="which port; a stage without a camera means all its cameras"
    )
    parser.add_argument(
        "-n", dest="number", type=_count, default=0, metavar="N", help="exit after N messages"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")
    _add_run(parser)


def _add_run(parser: argparse.ArgumentParser) -> None:
    """Add --run, --plugin and the network options."""
    add_run_option(parser)
    add_plugin_option(parser, "load a Python file with stages that agents have loaded; repeatable")
    add_network_options(parser)


def _configure_logs(parser: argparse.ArgumentParser) -> None:
    add_run_option(parser, or_folder=True)
    parser.add_argument(
        "-f", "--follow", action="store_true", help="print new records until the run ends, or Ctrl-C"
    )
    parser.add_argument(
        "--level",
        choices=("info", "warning", "error"),
        default="info",
        help="the lowest level to print (default info)",
    )
    parser.add_argument(
        "--stage", metavar="STAGE", help="records of this stage only; STAGE means all its cameras"
    )
    parser.add_argument("--worker", metavar="NAME", help="records of this worker only")
    parser.add_argument("--host", metavar="NAME", help="records of this host only")
    parser.add_argument("--json", action="store_true", help="print one JSON object per line")
    add_network_options(parser)


def _top(args: argparse.Namespace) -> int:
    """Show each stage and edge of a run: state, the edge it waits for, rate, ledger, latency, errors.

    On a terminal the report renews itself until the run ends or Ctrl-C. In a pipe, and with --json, the
    command prints it once.

    Examples:
      followspot top
      followspot top --run glowballs --json
      followspot top --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.top import top

    return top(args)


def _hz(args: argparse.Namespace) -> int:
    """Measure how regularly the ports of a run send: rate, gaps, and messages lost on their edges.

    The run measures at the port, so the network to this host has no influence. On a terminal the table renews
    itself until the run ends or Ctrl-C. In a pipe, and with --json, the command prints it once.

    Examples:
      followspot hz
      followspot hz color --run glowballs --seconds 10
      followspot hz track.tracks --json
      followspot hz camera --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.hz import hz

    return hz(args)


def _echo(args: argparse.Namespace) -> int:
    """Print the messages of a port of a run.

    The run never waits for this command: it skips messages if they come faster than they can be printed. Of a
    picture it prints only the size.

    Examples:
      followspot echo track.tracks
      followspot echo color/cam0 -n 3
      followspot echo infrared --run glowballs --json
      followspot echo color --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.echo import echo

    return echo(args)


def _logs(args: argparse.Namespace) -> int:
    """Print the log of a run: records of stages and libraries on all hosts, and of workers that died.

    Name a run that goes on, or the output folder of a run that has ended. `followspot run` prints warnings
    and errors, too; the log has all records. A stage writes records with self.log and self.context.warn.

    Examples:
      followspot logs
      followspot logs --run glowballs -f --level warning
      followspot logs --run runs/glowballs-20261121-180000 --stage color --json
      followspot logs --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.logs import logs

    return logs(args)


def _pause(args: argparse.Namespace) -> int:
    """Pause a replay: its sources send nothing until it is resumed or stepped.

    Stages process the messages that were sent already. The outputs of the run are the same as without pauses.
    Live runs cannot be paused.

    Examples:
      followspot pause
      followspot pause --run glowballs --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.hold import pause

    return pause(args)


def _resume(args: argparse.Namespace) -> int:
    """Resume a paused replay.

    Examples:
      followspot resume
    """
    from followspot_watch.hold import resume

    return resume(args)


def _step(args: argparse.Namespace) -> int:
    """Let a paused replay go on for the next N capture times of one source, then pause it again.

    Every other source sends until it has reached the last of these times.

    Examples:
      followspot step
      followspot step 5 --source camera/cam0
    """
    from followspot_watch.hold import step

    return step(args)


def _seconds(text: str) -> float:
    """Parse a length of time, s. Raises argparse.ArgumentTypeError."""
    seconds = float(text)
    if not 0.1 <= seconds <= 3600:
        raise argparse.ArgumentTypeError("from 0.1 to 3600")
    return seconds


def _count(text: str) -> int:
    """Parse a number of messages. Raises argparse.ArgumentTypeError."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return number
