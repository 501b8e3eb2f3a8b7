"""Any message as a line of JSON."""

from __future__ import annotations

import json

from followspot import Field, Joined, Message, OutputPath, Room, StageParams
from followspot.message_table import as_json
from followspot_sinks.line_sink import LineSink


class JsonLines(LineSink):
    """Write a JSON object per message: type, source, seq, time (ns), single values, and `rows`, an object for
    each row with names of targets, cameras and states; NaN becomes null.
    """

    class Params(StageParams):
        path: OutputPath = Field("messages.jsonl", description="the file, below the output folder")

    params: Params

    def process(self, messages: Joined[Message]) -> None:
        """Add a line for each message."""
        self.write(json_text(message, self.room) + "\n" for message in messages)


def json_text(message: Message, room: Room) -> str:
    """A message as one line of JSON without its end."""
    return json.dumps(as_json(message, room), allow_nan=False, separators=(",", ":"))
