"""A video file as a camera."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.datasets import dataset, needs_data
from tests.plugins.cameras.recordings import SIZE, context, numbers, picture, record

import followspot as fs
from followspot import InputError, Room, room_file
from followspot.frame_times import capture_time, exact_rate
from followspot_cameras.video.stage import Video

GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")


def play(path: Path, kind: str = "color", **params: object) -> tuple[list, list[str]]:
    warnings: list[str] = []
    video = Video(context(kind, warn=warnings.append), path=path, **params)
    video.setup()
    frames = list(video.process())
    video.close()
    return frames, warnings


def test_every_frame_comes_once_with_its_number_and_exact_time(tmp_path: Path) -> None:
    frames, warnings = play(record(tmp_path / "a.mkv"))
    assert [numbers(f.pixels) for f in frames] == list(range(20))
    assert [f.header.seq for f in frames] == list(range(20))
    assert [f.header.time for f in frames] == [n * 1_000_000_000 // 30 for n in range(20)]
    assert not warnings


@pytest.mark.parametrize("name", ["12:30:01.mkv", "http:a.mkv", "concat:b.mkv", "cam%03d.mkv", "-i.mkv"])
def test_a_file_may_have_any_name(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    record(tmp_path / name, frames=3)
    record(tmp_path / "b.mkv", frames=2)
    monkeypatch.chdir(tmp_path)
    assert len(play(Path(name))[0]) == 3


def test_color_camera_gives_three_channels_and_infrared_camera_one(tmp_path: Path) -> None:
    path = record(tmp_path / "a.avi", frames=2)
    (color, *_), _ = play(path)
    (infrared, *_), _ = play(path, "infrared")
    assert color.pixels.shape == (SIZE[1], SIZE[0], 3)
    assert infrared.pixels.shape == (SIZE[1], SIZE[0], 1)
    assert infrared.camera == "cam3"


def test_color_picture_is_decoded_into_the_loaned_array(tmp_path: Path) -> None:
    loans: list[np.ndarray] = []

    def loan(shape: tuple[int, ...], dtype: str) -> np.ndarray:
        loans.append(np.empty(shape, dtype))
        return loans[-1]

    video = Video(replace(context(), loan=loan), path=record(tmp_path / "a.mkv", frames=3))
    video.setup()
    frames = list(video.process())
    assert len(loans) == 3
    assert all(np.shares_memory(f.pixels, a) for f, a in zip(frames, loans, strict=True))


def test_start_frame_and_frames_choose_a_part_and_keep_the_numbers(tmp_path: Path) -> None:
    frames, warnings = play(record(tmp_path / "a.mkv"), start_frame=5, frames=3)
    assert [f.header.seq for f in frames] == [5, 6, 7]
    assert [numbers(f.pixels) for f in frames] == [5, 6, 7]
    assert not warnings


def test_given_frame_rate_overrides_that_of_the_file(tmp_path: Path) -> None:
    frames, _ = play(record(tmp_path / "a.mkv", frames=3), fps=50)
    assert [f.header.time for f in frames] == [0, 20_000_000, 40_000_000]


@pytest.mark.parametrize("given", [{}, {"fps": 50.0}, {"start_frame": 2, "start_time": 3.0}])
def test_capture_times_are_known_before_the_first_frame(given: dict[str, float], tmp_path: Path) -> None:
    video = Video(context(), path=record(tmp_path / "a.mkv", frames=5), **given)
    video.setup()
    told = [video.capture_time(number) for number in range(video.length() or 0)]
    assert told == [frame.header.time for frame in video.process()]


def test_length_is_known_before_the_first_frame(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mkv")
    assert Video(context(), path=path).length() == 20
    assert Video(context(), path=path, start_frame=15, frames=9).length() == 5


@pytest.mark.parametrize("name", ["a.mkv", "a.avi"])
def test_truncated_file_warns_how_far_it_went(tmp_path: Path, name: str) -> None:
    path = record(tmp_path / name)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    frames, warnings = play(path)
    assert 0 < len(frames) < 20
    (warning,) = warnings
    assert warning.startswith(f"{name} ended after {len(frames)} of 20 frames (the file is cut off: ")


@pytest.mark.parametrize("uses", ["cameras.video", "cameras.rectified_video"])
def test_a_file_that_is_cut_off_is_a_warning_of_check_where_its_path_is_written(
    tmp_path: Path, uses: str
) -> None:
    path = record(tmp_path / "a.avi")
    (camera,) = context().room.cameras.values()
    room_file.save(Room("r", {camera.name: camera}), tmp_path / "room.yaml")
    lens = {"size": SIZE, "matrix": camera.matrix.tolist(), "distortion": [], "rotation": np.eye(3).tolist()}
    params = {"path": str(path), **({"lens": lens} if uses == "cameras.rectified_video" else {})}
    (tmp_path / "graph.yaml").write_text(
        "graph: g\nroom: room.yaml\nstages:\n"
        f"  camera: {{uses: {uses}, each: cameras, with: {json.dumps(params)}}}\n"
        "  save: {uses: sinks.draw, each: cameras, in: {frames: camera}}\n"
    )
    assert [m.text for m in fs.check(tmp_path / "graph.yaml")] == []
    path.write_bytes(path.read_bytes()[:-100])
    (mistake,) = fs.check(tmp_path / "graph.yaml")
    assert mistake.text.startswith("path: a.avi ends early (the file is cut off: ")
    assert mistake.warning
    assert mistake.place is not None
    assert mistake.place.line == 4


def test_pictures_of_another_size_within_a_file_are_stretched_as_is_documented(tmp_path: Path) -> None:
    """The decoder gives them like the others. Once a decoder tells, the source should."""
    path = tmp_path / "a.mjpeg"
    parts = [picture(0), np.pad(picture(0), ((0, 0), (0, SIZE[0]), (0, 0)))]  # black at the right
    path.write_bytes(b"".join(cv2.imencode(".jpg", part)[1].tobytes() for part in parts))
    frames, warnings = play(path)
    assert [f.pixels.shape for f in frames] == [(SIZE[1], SIZE[0], 3)] * 2
    brightness = [[f.pixels[:, half].mean() for half in (slice(28), slice(36, None))] for f in frames]
    assert [left > 20 for left, _ in brightness] == [True, True]
    assert [right > 20 for _, right in brightness] == [True, False]
    assert not warnings
    assert "stretched to the size that the file states" in " ".join((Video.__doc__ or "").split())


def test_mp4_without_its_end_is_refused_as_cut_off(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mp4", codec="mp4v")
    path.write_bytes(path.read_bytes()[:-600])
    with pytest.raises(InputError, match=r"a\.mp4 cannot be read as a video \(the file is cut off"):
        Video(context(), path=path).setup()


def test_damaged_frames_are_counted_and_later_frames_keep_their_time(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mkv")
    data = bytearray(path.read_bytes())
    middle = len(data) // 2
    data[middle : middle + len(data) // 10] = bytes(len(data) // 10)
    path.write_bytes(data)
    frames, warnings = play(path)
    lost = 20 - len(frames)
    assert lost > 0
    half_damaged = [f.header.seq for f in frames if f.header.seq != numbers(f.pixels)]
    assert len(half_damaged) <= 2
    assert frames[-1].header.seq == 19
    (warning,) = [said for said in warnings if "checksum" not in said]
    assert warning.startswith(f"a.mkv: {lost} frames are missing or damaged, unless its frame rate varies")


@pytest.mark.parametrize("codec", ["FFV1", "MJPG"])
def test_damage_that_the_decoder_hides_is_told_by_the_checksums_of_the_file(
    tmp_path: Path, codec: str
) -> None:
    path = record(tmp_path / "a.mkv", codec=codec, frames=400)
    whole, _ = play(path)
    data = bytearray(path.read_bytes())
    data[len(data) * 3 // 4] ^= 0x10
    path.write_bytes(data)
    frames, warnings = play(path)
    assert len(frames) == 400, "nothing else tells that a picture is damaged"
    wrong = [f for f, right in zip(frames, whole, strict=True) if not (f.pixels == right.pixels).all()]
    (warning,) = warnings
    begin = float(warning.removeprefix("a.mkv is damaged from ").split(" s on: ")[0])
    assert 0 < begin <= wrong[0].header.time / 1e9
    assert warning.endswith("pictures may be wrong; copy the recording again")
    assert not play(path, frames=round(begin * 30) - 5)[1], "what is damaged was not played"


def test_damaged_parts_of_a_file_are_counted(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mkv")
    data = bytearray(path.read_bytes())
    for place in (0.4, 0.6, 0.8):
        data[round(len(data) * place)] ^= 0x10
    path.write_bytes(data)
    _, warnings = play(path)
    _, told = [said for said in warnings if "checksum" in said]
    assert told == "a.mkv: 3 parts do not match their checksums"


def test_wrong_picture_size_names_file_camera_and_both_sizes(tmp_path: Path) -> None:
    video = Video(context(size=(320, 240)), path=record(tmp_path / "a.mkv", frames=2))
    with pytest.raises(InputError, match=r"a\.mkv has pictures of 64x48 px, but camera cam3 .* 320x240 px"):
        video.setup()
    with pytest.raises(InputError, match=r"a\.mkv has pictures of 64x48 px, but camera cam3 .* 320x240 px"):
        list(Video.check_files(video.params, video.room, video.context.member))
    elsewhere = Room(cameras={"cam3": replace(video.camera, host="pc-left")})
    assert not list(Video.check_files(video.params, elsewhere, video.context.member)), "its file is there"


def test_file_that_is_no_video_is_named(tmp_path: Path) -> None:
    path = tmp_path / "notes.mkv"
    path.write_text("not a video")
    video = Video(context(), path=path)
    with pytest.raises(InputError, match=r"notes\.mkv cannot be read as a video"):
        video.setup()
    video.close()


@given(st.integers(0, 10**9), st.sampled_from([24.0, 25.0, 30000 / 1001, 59.94005994, 0.5]))
def test_capture_times_never_drift(frame: int, fps: float) -> None:
    rate = exact_rate(fps)
    assert 0 <= frame / rate * 10**9 - capture_time(frame, rate) < 1


def test_ntsc_rate_is_exact() -> None:
    assert exact_rate(29.97002997) == Fraction(30000, 1001)


@needs_recordings
def test_recording_with_useless_time_stamps_plays_at_its_frame_rate() -> None:
    base = context("infrared", size=(320, 240))
    video = Video(base, path=GLOWBALLS / "dev1/cam1.mkv")
    video.setup()
    times = [f.header.time for f in video.process()]
    assert len(times) == 200
    assert times[-1] == 199 * 10**9 // 30
    assert video.length() is None
