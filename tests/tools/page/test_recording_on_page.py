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
from followspot_page.changing import Seek, wish_of
from followspot_page.showing import PageOrder, shown
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
        wish_of('{"seek": NaN, "play": true}')
    assert wish_of('{"seek": 1.5, "play": false}') == Seek(1.5, play=False)


def test_a_file_that_is_no_recording_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mcap").write_text("hello")
    assert main(["dashboard", str(tmp_path / "a.mcap"), "--dashboard-at", "127.0.0.1:0"]) == 1
    assert "a.mcap is no recording" in capsys.readouterr().err
