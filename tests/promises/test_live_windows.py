"""A 1 kHz sensor beside a 60 Hz camera, live and replayed: every reading is in exactly one window."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from tests.commands import command

STAGES = Path(__file__).parents[1] / "stages" / "rates.py"
GRAPH = """
graph: windows
stages:
  camera: {{uses: rates.device, with: {{hz: 60, count: {frames}}}}}
  sensor: {{uses: rates.device, with: {{hz: 1000, count: {readings}}}}}
  gather: {{uses: rates.gather, in: {{frame: camera, readings: sensor}}, deadline: 0.5}}
  save:   {{uses: rates.write, in: {{readings: gather}}, with: {{path: windows.csv}}}}
"""


def told(*words: object) -> dict[str, Any]:
    """What the command says at the end."""
    done = command(*words, "--plugin", STAGES, "--json", "--quiet")
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    return json.loads(done.stdout.splitlines()[-1])


def windows(folder: Path) -> list[tuple[int, list[tuple[int, int]]]]:
    """The time of each firing, ns, and its readings with their times."""
    found = []
    for line in (folder / "windows.csv").read_text().splitlines():
        time, _, rest = line.partition(":")
        found.append((int(time), [(int(v), int(t)) for v, _, t in (w.partition("@") for w in rest.split())]))
    return found


def edge(summary: dict[str, Any]) -> dict[str, int]:
    """The ledger of the edge from the sensor to its window."""
    return next(e for e in summary["edges"] if e["from"] == "sensor.out" and e["to"] == "gather.readings")


@pytest.mark.parametrize("seconds", [2, pytest.param(60, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("placement", ["", pytest.param("stage", marks=pytest.mark.thorough)])
def test_every_reading_is_in_exactly_one_window_live_and_replayed(
    tmp_path: Path, seconds: int, placement: str
) -> None:
    graph, recording = tmp_path / "windows.yaml", tmp_path / "all.mcap"
    graph.write_text(GRAPH.format(frames=60 * seconds, readings=1000 * seconds))
    placed = ("--placement", placement) if placement else ()
    live = told("run", graph, "--out", tmp_path / "live", "--record", recording, *placed)
    count = edge(live)
    seen = [value for _, readings in windows(tmp_path / "live") for value, _ in readings]
    assert all(a < b for a, b in pairwise(seen)), "in order, and none twice"
    assert len(seen) == count["delivered"]
    assert count["produced"] == 1000 * seconds == len(seen) + count["dropped"] + count["unmatched"]
    assert all(t <= time for time, readings in windows(tmp_path / "live") for _, t in readings)

    replays = [told("replay", recording, "--out", tmp_path / f"replay{n}") for n in range(2)]
    first, second = ((tmp_path / f"replay{n}" / "windows.csv").read_bytes() for n in range(2))
    assert first == second
    before = -1
    for time, readings in windows(tmp_path / "replay0"):
        assert all(before < t <= time for _, t in readings)
        before = time
    replayed = [value for _, readings in windows(tmp_path / "replay0") for value, _ in readings]
    assert all(a < b for a, b in pairwise(replayed))
    counts = edge(replays[0])
    assert (counts["dropped"], counts["late"]) == (0, 0)
    assert len(replayed) + counts["unmatched"] == counts["produced"]
