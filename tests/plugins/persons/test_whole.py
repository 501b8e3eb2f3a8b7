"""Whole bodies that speak for the upper ones."""

import csv
from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data

from followspot import Camera, InputError
from followspot.context import Context
from followspot.tracking import Frame
from followspot_persons.hog import whole
from followspot_persons.hog.model import DIRECTIONS, Classification
from followspot_persons.hog.network import Network
from followspot_persons.hog.stage import Hog
from followspot_persons.hog.trees import Trees
from followspot_persons.hog.whole import DOUBT, parts, raised, within
from followspot_persons.hog.whole_model import (
    INPUTS,
    LAYOUT,
    SHIPPED_WHOLE,
    TREES,
    WholeModel,
    load,
    save,
    whole_log_odds,
)

PIXELS = np.random.default_rng(0).integers(0, 256, (300, 400, 3), np.uint8)
BOX = np.array([100.0, 20, 140, 80])


def saying(odds, by_network=None):
    """A network and trees that say the same of all, and both the same if one is not given."""
    one = np.zeros((1, 3), np.float32)
    trees = Trees(np.zeros((1, 3), np.intp), one, np.full((1, 4), odds, np.float32))
    said = np.float32(odds if by_network is None else by_network)
    nothing = np.zeros((INPUTS, 1), np.float32), np.zeros(1, np.float32), np.zeros((1, 1), np.float32)
    return WholeModel(Network(*nothing, said[None]), trees)


def test_a_whole_body_is_as_sure_as_the_weighted_mean_of_trees_and_network():
    windows = whole.windows(PIXELS, np.tile(BOX, (3, 1)))
    assert whole_log_odds(saying(4.0, -1.0), windows) == pytest.approx([TREES * 4 - (1 - TREES)] * 3)


def test_the_network_judges_what_the_window_shows():
    """Its only unit adds up all channels, which a flat picture has less of."""
    model = saying(0.0, 0.0)
    sum_of = replace(
        model.network, hidden=np.ones((INPUTS, 1), np.float32), output=np.ones((1, 1), np.float32)
    )
    rough, flat = PIXELS, np.full_like(PIXELS, 128)
    box = BOX[None]
    said = [
        whole_log_odds(replace(model, network=sum_of), whole.windows(pixels, box))[0]
        for pixels in (rough, flat)
    ]
    assert said[0] > said[1] + 1


def test_a_surer_whole_body_raises_a_score_to_the_mean_and_an_unsure_one_changes_nothing():
    box, score = np.tile(BOX, (3, 1)), np.array([-1.0, 2.0, 5.0])
    assert raised(saying(4.0), 0.5, PIXELS, box, score) == pytest.approx([1.5, 3.0, 5.0])
    assert raised(saying(4.0), 0.25, PIXELS, box, score) == pytest.approx([0.25, 2.5, 5.0])
    assert raised(saying(-9.0), 0.5, PIXELS, box, score) == pytest.approx(score)
    assert score.tolist() == [-1.0, 2.0, 5.0]  # what was given stays


def test_what_is_hardly_an_upper_body_is_not_looked_at():
    score = np.array([DOUBT - 0.1, DOUBT + 0.1])
    found = raised(saying(4.0), 0.5, PIXELS, np.tile(BOX, (2, 1)), score)
    assert found[0] == score[0]
    assert found[1] == pytest.approx((4.0 + score[1]) / 2)


def test_no_boxes_have_no_scores():
    assert raised(saying(4.0), 0.5, PIXELS, np.empty((0, 4)), np.empty(0)).shape == (0,)


def test_legs_count_where_the_picture_has_them():
    """The upper body is 60 px high, so the feet are 145 px below the head's top."""
    down, across = np.array([0, 1, 0, 1]), np.array([1, 0, 1, 0])
    low, outside = BOX + 137 * down, BOX - 101 * across
    assert within(np.array([BOX, BOX + 135 * down, low, outside]), PIXELS.shape).tolist() == [
        True,
        True,
        False,
        False,
    ]
    score = np.array([-1.0, -1.0])
    assert raised(saying(4.0), 0.5, PIXELS, np.array([low, BOX]), score) == pytest.approx([-1.0, 1.5])


def test_a_window_has_head_and_waist_in_their_rows():
    """A picture whose rows tell where they are, at twice the window's size."""
    rows = np.repeat(np.arange(300, dtype=np.uint8)[:, None], 400, axis=1)
    [window] = whole.windows(np.repeat(rows[:, :, None], 3, axis=2), np.array([[100.0, 40, 188, 128]]))
    assert window.shape == (LAYOUT.height, LAYOUT.width, 3)
    assert int(window[14, 30, 0]) == pytest.approx(40, abs=1.5)
    assert int(window[58, 30, 0]) == pytest.approx(128, abs=1.5)


def test_weights_come_back_as_they_were_written(tmp_path):
    model = load(SHIPPED_WHOLE)
    save(model, tmp_path / "again.npz")
    again = load(tmp_path / "again.npz")
    for name in ("feature", "threshold", "leaf"):
        assert np.array_equal(getattr(model.trees, name), getattr(again.trees, name))
    for name in ("hidden", "hidden_bias", "output", "output_bias"):
        assert np.array_equal(getattr(model.network, name), getattr(again.network, name))
    assert SHIPPED_WHOLE.stat().st_size < 1_000_000


