"""Any message as a line of JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from followspot import Field, Message, OutputPath, StageParams
from followspot.messages import Array
from followspot_sinks.line_sink import LineSink


class JsonLines(LineSink):
    """Write a JSON object per message: its type, source, seq, time (ns) and every field; NaN becomes null."""

    class Params(StageParams):
        path: OutputPath = Field("messages.jsonl", description="the file, below the output folder")

    params: Params

    def process(self, message: Message) -> None:
        """Add one line."""
        self.write([json.dumps(as_json(message), allow_nan=False, separators=(",", ":")) + "\n"])


def as_json(message: Message) -> dict[str, Any]:
    """The message as JSON types; arrays become nested lists."""
    source, seq, time, _ = message.header
    fields = {name: _scalar(getattr(message, name)) for name, _ in message.scalars}
    arrays = {c.name: _nested(getattr(message, c.name)) for c in message.columns}
    return {"type": type(message).__name__, "source": source, "seq": seq, "time": time} | fields | arrays


def _scalar(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _nested(array: Array) -> Any:
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        unknown = ~np.isfinite(array)
        array = array.astype(object)
        array[unknown] = None
    return array.tolist()
