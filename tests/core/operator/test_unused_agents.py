"""A run that is led to agents of other hosts, and whose plan uses none of them, says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.library.scripts import TICKS

import followspot as fs
from followspot.cli.main import main
from followspot.graph.compile import compile_graph
from followspot.operator.launch import unused_agents
from followspot.transport.zenoh.network import Network

GRAPH = """
graph: counted
stages:
  a: {uses: ticks.count, with: {count: 3}}
  save: {uses: ticks.write, in: {number: a}}
"""
AGENT = "tcp/127.0.0.1:7999"
TOLD = f"no worker is on another host, so agents at {AGENT} have nothing to do: "


@pytest.fixture
def graph(tmp_path: Path) -> Path:
    path = tmp_path / "graph.yaml"
    path.write_text(GRAPH)
    return path


@pytest.mark.parametrize("named", [False, True])
def test_a_command_says_it_of_agents_that_it_names(
    graph: Path, capsys: pytest.CaptureFixture[str], named: bool
) -> None:
    network = ["--connect", AGENT] if named else []
    assert (
        main(["run", str(graph), "--plugin", str(TICKS), "--out", str(graph.parent / "out"), *network]) == 0
    )
    assert (f"note: {TOLD}name hosts in a file for --placement" in capsys.readouterr().err) == named


def test_a_script_is_warned(graph: Path, recwarn: pytest.WarningsRecorder) -> None:
    with fs.run(graph, plugin_files=[TICKS], out=graph.parent / "out", network=Network(connect=(AGENT,))):
        pass
    (told,) = [str(warning.message) for warning in recwarn]
    assert told.startswith(f"{TOLD}name hosts in a file for placement=")


def test_an_endpoint_that_is_none_is_refused_although_no_agent_is_needed(
    graph: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = graph.parent / "out"
    wrong = ["--connect", "ws/192.168.0.7:7450"]
    assert main(["run", str(graph), "--plugin", str(TICKS), "--out", str(out), *wrong]) == 1
    told = "followspot: 'ws/192.168.0.7:7450' is no endpoint; write PROTOCOL/HOST:PORT with tcp or tls"
    assert capsys.readouterr().err.startswith(told)
    assert not (out / "ticks.csv").exists()
    network = Network(connect=("ws/192.168.0.7:7450",))
    run = fs.run(graph, plugin_files=[TICKS], out=out, network=network)
    with pytest.raises(fs.FollowspotError, match="is no endpoint"), run:
        pass


def test_nothing_is_said_of_agents_that_a_worker_needs(graph: Path) -> None:
    placement = graph.with_name("placement.yaml")
    placement.write_text("placement: p\nworkers: {left: {host: pc-left, stages: [a]}}\n")
    plan = compile_graph(graph, placement=placement, plugin_files=[str(TICKS)])
    assert unused_agents(plan, [AGENT]) == ()
