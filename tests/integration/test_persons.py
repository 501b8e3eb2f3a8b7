"""People in recordings get poses as exact as promised, whichever process the slow instance runs in.

The recordings are `persons-dev`: rendered people with ground truth. Short parts, and a
detector that looks at every third picture, for speed; `docs/persons.md` has the figures of whole ones.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from tests.commands import command
from tests.datasets import dataset, needs_data
from tests.integration.running import balanced

ROOT = Path(__file__).parent.parent.parent
GRAPHS = ROOT / "graphs"
DATA = dataset("persons-dev")
PERIOD = 3
"""Pictures from one that the detector processes to the next."""

needs_recordings = needs_data("persons-dev")


def said(*words: str | int | Path) -> str:
    return command(*words, check=True).stdout


def room_of(tmp_path: Path, *cameras: str) -> Path:
    """A room file with some of the recordings."""
    room = tmp_path / "room.yaml"
    said("room", "import", DATA / "calib.json", "--videos", DATA, "--only", *cameras, "-o", room)
    return room


def tracked(room: Path, graph: str, frames: int, out: Path, *options: str | Path) -> dict[str, Any]:
    """The summary of a run of the first `frames` frames."""
    files = (GRAPHS / graph, "--room", room, "--out", out)
    asked = ("--frames", frames, "--json", "--quiet", "--set", f"hog.frame_interval={PERIOD}", *options)
    summary: dict[str, Any] = json.loads(said("run", *files, *asked))
    assert balanced(summary)
    return summary


@pytest.mark.thorough
@needs_recordings
def test_a_person_in_a_panorama_is_followed_the_same_with_the_slow_instance_in_a_process_of_its_own(
    tmp_path: Path,
) -> None:
    room = room_of(tmp_path, "d_o")
    placement = GRAPHS / "placements/person.yaml"
    summary = tracked(room, "person_panorama.yaml", 26, tmp_path / "two", "--placement", placement)
    found = summary["persons"]["all"]
    assert found["coverage"] >= 0.8  # of 26 frames, which hold the time until the person is known
    assert max(found["acquire_s"]) <= 2
    assert found["height_cm"]["sigma"] < 3
    assert found["distance_m"]["sigma"] < 0.25
    assert found["direction_deg"]["median"] < 1
    assert found["torso"]["median_deg"] < 15
    assert found["torso"]["flipped"] < 0.05
    assert found["pan_median_deg"] < 20
    assert found["identity_switches"] == found["false_rows"] == found["duplicate_rows"] == 0

    tracked(room, "person_panorama.yaml", 7, tmp_path / "one")
    alone = (tmp_path / "one/poses.csv").read_text().splitlines()
    assert len(alone) > 3
    assert (tmp_path / "two/poses.csv").read_text().splitlines()[: len(alone)] == alone


@pytest.mark.thorough
@needs_recordings
def test_three_cameras_tell_where_two_people_are_to_within_centimetres(tmp_path: Path) -> None:
    room = room_of(tmp_path, "d_m_c1", "d_m_c2", "d_m_c3")
    found = tracked(room, "person_room.yaml", 13, tmp_path / "out")["persons"]
    for person in ("1", "2"):
        assert found[person]["position_cm"]["median"] < 8
        assert found[person]["torso"]["median_deg"] < 15
    assert found["all"]["height_cm"]["sigma"] < 3
    assert found["all"]["identity_switches"] == found["all"]["false_rows"] == 0


def test_simulated_people_are_followed_without_any_recording(tmp_path: Path) -> None:
    room = GRAPHS / "rooms/simulated_panorama.yaml"
    found = tracked(room, "person_panorama.yaml", 12, tmp_path / "out")["persons"]["all"]
    assert found["coverage"] >= 0.6  # of 12 frames, of which 4 pass until two boxes have shown somebody
    assert found["direction_deg"]["median"] < 1
    assert found["height_cm"]["median"] < 8
    assert found["identity_switches"] == found["false_rows"] == 0
