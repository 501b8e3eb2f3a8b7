"""Recorded true poses of persons."""

from pathlib import Path

import numpy as np
import pytest

from followspot import Context, InputError
from followspot.testing import check_stage
from followspot.testing.tiny_room import tiny_room
from followspot_cameras.pose_truth_csv import PoseTruthCsv

HEAD = (
    "frame,time,person,x,y,r,z_head_top,torso_heading_room,torso_heading,head_pan,head_tilt,visible_upper,"
    "more\n"
)
FIRST = "0,0.0125,1,1,2,2.2,1.7,0.3,0.1,0.2,-0.1,1.0,x\n"
SECOND = "1,0.1663,1,1,2.1,2.3,1.7,0.3,0.1,0.2,-0.1,0.4,x\n1,0.1663,2,4,5,6.4,1.6,-0.3,0.1,0.2,-0.1,0.8,x\n"


def source(path: Path) -> PoseTruthCsv:
    stage = PoseTruthCsv(Context(room=tiny_room()), path=path)
    stage.setup()
    return stage


def test_stage_keeps_the_promises_of_stages() -> None:
    check_stage(PoseTruthCsv)


def test_rows_become_one_message_per_frame_with_the_persons_who_are_there(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(HEAD + FIRST + SECOND)
    stage = source(path)
    first, second = stage.process()
    assert (stage.length(), first.header.time, first.person.tolist()) == (2, 12_500_000, [1])
    assert (second.person.tolist(), second.visible.tolist()) == ([1, 2], [0.4, 0.8])
    np.testing.assert_array_equal(second.xy, [[1, 2.1], [4, 5]])
    values = (second.height[1], second.heading[1], second.pan[1], second.tilt[1])
    assert values == (1.6, -0.3, 0.2, -0.1)


def test_folder_gives_the_truth_of_the_rooms_cameras_together(tmp_path: Path) -> None:
    left, right = list(tiny_room().cameras)[:2]
    (tmp_path / f"{left}_gt.csv").write_text(HEAD + FIRST)
    (tmp_path / f"{right}_gt.csv").write_text(HEAD + SECOND)
    (tmp_path / "other_gt.csv").write_text("of another room")
    assert [message.person.tolist() for message in source(tmp_path).process()] == [[1], [1, 2]]


def test_folder_without_truth_of_the_rooms_cameras_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no truth of this room's cameras"):
        source(tmp_path)


def test_bad_cell_is_named_with_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(HEAD + FIRST.replace("2.2", "far"))
    with pytest.raises(InputError, match=r'truth\.csv:2:16: "far" in column r'):
        source(path)
