"""`followspot verify`: the recorded graph again on its recorded sources; every port is compared."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from operator import itemgetter
from pathlib import Path

from followspot.cli.progress import ProgressBar
from followspot.errors import FollowspotError, InputError
from followspot.frame_times import to_seconds
from followspot.graph.output_ports import output_ports
from followspot.graph.plan import Plan
from followspot.library.execute import RunOptions, run_plan
from followspot.operating_system.standard_output import printed_to_stderr
from followspot.operating_system.temporary_folder import TemporaryFolder
from followspot.tables.terminal import table
from followspot_record.comparison import Compared, compare
from followspot_record.embedded import recorded_plan
from followspot_record.firings import MOMENT
from followspot_record.flight.repeated import repeated
from followspot_record.record import Target, with_recording
from followspot_record.replay import check_sampled_cycles, source_ports
from followspot_record.replay_plan import Clip, in_one_worker, replay_plan, replay_stages
from followspot_recording.recording import Recording

_LIVE = "it was recorded live: a message that came too late then comes in time now"


def verify_command(args: argparse.Namespace) -> int:
    """Run again, compare, print. Returns the exit code."""
    with (
        printed_to_stderr(args.json),
        Recording(args.recording) as old,
        TemporaryFolder("verify") as folder,
    ):
        old.examine()
        plan = recorded_plan(old, args.plugin_files)
        if old.firings or old.metadata.get(MOMENT) == "true":
            rows, notes = repeated(old, plan, folder.path)
            early = ""
        else:
            rows, early = _run_again(old, plan, folder.path, quiet=args.quiet)
            live = old.metadata.get("live") == "true" and any(row.difference for row in rows)
            notes = [_LIVE] * live
        notes = [note for note in (old.problem, early) if note] + notes
        damage = old.problem
    # a stage that sends more now leaves the same file as a worker that died: neither is a proof of sameness
    equal = not early and not any(row.difference for row in rows) and any(row.messages for row in rows)
    same = equal and (args.up_to_damage or not damage)
    print(_json(same, rows, notes, damage) if args.json else text(equal, rows, notes, damage))
    return 0 if same else 1


def _run_again(old: Recording, plan: Plan, folder: Path, *, quiet: bool) -> tuple[list[Compared], str]:
    """Run the graph on the recorded sources, and compare every other port. Raises FollowspotError.

    Returns the results, and where the recording ends before its sources, "" if it does not.
    """
    sources = source_ports(plan)
    missing = [port for port in sources if port not in old.ports]
    if missing:
        remedy = old.problem or "record it with all ports"
        raise InputError.of(f"sources that were not recorded: {', '.join(missing)}", remedy)
    plan = replay_plan(plan, replay_stages(old, plan, sources), Clip(old.path))
    check_sampled_cycles(plan, "the graph and record it again: what timing decided cannot be verified")
    names = [port for port in output_ports(plan) if port in old.ports and port not in sources]
    if not names:
        return [], ""
    again = folder / "again.mcap"
    target = Target(again, {"picture_format": "none"}, {}, {})
    _run(in_one_worker(with_recording(plan, names, target)), folder, quiet=quiet)
    with Recording(again) as new:
        return _compare(old, new, names, sources)


def _run(plan: Plan, out: Path, *, quiet: bool) -> None:
    """Raises FollowspotError if the run fails."""
    with closing(ProgressBar()) as bar:
        report = run_plan(plan, RunOptions(out), None if quiet or not sys.stderr.isatty() else bar.show)
    if report.stopped:
        raise KeyboardInterrupt
    if not report.ok:
        raise FollowspotError("\n".join(report.errors) or "messages are unaccounted for")


def _compare(
    old: Recording, new: Recording, names: Sequence[str], sources: Sequence[str]
) -> tuple[list[Compared], str]:
    """Compare every port; if the recording ends early, up to the last time that all of it reaches.

    Returns the results, and where a whole file ends before its sources, "" if it does not.
    """
    if old.problem:
        return _compare_up_to(min(_end(old, port) for port in sources), old, new, names), ""
    rows = [
        compare(port, old.ports[port], old.messages(port), new.messages(port), whole=True) for port in names
    ]
    end = max(_end(old, port) for port in sources)
    # one more message at the very end is no early end: a stage that sends more than then does that, too
    short = {row.port: row.lacks for row in rows if row.lacks is not None and row.lacks < end}
    if not short:
        return rows, ""
    port, lacks = min(short.items(), key=itemgetter(1))
    note = (
        f"{old.path} ends early: {port} has nothing from {to_seconds(lacks):g} s on, and the sources go on "
        f"to {to_seconds(end):g} s: a worker of the run died there, or the stage sends more now. "
        "Compared up to there"
    )
    return _compare_up_to(lacks - 1, old, new, names), note


def _compare_up_to(stop: int, old: Recording, new: Recording, names: Sequence[str]) -> list[Compared]:
    """Compare the messages of both for every port, up to and including this capture time, ns."""
    return [
        compare(
            port, old.ports[port], old.messages(port, stop=stop), new.messages(port, stop=stop), whole=False
        )
        for port in names
    ]


def _end(recording: Recording, port: str) -> int:
    """The latest capture time of a port, ns; -1 without messages."""
    return max((message.time for message in recording.messages(port)), default=-1)


def text(equal: bool, rows: Sequence[Compared], notes: Sequence[str], damage: str = "") -> str:
    """The result for people. Its last line counts the recorded ports that are not repeated.

    equal: whether all that was read is the same to the end; damage: what was not read, and why.
    """
    cells = [(row.port, str(row.messages), _said(row)) for row in rows]
    lines = [table(("port", "messages", ""), cells), *notes]
    count = sum(row.messages for row in rows)
    repeated = sum(not row.unrepeated for row in rows)
    same = "the same as far as the damaged file can be read" if damage else "the same, byte for byte"
    result = same if equal else _unproved(rows)
    left = len(rows) - repeated
    besides = f"; {left} of {len(rows)} recorded ports not repeated" * bool(left)
    lines.append(f"{repeated} ports, {count} messages: {result}{besides}")
    return "\n".join(lines)


def _unproved(rows: Sequence[Compared]) -> str:
    """The result if not all is the same; without any difference, the recording ends early."""
    if not any(row.messages for row in rows):
        return "nothing is repeated"
    return "different" if any(row.difference for row in rows) else "the same up to there"


def _said(row: Compared) -> str:
    return f"not repeated: {row.unrepeated}" if row.unrepeated else row.difference or "the same"


def _json(same: bool, rows: Sequence[Compared], notes: Sequence[str], damage: str) -> str:
    ports = [{name: value for name, value in asdict(row).items() if name != "lacks"} for row in rows]
    return json.dumps({"same": same, "ports": ports, "notes": list(notes), "damage": damage})
