"""What viewers of a recording are shown, in the schemas of Foxglove."""

from __future__ import annotations

import json
from base64 import b64decode
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader
from tests.plugins.recording.recorded_messages import ROOM, record

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, stamped
from followspot.room import Camera, LensModel, Room
from followspot.rotation import matrix
from followspot.tracking import Blobs, Positions
from followspot_recording.foxglove import cameras_of, view_of


@pytest.mark.parametrize("pictures", ["jpeg", "png", "raw"])
def test_what_viewers_are_shown_fits_its_foxglove_schema(tmp_path: Path, pictures: str) -> None:
    with record(tmp_path / "a.mcap", 3, picture_format=pictures).open("rb") as file:
        views = [m for m in make_reader(file).iter_messages() if m[1].message_encoding == "json"]
    names = set()
    for schema, _, message in views:
        assert schema is not None
        names.add(schema.name)
        told = json.loads(schema.data)
        jsonschema.Draft202012Validator.check_schema(told)
        jsonschema.validate(json.loads(message.data), told)
    image = "foxglove.RawImage" if pictures == "raw" else "foxglove.CompressedImage"
    room = {"foxglove.CameraCalibration", "foxglove.FrameTransform"}
    assert names == {image, "foxglove.SceneUpdate", "foxglove.Log", *room}


def told_of(camera: Camera) -> dict[str, dict[str, Any]]:
    """What viewers are told of a camera, by schema."""
    views = cameras_of(Room(cameras={camera.name: camera}), 1_500_000_000)
    return {schema.name: json.loads(data) for _, schema, data in views}


@pytest.mark.parametrize(
    ("model", "terms", "name"),
    [("pinhole", 5, "plumb_bob"), ("rational", 8, "rational_polynomial"), ("fisheye", 4, "kannala_brandt")],
)
def test_viewers_are_told_where_a_camera_stands_and_its_lens(model: LensModel, terms: int, name: str) -> None:
    known = ROOM.cameras["cam0"]
    rotation, _ = cv2.Rodrigues(np.array([0.3, -1.2, 2.0]))
    place = np.array([0.5, -0.25, 2.0])
    camera = replace(
        known, model=model, distortion=np.full(terms, 0.01), rotation=rotation, translation=place
    )
    told = told_of(camera)
    frame, lens = told["foxglove.FrameTransform"], told["foxglove.CameraCalibration"]
    assert (
        (frame["parent_frame_id"], frame["child_frame_id"]) == ("room", "cam0") == ("room", lens["frame_id"])
    )
    turn = np.array([frame["rotation"][axis] for axis in "wxyz"])
    origin = np.array([frame["translation"][axis] for axis in "xyz"])
    np.testing.assert_allclose(matrix(turn), rotation.T, atol=1e-12)
    np.testing.assert_allclose(rotation @ origin + place, np.zeros(3), atol=1e-12)
    assert (lens["distortion_model"], lens["D"]) == (name, [0.01] * terms)
    assert (lens["width"], lens["height"]) == known.size
    np.testing.assert_array_equal(np.reshape(lens["K"], (3, 3)), known.matrix)
    np.testing.assert_array_equal(np.reshape(lens["P"], (3, 4))[:, :3], known.matrix)


def test_viewers_are_told_the_place_alone_of_a_panorama() -> None:
    assert set(told_of(replace(ROOM.cameras["cam0"], model="cylinder"))) == {"foxglove.FrameTransform"}


def shown(message: Message) -> dict[str, Any]:
    """What viewers are shown of it, held against its schema."""
    view = view_of(stamped(seal(message), Header("x", 0, 1_500_000_000)), ROOM, "none")
    assert view is not None
    schema, data = view
    told: dict[str, Any] = json.loads(data)
    jsonschema.validate(told, json.loads(schema.text))
    return told | {"schema": schema.name}


def test_viewers_are_shown_points_in_pictures_and_in_the_room() -> None:
    pixel = np.array([[10.5, 20.0], [np.nan, 0.0]])
    two = np.zeros(2)
    marks = shown(Blobs("cam0", pixel, pixel, two, two, np.zeros((2, 1), bool)))
    assert marks["schema"] == "foxglove.ImageAnnotations"
    assert [points["points"] for points in marks["points"]] == [[{"x": 10.5, "y": 20.0}]]
    empty = Positions.empty()
    xyz = np.array([[1.0, -2.0, 0.5]])
    whole, yes = np.zeros(1, "i4"), np.ones(1, bool)
    cloud = shown(
        replace(
            empty,
            target=whole,
            xyz=xyz,
            covariance=np.zeros((1, 3, 3)),
            support=whole,
            confirmed=yes,
            evident=yes,
            iterations=whole,
            predicted=yes,
        )
    )
    assert (cloud["schema"], cloud["timestamp"]) == ("foxglove.PointCloud", {"sec": 1, "nsec": 500_000_000})
    assert np.frombuffer(b64decode(cloud["data"]), "<f4").tolist() == xyz[0].tolist()
    assert shown(empty)["data"] == ""
