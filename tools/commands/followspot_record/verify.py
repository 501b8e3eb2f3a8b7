"""`followspot verify`: the recorded graph again on its recorded sources; every port is compared."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from followspot.cli.progress import ProgressBar
from followspot.errors import FollowspotError, InputError
from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan
from followspot.library.execute import RunOptions, run_plan
from followspot.tables import table
from followspot_record.comparison import Compared, compare
from followspot_record.embedded import recorded_plan
from followspot_record.played import Clip, alone, played, replays
from followspot_record.record import Target, with_recording
from followspot_record.replay import check_sampled_cycles, source_ports
from followspot_recording.recording import Recording

_LIVE = "it was recorded live: a message that came too late then comes in time now"


def verify_command(args: argparse.Namespace) -> int:
    """Run again, compare, print. Returns the exit code."""
    with Recording(args.recording) as old:
        old.examine()
        plan = recorded_plan(old, args.plugin_files)
        sources = source_ports(plan)
        missing = [port for port in sources if port not in old.ports]
        if missing:
            remedy = "record it with all ports"
            raise InputError.of(f"the source {', '.join(missing)} was not recorded", remedy)
        plan = played(plan, replays(old, plan, sources), Clip(old.path))
        check_sampled_cycles(plan, "the graph and record it again: what timing decided cannot be verified")
        names = [port for port in output_ports(plan) if port in old.ports and port not in sources]
        with tempfile.TemporaryDirectory(prefix="followspot-verify-") as folder:
            new_path = Path(folder) / "again.mcap"
            target = Target(new_path, {"picture_format": "none"}, {}, {})
            _run(alone(with_recording(plan, names, target)), Path(folder), quiet=args.quiet)
            with Recording(new_path) as new:
                rows = _compare(old, new, names, sources)
        problem, live = old.problem, old.metadata.get("live") == "true"
    same = all(not row.difference for row in rows)
    notes = [problem] * bool(problem) + [_LIVE] * (live and not same)
    print(_json(same, rows, notes) if args.json else _text(same, rows, notes))
    return 0 if same else 1


def _run(plan: Plan, out: Path, *, quiet: bool) -> None:
    """Raises FollowspotError if the run fails."""
    with closing(ProgressBar()) as bar:
        report = run_plan(plan, RunOptions(out), None if quiet or not sys.stderr.isatty() else bar.show)
    if report.stopped:
        raise KeyboardInterrupt
    if not report.ok:
        raise FollowspotError("\n".join(report.errors) or "messages are unaccounted for")


def _compare(old: Recording, new: Recording, names: Sequence[str], sources: Sequence[str]) -> list[Compared]:
    """Compare every port; if the recording ends early, up to the last time that all its sources reach."""
    stop = None
    if old.problem:
        stop = min(max((m.time for m in old.messages(port)), default=-1) for port in sources)
    return [
        compare(
            port,
            old.ports[port],
            old.messages(port, stop=stop),
            new.messages(port, stop=stop),
            whole=not old.problem,
        )
        for port in names
    ]


def _text(same: bool, rows: Sequence[Compared], notes: Sequence[str]) -> str:
    cells = [(row.port, str(row.messages), row.difference or "the same") for row in rows]
    lines = [table(("port", "messages", ""), cells), *notes]
    count = sum(row.messages for row in rows)
    lines.append(
        f"{len(rows)} ports, {count} messages: " + ("the same, byte for byte" if same else "different")
    )
    return "\n".join(lines)


def _json(same: bool, rows: Sequence[Compared], notes: Sequence[str]) -> str:
    found = [{"port": row.port, "messages": row.messages, "difference": row.difference} for row in rows]
    return json.dumps({"same": same, "ports": found, "notes": list(notes)})
