"""Joints from the files of OpenPose and in COCO's format for results."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import followspot as fs
from followspot import Context, InputError
from followspot.room import Member
from followspot.testing import check_stage, tiny_room
from followspot_vision.keypoints_json import KeypointsJson
from followspot_vision.skeletons import BODY_25, COCO, OPENPOSE_18

ROOM = tiny_room()


def read(path: Path, camera: str = "cam0", **params: Any) -> list[Any]:
    stage = KeypointsJson(Context("a", ROOM, Member("cameras", camera)), path=path, **params)
    stage.setup()
    found = list(stage.process())
    assert stage.length() == len(found)
    return found


def body(count: int, x: float) -> list[float]:
    """Joint i at (x, i), all but the first two not found."""
    return [value for i in range(count) for value in (x, i, 0.9 if i < 2 else 0.0)]


def coco(*results: tuple[object, list[float]]) -> str:
    return json.dumps(
        [{"image_id": image, "category_id": 1, "keypoints": k, "score": 1} for image, k in results]
    )


def test_coco_results_give_a_message_for_each_picture(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(coco((3, body(17, 10)), (1, body(17, 20)), (3, body(17, 30))))
    first, second, third = read(path, fps=10, first_picture=1)
    assert (first.header.time, third.header.time) == (0, 200_000_000)
    assert (first.labels, first.pixel.tolist()) == (("nose", "left_eye"), [[20, 0], [20, 1]])
    assert len(second.xy) == 0
    assert third.instance.tolist() == [0, 0, 1, 1]
    assert [third.labels[i] for i in third.label] == ["nose", "left_eye"] * 2


def test_images_may_be_named_by_their_files(tmp_path: Path) -> None:
    (tmp_path / "cam0.json").write_text(coco(("video/000001.jpg", body(17, 5))))
    assert [len(message.xy) for message in read(tmp_path)] == [0, 2]


def test_openpose_writes_a_folder_for_each_camera(tmp_path: Path) -> None:
    folder = tmp_path / "cam1"
    folder.mkdir()
    for number, people in ((0, [25]), (2, [25, 25]), (10, [])):
        written = {"version": 1.3, "people": [{"pose_keypoints_2d": body(n, 7.0)} for n in people]}
        (folder / f"cam1_{number:012}_keypoints.json").write_text(json.dumps(written))
    found = read(tmp_path, "cam1")
    assert [len(message.xy) for message in found] == [2, 0, 4, *[0] * 8]
    assert found[0].labels == ("nose", "neck")


def test_skeletons_are_those_of_the_programs() -> None:
    assert (len(COCO), len(OPENPOSE_18), len(BODY_25)) == (17, 18, 25)
    assert (COCO[5], COCO[6], COCO[15]) == ("left_shoulder", "right_shoulder", "left_ankle")
    assert (BODY_25[8], BODY_25[9], BODY_25[14], BODY_25[19], BODY_25[24]) == (
        *("mid_hip", "right_hip", "left_ankle", "left_big_toe", "right_heel"),
    )
    assert (OPENPOSE_18[8], OPENPOSE_18[13], OPENPOSE_18[14]) == ("right_hip", "left_ankle", "right_eye")


def test_other_skeletons_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(coco((0, body(2, 3))))
    (found,) = read(path, joints=["tip", "tail"])
    assert found.labels == ("tip", "tail")
    with pytest.raises(InputError, match=r"(?s)persons with 2 joints.*joints: \[\.\.\.\]; known are"):
        read(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[\n{]", r"a\.json:2:2: this is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ('[{"image_id": 1, "keypoints": [], "keypoints": [1, 2, 1]}]', 'an object has "keypoints" twice'),
        ("3", "is no list of results"),
        ('{"annotations": 3}', "is no list of results"),
        ("[3]", r"\[0\] has no image_id"),
        ('[{"image_id": 1}]', r"\[0\] has no keypoints"),
        ('[{"image_id": -1, "keypoints": []}]', "image_id is '-1'"),
        ('[{"image_id": true, "keypoints": []}]', "image_id is 'True'"),
        ('[{"image_id": 1, "keypoints": [1, 2]}]', "has no list x, y, score"),
        ('[{"image_id": 1, "keypoints": [1, 2, NaN]}]', "NaN is no number"),
        ('[{"image_id": 1, "keypoints": [1, 2, "a"]}]', 'number 2 is "a"'),
        ('[{"image_id": 1, "keypoints": [1, 2, null]}]', "number 2 is null.*not found has the score 0"),
        ('[{"image_id": 1, "keypoints": [1e300, 2, 1]}]', "numbers lie within 1000000"),
        ('[{"image_id": 99999999999999999999, "keypoints": []}]', "image_id is"),
        ('[{"image_id": 2000000000, "keypoints": []}]', "goes up to picture 2000000000.*at most"),
        (json.dumps([{"image_id": 1, "keypoints": []}] * 1001), "a picture has 1001 persons"),
    ],
)
def test_a_file_that_is_wrong_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError, match=f"(?s){said}"):
        read(path)


VALUES = st.none() | st.booleans() | st.integers(-5, 10**20) | st.floats() | st.text(max_size=3)
KEYS = st.sampled_from(["image_id", "keypoints", "annotations", "people", "score"])
JSON = st.recursive(
    VALUES, lambda inner: st.lists(inner, max_size=6) | st.dictionaries(KEYS, inner, max_size=3)
)


@settings(max_examples=200, deadline=None)
@given(JSON)
def test_any_json_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, data: Any) -> None:
    path = tmp_path_factory.getbasetemp() / "any.json"
    path.write_text(json.dumps(data))
    with suppress(InputError):
        read(path)


def test_pictures_before_the_first_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(coco((3, body(17, 1))))
    with pytest.raises(InputError, match=r"(?s)begins with picture 3.*with: \{first_picture: 3\}"):
        read(tmp_path / "a.json", first_picture=4)


def test_an_openpose_file_without_people_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x_000_keypoints.json").write_text("{}")
    with pytest.raises(InputError, match=r"x_000_keypoints\.json has no list people"):
        read(tmp_path)


def test_two_cameras_in_one_folder_are_refused(tmp_path: Path) -> None:
    for camera in ("a", "b"):
        (tmp_path / f"{camera}_000_keypoints.json").write_text("{}")
    with pytest.raises(InputError, match=r"(?s)are of one picture.*a folder of its own"):
        read(tmp_path)


@pytest.mark.parametrize("name", ["cam0.json", "cam0"])
def test_results_of_one_camera_are_not_those_of_another(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    if path.suffix:
        path.write_text(coco((0, body(17, 3))))
    else:
        path.mkdir()
    read(path, "cam0")
    with pytest.raises(InputError, match="has the name of camera cam0, and is read for cam1, too"):
        read(path, "cam1")


def test_pictures_that_the_network_left_out_are_doubted(tmp_path: Path) -> None:
    folder = tmp_path / "cam0"
    folder.mkdir()
    for number in range(0, 60, 5):
        (folder / f"cam0_{number:012}_keypoints.json").write_text('{"people": []}')
    told: list[str] = []
    KeypointsJson(
        Context("a", ROOM, Member("cameras", "cam0"), warn=told.append), path=tmp_path, fps=25
    ).setup()
    assert len(told) == 1
    assert told[0].endswith(
        "steps of 5, and those between count as empty: number them 0, 1, 2, ... and say fps: 5"
    )


def test_pictures_without_a_file_are_told(tmp_path: Path) -> None:
    for number in (0, 1, 4, 5):
        (tmp_path / f"a_{number:012}_keypoints.json").write_text('{"people": []}')
    told: list[str] = []
    KeypointsJson(Context("a", ROOM, Member("cameras", "cam0"), warn=told.append), path=tmp_path).setup()
    assert told == [f"{tmp_path}: 2 pictures have no file, the first of them 2, and count as empty"]


def test_pictures_of_another_camera_are_not_taken_for_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(coco(("cam0_000001.jpg", body(17, 5)), ("out/cam1/000001.jpg", body(17, 6))))
    with pytest.raises(InputError, match=r"(?s)\[1\].image_id is .*of camera cam1, and is read for cam0"):
        read(path)
    path.write_text(coco(("cam0_000001.jpg", body(17, 5)), ("cam1/cam0_000002.jpg", body(17, 6))))
    assert [len(message.xy) for message in read(path)] == [0, 2, 2]


def test_a_file_in_another_encoding_is_refused_with_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_bytes("[]".encode("utf-16"))
    with pytest.raises(InputError, match=r"(?s)is not UTF-8.*save it as UTF-8"):
        read(tmp_path / "a.json")


def test_the_source_keeps_the_promises_of_stages(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(coco((0, body(17, 3)), (2, body(17, 4))))
    check_stage(KeypointsJson, path=str(tmp_path / "a.json"))


def test_a_run_whose_joints_all_have_the_score_0_says_where_to_look(tmp_path: Path) -> None:
    (tmp_path / "cam0.json").write_text(json.dumps([{"image_id": 1, "keypoints": [1, 2, 0] * 17}]))
    graph = fs.Graph("scores", room=Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
    joints = graph.add("joints", "vision.keypoints_json", each="cameras[name=cam0]", path=str(tmp_path))
    graph.add("save", "sinks.csv", joints=joints, path="joints.csv")
    with pytest.warns(UserWarning, match="joints with the score 0"), fs.run(graph, out=tmp_path) as run:
        run.wait()
