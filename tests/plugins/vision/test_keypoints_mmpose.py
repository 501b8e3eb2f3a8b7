"""MMPose's files, and folders that grow while they are read."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from followspot import Context, InputError
from followspot.room import Member
from followspot.testing import tiny_room
from followspot_vision.keypoint_files import read_picture
from followspot_vision.keypoints_json import KeypointsJson
from followspot_vision.keypoints_live import KeypointsLive

ROOM = tiny_room()
CAMERA = Member("cameras", "cam0")


def instance(x: float, count: int = 17) -> dict[str, Any]:
    """Joint i at (x, i), all but the first two not found."""
    scores = [0.9 if i < 2 else 0.0 for i in range(count)]
    return {"keypoints": [[x, i] for i in range(count)], "keypoint_scores": scores, "bbox_score": 0.8}


def read(path: Path, **params: Any) -> list[Any]:
    stage = KeypointsJson(Context("a", ROOM, CAMERA), path=path, **params)
    stage.setup()
    return list(stage.process())


@pytest.mark.parametrize("whole", [False, True])
def test_results_of_a_video_give_a_message_for_each_picture(tmp_path: Path, whole: bool) -> None:
    frames = [
        {"frame_id": 1, "instances": [instance(5), instance(6)]},
        {"frame_id": 3, "instances": [instance(7)]},
    ]
    path = tmp_path / "cam0.json"
    path.write_text(json.dumps({"meta_info": {}, "instance_info": frames} if whole else frames))
    found = read(tmp_path, first_picture=1, fps=10)
    assert [len(one.xy) for one in found] == [4, 0, 2]
    assert found[0].instance.tolist() == [0, 0, 1, 1]
    assert found[2].pixel.tolist() == [[7, 0], [7, 1]]


def test_a_folder_may_have_a_file_for_each_picture(tmp_path: Path) -> None:
    (tmp_path / "cam0").mkdir()
    (tmp_path / "cam0/shot2_000000.json").write_text(json.dumps([instance(3)]))
    (tmp_path / "cam0/shot2_000002.json").write_text(json.dumps({"instances": [instance(4), instance(5)]}))
    assert [len(one.xy) for one in read(tmp_path)] == [2, 0, 4]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ([{"frame_id": 0, "instances": 3}], r"\[0\]\.instances is no list of instances"),
        ([{"instances": []}], r"\[0\] has no frame_id"),
        ([{"frame_id": 0, "instances": [{"keypoints": []}]}], r"instances\[0\] has no keypoint_scores"),
        (
            [{"frame_id": 0, "instances": [{"keypoints": [[1, 2, 3]], "keypoint_scores": [1]}]}],
            r"instances\[0\] has no keypoints \[\[x, y\], \.\.\.\]",
        ),
        (
            [{"frame_id": 0, "instances": [{"keypoints": [[1, 2]], "keypoint_scores": []}]}],
            "as many keypoint_scores",
        ),
        ([{"frame_id": 0, "instances": [instance(1e9)]}], "numbers lie within"),
        ([{"frame_id": 0, "instances": [instance(1)] * 1001}], "has 1001 persons"),
    ],
)
def test_results_that_are_wrong_are_refused(tmp_path: Path, data: object, said: str) -> None:
    path = tmp_path / "results.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=said):
        read(path)


class Writer:
    """Stands in for the run's clock: each wait is one step of the program that writes files."""

    def __init__(self, *steps: Any) -> None:
        self.steps = list(steps)

    def __call__(self, seconds: float) -> bool:
        if not self.steps:
            return False
        step = self.steps.pop(0)
        if callable(step):
            step()
        elif step is not None:
            path, text = step
            path.write_text(text)
        return True


def live(folder: Path, *steps: Any, **params: Any) -> tuple[list[Any], list[str]]:
    """Messages and warnings while a program takes these steps."""
    warnings: list[str] = []
    context = Context("live", ROOM, CAMERA, pause=Writer(*steps), warn=warnings.append)
    stage = KeypointsLive(context, path=folder, **params)
    stage.setup()
    return list(stage.process()), warnings


