"""`followspot shape fit`: what is refused of a folder of crops."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.errors import InputError
from followspot_shape.crops import COLUMNS, read_crops


@pytest.mark.parametrize(
    ("row", "cause"),
    [
        ("c.png,0,1e308,0,0,1,2,3", "beyond 1000000"),
        ("c.png,1e30,0,0,0,1,2,3", "beyond 1000000"),
        ("c.png,0,nan,0,0,1,2,3", "not finite"),
        ("x" * 200_000, "field larger than"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(tmp_path: Path, row: str, cause: str) -> None:
    (tmp_path / "boxes.csv").write_text(f"{','.join(COLUMNS)}\n{row}\n")
    with pytest.raises(InputError, match=cause):
        read_crops(tmp_path)
