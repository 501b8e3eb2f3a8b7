"""A folder of pictures as a camera."""

from pathlib import Path

import cv2
import pytest
from pydantic import ValidationError
from tests.plugins.cameras.recordings import context, numbers, picture

from followspot import InputError
from followspot_cameras.images import Images


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for number in range(12):
        cv2.imwrite(str(tmp_path / f"shot{number}.png"), picture(number))
    (tmp_path / "README.md").write_text("not a picture")
    return tmp_path


def play(folder: Path, warnings: list[str] | None = None, **params: object) -> list:
    log: list[str] = [] if warnings is None else warnings
    images = Images(context(warn=log.append), path=folder, **params)
    images.setup()
    frames = list(images.process())
    assert images.length() >= len(frames)
    if images.length() == len(frames):
        assert [images.capture_time(k) for k in range(len(frames))] == [f.header.time for f in frames]
    return frames


def test_pictures_come_in_natural_order_at_the_given_rate(folder: Path) -> None:
    frames = play(folder, fps=10)
    assert [numbers(f.pixels) for f in frames] == list(range(12))
    assert frames[11].header[1:3] == (11, 1_100_000_000)


def test_pattern_and_range_choose_pictures(folder: Path) -> None:
    assert [numbers(f.pixels) for f in play(folder, pattern="shot1?.*")] == [10, 11]
    assert [f.header.seq for f in play(folder, start_frame=3, frames=2)] == [3, 4]


def test_numbers_that_are_missing_in_the_names_are_told(folder: Path) -> None:
    warnings: list[str] = []
    (folder / "shot5.png").unlink()
    assert len(play(folder, warnings)) == 11
    (warning,) = warnings
    assert warning.startswith("between shot4.png and shot6.png pictures are missing")
    for number in range(0, 12, 2):
        (folder / f"shot{number}.png").unlink()
    assert len(play(folder, warnings)) == 5, "every second one was never there"
    assert len(warnings) == 1


def test_unreadable_picture_leaves_a_gap_and_is_reported(folder: Path) -> None:
    (folder / "shot4.png").write_bytes(b"broken")
    warnings: list[str] = []
    frames = play(folder, warnings)
    assert [f.header.seq for f in frames] == [0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11]
    assert warnings == ["1 pictures cannot be read, the first is shot4.png"]


def test_folder_without_pictures_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no pictures"):
        Images(context(), path=tmp_path).setup()


def test_pattern_cannot_leave_the_folder(folder: Path) -> None:
    with pytest.raises(ValidationError):
        Images(context(), path=folder, pattern="../*.png")
