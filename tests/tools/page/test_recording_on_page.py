"""The page of a recording: it shows what was said last at any moment, and plays from there."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from followspot.cli.main import main
from followspot.errors import FollowspotError
from followspot_page.allowed_requests import Seek, request_of
from followspot_page.page_process import PageOrder, shown
from followspot_recording.recording import Recording

KEPT = Path(__file__).parents[2] / "plugins" / "recording" / "kept" / "version_0_1.mcap"
TRACKS = "track.tracks"
TIMEOUT = 60.0


def told(socket: ClientConnection, wanted: str, **known: Any) -> dict[str, Any]:
    """The next message of a type with these values."""
    deadline = time.monotonic() + TIMEOUT
    while time.monotonic() < deadline:
        said = socket.recv(timeout=TIMEOUT)
        found: dict[str, Any] = json.loads(said) if isinstance(said, str) else {"type": "picture"}
        if found["type"] == wanted and known.items() <= found.items():
            return found
    raise AssertionError(f"no {wanted} with {known}")


def look(url: str) -> ClientConnection:
    return connect(url.replace("http", "ws") + "look", proxy=None)


def test_a_moment_shows_what_was_said_last(tmp_path: Path) -> None:
    with Recording(KEPT) as recording:
        times = [message.time for message in recording.messages(TRACKS)]
    with shown(PageOrder(0, recording=str(KEPT))) as page, look(page.url) as socket:
        scene = told(socket, "scene")
        assert scene["graph"] == "points"
        assert scene["recorded"] == {"begin": 0.0, "end": pytest.approx(times[-1] / 1e9)}
        assert not scene["forms"]
        for time_ns in (times[5], times[2]):  # back, too
            socket.send(json.dumps({"seek": (time_ns + 1_000_000) / 1e9, "play": False}))
            assert told(socket, "view", port=TRACKS, time=time_ns / 1e6)["kind"] == "Tracks"
            assert not told(socket, "position")["playing"]


def test_it_plays_to_the_end_and_begins_anew(tmp_path: Path) -> None:
    with shown(PageOrder(0, recording=str(KEPT))) as page, look(page.url) as socket:
        told(socket, "position", at=0.0, playing=False)
        for _ in range(2):
            socket.send(json.dumps({"seek": None, "play": True}))
            assert told(socket, "position", playing=True)["at"] < 0.1
            assert told(socket, "position", playing=False)["at"] == pytest.approx(0.116666667)


def test_a_recording_on_the_page_cannot_be_changed() -> None:
    with shown(PageOrder(0, recording=str(KEPT))) as page, look(page.url) as socket:
        socket.send(json.dumps({"stage": "track", "key": "noise", "value": "1"}))
        answer = told(socket, "answer")
        assert (answer["ok"], answer["text"]) == (False, "this page shows a recording")
    with pytest.raises(FollowspotError):
        request_of('{"seek": NaN, "play": true}')
    assert request_of('{"seek": 1.5, "play": false}') == Seek(1.5, play=False)


def test_a_recording_that_is_cut_short_is_shown_up_to_there_and_says_so(tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    whole = KEPT.read_bytes()
    cut.write_bytes(whole[: len(whole) * 9 // 10])
    with shown(PageOrder(0, recording=str(cut))) as page, look(page.url) as socket:
        said = f"{cut}: its index is damaged or incomplete; the messages are whole"
        assert told(socket, "run")["faults"] == [said]
        assert told(socket, "view", port=TRACKS)["kind"] == "Tracks"
    cut.write_bytes(whole[: len(whole) // 2])
    with shown(PageOrder(0, recording=str(cut))) as page, look(page.url) as socket:
        (fault,) = told(socket, "run")["faults"]
        assert fault.startswith(str(cut))
        assert "read up to there" in fault
        socket.send(json.dumps({"seek": 1e300, "play": True}))
        assert told(socket, "answer")["ok"]


def test_damage_is_told_when_it_is_reached(tmp_path: Path) -> None:
    torn = tmp_path / "torn.mcap"
    data = bytearray(KEPT.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 200] = bytes(200)
    torn.write_bytes(data)
    with shown(PageOrder(0, recording=str(torn))) as page, look(page.url) as socket:
        end = told(socket, "scene")["recorded"]["end"]
        socket.send(json.dumps({"seek": end, "play": False}))
        assert told(socket, "answer")["ok"]
        faults: list[str] = []
        while not faults:
            faults = told(socket, "run")["faults"]
        assert "read up to there" in faults[0]


def test_tabs_that_close_while_they_scrub_leave_the_page_to_others() -> None:
    with shown(PageOrder(0, recording=str(KEPT))) as page:
        for number in range(20):
            with look(page.url) as tab:
                tab.send(json.dumps({"seek": number / 200, "play": number % 2 == 0}))
                if number % 3:
                    tab.socket.shutdown(2)  # without a word
        with look(page.url) as socket:
            socket.send(json.dumps({"seek": 0.05, "play": False}))
            assert told(socket, "answer")["ok"]
            told(socket, "position", at=0.05, playing=False)


def test_figures_of_a_recording_are_plotted(tmp_path: Path) -> None:
    with shown(PageOrder(0, recording=str(KEPT))) as page, look(page.url) as socket:
        scene = told(socket, "scene")
        fields = scene["figures"]["kinds"][scene["figures"]["ports"][TRACKS]]["fields"]
        assert "z" in [field["name"] for field in fields]
        target = scene["room"]["targets"][0]["name"]
        socket.send(json.dumps({"plot": [{"port": TRACKS, "row": target, "field": "z"}]}))
        assert told(socket, "answer")["ok"]
        ((row, field, value),) = told(socket, "curves", port=TRACKS)["values"]
        assert (row, field) == (target, "z")
        assert isinstance(value, float)
        socket.send(json.dumps({"plot": [{"port": "camera.out", "row": "", "field": "rows"}]}))
        assert not told(socket, "answer", ok=False)["ok"]


def test_a_file_that_is_no_recording_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mcap").write_text("hello")
    assert main(["dashboard", str(tmp_path / "a.mcap"), "--dashboard-at", "127.0.0.1:0"]) == 1
    assert "a.mcap is no recording" in capsys.readouterr().err
