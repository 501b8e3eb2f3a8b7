"""Recordings whose pictures have capture times of their own."""

from collections.abc import Sequence
from contextvars import Context
from fractions import Fraction
from pathlib import Path

import av
import cv2
import pytest
from pydantic import ValidationError
from tests.plugins.cameras.recordings import SIZE, context, numbers, picture, record

from followspot import InputError, Room
from followspot_cameras.images import Images
from followspot_cameras.recorded_times.file_names import time_of_name
from followspot_cameras.recorded_times.time_list import read_time_list
from followspot_cameras.video.stage import Video
from followspot_cameras.video.times import TimeStamps

TABLE = "sync_index,cam_id,frame_index,frame_time\n"
ROWS = ["5,2,30,9.0", "5,3,40,10.000000001", "6,3,42,10.05", "7,3,43,10.2"]
LIST = "# timestamp format v2\n0\n33.333\n# a pause\n500.5\n"


def video(path: Path, **params: object) -> list:
    stage = Video(context(), path=path, **params)
    stage.setup()
    frames = list(stage.process())
    stage.close()
    return frames


def times(frames: Sequence) -> list[int]:
    return [frame.header.time for frame in frames]


def stamped(path: Path, stamps: Sequence[int]) -> Path:
    """A Matroska file whose frames have these time stamps, ms."""
    base = Fraction(1, 1000)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=30)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuvj420p"
        stream.time_base = stream.codec_context.time_base = base
        for number, stamp in enumerate(stamps):
            frame = av.VideoFrame.from_ndarray(picture(number), format="bgr24")
            frame.pts, frame.time_base = stamp, base
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


@pytest.mark.parametrize("rows", [ROWS, ROWS[::-1]])
@pytest.mark.parametrize("name", ["a.mkv", "a.avi"])
def test_frames_take_their_times_from_the_table(tmp_path: Path, rows: list[str], name: str) -> None:
    (tmp_path / "timestamps.csv").write_text(TABLE + "\n".join(rows))
    path = record(tmp_path / name, frames=3)
    frames = video(path, times=tmp_path / "timestamps.csv", start_time=-10)
    assert times(frames) == [1, 50_000_000, 200_000_000]
    assert [(frame.header.seq, numbers(frame.pixels)) for frame in frames] == [(0, 0), (1, 1), (2, 2)]


def test_table_needs_no_frame_numbers(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("sync_index,cam_id,frame_time\n1,cam3,2.5\n0,cam3,2\n")
    assert times(video(record(tmp_path / "a.avi", frames=2), times=tmp_path / "t.csv")) == [
        2 * 10**9,
        25 * 10**8,
    ]


def test_frames_take_their_times_from_a_list(tmp_path: Path) -> None:
    (tmp_path / "a.pts").write_text(LIST)
    frames = video(record(tmp_path / "a.avi", frames=3), times=tmp_path / "a.pts", start_frame=1)
    assert times(frames) == [33_333_000, 500_500_000]


def test_time_stamps_of_the_file_count_if_asked_for(tmp_path: Path) -> None:
    path = stamped(tmp_path / "a.mkv", [500, 533, 700, 712, 1400])
    frames = video(path, time_stamps=True, start_time=2)
    assert times(frames) == [ms * 1_000_000 for ms in (2000, 2033, 2200, 2212, 2900)]
    assert [(frame.header.seq, numbers(frame.pixels)) for frame in frames] == [(n, n) for n in range(5)]
    assert [frame.header.seq for frame in video(path, time_stamps=True, start_frame=3)] == [3, 4]


def test_table_beside_a_file_of_irregular_time_stamps_counts_by_picture(tmp_path: Path) -> None:
    (tmp_path / "a.pts").write_text(LIST)
    assert times(video(stamped(tmp_path / "a.mkv", [0, 400, 900]), times=tmp_path / "a.pts")) == [
        0,
        33_333_000,
        500_500_000,
    ]


@pytest.mark.parametrize("name", ["a.avi", "a.mkv"])
def test_other_number_of_times_than_frames_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "a.pts").write_text(LIST)
    with pytest.raises(InputError, match=r"has 3 times for .* has (4|more) frames"):
        video(record(tmp_path / name, frames=4), times=tmp_path / "a.pts")


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        ("t.csv", TABLE + "5,2,30,9.0", r"t.csv:1:1: no row of camera cam3(.|\n)*N for cam_N"),
        ("t.csv", TABLE + "5,3,40,1\n6,3,40,2", r"t.csv:3:1: frame_index does not rise from line 2"),
        ("t.csv", TABLE + "5,3,40,1\n6,3,41,1", r"t.csv:3:1: frame_time does not rise from line 2"),
        ("t.csv", TABLE + "6,3,40,1\n5,3,41,2", r"t.csv:3:1: sync_index does not rise from line 2"),
        ("t.csv", TABLE + "5,3,40,soon", r't.csv:2:\d+: "soon" in column frame_time(.|\n)*time in s'),
        ("t.csv", TABLE + "5,3,40,1e30", r't.csv:2:\d+: "1e30" in column frame_time'),
        ("t.csv", "sync_index,cam_id\n5,3", r"t.csv:1:1: missing columns: frame_time"),
        ("t.pts", "0\n33\n", r"t.pts:1:1: this is no list(.|\n)*# timestamp format v2"),
        ("t.pts", "# timestamp format v2\n0\n-5\n", r't.pts:3:1: "-5" is no time in ms'),
        ("t.pts", "# timecode format v2\n0\n7\n7.0\n", r"t.pts:4:1: this time stands twice"),
        ("t.pts", "# timestamp format v2\n" + "9" * 18, r"t.pts:2:1: .* is no time in ms"),
        ("t.pts", "# timestamp format v2\n", r"t.pts:1:1: no time stamp"),
        ("t.pts", "\xff", r"t.pts is no list"),
        ("t.pts", None, r"t.pts cannot be read: No such file"),
    ],
)
def test_mistake_in_recorded_times_is_found_by_check(
    tmp_path: Path, file: str, text: str | None, complaint: str
) -> None:
    if text is not None:
        (tmp_path / file).write_text(text, "latin-1")
    path = record(tmp_path / "a.avi", frames=2)
    for stage, at in ((Video, path), (Images, tmp_path)):
        cv2.imwrite(str(tmp_path / "0.png"), picture(0))
        with pytest.raises(InputError, match=complaint):
            list(stage.check_files(stage.Params(path=at, times=tmp_path / file), Room(), context().member))


