"""One column of the table that a message is written as, in text files, on screens and in data frames."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray


class TableColumn(NamedTuple):
    """One column of a table; see `followspot.message_table`.

    values: (R,) numbers, truth values or texts, or a list of one JSON value for each row; unit, decimals,
    extra: as of a `followspot.columns.Column`.
    """

    name: str
    values: NDArray[Any] | list[Any]
    unit: str = "1"
    decimals: int | None = None
    extra: bool = False
