"""Agents: detached runs, restarts of agents, runs that a dead operator left, and refusals."""

from __future__ import annotations

import json
import re
import resource
import signal
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Timer
from typing import Any
from urllib.request import urlopen

import pytest
import zenoh
from tests.commands import Started, command, launch
from tests.integration.hosts import Agent, free_port, near_agent
from tests.integration.live_sum import LIVE, grows, of_left
from tests.integration.running import (
    STAGES,
    Finished,
    alive,
    balanced,
    finish,
    start,
    wait_until,
    workers,
    write_graph,
)
from tests.tools.page.bundled import UNREACHED, made

import followspot as fs
from followspot.control.zenoh_rpc import agents
from followspot.operator.connect import run_here
from followspot.operator.discovery import await_named, operator_session
from followspot.transport.keys import agent_key
from followspot.transport.zenoh.network import Network

PLACEMENT = """
placement: hosts
workers:
  left:  {host: pc-left, stages: [a, more]}
  right: {host: pc-right, stages: [b, less]}
"""
HOSTS = ("pc-left", "pc-right")


class Room:
    """Two agents on this host, and a live graph with one source on each."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.graph = write_graph(folder, LIVE)
        (folder / "hosts.yaml").write_text(PLACEMENT)
        self.agents: dict[str, Agent] = {}
        self.endpoints = {name: f"tcp/127.0.0.1:{free_port()}" for name in HOSTS}
        self.connect = [word for endpoint in self.endpoints.values() for word in ("--connect", endpoint)]

    def agent(self, name: str) -> Agent:
        home = self.folder / name
        home.mkdir(exist_ok=True)
        others = [word for other in HOSTS if other != name for word in ("--connect", self.endpoints[other])]
        self.agents[name] = near_agent(name, home, *others, at=self.endpoints[name])
        return self.agents[name]

    def begin(self, *options: str) -> Started:
        placement = ("--placement", str(self.folder / "hosts.yaml"))
        return start(self.graph, self.folder / "out", *placement, *self.connect, *options)

    def close(self) -> None:
        for agent in self.agents.values():
            agent.process.kill()
            agent.process.communicate()


@pytest.fixture
def room(tmp_path: Path) -> Iterator[Room]:
    made = Room(tmp_path)
    made.agent("pc-left")
    made.agent("pc-right")
    yield made
    made.close()


def ended(process: Started, out: Path) -> Finished:
    process.send_signal(signal.SIGINT)
    return finish(process, out)


@pytest.mark.thorough
def test_a_restarted_agent_resumes_its_runs(room: Room) -> None:
    process = room.begin()
    out = room.folder / "out"
    grows(out / "ticks.csv", of_left, 5)
    room.agents["pc-left"].process.kill()
    room.agents["pc-left"].process.communicate()
    grows(out / "ticks.csv", lambda value: not of_left(value), 50)
    room.agent("pc-left")
    grows(out / "ticks.csv", of_left, 5)
    finished = ended(process, out)
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    assert any("the agent was restarted" in line for line in finished.summary["warnings"])
    assert balanced(finished.summary), finished.summary["edges"]


def test_a_script_holds_and_ends_a_run_under_agents(room: Room) -> None:
    process = room.begin("--detach", "--host", "pc-right")
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    network = fs.Network(connect=tuple(word for word in room.connect if word != "--connect"))
    with fs.connect(json.loads(stdout)["run"], network=network, plugin_files=[STAGES]) as run:
        assert {worker.phase for worker in run.status().workers} == {"running"}
        heard = set()
        for message in run["more,less"]:  # one of each host
            heard.add(of_left(message.value))
            if len(heard) == 2:
                break
        messages = iter(run["sum"])
        before = next(messages)
        run.stop()
        assert all(message.header.time >= before.header.time for message in messages)
        assert run.over()


def page_of(run: str, connect: list[str]) -> Started | None:
    """The page of a run under agents, once it shows the work of both; None if npm cannot be reached."""
    code, said = made()
    if code == UNREACHED:
        return None
    assert code == 0, said
    page = launch("dashboard", "--run", run, "--dashboard-at", "127.0.0.1:0", "--plugin", STAGES, *connect)
    url = page.stderr.readline().split()[-1]
    assert wait_until(lambda: shown_hosts(url) == {"pc-left", "pc-right"})
    return page


def shown_hosts(url: str) -> set[str]:
    """The hosts of the stages that have fired, as the page of a run tells."""
    with suppress(OSError), urlopen(f"{url}status", timeout=20) as answer:
        return {stage["host"] for stage in json.load(answer)["stages"] if stage["fired"]}
    return set()


def test_a_detached_run_outlives_its_operators(room: Room) -> None:
    process = room.begin("--detach", "--host", "pc-right")
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    run = json.loads(stdout)["run"]
    assert wait_until(lambda: bool(list(room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    grows(written)
    watched_from_elsewhere(run, room.connect)
    page = page_of(run, room.connect)
    looking = launch("attach", *room.connect)
    assert run[:8] in looking.stderr.readline()
    looking.kill()
    looking.communicate()
    grows(written)
    (worker,) = workers(room.agents["pc-left"].process.pid)
    subprocess.run(["kill", "-9", str(worker)], check=True)
    grows(written, lambda value: not of_left(value))
    grows(written, of_left, 5)
    room.agents["pc-left"].process.kill()
    room.agents["pc-left"].process.communicate()
    grows(written, lambda value: not of_left(value), 50)
    seen = command("top", "--run", run, "--json", *room.connect)
    assert seen.returncode == 0, seen.stderr
    assert json.loads(seen.stdout)["faults"] == ["host pc-left is absent: nothing is heard of the run there"]
    assert {s["stage"] for s in json.loads(seen.stdout)["stages"] if s["state"] == "absent"} == {"a", "more"}
    room.agent("pc-left")  # it takes up by itself what it was at
    grows(written, of_left, 5)
    done = command("attach", "--run", "graph", "--stop", "--json", *room.connect)
    assert done.returncode == 0, done.stderr + done.stdout
    if page is not None:
        page.communicate(timeout=60)
        assert page.returncode == 0, "the page ends with its run"
    summary: dict[str, Any] = json.loads(done.stdout)
    assert balanced(summary)
    assert any("worker left is back" in line for line in summary["warnings"])
    assert "pc-left: the agent was restarted: its workers start again" in summary["warnings"]
    kept = command("logs", "--run", *room.folder.glob(f"pc-left/runs/*-{run}-pc-left"))
    assert "killed by SIGKILL" in kept.stdout, kept.stderr
    assert "worker left is back" in kept.stdout
    gone = command("attach", "--run", "graph", *room.connect)
    assert gone.returncode == 1
    assert "there is no run graph" in gone.stderr


def test_an_agent_that_is_ended_takes_its_part_of_a_detached_run_up_again(room: Room) -> None:
    stdout, _ = room.begin("--detach", "--host", "pc-right").communicate(timeout=60)
    run = json.loads(stdout)["run"]
    assert wait_until(lambda: bool(list(room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    (home,) = room.folder.glob(f"pc-left/runs/*-{run}-pc-left")
    grows(written, of_left, 5)
    assert wait_until((home / ".order").exists)
    left = room.agents["pc-left"].process
    left.send_signal(signal.SIGTERM)
    left.communicate(timeout=60)
    grows(written, lambda value: not of_left(value))
    room.agent("pc-left")
    grows(written, of_left, 5)
    done = command("attach", "--run", "graph", "--stop", "--json", *room.connect)
    assert done.returncode == 0, done.stderr + done.stdout
    assert not (home / ".order").exists()


def test_an_operator_that_sleeps_while_another_one_ends_the_run_says_so(room: Room) -> None:
    process = room.begin("--detach", "--host", "pc-right")
    process.communicate(timeout=60)
    assert process.returncode == 0
    asleep = launch("attach", "--json", *room.connect)
    assert "of graph on" in asleep.stderr.readline()
    asleep.send_signal(signal.SIGSTOP)
    done = command("attach", "--stop", "--json", *room.connect)
    assert done.returncode == 0, done.stderr
    asleep.send_signal(signal.SIGCONT)
    said, _ = asleep.communicate(timeout=90)
    assert asleep.returncode == 1
    why = "no longer has the run: another operator ended it, or the agent was restarted"
    assert json.loads(said)["errors"] == [
        f"worker {name} was not there at the end: host {host} {why}"
        for name, host in (("left", "pc-left"), ("right", "pc-right"), ("main", "pc-right"))
    ]


def test_the_summary_of_an_attached_run_counts_its_seconds_from_the_beginning(room: Room) -> None:
    process = room.begin("--detach", "--host", "pc-right")
    run = json.loads(process.communicate(timeout=60)[0])["run"]
    assert wait_until(lambda: bool(list(room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = room.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    grows(written, more=100)
    summary = json.loads(command("attach", "--stop", "--json", *room.connect).stdout)
    period = 0.02
    assert summary["frames"] * period < summary["seconds"], "no device gives more frames in a second"


def test_an_agent_that_does_not_answer_hides_no_runs_of_other_agents(room: Room) -> None:
    run = json.loads(room.begin("--detach", "--host", "pc-right").communicate(timeout=60)[0])["run"]
    with operator_session(Network(connect=tuple(room.endpoints.values()))) as session:
        token = session.liveliness().declare_token(agent_key("pc-aside"))
        assert wait_until(lambda: len(agents(session)) == 3)
        listed = command("runs", "--json", *room.connect)
        stopped = command("attach", "--stop", "--json", *room.connect)
        token.undeclare()
    assert run in [found["run"] for found in json.loads(listed.stdout)], listed.stderr
    assert stopped.returncode == 0, stopped.stderr


def test_a_search_for_runs_tells_endpoints_without_an_agent(tmp_path: Path) -> None:
    nobody = f"tcp/127.0.0.1:{free_port()}"
    agent = near_agent("pc-left", tmp_path)
    missed = command("attach", "--connect", nobody)
    listed = command("runs", "--connect", agent.endpoint, "--connect", nobody)
    assert agent.end() == 0
    assert f"there is no run; runs in reach, though no agent is heard at {nobody}: none" in missed.stderr
    assert f"warning: only 1 agent is heard at {agent.endpoint}, {nobody}: the list" in listed.stderr
    assert "warning" not in command("runs").stderr


def readers_of(session: zenoh.Session, port: str) -> list[str]:
    """The tokens of the readers of a port, as far as a session has heard of them."""
    heard = (str(reply.ok.key_expr) for reply in session.liveliness().get("followspot/**") if reply.ok)
    return [token for token in heard if f"/{port}/.reader/" in token]


def test_a_run_says_which_edge_stalls_because_another_peer_speaks_for_its_reader(room: Room) -> None:
    process = room.begin()
    out = room.folder / "out"
    grows(out / "ticks.csv")
    run = run_here(str(process.pid))
    begins = "more.out -> sum.numbers stalls: more has had no room to send for "
    with operator_session(Network(connect=tuple(room.endpoints.values()))) as session:
        assert wait_until(lambda: readers_of(session, f"{run.run}/pc-left/more/out")), (
            "nobody knows its reader"
        )
        (reader,) = readers_of(session, f"{run.run}/pc-left/more/out")
        forged = session.liveliness().declare_token(f"{reader.rpartition('/')[0]}/7")
        assert wait_until(lambda: any(line.startswith(begins) for line in run.status().faults()))
        forged.undeclare()
    assert wait_until(lambda: "more.out -> sum.numbers moves again" in run.status().news)
    finished = ended(process, out)
    assert f"warning: {begins}" in finished.errors


def killed(room: Room) -> Started:
    """A run whose operator was killed; both agents keep it running."""
    process = room.begin()
    grows(room.folder / "out" / "ticks.csv", of_left, 5)
    process.kill()
    process.communicate()
    return process


def test_the_next_run_ends_what_a_dead_operator_left_on_hosts(room: Room) -> None:
    killed(room)
    (left,) = workers(room.agents["pc-left"].process.pid)
    assert alive(left), "it might be a cable that is out"
    process = room.begin()
    assert wait_until(lambda: not alive(left), 60.0)
    grows(room.folder / "out" / "ticks.csv", of_left, 5)
    finished = ended(process, room.folder / "out")
    assert finished.code == 0, finished.errors + json.dumps(finished.summary)
    said = "was left there by a process of this machine that has died; it was ended"
    for name in HOSTS:
        assert any(line.startswith(name) and line.endswith(said) for line in finished.summary["warnings"])


def test_a_run_of_n_frames_says_that_it_waits_for_a_lost_host_alone(room: Room) -> None:
    process = room.begin("--frames", "150")
    grows(room.folder / "out" / "ticks.csv")
    room.agents["pc-left"].process.kill()
    room.agents["pc-left"].process.communicate()
    waits = "the run waits for host pc-left alone: start the agent or mend the link there, or stop the run"
    run = run_here(str(process.pid))
    assert wait_until(lambda: waits in run.status().news)
    finished = ended(process, room.folder / "out")
    assert finished.code == 1
    assert f"warning: {waits}" in finished.errors
    assert finished.summary["errors"] == [
        "worker left was not there at the end: host pc-left does not answer"
    ]


@pytest.mark.thorough
def test_attach_ends_what_a_dead_operator_left_on_hosts(room: Room) -> None:
    killed(room)
    done = command("attach", "--run", "graph", "--stop", "--json", *room.connect)
    assert json.loads(done.stdout)["edges"], done.stderr
    assert wait_until(lambda: not any(workers(agent.process.pid) for agent in room.agents.values()), 60.0)


def watched_from_elsewhere(run: str, connect: list[str]) -> None:
    """Any host can watch a run without an operator."""
    where = ("--run", run, "--json", "--plugin", STAGES, *connect)
    done = [
        command("top", "--run", run, "--json", *connect),
        command("hz", "more", "--seconds", "1", *where),
        command("echo", "less", "-n", "1", *where),
    ]
    assert not any(process.returncode for process in done), done
    top, (pace,), message = (json.loads(process.stdout) for process in done)
    assert {stage["worker"] for stage in top["stages"]} >= {"left", "right"}
    assert pace["count"] > 0
    assert pace["rate"] > 0
    assert not of_left(message["value"])


def test_an_operator_waits_for_an_agent_that_is_slow_to_connect(tmp_path: Path) -> None:
    agent = near_agent("pc-left", tmp_path)
    agent.signal(signal.SIGSTOP)
    busy = Timer(1.0, agent.signal, [signal.SIGCONT])
    busy.start()
    network = Network(connect=(agent.endpoint,))
    try:
        with operator_session(network) as session:
            await_named(session, network)
            assert agents(session) == {"pc-left"}
    finally:
        busy.join()
        assert agent.end() == 0


def test_a_host_without_an_agent_is_named_with_the_command_to_start_it(tmp_path: Path) -> None:
    room = Room(tmp_path)
    finished = finish(room.begin(), tmp_path / "out")
    assert finished.code == 2
    assert 'there is no agent for host "pc-left"' in finished.errors
    assert "followspot agent --name pc-right" in finished.errors


def test_a_host_whose_disk_is_full_says_where_the_outputs_were_to_go(room: Room) -> None:
    process = room.agents["pc-right"].process
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))
    finished = finish(room.begin(), room.folder / "out")
    assert finished.code == 1
    folder = re.escape(str(room.folder / "pc-right" / "runs"))
    why = rf"pc-right: the run cannot begin: File too large \(outputs go to {folder}/\S+-pc-right\)\n.*ulimit"
    assert re.search(why, finished.errors), finished.errors


def test_an_agent_beyond_loopback_needs_consent_and_says_what_it_means(tmp_path: Path) -> None:
    refused = command("agent", "--name", "pc-left", "--listen", "tcp/0.0.0.0:0")
    assert refused.returncode == 1
    assert "open to other hosts without protection" in refused.stderr
    agent = Agent(launch("agent", "--name", "pc-left", "--listen", "tcp/0.0.0.0:0", "--insecure"), tmp_path)
    assert "warning: --insecure" in agent.lines[0]
    assert agent.end() == 0


TIMES = """
from followspot import Stage
from followspot_file_ticks import Tick, tick


