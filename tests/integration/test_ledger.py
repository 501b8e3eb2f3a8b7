"""Each kind of fault is counted in the ledger and reported to the user."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.integration.running import balanced, run, write_graph

CHAIN = """
a:    {uses: ticks.count, with: {count: 20}}
b:    {uses: ticks.add, in: {number: a}}
save: {uses: ticks.write, in: {number: b}}
"""


def test_a_stage_that_raises_ends_the_run_and_is_named_with_its_message(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "b.raise_at=7")
    assert finished.code == 1
    error = finished.summary["errors"][0]
    assert "stage b failed at a#7, 0.070000 s: ValueError: cannot add to 7" in error
    assert "ticks.py" in error, "the traceback leads to the line"
    assert finished.values() == list(range(1, 8))
    assert finished.edge("a.", "b.")["delivered"] == 8


def test_a_stage_that_raises_in_another_worker_ends_the_run_too(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "b.raise_at=7", "--placement", "stage")
    assert finished.code == 1
    assert any("stage b failed at a#7" in error for error in finished.summary["errors"])
    assert finished.edge("a.", "b.")["delivered"] == 8
    assert finished.values() == list(range(1, 8))


QUITS = """
import sys
from followspot import Message, Source, Stage, at

class Number(Message):
    value: int

class Give(Stage):
    def process(self) -> Source[Number]:
        yield from (at(10_000_000 * n, Number(n)) for n in range(20))

class Quit(Stage):
    def process(self, number: Number) -> Number:
        if number.value == 7:
            sys.exit("the licence has expired")
        return number

class Keep(Stage):
    def process(self, number: Number) -> None: ...
"""


@pytest.mark.parametrize("placement", [(), ("--placement", "stage")], ids=["one", "stages"])
def test_a_library_that_ends_the_process_is_an_error_of_its_stage(
    tmp_path: Path, placement: tuple[str, ...]
) -> None:
    (tmp_path / "quits.py").write_text(QUITS)
    stages = (
        "a: {uses: quits.give}\nb: {uses: quits.quit, in: {number: a}}\n"
        "c: {uses: quits.keep, in: {number: b}}"
    )
    finished = run(write_graph(tmp_path, stages), "--plugin", str(tmp_path / "quits.py"), *placement)
    assert finished.code == 1
    assert any(
        "stage b failed at a#7, 0.070000 s: SystemExit: the licence has expired" in error
        for error in finished.summary["errors"]
    )


def test_policy_skip_leaves_the_message_out_and_counts_it(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "b.raise_at=7", "--set", "b.on_error=skip")
    assert finished.code == 0
    assert finished.values() == [n + 1 for n in range(20) if n != 7]
    assert balanced(finished.summary)
    stages = {s["stage"]: s for w in finished.summary["workers"] for s in w["stages"]}
    assert stages["b"]["skipped"] == 1
    assert any("cannot add to 7" in warning for warning in finished.summary["warnings"])


def test_policy_restart_builds_a_new_stage(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "b.raise_at=7", "--set", "b.on_error=restart")
    assert finished.code == 0
    stages = {s["stage"]: s for w in finished.summary["workers"] for s in w["stages"]}
    assert stages["b"]["restarts"] == 1
    assert balanced(finished.summary)


def test_a_source_that_raises_is_named(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "a.raise_at=5")
    assert finished.code == 1
    assert "stage a failed" in finished.summary["errors"][0]
    assert "the camera fell down" in finished.summary["errors"][0]


def test_a_message_that_breaks_its_contract_is_invalid_and_goes_no_further(
    tmp_path: Path,
) -> None:
    for options in ([], ["--placement", "stage"]):
        finished = run(write_graph(tmp_path, CHAIN), "--set", "b.invalid_at=7", *options)
        assert finished.code == 0, finished.errors
        assert finished.edge("b.", "save.") == {
            "produced": 20,
            "away": 0,
            "sent": 20,
            "delivered": 19,
            "dropped": 0,
            "late": 0,
            "unmatched": 0,
            "invalid": 1,
            "lost": 0,
            "gap": 0,
            "packet_loss": 0,
            "device_overrun": 0,
            "in_flight": 0,
        }
        assert any("load has dtype float64, declared uint8" in w for w in finished.summary["warnings"])


def test_time_that_runs_backwards_is_invalid(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--set", "a.backwards_at=9")
    assert finished.edge("a.", "b.")["invalid"] == 1
    assert any(
        "a: " in warning and "before the watermark" in warning for warning in finished.summary["warnings"]
    )
    assert balanced(finished.summary)


def test_a_partner_that_is_missing_is_unmatched(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.count, with: {count: 20}}
b:    {uses: ticks.count, with: {count: 20, skip: 4}}
both: {uses: ticks.both, in: {left: a, right: b}}
save: {uses: ticks.write, in: {number: both}}
""",
    )
    finished = run(graph)
    assert finished.values() == [n * 1001 for n in range(20) if n % 4 != 3]
    assert finished.edge("a.", "both.left")["unmatched"] == 5
    assert balanced(finished.summary)


