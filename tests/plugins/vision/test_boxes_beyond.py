"""`vision.boxes_csv`: columns that are not what `box` says."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot import Context
from followspot.room import Member
from followspot.testing import tiny_room
from followspot_vision.boxes_csv import BoxesCsv

ROOM = tiny_room()


@pytest.mark.parametrize(
    ("box", "columns", "told"),
    [
        ("x0 y0 x1 y1", {}, False),
        ("x y width height", {"x": "x0", "y": "y0", "width": "x1", "height": "y1"}, True),
    ],
)
def test_corners_that_are_taken_for_sizes_are_told(
    box: str, columns: dict[str, str], told: bool, tmp_path: Path
) -> None:
    width, height = ROOM.cameras["cam0"].size
    rows = "".join(f"{n},cam0,{0.6 * width},{0.6 * height},{0.9 * width},{0.9 * height}\n" for n in range(30))
    (tmp_path / "boxes.csv").write_text("frame,camera,x0,y0,x1,y1\n" + rows)
    warnings: list[str] = []
    context = Context("boxes", ROOM, Member("cameras", "cam0"), warn=warnings.append)
    BoxesCsv(context, path=tmp_path / "boxes.csv", fps=25, box=box, columns=columns).setup()
    assert len(warnings) == told
    assert all("30 of 30 boxes of camera cam0 end far beyond" in text and box in text for text in warnings)