def test_a_folder_that_is_gone_for_a_while_is_told_and_read_again(tmp_path: Path) -> None:
    folder, away = tmp_path / "cam0", tmp_path / "away"
    folder.mkdir()
    people = json.dumps({"people": [{"pose_keypoints_2d": [1, 2, 0.9] * 17}]})
    steps = [lambda: folder.rename(away), None, lambda: away.rename(folder)]
    found, warnings = live(folder, *steps, (folder / "a_001_keypoints.json", people), fps=10)
    assert [m.header.seq for m in found] == [1]
    assert warnings == [f"{folder} is gone: no joints until it is there again"]


def test_a_file_that_is_removed_as_soon_as_it_was_read_ends_no_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a_001_keypoints.json"
    people = json.dumps({"people": [{"pose_keypoints_2d": [1, 2, 0.9] * 17}]})

    def cleaned(file: Path) -> list[Any]:
        persons = read_picture(file)
        file.unlink()
        return persons

    monkeypatch.setattr("followspot_vision.keypoints_live.read_picture", cleaned)
    found, warnings = live(tmp_path, (path, people))
    assert [(m.header.seq, len(m.xy)) for m in found] == [(1, 17)]
    assert warnings == []


def test_pictures_come_when_their_files_do(tmp_path: Path) -> None:
    (tmp_path / "a_000_keypoints.json").write_text("old")
    one, two = tmp_path / "a_001_keypoints.json", tmp_path / "a_002_keypoints.json"
    people = json.dumps({"people": [{"pose_keypoints_2d": [1, 2, 0.9] * 17}]})
    found, warnings = live(tmp_path, None, (one, people), (two, people), fps=10)
    assert [(m.header.seq, m.header.time, len(m.xy)) for m in found] == [(1, 10**8, 17), (2, 2 * 10**8, 17)]
    assert warnings == []


def test_a_file_is_read_when_it_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "7.json"
    whole = json.dumps([instance(3)])
    found, warnings = live(tmp_path, (path, whole[:20]), None, (path, whole))
    assert [(m.header.seq, m.header.time) for m in found] == [(7, path.stat().st_mtime_ns)]
    assert warnings == []


def test_a_file_that_stays_broken_is_left_out_with_a_warning(tmp_path: Path) -> None:
    broken, good = tmp_path / "1.json", tmp_path / "2.json"
    found, warnings = live(tmp_path, (broken, "[{"), (good, json.dumps([instance(3)])), None, read_timeout=0)
    assert [m.header.seq for m in found] == [2]
    assert len(warnings) == 1
    assert "1.json:1:" in warnings[0]


def test_files_of_earlier_pictures_are_told_once(tmp_path: Path) -> None:
    people = json.dumps([instance(3)])
    one, two, three, four = (tmp_path / f"{number}.json" for number in (1, 2, 3, 4))
    found, warnings = live(tmp_path, (two, people), (one, people), (four, people), (three, people), None)
    assert [m.header.seq for m in found] == [2, 4]
    (told,) = warnings
    assert told.startswith(f"{one} was written after picture 2 and is left out")


def test_a_network_that_begins_anew_is_told(tmp_path: Path) -> None:
    people = json.dumps([instance(3)])
    one, two = tmp_path / "1.json", tmp_path / "2.json"
    found, warnings = live(tmp_path, (one, people), (two, people), None)
    assert ([m.header.seq for m in found], warnings) == ([1, 2], [])
    os.utime(one, ns=(0, two.stat().st_mtime_ns - 1))
    assert live(tmp_path, None, None) == ([], [])
    later = two.stat().st_mtime_ns + 1

    def again(seconds: float) -> bool:
        os.utime(one, ns=(later, later))
        return next(polls)

    polls = iter([True, True, False])
    told: list[str] = []
    stage = KeypointsLive(Context("live", ROOM, CAMERA, pause=again, warn=told.append), path=tmp_path)
    stage.setup()
    assert list(stage.process()) == []
    assert len(told) == 1
    assert "before a network begins anew, empty the folder" in told[0]


def test_a_live_folder_must_be_one(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text("[]")
    with pytest.raises(InputError, match="is no folder"):
        live(path)
