"""`followspot agent`: start and supervise workers on this host for operators on other hosts."""

from __future__ import annotations

import argparse
import signal
import sys
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.cli.graph_options import add_plugin_option
from followspot.host.operator_timeout import OPERATOR_TIMEOUT
from followspot.operating_system.ending_signals import ending_signals
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--name", required=True, help="name of this host in rooms and placements")
    _add_grants(parser)
    add_plugin_option(parser)
    parser.add_argument(
        "--clock-offset",
        type=float,
        default=0.0,
        metavar="MS",
        help="milliseconds by which this host's clock is behind; they are added to the times of its cameras",
    )
    parser.add_argument(
        "--operator-timeout",
        type=_seconds,
        default=OPERATOR_TIMEOUT,
        metavar="S",
        help="seconds without a word of its operator after which a run on this host ends "
        f"(default: {OPERATOR_TIMEOUT:g})",
    )
    add_network_options(parser, listens=True)


def _add_grants(parser: argparse.ArgumentParser) -> None:
    """Add the options that say which files, addresses and devices stages on this host may use."""
    parser.add_argument(
        "--media", metavar="DIR", help="folder with the files that cameras on this host may read"
    )
    parser.add_argument(
        "--send-to",
        action="append",
        default=[],
        metavar="HOST",
        help="let stages on this host send to that host or multicast group, too, as sinks.osc does; "
        "repeatable; any: to every address",
    )
    parser.add_argument(
        "--open",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="let stages on this host open this device or stream and those below it, for example "
        "/dev/v4l or rtsp://192.168.0.9, beside cameras by number; repeatable; any: every device",
    )
    parser.add_argument(
        "--runs",
        metavar="DIR",
        default="runs",
        help="folder for the outputs of stages on this host (default: runs)",
    )


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0 < seconds < float("inf"):
        raise ValueError(text)
    return seconds


def _run(args: argparse.Namespace) -> int:
    """Run workers on this host for operators on other hosts.

    The agent runs installed plugins only. It reads files below --media, writes files below --runs, sends to
    addresses that --send-to allows, and opens devices that --open allows.

    Examples:
      followspot agent --name pc-left                                   for operators on this host only
      followspot agent --name pc-left --listen tls/192.168.0.7:7450 --certificates certs --media recordings
      followspot agent --name pc-left --discover --certificates certs   operators find it by --discover
    """
    from followspot.host.agent import Agent
    from followspot.host.agent_options import AgentOptions
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
        for number in ending_signals():
            signal.signal(number, lambda *_: agent.stop())
        _tell(f"agent {args.name} listens on {', '.join(agent.locators) or network.router}")
        agent.serve()
    return 0


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


COMMAND = Command("agent", _configure, _run)
