"""Messages of any type as a CSV file."""

from __future__ import annotations

import json
import re
from typing import Any, TypeVar

from followspot import Field, Joined, Message, OutputPath, StageParams
from followspot.errors import FollowspotError
from followspot.message_table import Table, head_of, plain, table_of
from followspot.tables.table_column import TableColumn
from followspot_sinks.chosen_columns import chosen_columns
from followspot_sinks.line_sink import LineSink, seconds

M = TypeVar("M", bound=Message)
_SPECIAL = re.compile(r'[,"\r\n]')


class CsvFile(LineSink):
    """Write messages of one type, whichever it is: their frame, time (s) and table, a row for each row.

    Tracks have the columns object, state, x, y, z, vx, vy, vz, sx, sy, sz (m, m/s, one sigma in m). Targets,
    cameras and states are written by their names, not by numbers. Equal runs give equal bytes.
    """

    table_path = "path"

    class Params(StageParams):
        path: OutputPath = Field("tracks.csv", description="the CSV file, below the output folder")
        columns: tuple[str, ...] = Field(
            (), description="columns beside frame and time, by name, in this order; by default the usual ones"
        )

    params: Params
    names: tuple[str, ...] = ()

    def setup(self) -> None:
        """Create the file. Raises FollowspotError if that is not possible, or there is no such column."""
        super().setup()
        self.chosen: list[int] | None = None
        if self.context.receives:
            self._begin(head_of(self.context.receives[0], self.room))

    def process(self, messages: Joined[M]) -> None:
        """Add the rows of one frame, message after message. Raises FollowspotError if their types differ."""
        for message in messages:
            table = table_of(message, self.room)
            if self.chosen is None:
                self._begin(table)
            if self.names != tuple(cells.name for cells in table):
                raise FollowspotError(
                    f"{self.params.path} has other columns than {type(message).__name__};"
                    " give messages of another type a sink and a file of their own"
                )
            start = f"{message.header.seq},{seconds(message.header.time)},"
            columns = [table[i] for i in self.chosen or ()]
            line = f"{start}{','.join(map(_form, columns))}\n"
            self.write(line % row for row in zip(*map(_values, columns), strict=True))

    def _begin(self, table: Table) -> None:
        """Write the first line of the file."""
        self.names = tuple(cells.name for cells in table)
        self.chosen = chosen_columns(table, self.params.columns)
        head = ("frame", "time", *(self.names[i] for i in self.chosen))
        self.begin(",".join(map(_text, head)) + "\n")


def _form(cells: TableColumn) -> str:
    """How a line of the file shows a value of a column, in the language of the operator %."""
    return "%s" if cells.decimals is None or isinstance(cells.values, list) else f"%.{cells.decimals}f"


def _values(cells: TableColumn) -> list[Any]:
    """The values of a column, as :func:`_form` shows them."""
    if cells.decimals is None or isinstance(cells.values, list):
        return [_text(value) for value in plain(cells.values)]
    return list(cells.values.tolist())


def _text(value: Any) -> str:
    """A value: empty if unknown, a list as JSON; in quotes if it has commas, quotes or line ends."""
    if not isinstance(value, str):
        value = "" if value is None else json.dumps(value) if isinstance(value, list | tuple) else str(value)
    return f'"{value.replace(chr(34), chr(34) * 2)}"' if _SPECIAL.search(value) else value
