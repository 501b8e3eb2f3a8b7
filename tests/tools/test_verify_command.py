"""`verify` as a user types it: what a recording repeats, and what is different."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.tools.recorded_show import FRAMES, GRAPHS, altered, chunks_of, recorded

from followspot.cli.main import main
from followspot_record.comparison import Compared
from followspot_record.verify import text
from followspot_recording.recording import Recording


@pytest.fixture(scope="module")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("show"))


def test_verify_finds_everything_the_same(show: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", str(show), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["same"]
    assert {row["messages"] for row in found["ports"]} == {FRAMES}
    assert len(found["ports"]) == 14


def test_verify_says_that_sources_alone_are_not_repeated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "alone.yaml").write_text(
        f"graph: alone\nroom: {GRAPHS / 'rooms' / 'simulated.yaml'}\n"
        "stages:\n"
        "  camera: {uses: room.source, each: cameras}\n"
        "  draw: {uses: sinks.draw, in: {frames: camera}}\n"
    )
    file = str(tmp_path / "alone.mcap")
    assert main(["record", str(tmp_path / "alone.yaml"), "--frames", "2", "--record", file]) == 0
    capsys.readouterr()
    assert main(["verify", file]) == 1
    assert capsys.readouterr().out.endswith("0 ports, 0 messages: nothing is repeated\n")


def tracked_otherwise(show: Path, changed: Path) -> Path:
    """The recording with another parameter of its tracker in the plan: other tracks than those recorded."""
    with Recording(show) as recording:
        plan = json.loads(recording.attachment("plan.json"))
    track = next(stage for stage in plan["stages"] if stage["name"] == "track")
    track["params"]["acceleration_sigma"] *= 2
    return altered(show, changed, stages=plan["stages"])


def test_verify_names_the_first_difference(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = tracked_otherwise(show, tmp_path / "b.mcap")
    assert main(["verify", str(changed), "--json"]) == 1
    rows = {row["port"]: row["difference"] for row in json.loads(capsys.readouterr().out)["ports"]}
    assert rows["track.tracks"].startswith("message ")
    assert "column " in rows["track.tracks"]


def test_verify_says_where_a_recording_ends_before_its_sources(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As that of a run whose worker died: the file is whole, and the sources were ahead.

    A stage that sends more now leaves the same file, so that scripts are not told that all is the same.
    """
    ends = {"/followspot/infrared/cam1/out": 3, "/followspot/track/tracks": 4}
    early = altered(show, tmp_path / "early.mcap", ends)
    assert main(["verify", str(early)]) == 1
    told = capsys.readouterr().out
    assert "early.mcap ends early: infrared/cam1.out has nothing from 0.05 s on" in told
    assert "different" not in told
    assert f"14 ports, {14 * 3} messages: the same up to there" in told


def test_a_message_more_at_the_end_is_a_difference(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shorter = altered(show, tmp_path / "shorter.mcap", {"/followspot/track/tracks": FRAMES - 1})
    assert main(["verify", str(shorter)]) == 1
    assert f"message {FRAMES - 1} is new" in capsys.readouterr().out


def test_verify_says_up_to_where_a_damaged_recording_is_good(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    last = max(chunks_of(show))
    cut.write_bytes(show.read_bytes()[: last + 100])
    assert main(["verify", str(cut)]) == 1
    told = capsys.readouterr().out
    assert "read up to there" in told
    assert told.endswith("the same as far as the damaged file can be read\n")
    assert main(["verify", str(cut), "--up-to-damage", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["same"]
    assert "read up to there" in found["damage"]


def test_a_difference_counts_whatever_is_damaged(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = tracked_otherwise(show, tmp_path / "b.mcap")
    changed.write_bytes(changed.read_bytes()[:-100])
    assert main(["verify", str(changed), "--up-to-damage"]) == 1
    told = capsys.readouterr().out
    assert "its index is damaged" in told
    assert told.endswith("different\n")


def test_verify_says_that_a_recording_was_cut_before_its_sources(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    first = min(chunks_of(show))
    cut.write_bytes(show.read_bytes()[: first + 100])
    assert main(["verify", str(cut)]) == 2
    assert f"damaged at byte {first} of {first + 100}" in capsys.readouterr().err


def test_the_last_line_of_verify_counts_the_ports_that_are_not_repeated() -> None:
    repeated, left = Compared("track.tracks", 12), Compared("verify.out", 0, unrepeated="its type differs")
    assert text(True, [repeated], []).endswith("1 ports, 12 messages: the same, byte for byte")
    assert text(True, [repeated, left], []).endswith(
        "1 ports, 12 messages: the same, byte for byte; 1 of 2 recorded ports not repeated"
    )


def test_what_is_no_recording_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mcap").write_text("hello")
    assert main(["verify", str(tmp_path / "a.mcap")]) == 1
    assert "a.mcap is no recording" in capsys.readouterr().err
    assert main(["replay", str(tmp_path / "none.mcap")]) == 1
    assert "No such file" in capsys.readouterr().err
