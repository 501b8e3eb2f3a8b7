"""Streams of different rates give the same bytes in one process, in one for each stage, and over Zenoh."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.promises.played import Played, differences, play

STAGES = Path(__file__).parents[1] / "stages" / "rates.py"
GRAPH = """
graph: rates
stages:
  camera:  {uses: rates.sensor, with: {hz: 60, count: 60, shift: 0.0041}}
  sensor:  {uses: rates.sensor, with: {hz: 1000, count: 1000}}
  slow:    {uses: rates.sensor, with: {hz: 7, count: 7}}
  gather:  {uses: rates.gather, in: {frame: camera, readings: {from: sensor, depth: 2}}}
  near:    {uses: rates.near, in: {frame: camera, reading: {from: slow, tolerance: 0.06}}}
  meet:    {uses: rates.meet, in: {frame: camera, reading: sensor}}
  mix:     {uses: rates.mix, in: {frame: camera, window: [sensor, slow], near: sensor, latest: sensor}}
  again:   {uses: rates.mix, in: {frame: mix, other: camera, window: sensor, near: {from: sensor, depth: 1}}}
  windows: {uses: rates.write, in: {readings: gather}, with: {path: windows.csv}}
  nears:   {uses: rates.write, in: {readings: near}, with: {path: nears.csv}}
  meets:   {uses: rates.write, in: {readings: meet}, with: {path: meets.csv}}
  burst:   {uses: rates.burst, in: {reading: camera}, with: {step_us: 5000}}
  later:   {uses: rates.later, in: {reading: burst}, concurrency: 4}
  last:    {uses: rates.mix, in: {frame: later, window: sensor, near: burst, latest: camera}}
  bursts:  {uses: rates.note, in: {reading: burst}, with: {path: bursts.csv}}
  laters:  {uses: rates.note, in: {reading: later}, with: {path: laters.csv}}
  lasts:   {uses: rates.note, in: {reading: last}, with: {path: lasts.csv}}
  mixes:   {uses: rates.note, in: {reading: again}, with: {path: mixes.csv}}
"""
PLACEMENT = """
placement: three
workers:
  sources: {stages: [camera, sensor, slow]}
  first:   {stages: [mix, meet, gather, near, burst]}
"""
"""What is not named runs in a worker of its own."""


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Played]:
    folder = tmp_path_factory.mktemp("rates")
    graph = folder / "rates.yaml"
    graph.write_text(GRAPH)
    return graph, play(graph, folder, "--plugin", str(STAGES), record=False)


def test_it_ran_and_each_stage_fired(once: tuple[Path, Played]) -> None:
    fired = once[1].report["stages"]
    assert {fired[name] for name in ("gather", "near", "meet", "mix", "again", "burst")} == {(60, 0)}
    assert fired["later"] == (180, 0)


def again(once: tuple[Path, Played], folder: Path, placement: str, edges: str) -> list[str]:
    """What differs if the stages are placed like this."""
    graph, expected = once
    (folder / "three.yaml").write_text(PLACEMENT)
    placed = str(folder / "three.yaml") if placement == "three" else placement
    options = ("--plugin", str(STAGES), "--placement", placed, "--edges", edges)
    return differences(expected, play(graph, folder, *options, record=False))


@pytest.mark.parametrize("edges", ["ring", "zenoh"])
def test_the_same_bytes_in_three_processes(once: tuple[Path, Played], tmp_path: Path, edges: str) -> None:
    assert not again(once, tmp_path, "three", edges)


@pytest.mark.thorough
@pytest.mark.parametrize("edges", ["ring", "zenoh"])
def test_the_same_bytes_in_a_process_each(once: tuple[Path, Played], tmp_path: Path, edges: str) -> None:
    assert not again(once, tmp_path, "stage", edges)