def folder(path: Path, *names: str) -> Path:
    for number, name in enumerate(names):
        cv2.imwrite(str(path / name), picture(number))
    return path


def images(path: Path, **params: object) -> list:
    stage = Images(context(), path=path, **params)
    stage.setup()
    return list(stage.process())


@pytest.mark.parametrize(
    ("form", "names", "expected"),
    [
        ("ns", ["1403636579763555584.png", "1403636579813555456.png"], 1403636579763555584),
        ("s", ["cam3-10.25.png", "cam3-10.5.png"], 10_250_000_000),
        ("ms", ["7_cam3.jpg", "8_cam3.jpg"], None),
        (
            "%Y-%m-%dT%H%M%S.%f%z",
            ["1970-01-01T010001.5+0100.png", "1970-01-01T000001.75+0000.png"],
            1_500_000_000,
        ),
        ("shot_%Y%m%d_%H%M%S", ["shot_19700102_000000.png", "shot_19700102_000001.png"], 86_400 * 10**9),
    ],
)
def test_pictures_take_their_times_from_their_names(
    tmp_path: Path, form: str, names: list[str], expected: int | None
) -> None:
    if expected is None:
        with pytest.raises(InputError, match="were taken at one time"):
            images(folder(tmp_path, *names), name_time=form)
        return
    frames = images(folder(tmp_path, *names), name_time=form)
    assert frames[0].header.time == expected
    assert [(frame.header.seq, numbers(frame.pixels)) for frame in frames] == [(0, 0), (1, 1)]


def test_decimal_places_of_names_are_compared_as_numbers(tmp_path: Path) -> None:
    frames = images(folder(tmp_path, "1.5.png", "1.25.png"), name_time="s", start_time=1)
    assert times(frames) == [2_250_000_000, 2_500_000_000]
    assert [numbers(frame.pixels) for frame in frames] == [1, 0]


@pytest.mark.parametrize("form", ["s", "%Y", "%Q", "("])
def test_name_without_a_time_is_refused_by_check(tmp_path: Path, form: str) -> None:
    params = Images.Params(path=folder(tmp_path, "no time.png"), name_time=form)
    with pytest.raises(InputError, match=r"no time.png: the name has no(.|\n)*another name_time"):
        list(Images.check_files(params, Room(), context().member))


def test_pictures_take_their_times_from_a_table(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("cam_id,frame_time\n3,2\n3,2.5\n")
    assert times(images(folder(tmp_path, "a2.png", "a10.png"), times=tmp_path / "t.csv")) == [
        2 * 10**9,
        25 * 10**8,
    ]
    folder(tmp_path, "a11.png")
    with pytest.raises(InputError, match=r"has 3 pictures, t.csv times of 2"):
        images(tmp_path, times=tmp_path / "t.csv")


def test_two_clocks_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValidationError, match="times and fps each give capture times"):
        Video.Params(path=tmp_path, times=tmp_path, fps=30)
    with pytest.raises(ValidationError, match="times and name_time both"):
        Images.Params(path=tmp_path, times=tmp_path, name_time="s")


class Still:
    """A video whose time stamps do not advance."""

    def get(self, prop: int) -> float:
        return 40.0


def test_time_stamps_that_stand_still_are_refused(tmp_path: Path) -> None:
    stamps = TimeStamps(tmp_path / "a.mkv", Still(), 0)
    assert stamps.time_of(0) == 40_000_000
    with pytest.raises(InputError, match=r"a.mkv: frame 1 has no later time stamp"):
        stamps.time_of(1)


def test_reading_times_sets_no_context_variable(tmp_path: Path) -> None:
    """One that is set makes each later call of numpy slower; arithmetic of decimal numbers sets one."""
    path, here = tmp_path / "t.pts", Context()
    path.write_text(LIST)
    assert here.run(read_time_list, path) == [0, 33_333_000, 500_500_000]
    assert here.run(time_of_name, Path("cam_12.5.png"), "ms") == 12_500_000
    assert not len(here)


def test_a_rate_that_is_next_to_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValidationError, match=r"a frame rate is 0 or at least 0\.001"):
        Video.Params(path=tmp_path, fps=1e-9)
