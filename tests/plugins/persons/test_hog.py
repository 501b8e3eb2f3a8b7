"""Windows, groups and weights of the detector of upper bodies."""

import csv
import pickle
from dataclasses import replace

import cv2
import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.plugins.persons.detector_cameras import panorama, perspective

from followspot import InputError
from followspot.context import Context
from followspot.files import DATA
from followspot.messages import Header, stamped
from followspot.tracking import Frame
from followspot_persons.hog.cells import CELL_FEATURES, cell_features
from followspot_persons.hog.channels import CHANNELS
from followspot_persons.hog.model import DIRECTIONS, SHIPPED, classify, load, save, trusted
from followspot_persons.hog.search import groups, nesting, outermost, overlap
from followspot_persons.hog.stage import Hog
from followspot_persons.hog.window import BODY, HEIGHT, WIDTH, cut
from followspot_persons.people_detector import PeopleDetector

PERSONS = dataset("persons-dev")
needs_recordings = needs_data("persons-dev")


def ready(stage, camera, **params):
    made = stage(Context.serving(camera), **params)
    made.setup()
    return made


def test_a_box_of_the_size_of_the_window_is_cut_without_change():
    pixels = np.random.default_rng(0).integers(0, 256, (120, 100, 3), np.uint8)
    window = cut(pixels, BODY + np.tile([20, 30], 2))
    assert np.array_equal(window, pixels[30 : 30 + HEIGHT, 20 : 20 + WIDTH])


@pytest.mark.parametrize("scale", [0.5, 2.0, 4.0])
def test_a_window_shows_the_same_in_any_size_of_the_picture(scale):
    v, u = np.mgrid[:120, :100]
    wave = 128 + 60 * np.sin(u / 9) + 40 * np.cos(v / 11)
    pixels = np.repeat(wave[:, :, None], 3, axis=2).astype(np.uint8)
    kind = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    resized = cv2.resize(pixels, None, fx=scale, fy=scale, interpolation=kind)
    box = BODY + np.tile([20, 30], 2)
    apart = cut(resized, box * scale).astype(int) - cut(pixels, box)
    assert np.abs(apart).max() <= 12  # of a contrast of 200: half a pixel would be 15


def test_beyond_the_picture_its_border_goes_on():
    pixels = np.zeros((100, 100, 3), np.uint8)
    pixels[:, 0] = 77
    assert (cut(pixels, BODY - [40, 0, 40, 0])[:, :30] == 77).all()


def test_looks_do_not_depend_on_the_exposure():
    window = np.random.default_rng(1).integers(40, 120, (1, HEIGHT, WIDTH, 3), np.uint8)
    dark, bright = cell_features(window), cell_features(2 * window)
    assert dark.shape == (1, CELL_FEATURES)
    brightness = slice(9 * 144, 9 * 144 + 80)
    assert np.abs(dark[0, brightness] - bright[0, brightness]).max() < 0.1


def test_overlap_reaches_across_the_seam():
    left, right = np.array([2.0, 0, 50, 72]), np.array([[1390.0, 0, 1438, 72]])
    assert overlap(left, right, 1396.0)[0] == pytest.approx(40 / 56)
    assert overlap(left, right, 0.0)[0] == 0


def test_groups_are_headed_by_the_best_and_share_no_row():
    box = np.array([[0, 0, 48, 72], [4, 0, 52, 72], [200, 0, 248, 72], [6, 2, 54, 74.0]])
    found = groups(box, np.array([1.0, 3.0, 2.0, 0.5]), 0.5, 0.0)
    assert [group.tolist() for group in found] == [[1, 0, 3], [2]]


def test_a_box_within_a_better_one_is_no_other_body():
    whole, part, beside = [0, 0, 96, 144.0], [24, 0, 72, 72.0], [100, 0, 196, 144.0]
    box = np.array([part, whole, beside])
    assert nesting(box[0], box[1:2], 0.0)[0] == 1
    assert outermost(box, np.array([2.0, 3.0, 1.0]), 0.75, 0.0).tolist() == [1, 2]
    assert outermost(box, np.array([4.0, 3.0, 1.0]), 0.75, 0.0).tolist() == [0, 2]


