"""Videos and folders of pictures that `sinks.draw` writes, also if the disk is full or a run is killed."""

import signal
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.full_disk import full_disk
from tests.plugins.sinks.drawn import ROOM, frame, poses

from followspot import Context, FollowspotError, InputError
from followspot_sinks.draw import Draw
from followspot_sinks.picture_files import PictureFolder, VideoFile


def test_a_video_that_cannot_be_written_names_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cv2.VideoWriter.isOpened", lambda self: False, raising=False)
    file = VideoFile(tmp_path / "left.mp4")
    file.write(np.zeros((48, 64, 3), "u1"), 0, 0)
    with pytest.raises(FollowspotError, match="format: jpg"):
        file.close()


def test_a_disk_that_gets_full_is_told_and_not_left_to_the_video(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = VideoFile(tmp_path / "left.mp4")
    for number in range(4):
        file.write(np.zeros((48, 64, 3), "u1"), number, number * 10**8)
    monkeypatch.setattr("followspot_sinks.picture_files.LEAST_SPACE", 1 << 60)
    for step in (lambda: file.write(np.zeros((48, 64, 3), "u1"), 4, 4 * 10**8), file.close):
        with pytest.raises(FollowspotError, match=r"left\.mp4 cannot be written: No space left"):
            step()


def test_a_limit_of_the_size_of_a_file_is_told_and_not_left_to_the_video(tmp_path: Path) -> None:
    file = VideoFile(tmp_path / "left.mp4")
    for number in range(4):
        file.write(np.zeros((48, 64, 3), "u1"), number, number * 10**8)
    with full_disk(500_000):
        for step in (lambda: file.write(np.zeros((48, 64, 3), "u1"), 4, 4 * 10**8), file.close):
            with pytest.raises(FollowspotError, match=r"left\.mp4 cannot be written: .*\n.*ulimit -f"):
                step()


def test_a_limit_of_the_size_of_a_file_counts_what_the_video_has_already(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, rng = VideoFile(tmp_path / "left.mkv"), np.random.default_rng(1)
    pictures = rng.integers(0, 255, (30, 240, 320, 3), "u1")
    for number, picture in enumerate(pictures):
        file.write(picture, number, number * 10**8)
    size = file.path.stat().st_size
    assert size > 1000
    monkeypatch.setattr("followspot_sinks.picture_files.LEAST_SPACE", 1000)
    monkeypatch.setattr("followspot_sinks.picture_files.getrlimit", lambda _: (size + 999, -1))
    with pytest.raises(FollowspotError, match="ulimit -f"):
        file.write(pictures[0], 30, 30 * 10**8)


@pytest.mark.parametrize("gone", ["drawn/left.mp4", "drawn"])
def test_a_video_that_is_gone_while_it_is_written_is_an_error(tmp_path: Path, gone: str) -> None:
    (tmp_path / "drawn").mkdir()
    file = VideoFile(tmp_path / "drawn/left.mp4")
    for number in range(4):
        file.write(np.zeros((48, 64, 3), "u1"), number, number * 10**8)
    (tmp_path / gone).rename(tmp_path / "elsewhere")
    for step in (lambda: file.write(np.zeros((48, 64, 3), "u1"), 4, 4 * 10**8), file.close):
        with pytest.raises(FollowspotError, match=r"left\.mp4 was moved or removed while the run wrote it"):
            step()


def test_a_folder_of_pictures_that_is_gone_while_it_is_written_is_an_error(tmp_path: Path) -> None:
    folder = PictureFolder(tmp_path, "left", "png")
    folder.write(np.zeros((48, 64, 3), "u1"), 0, 0)
    (tmp_path / "left").rename(tmp_path / "elsewhere")
    with pytest.raises(FollowspotError, match="left was moved or removed while the run wrote it"):
        folder.write(np.zeros((48, 64, 3), "u1"), 1, 0)


@pytest.mark.parametrize("count", [1, 5])
def test_video_has_every_picture_and_the_rate_of_the_recording(tmp_path: Path, count: int) -> None:
    sink = Draw(Context(room=ROOM, out=tmp_path))
    sink.setup()
    for seq in range(count):
        sink.process((frame(seq),), (poses(),))
    sink.close()
    video = cv2.VideoCapture(str(tmp_path / "drawn/left.mp4"))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == count
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(10 if count > 1 else 1)
    assert video.read()[0]


def test_folder_that_cannot_be_written_and_one_outside_are_refused(tmp_path: Path) -> None:
    (tmp_path / "drawn").write_text("a file")
    with pytest.raises(FollowspotError, match="cannot be written"):
        Draw(Context(room=ROOM, out=tmp_path)).setup()
    with pytest.raises(InputError, match="outside the output folder"):
        Draw(Context(room=ROOM, out=tmp_path), path="../up").setup()


def test_the_video_of_a_stage_that_is_resumed_stands_beside_the_first_one(tmp_path: Path) -> None:
    for resumed in (False, True):
        sink = Draw(Context(room=ROOM, out=tmp_path, resumed=resumed))
        sink.setup()
        sink.process((frame(),))
        sink.close()
    assert sorted(path.name for path in (tmp_path / "drawn").iterdir()) == ["left-2.mp4", "left.mp4"]


KILLED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from followspot_sinks.picture_files import VideoFile
file, rng = VideoFile(Path(sys.argv[1])), np.random.default_rng(0)
for number in range(100):
    file.write(rng.integers(0, 255, (240, 320, 3), "u1"), number, number * 10**8)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_an_mkv_can_be_played_after_a_kill_but_for_its_last_megabyte(tmp_path: Path) -> None:
    path = tmp_path / "left.mkv"
    assert subprocess.run([sys.executable, "-c", KILLED, path], check=False).returncode == -signal.SIGKILL
    whole = tmp_path / "whole.mkv"
    file, rng = VideoFile(whole), np.random.default_rng(0)
    for number in range(100):
        file.write(rng.integers(0, 255, (240, 320, 3), "u1"), number, number * 10**8)
    file.close()
    assert path.stat().st_size > whole.stat().st_size - (1 << 20)
    frames = [cv2.VideoCapture(str(one)) for one in (path, whole)]
    played = [sum(1 for _ in iter(video.grab, False)) for video in frames]
    assert played[1] == 100
    assert played[0] >= int(100 * path.stat().st_size / whole.stat().st_size) - 2


def test_videos_have_the_ending_of_their_format(tmp_path: Path) -> None:
    sink = Draw(Context(room=ROOM, out=tmp_path), format="mkv")
    sink.setup()
    for seq in range(3):
        sink.process((frame(seq),), (poses(),))
    sink.close()
    video = cv2.VideoCapture(str(tmp_path / "drawn/left.mkv"))
    assert sum(1 for _ in iter(video.grab, False)) == 3
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(10)
