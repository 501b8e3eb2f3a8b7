"""Outputs of pose networks become people: shapes, orders, units and scores."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.pose_net.tiny_models import movenet_row

from followspot_persons.pose_net.blazepose import BlazePose
from followspot_persons.pose_net.contract import Network, People
from followspot_persons.pose_net.movenet import MoveNetMultiPose


def test_movenet_takes_whole_numbers_and_gives_shares_of_the_sides_row_before_column():
    image = np.arange(64 * 96 * 3, dtype=np.uint8).reshape(64, 96, 3)
    decoder = MoveNetMultiPose()
    tensor = decoder.tensor(image)
    assert tensor.dtype == np.int32
    assert np.array_equal(tensor, image[None])
    rows = np.stack([movenet_row(0.7, nose=(0.25, 0.5, 0.9), right_ankle=(0.5, 1.0, 0.4)), movenet_row(0.1)])
    found = decoder.people([rows[None].astype(np.float32)], (96, 64))
    assert found.score == pytest.approx([0.7, 0.1])
    assert found.pixel[0, 0] == pytest.approx([23.5, 31.5])  # x 0.25 of 96 is the corner of pixel 24
    assert found.pixel[0, 16] == pytest.approx([47.5, 63.5])
    assert found.certainty[0, [0, 16]] == pytest.approx([0.9, 0.4])


def test_the_joints_of_movenet_are_those_of_coco_in_their_order():
    assert MoveNetMultiPose.joints[:7] == (
        *("nose", "left_eye", "right_eye", "left_ear", "right_ear"),
        *("left_shoulder", "right_shoulder"),
    )
    assert MoveNetMultiPose.joints[11:] == (
        *("left_hip", "right_hip", "left_knee", "right_knee", "left_ankle", "right_ankle"),
    )


def test_blazepose_gives_px_log_odds_of_joints_and_the_probability_of_a_person():
    decoder = BlazePose()
    tensor = decoder.tensor(np.full((256, 256, 3), 51, np.uint8))
    assert tensor.dtype == np.float32
    assert tensor == pytest.approx(0.2)
    landmarks = np.zeros((39, 5), np.float32)
    landmarks[23, :4] = 100.5, 30.5, -7, np.log(3)  # left hip
    found = decoder.people([np.zeros((1, 117)), landmarks.reshape(1, 195), np.array([[0.8]])], (256, 256))
    assert found.score == pytest.approx([0.8])
    assert len(decoder.joints) == 33
    hip = decoder.joints.index("left_hip")
    assert found.pixel[0, hip] == pytest.approx([100, 30])
    assert found.certainty[0, hip] == pytest.approx(0.75)
    assert found.certainty[0, 0] == pytest.approx(0.5)
    assert decoder.joints[11] == "left_shoulder"
    assert decoder.joints[28] == "right_ankle"


@pytest.mark.parametrize("shape", [(1, 6, 57), (6, 56), (2, 6, 56), (1, 10_000_000, 56)])
def test_outputs_of_another_model_are_refused_by_movenet(shape):
    output = np.broadcast_to(np.float32(0), shape)
    with pytest.raises(ValueError, match="MoveNet"):
        MoveNetMultiPose().people([output], (64, 64))


@pytest.mark.parametrize("sizes", [(195,), (195, 195, 1), (1,), ()])
def test_outputs_of_another_model_are_refused_by_blazepose(sizes):
    with pytest.raises(ValueError, match="BlazePose"):
        BlazePose().people([np.zeros((1, size)) for size in sizes], (256, 256))


class Given:
    """A session that gives an output whatever it sees, and notes what that was."""

    size = None

    def __init__(self, output: np.ndarray) -> None:
        self.output = output
        self.seen: list[tuple[int, ...]] = []

    def run(self, tensor: np.ndarray) -> list[np.ndarray]:
        self.seen.append(tensor.shape)
        return [self.output]


def test_a_batch_gives_one_answer_for_each_image_whatever_their_sizes():
    session = Given(movenet_row(0.6, nose=(0.5, 0.5, 1))[None, None])
    network = Network(session, MoveNetMultiPose())
    first, second = network.people([np.zeros((64, 96, 3), np.uint8), np.zeros((128, 64, 3), np.uint8)])
    assert session.seen == [(1, 64, 96, 3), (1, 128, 64, 3)]
    assert first.pixel[0, 0] == pytest.approx([47.5, 31.5])
    assert second.pixel[0, 0] == pytest.approx([31.5, 63.5])
    assert network.people([]) == []


@pytest.mark.parametrize("column", [0, 1, 2, 55])
def test_people_with_numbers_that_are_not_finite_are_left_out(column):
    rows = np.stack([movenet_row(0.6), movenet_row(0.9)])
    rows[0, column] = np.nan
    network = Network(Given(rows[None]), MoveNetMultiPose())
    assert network.people([np.zeros((64, 64, 3), np.uint8)])[0].score == pytest.approx([0.9])


def test_a_decoder_that_breaks_the_contract_is_found():
    class Short(MoveNetMultiPose):
        def people(self, outputs, size):
            return People(np.zeros((1, 3, 2)), np.zeros((1, 3)), np.zeros(1))

    with pytest.raises(ValueError, match="1 people with 17 joints"):
        Network(Given(np.zeros(1)), Short()).people([np.zeros((64, 64, 3), np.uint8)])
