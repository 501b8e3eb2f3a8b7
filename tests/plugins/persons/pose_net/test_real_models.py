"""The networks that docs/pose_nets.md names, where their files are, find rendered people where they are."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.datasets import dataset
from tests.plugins.persons.detector_cameras import perspective
from tests.plugins.persons.drawn import frame_of, ready

from followspot import InputError
from followspot.people import Boxes
from followspot_persons.hog.stage import Hog
from followspot_persons.pose_net.blazepose import BlazePose
from followspot_persons.pose_net.loading import network
from followspot_persons.pose_net.stage import PoseNet

MODELS = Path(os.environ.get("FOLLOWSPOT_POSE_MODELS", "models"))
RECORDINGS = dataset("persons-dev")
MOVENET, BLAZEPOSE = MODELS / "movenet_multipose.onnx", MODELS / "pose_landmark_full.tflite"
DETECTOR = MODELS / "pose_detection.tflite"
EVERY = 25


def model(path: Path) -> Path:
    if not path.is_file():
        pytest.skip(f"no {path.name} in the folder FOLLOWSPOT_POSE_MODELS")
    return path


def pictures() -> list[tuple[np.ndarray, np.ndarray]]:
    """Every 25th picture of `d_p`, with the upper body in it."""
    if not RECORDINGS.is_dir():
        pytest.skip("no recordings persons-dev")
    truth = list(csv.DictReader((RECORDINGS / "d_p_gt.csv").open()))
    video, found = cv2.VideoCapture(str(RECORDINGS / "d_p.mp4")), []
    for row in truth:
        _, pixels = video.read()
        if int(row["frame"]) % EVERY == 0:
            found.append((pixels, np.array([float(row[key]) for key in ("ux0", "uy0", "ux1", "uy1")])))
    return found


def error(boxes: Boxes, truth: np.ndarray) -> float:
    """Largest distance of top, bottom or middle of the only box, over its height."""
    ((x0, y0, x1, y1),) = boxes.box
    apart = [y0 - truth[1], y1 - truth[3], (x0 + x1 - truth[0] - truth[2]) / 2]
    return float(np.abs(apart).max() / (truth[3] - truth[1]))


def test_movenet_finds_a_rendered_person_by_itself():
    pytest.importorskip("onnxruntime")
    camera = perspective()
    net = ready(PoseNet, camera, model=model(MOVENET))
    errors = [error(net.process(frame_of(camera, pixels)).boxes, truth) for pixels, truth in pictures()]
    assert len(errors) == 8
    assert max(errors) < 0.15


def test_blazepose_finds_the_joints_of_a_person_whom_hog_has_found():
    camera = perspective()
    detector = ready(Hog, camera)
    net = ready(PoseNet, camera, model=model(BLAZEPOSE), decoder="blazepose")
    frames = [(frame_of(camera, pixels), truth) for pixels, truth in pictures()[::2]]
    errors = [error(net.process(frame, detector.process(frame)).boxes, truth) for frame, truth in frames]
    assert max(errors) < 0.15


def test_the_detector_of_blazepose_is_no_model_of_landmarks():
    with pytest.raises(InputError, match="understands"):
        network(model(DETECTOR), BlazePose)