def test_trust_bounds_how_unlikely_a_direction_may_be():
    logits = np.zeros((1, DIRECTIONS))
    logits[0, 3] = 50
    sure, doubting = trusted(logits, 1.0, 0.0), trusted(logits, 1.0, 0.16)
    assert sure[0, 3] == pytest.approx(0)
    assert np.exp(doubting[0, 5]) == pytest.approx(0.01)
    assert np.exp(doubting).sum() == pytest.approx(1)


def test_weights_come_back_as_they_were_written(tmp_path):
    model = load(SHIPPED)
    save(model, tmp_path / "again.npz")
    again = load(tmp_path / "again.npz")
    window = np.random.default_rng(2).integers(0, 256, (3, HEIGHT, WIDTH, 3), np.uint8)
    assert np.array_equal(classify(model, window).score, classify(again, window).score)
    assert SHIPPED.stat().st_size < 1_500_000


def tree(feature):
    """Arrays of one tree that asks for a feature at its root."""
    return {
        "tree_feature": np.array([[feature, 0, 0]]),
        "tree_threshold": np.zeros((1, 3)),
        "tree_leaf": np.zeros((1, 4)),
    }


def test_weights_without_trees_are_those_of_a_network_alone(tmp_path):
    with np.load(SHIPPED) as stored:
        np.savez(tmp_path / "old.npz", **{n: a for n, a in stored.items() if not n.startswith("tree_")})
    window = np.random.default_rng(2).integers(0, 256, (3, HEIGHT, WIDTH, 3), np.uint8)
    model = load(tmp_path / "old.npz")
    hidden = np.maximum(cell_features(window) @ model.hidden + model.hidden_bias, 0)
    np.testing.assert_allclose(
        classify(model, window).score, hidden @ model.output[:, 0] + model.output_bias[0], rtol=1e-4
    )


def test_scores_are_calibrated():
    model, window = load(SHIPPED), np.random.default_rng(2).integers(0, 256, (3, HEIGHT, WIDTH, 3), np.uint8)
    before = classify(model, window)
    after = classify(replace(model, calibration=np.array([2.0, -1.5])), window)
    np.testing.assert_allclose(after.score, 2 * before.score - 1.5, rtol=1e-6)
    assert np.array_equal(after.torso, before.torso)