class Times(Stage):
    '''Multiples of numbers.'''

    def process(self, number: Tick) -> Tick:
        return tick({factor} * number.value)
"""
MULTIPLES = """
count: {uses: ticks.count}
times: {uses: times.times, in: {number: count}}
save:  {uses: ticks.write, in: {number: times}}
"""


def test_a_host_whose_code_of_a_plugin_file_is_another_is_named(tmp_path: Path) -> None:
    home, out = tmp_path / "pc-left", tmp_path / "out"
    home.mkdir()
    for folder, factor in ((tmp_path, 2), (home, 3)):
        (folder / "times.py").write_text(TIMES.format(factor=factor))
    (tmp_path / "hosts.yaml").write_text(
        "placement: hosts\nworkers: {left: {host: pc-left, stages: [times]}}\n"
    )
    agent = near_agent("pc-left", home, "--plugin", home / "times.py")
    hosts = ("--placement", str(tmp_path / "hosts.yaml"), "--connect", agent.endpoint)
    try:
        graph = write_graph(tmp_path, MULTIPLES)
        done = finish(start(graph, out, "--plugin", str(tmp_path / "times.py"), *hosts), out)
        assert done.code == 0, done.errors
        assert done.values() == [3 * number for number in range(10)]
        told = "pc-left: its code of times.py is not the operator's, so results may differ"
        assert any(warning.startswith(told) for warning in done.summary["warnings"])
    finally:
        agent.process.kill()
        agent.process.communicate()
