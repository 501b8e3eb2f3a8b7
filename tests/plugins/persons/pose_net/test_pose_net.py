"""The stage: pictures of one or several cameras to joints and upper bodies."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from tests.plugins.persons.detector_cameras import panorama
from tests.plugins.persons.drawn import frame_of, perspective, ready
from tests.plugins.persons.pose_net.tiny_models import TINY_BLAZEPOSE, lit, movenet_row

import followspot as fs
from followspot import InputError, Room
from followspot.context import Context
from followspot.messages import identical, stamped
from followspot.people import Boxes
from followspot.points import Points2D
from followspot.testing import check_stage
from followspot_persons.body.upper_body_box import LEVELS
from followspot_persons.pose_net.movenet import MoveNetMultiPose
from followspot_persons.pose_net.stage import PoseNet

GRAPHS = Path(__file__).parents[4] / "graphs"
CAMERA = perspective()
WHITE = np.full((240, 320, 3), 255, np.uint8)


def person(x: float, top: float, height: float, score: float = 0.8, sides: float = 0.05) -> np.ndarray:
    """A row of MoveNet's output: an upright person at shares of the image; the left side is on the right."""
    joints = {}
    for name in MoveNetMultiPose.joints:
        side, _, part = name.rpartition("_")
        sign = {"left": 1, "right": -1}.get(side, 0)
        joints[name] = (x + sign * sides, top + (1 - LEVELS.get(part, 0.3)) * height, 0.9)
    return movenet_row(score, **joints)


@pytest.fixture
def movenet(tmp_path):
    pytest.importorskip("onnxruntime")

    def made(*rows: np.ndarray) -> Path:
        padded = [*rows, *[movenet_row(0.0)] * (6 - len(rows))]
        path = tmp_path / "movenet.onnx"
        path.write_bytes(lit(np.stack(padded)))
        return path

    return made


@pytest.fixture
def blazepose(tmp_path):
    path = tmp_path / "blazepose.tflite"
    path.write_bytes(TINY_BLAZEPOSE)
    return path


def boxed(*boxes: list[float], camera: str = "c") -> Boxes:
    none = np.zeros((len(boxes), 0))
    return Boxes(camera, np.array(boxes, float).reshape(-1, 4), np.ones(len(boxes)), none, none)


def joint(points: Points2D, name: str) -> np.ndarray:
    return points.pixel[points.label == points.labels.index(name)]


def test_people_of_a_picture_are_joints_by_person_and_upper_bodies(movenet):
    net = ready(PoseNet, CAMERA, model=movenet(person(0.25, 0.1, 0.6), person(0.7, 0.2, 0.7, score=0.5)))
    found = net.process(frame_of(CAMERA, WHITE))
    # 320 x 240 becomes 341 x 256 in 352 x 256
    assert joint(found.points, "nose") == pytest.approx(
        np.array([[0.25 * 352, 0.154 * 256], [0.7 * 352, 0.263 * 256]]) * [320 / 341, 240 / 256] - 0.5
    )
    assert found.points.instance.tolist() == [0] * 17 + [1] * 17
    assert found.boxes.box[0, [1, 3]] == pytest.approx([23.5, 23.5 + 0.385 * 0.6 * 240])
    assert found.boxes.score == pytest.approx([np.log(4 * 3), np.log(1 * 3)])
    assert len(net.process(frame_of(CAMERA, 0 * WHITE)).boxes.box) == 0


def test_scores_decide_who_and_what_counts(movenet):
    faint = person(0.7, 0.2, 0.7, score=0.3)
    faint[3 * 9 + 2] = 0.1  # left wrist
    model = movenet(person(0.25, 0.1, 0.6), faint)
    found = ready(PoseNet, CAMERA, model=model).process(frame_of(CAMERA, WHITE))
    assert len(joint(found.points, "left_wrist")) == 1
    assert len(joint(found.points, "right_wrist")) == 2
    strict = ready(PoseNet, CAMERA, model=model, minimum_score=0.4).process(frame_of(CAMERA, WHITE))
    assert len(joint(strict.points, "nose")) == 1


