"""`followspot agent`: stand on a host, start and supervise workers for operators elsewhere."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.host.operator_timeout import OPERATOR_TIMEOUT
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--name", required=True, help="of this host, as rooms and placements know it")
    parser.add_argument("--media", metavar="DIR", help="folder with the files that cameras here may read")
    parser.add_argument(
        "--send-to",
        action="append",
        default=[],
        metavar="HOST",
        help="let operators have stages here send to this host or multicast group, as sinks.osc does, "
        "beside this one; repeatable; any: to every one",
    )
    parser.add_argument(
        "--open",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="let operators have stages here open this device or stream and those below, for example "
        "/dev/v4l or rtsp://192.168.0.9, beside cameras by number; repeatable; any: every one",
    )
    parser.add_argument(
        "--runs", metavar="DIR", default="runs", help="folder for the outputs of stages here (default: runs)"
    )
    parser.add_argument(
        "--plugin", dest="plugin_files", action="append", default=[], metavar="FILE.py", help="load a file"
    )
    parser.add_argument(
        "--clock-offset",
        type=float,
        default=0.0,
        metavar="MS",
        help="add this to the times of cameras here: for a clock that is known to be so much behind, in ms",
    )
    parser.add_argument(
        "--operator-timeout",
        type=_seconds,
        default=OPERATOR_TIMEOUT,
        metavar="S",
        help="end a run here after so many seconds without a word of its operator, whose cable may be out "
        f"(default: {OPERATOR_TIMEOUT:g})",
    )
    add_network_options(parser, listens=True)


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0 < seconds < float("inf"):
        raise ValueError(text)
    return seconds


def _run(args: argparse.Namespace) -> int:
    """Stand on this host, to run the workers that operators elsewhere place here

    Examples:
      followspot agent --name pc-left                                          reached from this host alone
      followspot agent --name pc-left --listen tls/192.168.0.7:7450 --certificates certs --media recordings
      followspot agent --name pc-left --discover --certificates certs   found by those who discover, too

    It runs installed plugins only, reads and writes files only below --media and --runs, and sends and opens
    only what --send-to and --open allow.
    """
    from followspot.host.agent import Agent, AgentOptions
    from followspot.security.grants import Grants
    from followspot.security.rejected_peers import RejectedPeers
    from followspot.transport.zenoh.network import AGENT, everywhere

    network = network_of(args, everywhere(args.certificates) if args.discover else AGENT, ())
    options = AgentOptions(
        args.name,
        network,
        Grants(Path(args.media) if args.media else None, tuple(args.send_to), tuple(args.open)),
        Path(args.runs),
        tuple(str(Path(file).absolute()) for file in args.plugin_files),
        round(args.clock_offset * 1e6),
        args.operator_timeout,
    )
    with RejectedPeers(_tell):
        agent = Agent(options, _tell)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: agent.stop())
        _tell(f"agent {args.name} listens on {', '.join(agent.locators) or network.router}")
        agent.serve()
    return 0


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


COMMAND = Command("agent", _configure, _run)
