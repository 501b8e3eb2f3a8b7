"""Marked moments become files that other programs open, and a full disk harms nothing."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from mcap.reader import make_reader
from tests.full_disk import full_disk

from followspot import Message
from followspot.graph.compile import compile_graph
from followspot.library.handle import Moment, RecorderState
from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.tracking import Frame, Tracks
from followspot.wire import pack
from followspot_record.flight import moment_file
from followspot_record.flight.kept_messages import KeptMessage
from followspot_record.flight.moment_file import RESERVE, MomentFile
from followspot_record.flight.recorder import FlightRecorder
from followspot_recording.recording import Recording

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
PORT = "track.tracks"
S = 1_000_000_000


class Show:
    """A flight recorder whose clock goes with the capture times."""

    def __init__(self, folder: Path, period: float = 4.0) -> None:
        self.now = 0.0
        self.folder = folder
        self.plan = compile_graph(GRAPH)
        self.files = 0
        self.recorder = FlightRecorder(period, 1 << 20, self.open_file, lambda: self.now)

    def open_file(self) -> MomentFile:
        self.files += 1
        path = self.folder / f"{self.files}.mcap"
        return MomentFile(path, self.plan, {PORT: Tracks}, {"graph/a.yaml": "graph: a\n"}, 1 << 20)

    def play(self, seconds: int, missing: int = 0) -> None:
        """A message each second."""
        for _ in range(seconds):
            nothing = np.zeros((0, 3))
            tracks = Tracks(np.zeros(0, "i4"), np.zeros(0, "u1"), nothing, nothing, nothing)
            moment = round(self.now * S)
            message = stamped(seal(tracks), Header("camera/cam0", round(self.now), moment))
            self.recorder.put(PORT, moment, missing, pack(message))
            self.now += 1.0
            self.recorder.finish_files()

    def wait_for(self, state: str) -> None:
        """Until the newest file is in this state; another thread writes it."""
        deadline = time.monotonic() + 60.0
        while self.moments()[-1].state != state:
            assert time.monotonic() < deadline
            time.sleep(0.01)

    def moments(self) -> tuple[Moment, ...]:
        found: RecorderState = self.recorder.kept()
        return found.moments


def seconds(path: Path) -> list[int]:
    with Recording(path) as recording:
        assert recording.problem == ""
        return [message.time // S for message in recording.messages(PORT)]


def test_a_mark_holds_the_seconds_before_and_after_it(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(20)
    show.recorder.mark(2.0, "blue jumped", 7)
    show.play(20)
    show.recorder.close()
    (moment,) = show.moments()
    assert (moment.state, moment.marks, moment.notes) == ("complete", (7,), ("blue jumped",))
    assert (moment.seconds, moment.messages) == (6.0, 7)
    assert seconds(Path(moment.file)) == [15, 16, 17, 18, 19, 20, 21]


def test_the_file_is_whole_before_the_recorder_ends_and_others_open_it(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(5)
    show.recorder.mark(0.0, "now")
    show.play(3)
    show.recorder.close()
    with (tmp_path / "1.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        log = [message.data for _, channel, message in reader.iter_messages() if channel.topic == "/log"]
        names = {attachment.name for attachment in reader.iter_attachments()}
        facts = {record.name: record.metadata for record in reader.iter_metadata()}
    assert b"marked: now" in log[-1]
    assert names == {"plan.json", "graph/a.yaml"}
    assert facts["mark 1"] == {"text": "marked: now", "time": str(4 * S)}
    assert facts["followspot"]["graph"] == "glowballs"


def test_marks_that_overlap_share_a_file_even_after_it_was_complete(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(10)
    show.recorder.mark(1.0, "one")
    show.play(1)
    show.recorder.mark(2.0, "two")
    show.play(5)
    show.wait_for("complete")
    show.recorder.mark(1.0, "three")
    assert show.moments()[0].state == "open", "what comes now belongs to it"
    show.play(3)
    show.recorder.close()
    (moment,) = show.moments()
    assert moment.notes == ("one", "two", "three")
    assert seconds(Path(moment.file)) == list(range(5, 17))


def test_a_mark_takes_no_seconds_from_an_earlier_one(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(10)
    show.recorder.mark(6.0, "long")
    show.play(2)
    show.recorder.mark(1.0, "short")
    show.play(10)
    show.recorder.close()
    assert seconds(tmp_path / "1.mcap") == list(range(5, 16))


def test_a_mark_after_its_file_was_taken_away_begins_another(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(10)
    show.recorder.mark(0.0, "one")
    show.play(1)
    show.wait_for("complete")
    (tmp_path / "1.mcap").rename(tmp_path / "mine.mcap")
    show.recorder.mark(0.0, "two")
    show.play(1)
    show.recorder.close()
    assert seconds(tmp_path / "mine.mcap") == list(range(5, 10))
    assert seconds(tmp_path / "2.mcap") == list(range(6, 11))


def test_a_later_mark_begins_a_file_of_its_own(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(5)
    show.recorder.mark(0.0, "one")
    show.play(12)
    show.recorder.mark(0.0, "two")
    show.play(3)
    show.recorder.close()
    assert [moment.notes for moment in show.moments()] == [("one",), ("two",)]
    assert seconds(tmp_path / "1.mcap") == [0, 1, 2, 3, 4]
    assert seconds(tmp_path / "2.mcap") == [12, 13, 14, 15, 16]


def test_messages_that_never_came_are_counted(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(3, missing=2)
    show.recorder.mark(0.0, "")
    show.recorder.close()
    assert show.moments()[0].lost == 6 == show.recorder.kept().lost


def test_a_full_disk_fails_the_moment_and_a_later_one_is_tried_anew(tmp_path: Path) -> None:
    show = Show(tmp_path)
    show.play(3)
    with full_disk(2_000):
        show.recorder.mark(10.0, "lost")
        show.wait_for("failed")
    show.recorder.mark(0.0, "kept")
    show.play(3)
    show.recorder.close()
    first, second = show.moments()
    assert (first.state, second.state) == ("failed", "complete")
    assert "1.mcap is cut short" in first.problem
    assert seconds(tmp_path / "2.mcap") == [0, 1, 2]


def test_a_mark_leaves_what_others_on_the_disk_need(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(tmp_path)
    free = [RESERVE, RESERVE - 1, RESERVE - 1]
    monkeypatch.setattr(moment_file.shutil, "disk_usage", lambda _: usage._replace(free=free.pop(0)))
    monkeypatch.setattr(moment_file, "_CHECKED", 1)
    show = Show(tmp_path)
    show.play(3)
    show.recorder.mark(0.0, "nearly full")
    show.wait_for("failed")
    show.recorder.close()
    assert "256 MiB is free" in show.moments()[0].problem
    assert "left to what the run writes" in show.moments()[0].problem
    assert seconds(tmp_path / "1.mcap") == []


def test_a_port_that_comes_while_a_file_is_open_is_in_it(tmp_path: Path) -> None:
    types: dict[str, type[Message]] = {PORT: Tracks}
    file = MomentFile(tmp_path / "a.mcap", compile_graph(GRAPH), types, {}, 1 << 20)
    file.mark(1, "", 0)
    types["new.out"] = Frame
    packed = pack(stamped(seal(Frame("cam0", np.zeros((2, 2, 3), "u1"))), Header("camera/cam0", 0, 5)))
    file.put(KeptMessage(1, "new.out", 5, 0, packed), held=False)
    file.close()
    with Recording(tmp_path / "a.mcap") as recording:
        assert [message.time for message in recording.messages("new.out")] == [5]


def test_while_the_disk_is_behind_viewers_lose_their_copies_first_and_losses_are_counted(
    tmp_path: Path,
) -> None:
    packed = pack(stamped(seal(Frame("cam0", np.zeros((10, 10, 3), "u1"))), Header("camera/cam0", 0, 0)))
    limit = 10 * len(packed)
    port = "camera/cam0.out"
    file = MomentFile(tmp_path / "a.mcap", compile_graph(GRAPH), {port: Frame}, {}, limit)
    disk = Event()
    file._do(lambda: disk.wait() and None)
    file.mark(1, "", 0)
    for number in range(20):
        file.put(KeptMessage(number, port, number, 0, packed), held=False)
    disk.set()
    file.close()
    moment = file.moment
    assert (moment.messages, moment.lost) == (16, 4), "half as much again as the limit may wait"
    with (tmp_path / "a.mcap").open("rb") as found:
        topics = [channel.topic for _, channel, _ in make_reader(found).iter_messages()]
    assert topics.count("/followspot/camera/cam0/out") == 16
    assert topics.count("/camera/cam0") == 11, "none while more than the limit waits"
