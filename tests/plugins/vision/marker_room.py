"""The room of the tests of markers, and the size of its markers, m."""

from __future__ import annotations

from pathlib import Path

from followspot import room_file

GRAPHS = Path(__file__).parents[3] / "graphs"
ROOM = room_file.load(GRAPHS / "rooms/simulated_markers.yaml")
SIZE = 0.2