def test_a_stream_that_ends_early_does_not_stop_the_join(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.count, with: {count: 20}}
b:    {uses: ticks.count, with: {count: 8}}
sum:  {uses: ticks.sum, in: {numbers: [a, b]}}
save: {uses: ticks.write, in: {number: sum}}
""",
    )
    finished = run(graph, "--placement", "stage")
    assert finished.values() == [2 * n if n < 8 else n for n in range(20)]
    assert balanced(finished.summary)


def test_a_reader_slower_than_the_writer_loses_nothing(tmp_path: Path) -> None:
    for edges in ("reference", "ring", "zenoh"):
        finished = run(
            write_graph(tmp_path, CHAIN),
            *("--set", "a.count=300", "--set", "a.size=20000", "--set", "b.sleep=0.001"),
            *("--edges", edges, *(() if edges == "reference" else ("--placement", "stage"))),
            out=edges,
        )
        assert finished.code == 0, finished.errors
        assert finished.values() == list(range(1, 301))
        assert balanced(finished.summary)


def test_a_stage_that_keeps_every_frame_neither_stalls_the_ring_nor_sees_it_change(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:     {uses: ticks.count, with: {count: 60, size: 50000}}
hoard: {uses: ticks.hoard, in: {number: a}}
save:  {uses: ticks.write, in: {number: hoard}}
""",
    )
    assert run(graph, "--placement", "stage").values() == list(range(1, 61))


def test_a_live_source_that_is_too_fast_drops_its_oldest_and_counts_it(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.live, with: {count: 200, period: 0.0005}}
b:    {uses: ticks.add, in: {number: a}, with: {sleep: 0.005}}
save: {uses: ticks.write, in: {number: b}}
""",
    )
    finished = run(graph)
    edge = finished.edge("a.", "b.")
    assert finished.code == 0, finished.errors
    assert edge["produced"] == edge["sent"] == 200
    assert edge["dropped"] > 0
    assert edge["delivered"] == 200 - edge["dropped"] == len(finished.lines())
    assert finished.values() == sorted(finished.values())
    assert balanced(finished.summary)


def test_a_live_join_waits_for_its_deadline_and_no_longer(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.live, with: {count: 100, period: 0.005}}
b:    {uses: ticks.live, with: {count: 2, period: 0.4}}
sum:  {uses: ticks.sum, in: {numbers: [a, b]}, deadline: 0.05, tolerance: 0.002}
save: {uses: ticks.write, in: {number: sum}}
""",
    )
    finished = run(graph)
    assert finished.code == 0, finished.errors
    assert len(finished.lines()) >= 90, "the silent source holds nobody up"
    assert finished.edge("a.", "sum.")["delivered"] >= 90
    assert balanced(finished.summary)


def test_frames_option_ends_every_source_after_so_many(tmp_path: Path) -> None:
    finished = run(write_graph(tmp_path, CHAIN), "--frames", "5", "--placement", "stage")
    assert finished.values() == [1, 2, 3, 4, 5]
    assert finished.summary["frames"] == 5
