"""The columns of a table that a text shows."""

from __future__ import annotations

from collections.abc import Sequence

from followspot.errors import InputError, did_you_mean
from followspot.message_table import Table


def chosen_columns(table: Table, names: Sequence[str]) -> list[int]:
    """Numbers of the columns with these names, in their order; without names, of all but the extra ones.

    Raises InputError if the table has no such column.
    """
    if not names:
        return [number for number, cells in enumerate(table) if not cells.extra]
    place = {cells.name: number for number, cells in enumerate(table)}
    strange = next((name for name in names if name not in place), None)
    if strange is not None:
        raise InputError.of(f'there is no column "{strange}"', did_you_mean(strange, place, "columns"))
    return [place[name] for name in names]
