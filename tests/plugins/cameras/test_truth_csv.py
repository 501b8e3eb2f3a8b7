"""Recorded ground truth."""

from pathlib import Path

import numpy as np
import pytest

from followspot import InputError
from followspot_cameras.truth_csv import TruthCsv

HEAD = "frame,time,object,x,y,z,hidden,trackable,pair,more\n"


def test_rows_become_one_message_per_frame_with_the_objects_that_are_there(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    rows = ["0,0.0,red,1,2,3,0,1,1,x", "1,0.03333,red,1,2,4,1,0,0,x", "1,0.03333,blue,5,6,7,0,1,0,x"]
    path.write_text(HEAD + "\n".join(rows))
    source = TruthCsv(path=path)
    source.setup()
    first, second = source.process()
    assert first.objects == ("red",)
    assert second.objects == ("red", "blue")
    assert second.header[1:3] == (1, 33_330_000)
    np.testing.assert_array_equal(second.xyz, [[1, 2, 4], [5, 6, 7]])
    assert second.hidden.tolist() == [True, False]
    assert second.trackable.tolist() == [False, True]
    assert source.length() == 2


@pytest.mark.parametrize(
    ("rows", "complaint"),
    [
        ("0,0.0,red,1,2,oops,0,1,1,x\n", r'truth\.csv:2:15: "oops" in column z'),
        ("0,0.0,red,1,2,nan,0,1,1,x\n", "finite"),
        ("0,0.0,red,1,2,3,maybe,1,1,x\n", "needs 0 or 1"),
        ("0,0.0,red,1,2,3,0,1,1,x\n0,0.0\n", r"truth\.csv:3:1: 2 columns, 9 needed"),
        ("0,0.0,,1,2,3,0,1,1,x\n", "a name of 1 to 100 characters"),
    ],
)
def test_bad_cell_is_named_with_line_and_column(tmp_path: Path, rows: str, complaint: str) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(HEAD + rows)
    with pytest.raises(InputError, match=complaint):
        TruthCsv(path=path).setup()


def test_missing_columns_are_listed(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("frame,time,object,x,y,z\n")
    with pytest.raises(InputError, match="missing columns: hidden, trackable, pair"):
        TruthCsv(path=path).setup()