def test_a_body_that_is_found_twice_is_one_person_the_surer_one(movenet):
    rows = person(0.3, 0.1, 0.6, score=0.5), person(0.31, 0.1, 0.61, score=0.7), person(0.6, 0.1, 0.6)
    model = movenet(*rows)
    found = ready(PoseNet, CAMERA, model=model).process(frame_of(CAMERA, WHITE))
    assert joint(found.points, "nose")[:, 0] == pytest.approx(np.array([0.6, 0.31]) * 330.3 - 0.5, abs=0.1)
    all_three = ready(PoseNet, CAMERA, model=model, maximum_similarity=1.0)
    assert len(all_three.process(frame_of(CAMERA, WHITE)).boxes.box) == 3


def test_a_person_on_the_seam_of_a_panorama_is_found_once_with_places_in_the_picture(movenet):
    camera = panorama()
    seen = (1396 + 260) * 256 / 260
    width = -(-round(seen) // 32) * 32
    share = 1396 * 256 / 260 / width
    rows = person(share, 0.1, 0.8, sides=0.01), person(0.0, 0.1, 0.8, score=0.6, sides=0.01)
    found = ready(PoseNet, camera, model=movenet(*rows)).process(
        frame_of(camera, np.full((260, 1396, 3), 255, np.uint8))
    )
    assert len(found.boxes.box) == 1
    assert (found.points.pixel[:, 0] >= -0.5).all()
    assert (found.points.pixel[:, 0] < 1395.5).all()
    assert joint(found.points, "left_hip")[0, 0] == pytest.approx(0.01 * width * 260 / 256, abs=1)
    x0, _, x1, _ = found.boxes.box[0]
    assert -0.5 <= x0 < 1395.5 < x1


def test_a_person_beyond_the_seam_has_a_box_at_the_left_of_a_panorama(movenet):
    camera, column = panorama(), 1396 + 100
    width = -(-round((1396 + 260) * 256 / 260) // 32) * 32
    share = column * 256 / 260 / width
    net = ready(PoseNet, camera, model=movenet(person(share, 0.1, 0.8, sides=0.01)))
    found = net.process(frame_of(camera, np.full((260, 1396, 3), 255, np.uint8)))
    assert found.boxes.box[0, [0, 2]].mean() == pytest.approx(100, abs=1)


def test_blazepose_looks_beyond_the_seam_of_a_panorama(blazepose):
    camera = panorama()
    net = ready(PoseNet, camera, model=blazepose, decoder="blazepose")
    pixels = np.zeros((260, 1396, 3), np.uint8)
    pixels[:, :150] = pixels[:, -150:] = 255
    found = net.process(frame_of(camera, pixels), boxed([1376.0, 60.0, 1416.0, 120.0]))
    side = 1.3 * 60 / 0.385
    assert joint(found.points, "nose")[0, 0] == pytest.approx(side / 2, abs=1.5)  # r = 1 is its right border


def test_a_model_of_one_size_gets_pictures_in_that_size(movenet, tmp_path):
    path = tmp_path / "fixed.onnx"
    path.write_bytes(lit(np.stack([person(0.25, 0.1, 0.6)]), size=(96, 128)))
    found = ready(PoseNet, CAMERA, model=path).process(frame_of(CAMERA, WHITE))
    assert joint(found.points, "nose")[0] == pytest.approx([0.25 * 320 - 0.5, 0.154 * 240 - 0.5])


def test_blazepose_looks_at_each_box_and_needs_opencv_alone(blazepose):
    net = ready(PoseNet, CAMERA, model=blazepose, decoder="blazepose")
    frame = frame_of(CAMERA, WHITE)
    box = [150.0, 60.0, 190.0, 120.0]
    found = net.process(frame, stamped(boxed(box, [1e9, 0, 2e9, 5e8]), frame.header))
    side = 1.3 * 60 / 0.385
    middle = 170, 60 + 0.47 * 60 / 0.385
    nose = joint(found.points, "nose")
    assert nose[0] == pytest.approx([middle[0] + side / 2, middle[1] + side / 2], abs=1.5)  # r = g = 1
    assert set(found.points.instance.tolist()) == {0}
    assert len(found.points.label) == 33
    assert len(net.process(frame, None).points.label) == 0
    dark = net.process(frame_of(CAMERA, 0 * WHITE), boxed(box))
    assert len(dark.points.label) == 0  # the probability of a person is 0


def test_colours_reach_the_network_in_its_order_and_gray_pictures_as_gray(blazepose):
    net = ready(PoseNet, CAMERA, model=blazepose, decoder="blazepose", minimum_score=0.1)
    box = boxed([150.0, 80.0, 180.0, 125.0])
    red = np.zeros((240, 320, 3), np.uint8)
    red[..., 2] = 255
    place = joint(net.process(frame_of(CAMERA, red), box).points, "nose")[0]
    other = joint(net.process(frame_of(CAMERA, red[..., ::-1].copy()), box).points, "nose")[0]
    assert place[0] - other[0] == pytest.approx(1.3 * 45 / 0.385, abs=1.5)  # 256 r is its column
    assert place[1] == pytest.approx(other[1])
    gray = net.process(frame_of(CAMERA, np.full((240, 320, 1), 128, np.uint8)), box)
    assert joint(gray.points, "nose")[0] == pytest.approx([165, 80 + 0.47 * 45 / 0.385], abs=1.5)


def test_one_frame_in_so_many_is_searched(blazepose):
    net = ready(PoseNet, CAMERA, model=blazepose, decoder="blazepose", frame_interval=3)
    given = [net.process(frame_of(CAMERA, WHITE, number=n), boxed()) for n in range(5)]
    assert [one is not None for one in given] == [True, False, False, True, False]


def test_cameras_of_a_worker_share_a_model_and_get_what_each_gets_alone(movenet):
    cameras = [CAMERA, replace(CAMERA, name="d")]
    room = Room(cameras={camera.name: camera for camera in cameras})
    model = movenet(person(0.25, 0.1, 0.6))
    stages = [PoseNet(Context.serving(camera, room), model=model) for camera in cameras]
    for stage in stages:
        stage.setup()
    assert stages[0].network is stages[1].network
    frames = [frame_of(camera, WHITE // k) for k, camera in enumerate(cameras, 1)]
    together = PoseNet.process_together(stages, [(frame, None) for frame in frames])
    for stage, frame, found in zip(stages, frames, together, strict=True):
        alone = stage.process(frame)
        assert identical(alone.points, found.points)
        assert identical(alone.boxes, found.boxes)
        assert found.points.camera == stage.camera.name


def test_a_decoder_of_boxes_says_that_it_needs_them(blazepose):
    context = replace(Context.serving(CAMERA), receives=(type(frame_of(CAMERA, WHITE)),))
    with pytest.raises(InputError, match="blazepose needs boxes"):
        PoseNet(context, model=blazepose, decoder="blazepose").setup()
    fed = replace(context, receives=(*context.receives, Boxes))
    PoseNet(fed, model=blazepose, decoder="blazepose").setup()


def test_another_package_adds_a_decoder_by_a_subclass(movenet):
    class Mirrored(MoveNetMultiPose):
        def people(self, outputs, size):
            found = super().people(outputs, size)
            return replace(found, pixel=[size[0] - 1, 0] + [-1, 1] * found.pixel)

    class MyNet(PoseNet):
        """With a decoder more."""

        decoders: ClassVar = {**PoseNet.decoders, "mirrored": Mirrored}

    model = movenet(person(0.25, 0.1, 0.6))
    usual = ready(MyNet, CAMERA, model=model).process(frame_of(CAMERA, WHITE))
    found = ready(MyNet, CAMERA, model=model, decoder="mirrored").process(frame_of(CAMERA, WHITE))
    assert joint(found.points, "nose")[0, 0] == pytest.approx(
        329.3 - joint(usual.points, "nose")[0, 0], abs=0.1
    )


def test_it_keeps_every_promise_of_a_stage(movenet, blazepose):
    check_stage(PoseNet, messages=100, model=movenet(person(0.25, 0.1, 0.6)))
    check_stage(PoseNet, messages=100, model=blazepose, decoder="blazepose")


def test_it_takes_the_place_of_the_detector_in_the_graph_of_persons_by_set(movenet):
    words = {"hog.uses": "persons.pose_net", "hog.model": str(movenet(person(0.25, 0.1, 0.6)))}
    assert fs.check(GRAPHS / "person_panorama.yaml", set=words) == []
    wrong = fs.check(GRAPHS / "person_panorama.yaml", set={**words, "hog.decoder": "movenet"})
    assert [mistake.text for mistake in wrong] == ['no decoder is called "movenet"']
