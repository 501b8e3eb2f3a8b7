"""Messages of any type as lines of text."""

from __future__ import annotations

from typing import Any

from followspot import Field, Joined, Message, Stage, StageParams
from followspot.message_table import rows_of, table_of
from followspot_sinks.chosen_columns import chosen_columns


class Console(Stage):
    """Print a line for each row of each message, a few times per second of capture time."""

    class Params(StageParams):
        maximum_rate: float = Field(
            1.0, gt=0, le=1000, unit="1/s", description="largest number of frames printed per second"
        )
        columns: tuple[str, ...] = Field(
            (), description="columns to print, by name, in this order; by default the usual ones"
        )

    params: Params

    def setup(self) -> None:
        """Print the first frame that comes."""
        self.next = 0

    def process(self, messages: Joined[Message]) -> None:
        """Print one frame if the last print was long enough ago. Raises InputError if a column is missing."""
        time = min((message.header.time for message in messages), default=0)
        if time < self.next or not messages:
            return
        self.next = time + round(1e9 / self.params.maximum_rate)
        for message in messages:
            table = table_of(message, self.room)
            shown = [table[i] for i in chosen_columns(table, self.params.columns)]
            for row in rows_of(shown):
                words = (_word(cells.name, value) for cells, value in zip(shown, row, strict=True))
                print(f"{time / 1e9:9.3f} s  {'  '.join(words)}", flush=True)


def _word(name: str, value: Any) -> str:
    """A text as it is, a number with its name."""
    if isinstance(value, str):
        return value
    return f"{name} {value:+.3f}" if isinstance(value, float) else f"{name} {value}"
