"""Files of streams that are not in step: each message is written, and joins that leave some out say so."""

from __future__ import annotations

import csv
import json
from collections import Counter
from pathlib import Path

import pytest

import followspot as fs

RATES = {"a": 100, "b": 123, "c": 400}
"""Readings of each sensor in a second, which is all that there is."""
GRAPH = """graph: rates
stages:
  imu:   {uses: room.source, each: sensors}
  save:  {uses: sinks.csv,   in: {messages: imu}, with: {path: all.csv}}
  lines: {uses: sinks.jsonl, in: {messages: imu}, with: {path: all.jsonl}}
"""


def ran(folder: Path, graph: str, placement: str | None = None) -> fs.Report:
    """The report of a run of sensors with these rates."""
    room = "room: rates\ncameras: {}\nsensors:\n"
    for name, rate in RATES.items():
        rows = "".join(f"{k / rate:.9f},0,0,0,0,0,9.8\n" for k in range(rate))
        (folder / f"{name}.csv").write_text("time,gx,gy,gz,ax,ay,az\n" + rows)
        source = f"{{uses: imu.csv, with: {{path: {name}.csv, batch: 1}}}}"
        room += f"  {name}: {{kind: imu, source: {source}}}\n"
    (folder / "room.yaml").write_text(room)
    (folder / "graph.yaml").write_text(graph)
    with fs.run(
        folder / "graph.yaml", room=folder / "room.yaml", out=folder / "out", placement=placement
    ) as run:
        return run.wait()


@pytest.mark.parametrize("placement", [None, "stage"])
def test_every_message_of_every_sender_is_written_in_the_order_of_time(
    tmp_path: Path, placement: str | None
) -> None:
    report = ran(tmp_path, GRAPH, placement)
    assert report.ok
    assert report.warnings == ()
    rows = [*csv.DictReader((tmp_path / "out/all.csv").open())]
    assert Counter(row["sensor"] for row in rows) == RATES
    times = [float(row["time"]) for row in rows]
    assert times == sorted(times)
    lines = [json.loads(line) for line in (tmp_path / "out/all.jsonl").read_text().splitlines()]
    assert len(lines) == sum(RATES.values())


def test_a_tolerance_joins_and_the_run_says_what_it_left_out(tmp_path: Path) -> None:
    report = ran(
        tmp_path, GRAPH.replace("in: {messages: imu}, with", "tolerance: 0.004, in: {messages: imu}, with", 1)
    )
    rows = (tmp_path / "out/all.csv").read_text().count("\n") - 1
    assert rows < sum(RATES.values())
    (warning,) = report.warnings
    assert warning.startswith(
        f"imu.out -> save.messages: {sum(RATES.values()) - rows} of 623 messages found no"
    )
    assert "tolerance" in warning
