"""`followspot export`: recorded ports as tables or lines of JSON."""

from __future__ import annotations

import argparse
import importlib.util
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from followspot.errors import FollowspotError, InputError, Mistake
from followspot.messages import InvalidMessage, Message
from followspot.wire import unpack
from followspot_record.formats import FORMATS
from followspot_record.ports import chosen
from followspot_recording.contract import message_type
from followspot_recording.recording import Recording

PICTURES = ("Frame", "Gradients")
"""Types that are exported only where they are asked for: as numbers they fill disks."""


def export_command(args: argparse.Namespace) -> int:
    """Write a file for each port. Returns the exit code."""
    form = FORMATS[args.to]
    if form.needs and importlib.util.find_spec(form.needs) is None:
        remedy = f'pip install "followspot[{args.to}]"'
        raise InputError([Mistake(None, f"export --to {args.to} needs {form.needs}", remedy)])
    folder = Path(args.folder)
    with Recording(args.recording) as recording:
        names = chosen(args.ports, recording.ports, "--ports")
        if args.ports is None:
            names = tuple(name for name in names if not recording.ports[name].schema.endswith(PICTURES))
        if not names:
            remedy = f"recorded: {', '.join(recording.ports) or 'none'}"
            raise InputError([Mistake(None, f"{recording.path} has no such ports", remedy)])
        folder.mkdir(parents=True, exist_ok=True)
        counts = {}
        for name in names:
            kind = message_type(recording.ports[name].contract)
            path = folder / f"{name.replace('/', '.')}.{args.to}"
            counts[str(path)] = form.write(path, kind, messages(recording, name, kind))
            if not args.json:
                print(f"{path}  {counts[str(path)]}")
        problem = recording.problem
    if problem:
        print(f"followspot: {problem}", file=sys.stderr)
    if args.json:
        print(json.dumps({"files": counts, "problem": problem}))
    return 0


def messages(recording: Recording, port: str, kind: type[Message]) -> Iterator[Message]:
    """The messages of a port. Raises FollowspotError where one is none."""
    for recorded in recording.messages(port):
        try:
            message = unpack(bytes(recorded.data), kind)
        except InvalidMessage as error:
            raise FollowspotError(
                f"{recording.path}: message {recorded.seq} of {port} is none: {error}"
            ) from None
        assert isinstance(message, Message)
        yield message
