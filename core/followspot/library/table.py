"""Tables of a report."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from followspot.tables.html import html_table
from followspot.tables.terminal import table


def data_frame(columns: Iterable[str], rows: Iterable[Sequence[Any]]) -> Any:
    """A DataFrame of these rows. Raises ImportError with the remedy if pandas is not installed."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("to_pandas needs the package pandas: pip install pandas", name="pandas") from error
    return pandas.DataFrame(list(rows), columns=list(columns))


class Table:
    """Rows under headings: iterate over them as dicts, show them, or take them to pandas."""

    def __init__(self, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        self.columns = tuple(columns)
        self.rows = tuple(tuple(row) for row in rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (dict(zip(self.columns, row, strict=True)) for row in self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def to_pandas(self) -> Any:
        """A DataFrame. Raises ImportError if pandas is not installed."""
        return data_frame(self.columns, self.rows)

    def __repr__(self) -> str:
        return table(self.columns, self._texts())

    def _repr_html_(self) -> str:
        return html_table(self.columns, self._texts())

    def _texts(self) -> list[list[str]]:
        return [[f"{c:.2f}" if isinstance(c, float) else str(c) for c in row] for row in self.rows]
