"""A slow reader in a live run loses only its own messages, by the policy of its edge."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from tests.integration.running import Finished, balanced, run, write_graph

SLOW = """
camera: {{uses: ticks.live, with: {{count: 3000, period: 0.0005}}}}
fast:   {{uses: ticks.write, in: {{number: camera}}}}
slow:   {{uses: ticks.hold, in: {{number: {feed}}}, with: {{lines: 150}}}}
late:   {{uses: ticks.write, in: {{number: slow}}, with: {{path: late.csv}}}}
other:  {{uses: ticks.live, with: {{count: 3000, period: 0.0005, clock: false}}}}
ten:    {{uses: ticks.counter, in: {{number: other}}, with: {{sleep: 0.005}}}}
line:   {{uses: ticks.write, in: {{number: ten}}, with: {{path: line.csv}}}}
"""
DEPTH = 8
IN_HAND = 4
"""Messages outside the edge: two in the source's buffer, one being sent, one being taken."""
APART = """
placement: apart
workers:
  slow: {stages: [slow, late, ten, line]}
"""


@pytest.mark.parametrize(("policy", "edges"), [("latest", "ring"), ("drop_oldest, depth: 6", "zenoh")])
def test_a_slow_reader_never_holds_up_the_fast_branch_and_what_it_gets_is_not_old(
    tmp_path: Path, policy: str, edges: str
) -> None:
    graph = write_graph(tmp_path, SLOW.format(feed=f"{{from: camera, policy: {policy}}}"))
    (tmp_path / "apart.yaml").write_text(APART)
    finished = run(graph, "--placement", str(tmp_path / "apart.yaml"), "--edges", edges)
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    fast, slow = finished.values("ticks.csv"), finished.values("late.csv")
    assert len(fast) >= 150, "it would have been held up"
    _, *after = slow  # the first is the one that was held
    waited = [value for value in after if value < fast[140]]
    assert len(waited) <= 2, f"too old after the number that was held: {waited} of {slow[:12]}"
    counts = finished.edge("camera.", "slow.")
    assert counts["dropped"] >= 100
    assert counts["delivered"] == len(slow)
    check_overload(finished)
    times = [int(line.split(",")[1]) for line in finished.lines("line.csv")]
    assert times == sorted(set(times)), "a camera without a clock goes by that of its host"
    assert abs(times[0] - time.time_ns()) < 600e9


def check_overload(finished: Finished) -> None:
    """A stage ten times too slow, on an edge without a policy: its messages waited for few others."""
    waited = finished.values("line.csv")
    assert max(waited) <= DEPTH + IN_HAND, "the line before it grew"
    counts = finished.edge("other.", "ten.")
    assert counts["dropped"] > 100, "the source dropped the others"
    assert counts["sent"] == 3000 == counts["delivered"] + counts["dropped"]
    after = finished.edge("ten.", "line.")
    assert (after["sent"], after["dropped"]) == (len(waited), 0), "where nothing was too slow, nothing was"


BESIDE = """
near:  {uses: ticks.live, with: {count: 400, period: 0.002}}
kept:  {uses: ticks.write, in: {number: near}}
other: {uses: ticks.live, with: {count: 400, period: 0.002}}
ten:   {uses: ticks.counter, in: {number: other}, with: {sleep: 0.005}}
line:  {uses: ticks.write, in: {number: ten}, with: {path: line.csv}}
"""


def test_a_stage_that_always_has_work_leaves_turns_to_the_camera_of_its_worker(tmp_path: Path) -> None:
    graph = write_graph(tmp_path, BESIDE)
    (tmp_path / "beside.yaml").write_text(
        "placement: beside\nworkers:\n  here: {stages: [near, kept, ten]}\n"
    )
    finished = run(graph, "--placement", str(tmp_path / "beside.yaml"))
    assert finished.code == 0, finished.errors
    assert balanced(finished.summary)
    firings = finished.edge("other.", "ten.")["delivered"]
    assert firings >= DEPTH
    assert finished.edge("near.", "kept.")["delivered"] >= firings // 4
