"""Any message as a line of JSON."""

from __future__ import annotations

import json

from followspot import Field, Joined, Message, OutputPath, StageParams
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
        self.write(
            json.dumps(as_json(one, self.room), allow_nan=False, separators=(",", ":")) + "\n"
            for one in messages
        )
