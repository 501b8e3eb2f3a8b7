"""`followspot export`: recorded ports as tables or lines of JSON."""

from __future__ import annotations

import argparse
import importlib.util
import json
import sys
from collections.abc import Iterable
from pathlib import Path

from followspot import Room
from followspot.errors import InputError, writing
from followspot.graph.output_ports import chosen_ports
from followspot.messages import Message
from followspot.people import Gradients
from followspot.tracking import Frame
from followspot_record.embedded import offered_ports, plan_of_recording
from followspot_record.formats import FORMATS, Port
from followspot_record.record import PLAN
from followspot_recording.contract import is_of, message_type, type_name
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording
from followspot_recording.records import Channel
from followspot_recording.replays import REPLAYS

PICTURES, HEAVY = type_name(Frame), (type_name(Gradients),)
"""Types that are exported on request only: as numbers they fill disks."""


def export_command(args: argparse.Namespace) -> int:
    """Write a file for each port. Returns the exit code."""
    form = FORMATS[args.to]
    if form.needs and importlib.util.find_spec(form.needs) is None:
        remedy = f'pip install "followspot[{args.to}]"'
        raise InputError.of(f"export --to {args.to} needs {form.needs}", remedy)
    folder = Path(args.folder)
    with Recording(args.recording) as recording:
        names = chosen_ports(args.ports, recording.ports, "--ports", offered_ports(recording))
        if args.ports is None:
            left_out = HEAVY if form.pictures else (*HEAVY, PICTURES)
            names = tuple(name for name in names if recording.ports[name].schema not in left_out)
        if not names:
            remedy = recording.problem or f"recorded: {', '.join(recording.ports) or 'none'}"
            raise InputError.of(f"{recording.path} has no such ports", remedy)
        paths = {name: folder / f"{name.replace('/', '.')}.{form.suffix}" for name in names}
        _refuse_existing(paths.values())
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        room = recorded_room(recording)
        counts = {}
        for name, path in paths.items():
            kind = type_of(recording.ports[name])
            with writing(path):
                counts[str(path)] = form.write(path, Port(name, kind, decoded(recording, name, kind), room))
            if not args.json:
                print(f"{path}  {counts[str(path)]}")
        problem = recording.problem
    if problem:
        print(f"followspot: {problem}", file=sys.stderr)
    if args.json:
        print(json.dumps({"files": counts, "problem": problem}))
    return 0


def _refuse_existing(paths: Iterable[Path]) -> None:
    """Raises InputError if a file would be replaced."""
    there = [str(path) for path in paths if path.exists()]
    if there:
        more = f" and {len(there) - 1} more" if len(there) > 1 else ""
        raise InputError.of(f"{there[0]}{more} exists already", "name another folder, or remove it")


def recorded_room(recording: Recording) -> Room:
    """The room of the recorded run; an empty one if the file has none."""
    if PLAN not in recording.attachments:
        return Room()
    return plan_of_recording(recording).room


def type_of(channel: Channel) -> type[Message]:
    """The installed message type if it equals the recorded one, else a made one. Raises ContractError."""
    known = next((kind for kind in REPLAYS.values() if type_name(kind) == channel.schema), None)
    return known if known and is_of(channel.contract, known) else message_type(channel.contract)