def test_files_that_do_not_tell_whole_bodies_are_refused(tmp_path):
    model = load(SHIPPED_WHOLE)
    trees, network = model.trees, model.network

    def written(name, **changed):
        save(replace(model, **changed), tmp_path / f"{name}.npz")

    written("beyond", trees=replace(trees, feature=np.full_like(trees.feature, INPUTS)))
    written("nan", trees=replace(trees, leaf=np.full_like(trees.leaf, np.nan)))
    written("endless", network=replace(network, output=np.full_like(network.output, np.inf)))
    written("narrow", network=replace(network, hidden=network.hidden[1:]))
    written("two", network=replace(network, output_bias=np.zeros(2, np.float32)))
    np.savez(tmp_path / "other.npz", linear=np.zeros(3))
    for name, cause in (
        ("beyond", "beyond 0 to"),
        ("nan", "tree_leaf holds numbers that are not finite"),
        ("endless", "output holds numbers that are not finite"),
        ("narrow", "hidden has shape"),
        ("two", "output_bias has shape"),
        ("other", "tree_feature"),
        ("no", "No such"),
    ):
        with pytest.raises(InputError, match=cause):
            load(tmp_path / f"{name}.npz")


def view():
    facing = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0.0]])
    matrix = np.array([[457.0, 0, 319.5], [0, 457.0, 239.5], [0, 0, 1]])
    return Camera("c", "color", (640, 480), matrix, np.zeros(5), facing, -facing @ [0, 0, 1.2])


def boxes(pixels, share, weights=SHIPPED_WHOLE):
    stage = Hog(Context.serving(view()), whole_share=share, weights_whole=str(weights))
    stage.setup()
    return stage.process(Frame(camera="c", pixels=pixels))


def test_legs_decide_whether_somebody_is_there_and_the_upper_body_where_and_how_turned():
    """Of two windows of one body the legs below speak for the lower one, whose upper body hardly counts."""
    stage = Hog(Context.serving(view()))
    stage.setup()
    box = np.array([[100.0, 100, 160, 160], [104.0, 112, 164, 172]])
    ahead, aside = np.eye(DIRECTIONS)[[0, 4]] - 1
    said = Classification(np.array([1.0, -2.0]), np.array([ahead, aside]), np.array([ahead, aside]))
    alone, legs = stage.boxes(box, said, said.score), stage.boxes(box, said, np.array([1.0, 4.0]))
    assert len(alone.score) == 0
    assert legs.score.tolist() == [pytest.approx(np.log((np.e + np.exp(4.0)) / 4))]
    share = 1 / (1 + np.exp(-3))
    assert legs.box[0] == pytest.approx(share * box[0] + (1 - share) * box[1])
    assert legs.torso[0] == pytest.approx(share * ahead + (1 - share) * aside)
    assert legs.head[0] == pytest.approx(legs.torso[0])


def test_an_arm_and_a_leg_of_a_surer_person_are_nobody_and_who_stands_apart_or_is_sure_alone_stays():
    body, part, apart = [200.0, 100, 300, 200], [180.0, 210, 215, 260], [500.0, 210, 535, 260]
    beside = [1000 - 20.0, 210, 1000 + 15, 260]
    box = np.array([body, part, apart, beside])
    assert parts(box, np.array([False, True, True, True]), 0.75, 0.0).tolist() == [False, True, False, False]
    assert not parts(box, np.array([False, False, True, True]), 0.75, 0.0).any()
    assert not parts(box[[1, 0]], np.array([True, False]), 0.75, 0.0).any()
    around = np.array([[0.0, 100, 100, 200], beside])
    assert parts(around, np.array([False, True]), 0.75, 1000.0).tolist() == [False, True]


def test_legs_speak_for_nobody_within_a_surer_person():
    stage = Hog(Context.serving(view()))
    stage.setup()
    box = np.array([[200.0, 100, 300, 200], [180.0, 210, 215, 260]])
    flat = np.zeros((2, DIRECTIONS))
    said = Classification(np.array([4.0, -1.0]), flat, flat)
    assert stage.boxes(box, said, np.array([4.0, 3.0])).box == pytest.approx(box[:1])
    box[1, [0, 2]] += 300
    assert len(stage.boxes(box, said, np.array([4.0, 3.0])).box) == 2


def person():
    """A picture of `d_p` that shows a person down to the feet."""
    with (dataset("persons-dev") / "d_p_gt.csv").open(newline="") as stream:
        truth = {int(row["frame"]): row for row in csv.DictReader(stream)}
    rows = {n: np.array([float(r[c]) for c in ("ux0", "uy0", "ux1", "uy1")]) for n, r in truth.items()}
    number = next(n for n in range(0, 200, 10) if within(rows[n][None], (480, 640))[0])
    video = cv2.VideoCapture(str(dataset("persons-dev") / "d_p.mp4"))
    for _ in range(number):
        assert video.grab()
    return np.asarray(video.read()[1])


@needs_data("persons-dev")
def test_a_person_seen_to_the_feet_is_surer_by_the_legs_and_no_box_is_lost(tmp_path):
    pixels, sure = person(), tmp_path / "sure.npz"
    save(saying(9.0), sure)
    alone, both, told = (
        boxes(pixels, 0.0),
        boxes(pixels, 0.5),
        boxes(pixels, 0.5, sure),
    )
    assert len(both.score) >= len(alone.score) >= 1
    assert both.score.max() >= alone.score.max()
    assert told.score.max() > alone.score.max() + 1
