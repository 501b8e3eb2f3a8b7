"""Thrown balls in one camera become tracks; what rests, rolls, scatters or is of another colour does not."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.datasets import dataset, needs_data
from tests.travelled import travelled

from followspot import Camera, Context, Header, Room, Target
from followspot.cli.main import main
from followspot.message_checks.sealing import seal
from followspot.messages import identical, stamped
from followspot.room import StageUse
from followspot.room_file import save
from followspot.tracking import Blobs, ImageTracks
from followspot_balls.throws.parabola import bend, residual
from followspot_balls.throws.stage import Throws

REPOSITORY = Path(__file__).parents[3]
THROWS = dataset("balls-thrown-room")
needs_recordings = needs_data("balls-thrown-room")
PERIOD = 1 / 30


def camera(source: StageUse | None = None) -> Camera:
    matrix = np.array([[600.0, 0, 320], [0, 600, 240], [0, 0, 1]])
    return Camera("cam0", "color", (640, 480), matrix, np.zeros(5), np.eye(3), np.zeros(3), source=source)


def thrown(
    frames: int, start: Sequence[float] = (-1, 1, 5), velocity: Sequence[float] = (1.2, -3.5, 0.5)
) -> np.ndarray:
    """Picture of a ball in free flight, (frames, 2) px: y down, 9.81 m/s^2."""
    time = np.arange(frames)[:, None] * PERIOD
    place = np.asarray(start) + np.asarray(velocity) * time + np.array([0, 9.81, 0]) * time**2 / 2
    return np.asarray(place[:, :2] / place[:, 2:] * 600 + [320, 240])


def followed(
    pictures: Sequence[np.ndarray], target: int = 0, *, handed_over: int = -1, **params: float
) -> list[ImageTracks]:
    """What the stage says to blobs (N, 2) of one target in each picture.

    handed_over: number of the picture before which a successor carries on, -1 for none.
    """
    room = Room(cameras={"cam0": camera()}, targets={n: Target(n, 0.1) for n in ("red", "yellow")})
    stage, successor = (Throws(Context.serving(room.cameras["cam0"], room), **params) for _ in range(2))
    stage.setup()
    tracks = []
    for seq, places in enumerate(pictures):
        if seq == handed_over:
            successor.setup()
            successor.restore(travelled(stage.state()))
            stage = successor
        xy = np.asarray(places, float).reshape(-1, 2)
        targets = np.zeros((len(xy), 2), bool)
        targets[:, target] = True
        ones = np.ones(len(xy))
        blobs = Blobs(camera="cam0", xy=xy, pixel=xy, area=200 * ones, similarity=ones, targets=targets)
        tracks.append(seal(stage.process(stamped(blobs, Header("cam0", seq, round(seq * PERIOD * 1e9))))))
    return tracks


def rows(tracks: Sequence[ImageTracks]) -> list[tuple[int, int, float, float]]:
    """Frame, track, u and v of all tracks."""
    return [
        (frame, number, u, v)
        for frame, one in enumerate(tracks)
        for number, (u, v) in zip(one.track.tolist(), one.xy.tolist(), strict=True)
    ]


def test_throw_is_one_track_of_its_target_from_the_twelfth_blob_to_its_end() -> None:
    path = thrown(25)
    tracks = followed(list(path[:24]), target=1)
    assert [frame for frame, *_ in rows(tracks)] == list(range(11, 24))
    assert len({track for _, track, *_ in rows(tracks)}) == 1
    last = tracks[-1]
    assert last.target.tolist() == [1]
    np.testing.assert_array_equal(last.xy[0], path[23])
    np.testing.assert_allclose(last.velocity[0], (path[24] - path[22]) / (2 * PERIOD), atol=3)


def test_a_successor_carries_on_with_the_paths_and_never_uses_a_number_twice() -> None:
    pictures = [*thrown(24), *[[]] * 8, *thrown(24, start=(1, 1, 5), velocity=(-1.2, -3.5, 0.5))]
    whole, parted = followed(pictures), followed(pictures, handed_over=16)
    assert all(identical(a, b) for a, b in zip(whole, parted, strict=True))
    assert len({track for _, track, *_ in rows(parted)}) == 2


@settings(max_examples=25, deadline=None)
@given(depth=st.floats(3, 8), across=st.floats(-1.5, 1.5), away=st.floats(-1, 2), seed=st.integers(0, 1000))
def test_any_throw_is_found_through_noise(depth: float, across: float, away: float, seed: int) -> None:
    path = thrown(24, (-across / 2, 0.15 * depth, depth), (across, -3.8, away))
    noisy = path + np.random.default_rng(seed).normal(0, 0.4, path.shape)
    tracks = followed(list(noisy))
    assert len({track for _, track, *_ in rows(tracks)}) == 1
    assert tracks[-1].residual[0] < 0.7


def test_ball_hidden_for_four_frames_keeps_its_track() -> None:
    pictures = list(thrown(26))
    pictures[14:18] = [np.empty((0, 2))] * 4
    found = rows(followed(pictures))
    assert {frame for frame, *_ in found} == {11, 12, 13, *range(18, 26)}
    assert len({track for _, track, *_ in found}) == 1


def test_two_balls_of_one_colour_that_cross_keep_their_tracks() -> None:
    left, right = thrown(24), thrown(24, (1, 1, 5), (-1.5, -3.9, 0))
    found = rows(followed(list(np.stack([left, right], axis=1))))
    paths = {track: [(f, u, v) for f, t, u, v in found if t == track] for _, track, *_ in found}
    assert len(paths) == 2
    for points in paths.values():
        frame = np.array([f for f, *_ in points])
        place = np.array([uv for _, *uv in points])
        assert any(np.array_equal(place, path[frame]) for path in (left, right))


def test_bounce_begins_another_track() -> None:
    down = thrown(22, (-1, 0.4, 5), (0.8, -2.5, 0))
    up = thrown(22, (-1 + 0.8 * 22 * PERIOD, 1.4, 5), (0.8, -3.4, 0))
    found = rows(followed([*down, *up]))
    first = {track for frame, track, *_ in found if frame < 22}
    second = {track for frame, track, *_ in found if frame > 35}
    assert len(first) == len(second) == 1
    assert first != second


def test_what_rests_rolls_or_swings_is_no_throw() -> None:
    rng = np.random.default_rng(3)
    frame = np.arange(120)[:, None]
    rests = np.array([200, 300]) + rng.normal(0, 0.5, (120, 2))
    rolls = np.array([20, 400]) + frame * [4.0, 0.3] + rng.normal(0, 0.3, (120, 2))
    swings = np.array([320, 200]) + 120 * np.hstack([np.sin(frame / 12), np.abs(np.cos(frame / 12))])
    for decoy in (rests, rolls, swings):
        assert rows(followed(list(decoy))) == []


def test_scattered_blobs_are_no_throw_and_hide_none() -> None:
    rng = np.random.default_rng(1)
    scatter = [rng.uniform([20, 20], [620, 460], (8, 2)) for _ in range(200)]
    assert rows(followed(scatter)) == []
    path = thrown(24)
    both = [np.vstack([noise, place]) for noise, place in zip(scatter, path, strict=False)]
    found = rows(followed(both))
    assert {(frame, u, v) for frame, _, u, v in found} >= {(f, *path[f].tolist()) for f in range(16, 24)}


def test_ball_cut_by_the_edge_of_the_picture_is_ignored() -> None:
    """A blob of 200 px is 8 px in radius; its centroid is wrong where less than that is left."""
    path = thrown(24)
    path[:, 1] += 479 - 7 - path[-1, 1]
    assert max(frame for frame, *_ in rows(followed(list(path)))) < 23


def test_residual_of_a_flight_in_depth_is_nil_and_of_noise_its_deviation() -> None:
    path = thrown(40, velocity=(1.0, -5, 3))
    time = np.arange(40) * PERIOD
    assert residual(time, path) < 1e-6
    noisy = path + np.random.default_rng(0).normal(0, 1, path.shape)
    assert residual(time, noisy) == pytest.approx(np.sqrt(2 * (1 - 8 / 80)), rel=0.2)


def test_bend_is_the_rise_above_the_line_between_the_ends() -> None:
    time = np.linspace(2, 4, 9)
    assert bend(time, 7 * (time - 3) ** 2 + 5 * time) == pytest.approx(7)
    assert bend(time, -7 * (time - 3) ** 2) == pytest.approx(-7)


def hue(*degrees: int) -> np.ndarray:
    """Histogram of 16 hues, equal parts of those given."""
    histogram = np.zeros(16)
    histogram[[d * 16 // 360 for d in degrees]] = 1 / len(degrees)
    return histogram


def office(path: Path) -> Path:
    """The room of the recording; blue is the colour of no ball here, but of a window frame and folders."""
    source = StageUse("cameras.images", {"path": str(THROWS.resolve()), "frames": 700})
    targets = {
        "red": Target("red", 0.1, {"cam0": hue(0, 340)}, {"cam0": (500, 1400)}),
        "yellow": Target("yellow", 0.1, {"cam0": hue(50)}, {"cam0": (400, 900)}),
        "blue": Target("blue", 0.1, {"cam0": hue(200, 220)}, {"cam0": (30, 5000)}),
    }
    save(Room("office", {"cam0": camera(source)}, targets=targets), path)
    return path


BY_HAND = {"red": (160, 265), "yellow": (541, 631)}
"""The throws of the recording, found by looking at all 700 pictures: the first and last picture that
shows the whole ball, frame00160.jpg to frame00265.jpg and so on. Parts of it enter three pictures earlier
and leave three later. With the yellow ball a pale disc flies, in 535 to 635, about 150 px to its left.
"""


@needs_recordings
@pytest.mark.thorough
def test_every_throw_of_the_recording_is_one_track_and_no_decoy_is(tmp_path: Path) -> None:
    """The throws are tracked from their 14th whole picture at the latest until the last.

    Their residual is over the whole flight, of the image of a parabola: the wide lens and the change of
    depth bend a plain one by 6 px RMS.
    """
    room = office(tmp_path / "office.yaml")
    graph = str(REPOSITORY / "graphs/throws.yaml")
    assert main(["run", graph, "--room", str(room), "--out", str(tmp_path / "run")]) == 0
    with (tmp_path / "run/throws.csv").open() as file:
        table = list(csv.DictReader(file))
    assert len({(row["target"], row["track"]) for row in table}) == len(BY_HAND)
    assert (tmp_path / "run/blobs.csv").read_text().count(",blue,") > 200
    for target, (first, last) in BY_HAND.items():
        found = [row for row in table if row["target"] == target]
        picture = [int(row["frame"]) + 1 for row in found]
        assert picture == list(range(picture[0], picture[0] + len(picture)))
        assert picture[0] <= first + 14
        assert abs(picture[-1] - last) <= 1
        assert max(float(row["residual"]) for row in found) < 3.0
        time = np.array([float(row["time"]) for row in found])
        place = np.array([[float(row["u"]), float(row["v"])] for row in found])
        assert residual(time, place) < 2.0
