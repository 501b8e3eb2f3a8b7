"""Joins looking at runs from a terminal to the command line: the commands top, hz, echo, logs."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from followspot.cli.agent_options import add_network_options
from followspot.cli.graph_options import add_plugin_option
from followspot.plugins.hooks import Command, hookimpl
from followspot_watch.run_option import RUN


@hookimpl
def followspot_commands() -> Sequence[Command]:
    """The commands top, hz, echo, logs."""
    return [
        Command("top", _configure_top, _top),
        Command("hz", _configure_hz, _hz),
        Command("echo", _configure_echo, _echo),
        Command("logs", _configure_logs, _logs),
    ]


def _configure_top(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", nargs="?", metavar="RUN", help=RUN)
    parser.add_argument("--json", action="store_true", help="print one JSON object and end")
    parser.add_argument(
        "--every", type=float, default=1.0, metavar="S", help="seconds between two tables (default 1)"
    )
    add_network_options(parser)


def _configure_hz(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", nargs="?", metavar="STAGE[.PORT]", help="which port (default: all)")
    parser.add_argument(
        "--seconds", type=_seconds, default=5.0, metavar="S", help="how long to look back (default 5)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON list and end")
    _add_run(parser)


def _configure_echo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("port", metavar="STAGE[.PORT]", help="which port; of all cameras where none is named")
    parser.add_argument("-n", dest="number", type=_count, default=0, metavar="N", help="end after N messages")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")
    _add_run(parser)


def _add_run(parser: argparse.ArgumentParser) -> None:
    """Which run, where, and what must be known to understand its messages."""
    parser.add_argument("--run", metavar="RUN", help=RUN)
    add_plugin_option(parser, "know the stages of a Python file that agents were given; repeatable")
    add_network_options(parser)


def _configure_logs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("run", nargs="?", metavar="RUN|DIR", help=f"{RUN}; or an output folder")
    parser.add_argument("-f", "--follow", action="store_true", help="go on until the run ends, or Ctrl-C")
    parser.add_argument(
        "--level", choices=("info", "warning", "error"), default="info", help="this and worse (default info)"
    )
    parser.add_argument("--stage", metavar="STAGE", help="of this stage only, of all cameras or STAGE/CAMERA")
    parser.add_argument("--worker", metavar="NAME", help="of this worker only")
    parser.add_argument("--host", metavar="NAME", help="of this host only")
    parser.add_argument("--json", action="store_true", help="one JSON object a line")
    add_network_options(parser)


def _top(args: argparse.Namespace) -> int:
    """What each stage and edge of a run is doing: state, on whom it waits, rate, ledger, latency, errors

    On a terminal it renews itself until the run ends or Ctrl-C; elsewhere, and with --json, it prints once.

    Examples:
      followspot top
      followspot top glowballs --json
      followspot top glowballs --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.top import top

    return top(args)


def _hz(args: argparse.Namespace) -> int:
    """How regularly the ports of a run send: rate, gaps, and what got lost behind them

    Measured where each port is, so that the way here does not count. On a terminal the table renews itself
    until the run ends or Ctrl-C; elsewhere, and with --json, it is printed once after some seconds.

    Examples:
      followspot hz
      followspot hz color --run glowballs --seconds 10
      followspot hz track.tracks --json
      followspot hz camera --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.hz import hz

    return hz(args)


def _echo(args: argparse.Namespace) -> int:
    """Print the messages of a port of a graph that runs

    Messages that come faster than they are printed are left out, for the run waits for nobody. Of pictures
    only the size is told.

    Examples:
      followspot echo track.tracks
      followspot echo color/cam0 -n 3
      followspot echo infrared --run glowballs --json
      followspot echo color --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.echo import echo

    return echo(args)


def _logs(args: argparse.Namespace) -> int:
    """What a run has said: stages and libraries of its workers on all hosts, and what became of them

    Of a run that goes on, under its name, or of one that has ended, in its output folder. What is wrong is
    shown while `followspot run` goes on, too; all of it is here. A stage says something with self.log, and
    warns with self.context.warn.

    Examples:
      followspot logs
      followspot logs glowballs -f --level warning
      followspot logs runs/glowballs-20261121-180000 --stage color --json
      followspot logs glowballs --connect tls/pc-left:7450 --certificates certs
    """
    from followspot_watch.logs import logs

    return logs(args)


def _seconds(text: str) -> float:
    """A length of time, s. Raises argparse.ArgumentTypeError."""
    seconds = float(text)
    if not 0.1 <= seconds <= 3600:
        raise argparse.ArgumentTypeError("from 0.1 to 3600")
    return seconds


def _count(text: str) -> int:
    """A number of messages. Raises argparse.ArgumentTypeError."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return number
