"""Sampled inputs in cycles, in whole runs: exact if an edge has a delay, else refused in replays."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.commands import command
from tests.integration.running import STAGES, run, write_graph

CYCLE = """
count: {uses: ticks.count, with: {count: 400}}
a:     {uses: ticks.accumulate, in: {number: count, before: b}}
b:     {uses: ticks.accumulate, in: {number: count, before: {from: a, delay: 1}}}
save:  {uses: ticks.write, in: {number: a}}
"""
LIVE = """
live:  {uses: ticks.live, with: {count: 50}}
sum:   {uses: ticks.accumulate, in: {number: live, before: later}}
later: {uses: ticks.add, in: {number: sum}}
save:  {uses: ticks.write, in: {number: later}}
"""


@pytest.mark.parametrize(
    "placement",
    [
        (),
        pytest.param(("--placement", "stage"), marks=pytest.mark.thorough),
        ("--placement", "stage", "--edges", "zenoh"),
    ],
)
def test_a_sampled_input_is_exact_if_another_edge_of_its_cycle_has_a_delay(
    tmp_path: Path, placement: tuple[str, ...]
) -> None:
    finished = run(write_graph(tmp_path, CYCLE), *placement)
    assert finished.code == 0, finished.errors
    expected, a, b = [], 0, 0
    for number in range(400):
        b = number + a  # of the firing before
        a = number + b
        expected.append(a)
    assert finished.values() == expected


@pytest.mark.thorough
def test_a_live_run_warns_before_it_starts_and_can_be_repeated_but_not_replayed_unless_exact(
    tmp_path: Path,
) -> None:
    graph = write_graph(tmp_path, LIVE)
    show = tmp_path / "show.mcap"
    plugin = ("--plugin", STAGES)
    for verb in ("check", "graph"):
        said = command(verb, graph, *plugin)
        assert said.returncode == 0
        assert "note: " in said.stdout
        assert "in the cycle later -> sum -> later" in said.stdout
    ran = command("run", graph, *plugin, "--record", show, "--out", tmp_path / "out")
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr.startswith(f"note: {graph}:4:"), "before anything else"

    refused = command("replay", show, *plugin)
    assert refused.returncode == 2, refused.stdout + refused.stderr
    assert "in the cycle later -> sum -> later" in refused.stderr
    assert "{from: later.out, delay: 1}" in refused.stderr
    repeated = command("verify", show, *plugin)
    assert repeated.returncode == 0, "the recording says what each firing took"
    played = command("replay", show, *plugin, "--ports", "later.out", "--out", tmp_path / "played")
    assert played.returncode == 0, played.stderr
    delayed = write_graph(
        tmp_path, LIVE.replace("before: later", "before: {from: later, delay: 1}"), "delayed"
    )
    again = command("replay", show, *plugin, "--graph", delayed, "--out", tmp_path / "again")
    assert again.returncode == 0, again.stderr
    same = command("replay", show, *plugin, "--graph", graph, "--out", tmp_path / "same")
    assert same.returncode == 2, "a graph file that samples is refused as well"
