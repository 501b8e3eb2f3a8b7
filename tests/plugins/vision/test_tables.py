"""Points, boxes and candidates from CSV files: units, frames of reference, and files that are wrong."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot import Context, InputError, Stage
from followspot.geometry import distort, undistort
from followspot.message_checks.sealing import seal
from followspot.plugins.registry import load_stage
from followspot.room import Member
from followspot.testing import check_stage, tiny_room
from followspot_vision.frame_table import MOST_FRAMES, MOST_IN_A_FRAME

ROOM = tiny_room()
"""Of cam0 and cam1, 64 x 48 px."""


def stage(uses: str, path: Path, text: str, camera: str = "cam0", **params: Any) -> Stage:
    path.write_text(text)
    place = Member("cameras", camera) if load_stage(uses).per_camera else None
    made = load_stage(uses)(Context(uses, ROOM, place), path=path, **params)
    made.setup()
    return made


def points(path: Path, text: str, camera: str = "cam0", **params: Any) -> list[Any]:
    made = stage("vision.points_csv", path, text, camera, **params)
    messages = list(made.process())
    assert made.length() == len(messages)
    return messages


TEXT = (
    "frame,camera,x,y,label,score\n2,cam0,10,20,red,0.5\n2,cam1,1,2,,1\n2,cam0,30,40,,0.9\n4,cam0,5,6,red,1\n"
)


def test_every_frame_of_the_file_gives_a_message_to_every_camera(tmp_path: Path) -> None:
    first, second, third = points(tmp_path / "a.csv", TEXT, fps=10)
    assert [m.header.seq for m in (first, second, third)] == [2, 3, 4]
    assert [m.header.time for m in (first, second, third)] == [200_000_000, 300_000_000, 400_000_000]
    assert (first.labels, first.label.tolist(), first.instance.tolist()) == (("red", ""), [0, 1], [-1, -1])
    assert first.pixel.tolist() == [[10, 20], [30, 40]]
    assert (first.score.tolist(), len(second.xy), third.labels) == ([0.5, 0.9], 0, ("red",))
    assert [len(m.xy) for m in points(tmp_path / "a.csv", TEXT, "cam1", fps=10)] == [1, 0, 0]


def test_times_may_be_in_the_file_exact_and_in_any_unit(tmp_path: Path) -> None:
    text = "time,camera,x,y\n1700000000123.456789,cam0,1,2\n1700000000124,cam0,1,2\n"
    found = points(tmp_path / "a.csv", text, time_unit="ms", start_time=-1.7e9)
    assert [m.header.time for m in found] == [123_456_789, 124_000_000]


@pytest.mark.parametrize(
    ("params", "place", "pixel"),
    [
        ({}, "32,12", [32, 12]),
        ({"pixel_origin": "corner"}, "32,12", [31.5, 11.5]),
        ({"unit": "share"}, "0.5,-1.25", [0.5 * 64 - 0.5, -1.25 * 48 - 0.5]),
    ],
)
def test_the_frame_of_reference_is_said(
    tmp_path: Path, params: Mapping[str, Any], place: str, pixel: list[float]
) -> None:
    text = f"frame,camera,u,v\n0,cam0,{place}\n"
    (found,) = points(tmp_path / "a.csv", text, fps=1, columns={"x": "u", "y": "v"}, **params)
    np.testing.assert_allclose(found.pixel, [pixel])
    np.testing.assert_allclose(found.xy, undistort(ROOM.cameras["cam0"], found.pixel))


def test_points_without_distortion_are_put_back_into_the_picture(tmp_path: Path) -> None:
    (found,) = points(tmp_path / "a.csv", "frame,camera,x,y\n0,cam0,32,12\n", fps=1, undistorted=True)
    assert found.xy.tolist() == [[32, 12]]
    np.testing.assert_allclose(found.pixel, distort(ROOM.cameras["cam0"], found.xy))


HEAD = "frame,camera,x,y\n"
WRONG = {
    "no column": (
        "frame,cam,x,y\n0,cam0,1,2\n",
        {"fps": 1},
        r"a\.csv:1:1: missing columns: camera\n.*did you mean \"cam\"",
    ),
    "other names": ("frame,cam,u,v\n", {"fps": 1}, r"missing columns: x, y, camera\n.*columns: \{x: NAME"),
    "renamed": (HEAD, {"fps": 1, "columns": {"x": "u"}}, r"a\.csv:1:1: missing columns: u"),
    "no such": (HEAD, {"fps": 1, "columns": {"xx": "u"}}, 'no column "xx".*did you mean "x"'),
    "no time": ("camera,x,y\n", {}, r"a\.csv:1:1: neither a column frame nor a column time"),
    "no rate": (HEAD, {}, r"numbers frames and has no column time.*with: \{fps: 30\}"),
    "camera": (
        HEAD + "0,cam2,1,2\n",
        {"fps": 1},
        r'a\.csv:2:3: "cam2" in column camera.*did you mean "cam\d"',
    ),
    "nan": (HEAD + "0,cam0,1,nan\n", {"fps": 1}, r'a\.csv:2:10: "nan" in column y.*a finite number'),
    "empty": (HEAD + "0,cam0,,2\n", {"fps": 1}, r'a\.csv:2:8: "" in column x.*a number'),
    "far": (HEAD + "0,cam0,1e300,2\n", {"fps": 1}, r"a\.csv:2:8: .*within 1000000 px"),
    "back": (
        HEAD + "5,cam0,1,2\n4,cam0,1,2\n",
        {"fps": 1},
        r"a\.csv:3:1: frame 4 comes after 5.*sort the rows",
    ),
    "half": (HEAD + "0.5,cam0,1,2\n", {"fps": 1}, r"a\.csv:2:1: .*a whole number"),
    "short": (HEAD + "0,cam0,1\n", {"fps": 1}, r"a\.csv:2:1: 3 columns, 4 needed"),
    "time": ("time,camera,x,y\n1e99999,cam0,1,2\n", {}, r'a\.csv:2:1: "1e99999" in column time.*a time in s'),
    "word": ("time,camera,x,y\nsoon,cam0,1,2\n", {}, r'a\.csv:2:1: "soon" in column time.*a time in s'),
    "clock": ("time,camera,x,y\n2,cam0,1,2\n1,cam0,1,2\n", {}, r"a\.csv:3:1: time 1 s comes after 2 s"),
    "two": ("frame,time,camera,x,y\n0,1,cam0,1,2\n0,2,cam0,1,2\n", {}, r"a\.csv:3:1: frame 0 has two times"),
    "runs": ("frame,time,camera,x,y\n1,5,cam1,1,2\n0,6,cam0,1,2\n", {}, "frame 1 is not later than frame 0"),
    "span": (HEAD + f"0,cam1,1,2\n{MOST_FRAMES},cam1,1,2\n", {"fps": 1}, "from frame 0 to 10000000.*at most"),
    "label": (HEAD[:-1] + ",label\n0,cam0,1,2," + "a" * 101, {"fps": 1}, "a name of 1 to 100 characters"),
    "flood": (HEAD + "0,cam0,1,2\n" * (MOST_IN_A_FRAME + 1), {"fps": 1}, "more than 10000 rows of one frame"),
    "no text": ("\0", {"fps": 1}, r"a\.csv:1:1: neither"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_file_that_is_wrong_is_refused_with_its_line_and_a_remedy(tmp_path: Path, name: str) -> None:
    text, params, said = WRONG[name]
    with pytest.raises(InputError, match=f"(?s){said}"):
        points(tmp_path / "a.csv", text, **params)


CELLS = [
    "0",
    "1",
    "7",
    "-1",
    "0.5",
    "nan",
    "1e308",
    "-1e-308",
    "",
    " 1 ",
    '"',
    "cam0",
    "cam1",
    "9" * 40,
    "1_0",
]
HEADS = ["frame,camera,x,y", "time,camera,x,y,score", "frame,time,camera,x,y,label", "x,y", "frame,frame,x,y"]


@settings(max_examples=200, deadline=None)
@given(
    st.sampled_from(HEADS), st.lists(st.lists(st.sampled_from(CELLS), max_size=6), max_size=5), st.booleans()
)
def test_any_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, head: str, lines: list[list[str]], rate: bool
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.csv"
    text = "\n".join([head, *map(",".join, lines)])
    try:
        found = points(path, text, fps=0.001 if rate else None)
    except InputError:
        return
    times = [seal(message).header.time for message in found]
    assert times == sorted(set(times))
    assert all(np.isfinite(message.pixel).all() for message in found)


@pytest.mark.parametrize(("step", "said"), [(1, []), (5, ["steps of 5, .* fps: 6$"])])
def test_frames_that_no_detector_looked_at_are_doubted(tmp_path: Path, step: int, said: list[str]) -> None:
    """A detector looked at every fifth picture: the others are not empty."""
    told: list[str] = []
    path = tmp_path / "a.csv"
    for uses, head, row in (
        ("vision.points_csv", "x,y", "1,2"),
        ("vision.boxes_csv", "x0,y0,x1,y1", "1,2,3,4"),
    ):
        path.write_text(f"frame,camera,{head}\n" + "".join(f"{step * k},cam0,{row}\n" for k in range(12)))
        context = Context(uses, ROOM, Member("cameras", "cam0"), warn=told.append)
        load_stage(uses)(context, path=path, fps=30).setup()
    assert len(told) == 2 * len(said)
    assert all(re.search(said[0], text) for text in told)


def test_a_camera_without_rows_is_told_of(tmp_path: Path) -> None:
    told: list[str] = []
    (tmp_path / "a.csv").write_text(HEAD + "0,cam1,1,2\n")
    made = load_stage("vision.points_csv")(
        Context("a", ROOM, Member("cameras", "cam0"), warn=told.append), path=tmp_path / "a.csv", fps=1
    )
    made.setup()
    assert [len(message.xy) for message in made.process()] == [0]
    assert told == [f"{tmp_path / 'a.csv'} has no points of camera cam0"]


@pytest.mark.parametrize(
    ("box", "cells"),
    [
        ("x0 y0 x1 y1", "10,20,30,60"),
        ("x y width height", "10,20,20,40"),
        ("center_x center_y width height", "20,40,20,40"),
    ],
)
def test_boxes_come_in_three_forms(tmp_path: Path, box: str, cells: str) -> None:
    text = f"frame,camera,{box.replace(' ', ',')},label,score\n"
    text += f"0,cam0,{cells},person,0.5\n0,cam0,{cells},ball,0.1\n"
    made = stage(
        "vision.boxes_csv", tmp_path / "a.csv", text, fps=1, box=box, person_label="person", upper_share=0.5
    )
    (found,) = made.process()
    assert found.boxes.box.tolist() == [[10, 20, 30, 40]]
    assert found.boxes.score.tolist() == [0.5]
    assert (found.centers.labels, found.centers.pixel.tolist()) == (("person", "ball"), [[20, 40]] * 2)


def test_a_box_without_a_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"(?s)a\.csv:2:14: .*column x1.*a width and a height"):
        stage("vision.boxes_csv", tmp_path / "a.csv", "frame,camera,x0,y0,x1,y1\n0,cam0,10,20,10,30\n", fps=1)


def test_candidates_are_turned_scaled_and_moved_into_the_room(tmp_path: Path) -> None:
    text = "frame,x,y,z,label,score,sigma\n0,100,200,300,red,0.5,2\n0,0,0,0,,0.01,2\n"
    made = stage(
        *("vision.candidates_csv", tmp_path / "a.csv", text),
        **{"fps": 1, "unit": "cm", "axes": "x -z y", "origin": (1.0, 0.0, 0.0), "minimum_score": 0.1},
    )
    (found,) = made.process()
    np.testing.assert_allclose(found.xyz, [[2, -3, 2]])
    np.testing.assert_allclose(found.covariance, [0.0004 * np.eye(3)])
    assert (found.labels, found.score.tolist(), found.views.tolist()) == (("red",), [0.5], [0])


@pytest.mark.parametrize(
    ("params", "text", "said"),
    [
        ({"axes": "x x y"}, "0,1,1,1\n", "each of x, y and z must be named once"),
        ({"unit": "ft"}, "0,1,1e9,1\n", r"a\.csv:2:5: .*within 100000 m"),
        ({}, "0,1,inf,1\n", r"a\.csv:2:5: .*a finite number"),
    ],
)
def test_candidates_that_are_wrong_are_refused(
    tmp_path: Path, params: Mapping[str, Any], text: str, said: str
) -> None:
    with pytest.raises(ValueError if "axes" in params else InputError, match=f"(?s){said}"):
        stage("vision.candidates_csv", tmp_path / "a.csv", "frame,x,y,z\n" + text, fps=1, **params)


@pytest.mark.parametrize(
    ("uses", "text"),
    [
        ("vision.points_csv", TEXT),
        ("vision.boxes_csv", "frame,camera,x0,y0,x1,y1\n0,cam0,1,2,3,4\n2,cam0,1,2,3,4\n"),
        ("vision.candidates_csv", "frame,x,y,z\n0,1,1,1\n2,1,1,1\n"),
    ],
)
def test_sources_keep_the_promises_of_stages(tmp_path: Path, uses: str, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    check_stage(load_stage(uses), path=str(tmp_path / "a.csv"), fps=10)
