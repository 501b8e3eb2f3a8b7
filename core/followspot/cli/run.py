"""`followspot run`: check, plan and run a graph; then report accuracy, latency and the ledger."""

from __future__ import annotations

import argparse
import json
import math
import sys
from contextlib import ExitStack, closing
from pathlib import Path
from typing import TYPE_CHECKING

from followspot.cli.agent_options import add_network_options, network_of
from followspot.cli.graph_options import add_graph_options, frame_count, output_folder, plan_of
from followspot.errors import FollowspotError, warning_lines
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.plugins.hooks import Command
from followspot.plugins.loaded_hooks import load_plan_options

_SOON = 1.0
"""Seconds that scoring may take after the user has stopped a run."""

if TYPE_CHECKING:
    from followspot.graph.plan import Plan
    from followspot.library.execute import RunReport
    from followspot.scoring import Score
    from followspot.transport.zenoh.network import Network


def _configure(parser: argparse.ArgumentParser) -> None:
    add_graph_options(parser)
    add_run_options(parser)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add --out, --frames, --json, --restart, --detach, --host, --media, the network."""
    parser.add_argument("--out", metavar="DIR", help="folder for outputs (default: runs/GRAPH-DATE-TIME)")
    parser.add_argument(
        "--frames",
        type=frame_count,
        metavar="N",
        help="stop after N frames of each camera; sensors end with the last of them",
    )
    parser.add_argument("--json", action="store_true", help="end with one JSON object instead of tables")
    parser.add_argument(
        "--restart",
        action="store_true",
        help="restart workers that die in a replay, too, as live runs do",
    )
    parser.add_argument(
        "--detach", action="store_true", help="leave the run to its agents once it has begun; see attach"
    )
    parser.add_argument(
        "--host",
        metavar="NAME",
        help="host of the workers that have none in the placement (default: this host)",
    )
    parser.add_argument(
        "--media",
        metavar="DIR",
        help="local folder whose files agents have below their --media (default: that of the room file)",
    )
    add_network_options(parser, listens=True)


def _run(args: argparse.Namespace) -> int:
    """Check, plan and run a graph; then report accuracy (if the truth is known), latency and the ledger.

    Cameras with a host in the room file run on that host, under `followspot agent`. A stage writes its
    outputs on its own host. Ctrl-C stops the sources; the run finishes the messages in flight, and all
    outputs are complete.

    Examples:
      followspot run graphs/glowballs.yaml
      followspot run graphs/glowballs.yaml --room room.yaml --placement camera
      followspot run graphs/glowballs.yaml --set fuse.uses=balls.mean --set color.similarity=0.9
      followspot run graphs/glowballs.yaml --room room.yaml --placement camera --connect tls/pc-left:7450
      followspot run graphs/glowballs.yaml --listen tcp/127.0.0.1:7460     any Zenoh client can subscribe
    """
    return execute(plan_of(args), args)


def execute(plan: Plan, args: argparse.Namespace) -> int:
    """Run a plan with the given options and print the summary. Returns the exit code."""
    from followspot.library.execute import replaced_outputs
    from followspot.library.report import Report

    plan = with_default_host(plan, args.host)
    network = network_of(args)
    _print_notes(plan, args)
    if args.detach:
        return _detach(plan, args, network)
    out = output_folder(args.out, plan.graph)
    if old := replaced_outputs(plan, out):
        print(
            f"warning: an earlier run left {', '.join(old)} in {out}; this one replaces it", file=sys.stderr
        )
    with printed_to_stderr(args.json):
        report = _watched_run(plan, args, network, out)
        whole = Report(report, out, _scores(report, out, quiet=args.quiet))
    if args.json:
        print(json.dumps(whole.to_json()))
    else:
        print(f"{whole}\n\noutputs: {out}")
        for host, folder in report.outs.items():
            print(f"outputs on {host}: {folder}")
    return 0 if report.ok else 1


def _watched_run(plan: Plan, args: argparse.Namespace, network: Network, out: Path) -> RunReport:
    """Run a plan to its end; meanwhile the terminal shows its progress and log, and plugins watch it."""
    from followspot.cli.progress import ProgressBar
    from followspot.cli.run_log import ShownLog
    from followspot.library.execute import RunOptions, run_plan

    with closing(ProgressBar()) as bar, ExitStack() as watchers:
        if network.certificates:
            from followspot.security.rejected_peers import RejectedPeers

            watchers.enter_context(RejectedPeers(bar.say))
        for options in load_plan_options():
            watchers.enter_context(options.watch(args))
        return run_plan(
            plan,
            RunOptions(out, args.frames),
            None if args.quiet else bar.show,
            network=network,
            media=media_folder(plan, args.media),
            restart=args.restart,
            on_log=ShownLog(out, bar.say, verbose=args.verbose).take,
        )


def _print_notes(plan: Plan, args: argparse.Namespace) -> None:
    """Print the warnings of a plan and, unless --quiet, its notes."""
    from followspot.library.execute import unused_agents

    if not args.quiet:
        for note in (*plan.notes, *unused_agents(plan, args.connect or ())):
            print(f"note: {note}", file=sys.stderr)
    for line in warning_lines(plan.warnings):
        print(line, file=sys.stderr)


def _scores(report: RunReport, out: Path, *, quiet: bool) -> dict[str, Score]:
    """Scores of a run that has ended, none if that fails or the user does not wait for them."""
    from followspot.library.execute import run_scores

    if report.stopped and not report.frames:
        return {}
    if report.stopped and report.plan.room.truth is not None and not quiet:
        state = "outputs are complete" if report.ok else "the run failed"
        what = f"scoring {report.frames} frames, Ctrl-C leaves that out"
        print(f"followspot: {state}; {what}", file=sys.stderr)
    try:
        return run_scores(report.plan, out, report.frames, _SOON if report.stopped else math.inf)
    except FollowspotError as error:
        print(f"followspot: cannot score the run: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("followspot: the run is not scored", file=sys.stderr)
    return {}


def _detach(plan: Plan, args: argparse.Namespace, network: Network) -> int:
    from followspot.library.attach import detach
    from followspot.library.execute import RunOptions

    run = detach(plan, RunOptions(frames=args.frames), network, media_folder(plan, args.media))
    print(
        json.dumps({"run": run})
        if args.json
        else f"run {run[:8]} goes on; followspot attach --run {plan.graph}"
    )
    return 0


def with_default_host(plan: Plan, host: str | None) -> Plan:
    """The plan, with `host` for workers that have no host; None changes nothing."""
    if host is None:
        return plan
    from followspot.graph.arrange import on_host

    return on_host(plan, host)


def media_folder(plan: Plan, asked: str | None) -> Path:
    """The folder `asked`, or that of the room file."""
    folders = [carrier.source.folder for carrier in plan.room.carriers if carrier.source]
    return Path(asked or next(iter(folders), "."))


COMMAND = Command("run", _configure, _run)
