"""`followspot attach`: become the operator of a run under agents again."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from followspot.cli.agent_options import add_network_options, network_of
from followspot.cli.run_option import add_run_option
from followspot.plugins.hooks import Command


def _configure(parser: argparse.ArgumentParser) -> None:
    add_run_option(parser)
    parser.add_argument("--stop", action="store_true", help="end the run; its outputs are complete")
    parser.add_argument("--json", action="store_true", help="end with one JSON object instead of tables")
    add_network_options(parser)


def _run(args: argparse.Namespace) -> int:
    """Become the operator of a run under agents again: show its progress, and its summary at the end.

    Examples:
      followspot run graphs/glowballs.yaml --placement camera --host pc-left --detach
      followspot attach --connect tls/pc-left:7450 --certificates certs
      followspot attach --run glowballs --stop

    Ctrl-C leaves the run to its agents again.
    """
    from followspot.cli.progress import ProgressBar
    from followspot.library.attach import attached_run, interruptible
    from followspot.library.report import Report

    network = network_of(args)
    with attached_run(network, args.run) as attachment:
        run = attachment.found
        print(f"run {run.run[:8]} of {run.graph} on {', '.join(run.hosts)}", file=sys.stderr, flush=True)
        if change := attachment.coordinator.status().unfinished_change:
            print(f"followspot: {change}", file=sys.stderr, flush=True)
        if args.stop:
            attachment.coordinator.stop()
        bar = ProgressBar()
        try:
            report = interruptible(attachment, None if args.quiet else bar.show)
        finally:
            bar.close()
    if attachment.stopped:
        print("the run goes on; come back with followspot attach", file=sys.stderr)
        return 0
    whole = Report(report, Path(), {})
    print(json.dumps(whole.to_json()) if args.json else whole)
    for host, folder in report.outs.items():
        print(f"outputs on {host}: {folder}", file=sys.stderr)
    return 0 if report.ok else 1


COMMAND = Command("attach", _configure, _run)
