"""What a source sends does not depend on who else is simulated in its process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOMS = sorted((Path(__file__).parents[3] / "graphs/rooms").glob("*.yaml"))
FEW = {
    "simulated": (40, 1),
    "simulated6": (12, 1),
    "simulated_panorama": (5, 4),
    "simulated_persons": (5, 4),
}
"""Frames for a short look, and how much coarser the cameras are (an empty room with furniture takes seconds).

In the first room a pixel of cam1 was another together from frame 92 on.
"""


def compare(room: Path, frames: int, coarser: int = 1) -> dict[str, Any]:
    """Each source of a room alone and with the others, bit for bit, each in processes of their own."""
    program = [
        sys.executable,
        str(Path(__file__).with_name("sources_together.py")),
        str(room),
        str(frames),
        str(coarser),
    ]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize(
    "name", ["simulated6", *(pytest.param(n, marks=pytest.mark.thorough) for n in FEW if n != "simulated6")]
)
def test_a_source_sends_the_same_bits_alone_and_together(name: str) -> None:
    found = compare(next(room for room in ROOMS if room.stem == name), *FEW[name])
    assert len(found["sources"]) > 1
    assert not found["differ"]


@pytest.mark.thorough
@pytest.mark.parametrize("room", ROOMS, ids=lambda room: room.stem)
def test_a_source_of_any_room_sends_the_same_bits_alone_and_together(room: Path) -> None:
    found = compare(room, 60 if "person" in room.stem or "panorama" in room.stem else 600)
    assert len(found["sources"]) > 1
    assert not found["differ"]
