"""Recorded ports as sources."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.plugins.recording.recorded_messages import ROOM, SPACING, record, tracks

from followspot import Context
from followspot.errors import FollowspotError
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot_recording.replays import REPLAYS


def test_every_replay_has_its_stage() -> None:
    for name, kind in REPLAYS.items():
        (port,) = ports(load_stage(f"recording.{name}")).outputs
        assert port.type is kind


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("recording.port[balls.kalman.track]", 'balls.kalman has no output "track"'),
        ("recording.port[balls.kallman.tracks]", 'no stage "balls.kallman"'),
        ("recording.port[recording.port[balls.kalman.tracks].out]", "cannot be asked for"),
        ("recording.tracks[balls.kalman.tracks]", "cannot be asked for"),
        ("recording.port[", 'no stage ""'),
    ],
)
def test_a_replay_of_a_port_that_is_none_says_so(name: str, said: str) -> None:
    with pytest.raises(FollowspotError) as told:
        load_stage(name)
    assert said in str(told.value)


def test_a_replay_without_a_type_says_what_to_write(tmp_path: Path) -> None:
    with pytest.raises(FollowspotError, match=r"recording\.port\[STAGE\.PORT\]"):
        load_stage("recording.port")(path=record(tmp_path / "a.mcap", 1)).setup()


def replayed(path: Path, **params: object) -> list[Message]:
    stage = load_stage("recording.tracks")(Context("track", ROOM), path=path, port="track.tracks", **params)
    stage.setup()
    try:
        return [message for message, _ in zip(stage.process(), range(100), strict=False)]
    finally:
        stage.close()


def test_a_replay_keeps_times_and_numbers(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap")
    found = replayed(path, start_time=0.06, stop_time=0.09)
    assert [m.header.seq for m in found] == [4, 5]
    assert [m.header.time for m in found] == [4 * SPACING, 5 * SPACING]
    assert found[0].xyz.tobytes() == tracks(4).xyz.tobytes()


def test_a_replay_in_a_loop_goes_on_in_time(tmp_path: Path) -> None:
    found = replayed(record(tmp_path / "a.mcap", 3), loop=True)
    times = [m.header.time for m in found]
    assert len(found) == 100
    assert times == sorted(set(times))
    assert [m.header.seq for m in found[:7]] == [0, 1, 2, 3, 4, 5, 6]


def test_a_replay_of_another_type_says_what_is_there(tmp_path: Path) -> None:
    path = record(tmp_path / "a.mcap", 1)
    stage = load_stage("recording.blobs")(Context("color", ROOM), path=path, port="track.tracks")
    stage.setup()
    with pytest.raises(FollowspotError, match=r"holds followspot\.tracking\.Tracks"):
        next(stage.process())
    stage.close()