def test_files_that_hold_no_weights_are_refused(tmp_path):
    def broken(name, **changes):
        with np.load(SHIPPED) as stored:
            arrays = {**dict(stored), **changes}
        np.savez(tmp_path / name, **arrays)
        return tmp_path / name

    evil = tmp_path / "evil.npz"
    evil.write_bytes(pickle.dumps([1, 2]))
    huge = tmp_path / "huge.npz"
    with huge.open("wb") as file:
        file.truncate(DATA + 1)
    bomb = tmp_path / "bomb.npz"
    np.savez_compressed(bomb, linear=np.zeros(DATA // 8 + 1))
    assert bomb.stat().st_size < 1_000_000
    cases = {
        evil: "not a zip file",
        bomb: "unpacks to",
        huge: "larger",
        tmp_path / "missing.npz": "No such file",
        broken("short.npz", linear=np.zeros(7)): "linear has shape",
        broken("leaves.npz", tree_leaf=np.zeros((7, 4))): "tree_feature has shape",
        broken("leaf.npz", tree_leaf=np.zeros(())): "has shape",
        broken(
            "beyond.npz", **tree(CELL_FEATURES + CHANNELS)
        ): "tree_feature holds numbers of features beyond",
        broken("half.npz", calibration=np.ones(3)): "calibration has shape",
        broken("turned.npz", calibration=np.array([-1.0, 0.0])): "a factor that is not above 0",
        broken("nan.npz", output_bias=np.full(33, np.nan)): "not finite",
        broken("object.npz", trust=np.array([[None, 1], [2, 3]], object)): "allow_pickle",
    }
    for path, cause in cases.items():
        with pytest.raises(InputError, match=cause):
            load(path)


@pytest.mark.parametrize("stage", [Hog, PeopleDetector])
def test_only_every_nth_frame_is_searched(stage):
    made = ready(stage, perspective(), frame_interval=3)
    frame = Frame(camera="c", pixels=np.full((480, 640, 3), 90, np.uint8))
    said = [made.process(stamped(frame, Header("camera", seq, seq))) for seq in range(4)]
    assert [boxes is None for boxes in said] == [False, True, True, False]
    assert said[0].box.shape == (0, 4)


def test_grey_pictures_are_searched_too():
    made = ready(Hog, perspective())
    grey = np.random.default_rng(3).integers(0, 256, (480, 640, 1), np.uint8)
    assert made.process(Frame(camera="c", pixels=grey)).torso.shape[1] == DIRECTIONS


def pictures_of(video, numbers):
    capture = cv2.VideoCapture(str(PERSONS / video))
    for number in range(max(numbers) + 1):
        assert capture.grab()
        if number in numbers:
            yield number, capture.retrieve()[1]


@needs_recordings
def test_a_person_on_the_seam_is_found_as_elsewhere():
    made = ready(Hog, panorama())
    [(_, pixels)] = pictures_of("d_o.mp4", [0])
    plain = made.process(Frame(camera="c", pixels=pixels))
    best = int(np.argmax(plain.score))
    middle = int(plain.box[best, [0, 2]].mean())
    moved = made.process(Frame(camera="c", pixels=np.roll(pixels, -middle, axis=1)))
    again = int(np.argmax(moved.score))
    shifted = plain.box[best] - [middle, 0, middle, 0]
    apart = (moved.box[again] - shifted + 698) % 1396 - 698
    assert np.abs(apart[[0, 2]]).max() < 8
    assert np.abs(moved.box[again, [1, 3]] - shifted[[1, 3]]).max() < 8
    assert moved.score[again] == pytest.approx(plain.score[best], abs=1)


@needs_recordings
def test_people_whose_heads_are_above_the_picture_are_found():
    """A quarter of the upper body is cut off with the picture's upper rows."""
    with (PERSONS / "d_p_gt.csv").open(newline="") as stream:
        truth = {int(row["frame"]): row for row in csv.DictReader(stream)}
    hits = []
    for number, pixels in pictures_of("d_p.mp4", range(0, 200, 80)):
        box = np.array([float(truth[number][c]) for c in ("ux0", "uy0", "ux1", "uy1")])
        above = int(box[1] + 0.25 * (box[3] - box[1]))
        whole = perspective()
        lower = whole.matrix - [[0, 0, 0], [0, 0, above], [0, 0, 0]]
        view = replace(whole, size=(640, 480 - above), matrix=lower)
        found = ready(Hog, view, minimum_height=60).process(Frame(camera="c", pixels=pixels[above:]))
        hits.append(bool((overlap(box - [0, above, 0, above], found.box, 0.0) > 0.4).any()))
    assert np.mean(hits) > 0.6


def wrapped(angle):
    return (angle + np.pi) % (2 * np.pi) - np.pi


def likeliest(likelihood):
    return 2 * np.pi * np.argmax(likelihood, axis=-1) / DIRECTIONS


@needs_recordings
@pytest.mark.parametrize(
    ("video", "view"), [("d_o", panorama()), pytest.param("d_p", perspective(), marks=pytest.mark.thorough)]
)
def test_strangers_in_strange_pictures_are_found_with_their_headings(video, view):
    """The shipped weights never saw these videos or the persons in them."""
    made = ready(Hog, view)
    with (PERSONS / f"{video}_gt.csv").open(newline="") as stream:
        truth = {int(row["frame"]): row for row in csv.DictReader(stream)}
    hits, extra, errors = [], 0, []
    numbers = range(0, 200, 40)
    for number, pixels in pictures_of(f"{video}.mp4", numbers):
        row = truth[number]
        boxes = made.process(Frame(camera="c", pixels=pixels))
        box = np.array([float(row[c]) for c in ("ux0", "uy0", "ux1", "uy1")])
        shared = overlap(box, boxes.box, view.size[0] if video == "d_o" else 0.0)
        hits.append(bool((shared > 0.4).any()))
        extra += int((shared < 0.2).sum())
        if hits[-1]:
            said = likeliest(boxes.torso[int(np.argmax(shared))])
            errors.append(np.rad2deg(abs(wrapped(said - float(row["torso_heading"])))))
    assert np.mean(hits) >= 0.9
    assert extra <= 0.25 * len(numbers)
    assert np.median(errors) < 22.5
