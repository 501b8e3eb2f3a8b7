"""Copies of recordings, and what of a target counts as within reach and beyond it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.balls.scene import make_room

from bench.balls import copies
from benching.room_copy import Copy, changed, copied, file_of, pictures, reversed_rows, write_video
from followspot import room_file
from followspot.errors import FollowspotError
from followspot.room import StageUse
from followspot_accuracy import TrackTable, TruthTable

TIME = np.arange(10) / 10


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """The file of a room with five pictures in two cameras, each brighter than the one before."""
    frames = [np.full((48, 64, 3), 40 + 30 * number, np.uint8) for number in range(5)]
    cameras = {}
    for name, camera in list(make_room().cameras.items())[:2]:
        write_video(tmp_path / f"{name}.mkv", (iter(frames), 30.0), "FFV1")
        source = StageUse("cameras.video", {"path": str(tmp_path / f"{name}.mkv")})
        cameras[name] = replace(camera, source=source)
    truth = tmp_path / "truth.csv"
    truth.write_text("frame,time,object,x,y,z\n0,0.0,red,1,2,3\n4,0.13333,red,4,5,6\n")
    use = StageUse("cameras.truth_csv", {"path": str(truth)})
    room_file.save(replace(make_room(), cameras=cameras, targets={}, truth=use), tmp_path / "room.yaml")
    return tmp_path / "room.yaml"


def means(room: Path, camera: str) -> list[float]:
    """Mean brightness of each picture."""
    found, rate = pictures(file_of(room_file.load(room).cameras[camera].source, camera))
    assert rate == 30.0
    return [float(picture.mean()) for picture in found]


def test_a_copy_has_the_pictures_and_a_reversed_one_has_the_last_picture_first(
    recorded: Path, tmp_path: Path
) -> None:
    before = means(recorded, "cam0")
    for reverse in (False, True):
        folder = tmp_path / str(reverse)
        folder.mkdir()
        copy = copied(recorded, folder, Copy(reverse, 2.0, "FFV1"))
        for camera in ("cam0", "cam1"):
            assert means(copy, camera) == pytest.approx(before[::-1] if reverse else before, abs=1.0)
        rows = file_of(room_file.load(copy).truth, "truth").read_text().splitlines()
        assert rows[1] == ("0,0.00000,red,4,5,6" if reverse else "0,0.0,red,1,2,3")


@pytest.mark.parametrize("gray", [True, False])
def test_noise_has_the_sigma_that_was_asked_for_and_gray_pictures_stay_gray(gray: bool) -> None:
    flat = [np.full((200, 200, 3), 120, np.uint8)]
    frames, _ = changed((flat, 30.0), Copy(False, 2.0, "FFV1"), gray, np.random.default_rng(0))
    noise = next(frames).astype(float) - 120
    assert noise.std() == pytest.approx(np.hypot(2.0, 1 / np.sqrt(12)), rel=0.02)
    assert np.array_equal(noise[..., 0], noise[..., 1]) == gray


def test_rows_of_truth_are_turned_by_frame_and_by_time() -> None:
    rows = [
        ["0", "0.00000", "red"],
        ["0", "0.00000", "blue"],
        ["1", "0.03333", "red"],
        ["2", "0.06667", "red"],
    ]
    turned = reversed_rows(rows, 0, 1)
    assert turned == [
        ["0", "0.00000", "red"],
        ["1", "0.03334", "red"],
        ["2", "0.06667", "red"],
        ["2", "0.06667", "blue"],
    ]


def test_what_cannot_be_copied_is_an_error(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(FollowspotError, match="cannot write"):
        copied(recorded, tmp_path, Copy(False, 0.0, "????"))
    with pytest.raises(FollowspotError, match="cam0 is not read from a file"):
        file_of(None, "cam0")


def test_shares_are_those_of_the_trackable_frames() -> None:
    """Ten frames, one of them not trackable: one without a position, one 20 cm off."""
    xyz, trackable = np.zeros((10, 1, 3)), np.ones((10, 1), bool)
    trackable[0] = False
    truth = TruthTable(("red",), TIME, xyz, np.zeros((10, 1), bool), trackable, trackable)
    frames = np.array([0, 1, 2, 3, 4, 5, 6, 8, 9])
    place = np.zeros((9, 3))
    place[[0, 8], 2] = 0.2
    sigma = np.full((9, 3), 0.1)
    sigma[8] = 0.05
    tracks = TrackTable(("red",), TIME[frames], np.zeros(9, int), np.zeros(9, np.uint8), place, sigma=sigma)
    (found,) = copies.held(tracks, truth, ("fusion", "room", "copy"))
    assert (found.frames, found.target) == (9, "red")
    assert found.within == pytest.approx(7 / 9)
    assert found.beyond == pytest.approx(1 / 9)
    assert found.rmse_mm == pytest.approx(1e3 * 0.2 / np.sqrt(8))
    assert found.within_95 == pytest.approx(7 / 8)
    assert found.nees == pytest.approx((0.2 / 0.05) ** 2 / (3 * 8))


def test_the_summary_leaves_out_the_recording_itself() -> None:
    shares = {copies.RECORDED: 0.5, "one": 1.0, "two": 0.9}
    found = [
        copies.Held("f", "dev", name, "red", 10, share, 0.0, 1.0, share, 2 * share)
        for name, share in shares.items()
    ]
    (line,) = copies.summary(found)
    assert line == ["f", "dev", "red", "95.0%", "90.0%", "two", "0.0%", "0.0%", "95.0%", "1.90"]
