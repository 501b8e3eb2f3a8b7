"""Detached runs under agents: operators that come and go, and lists of runs."""

from __future__ import annotations

import json
import signal
import subprocess
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from tests.commands import Started, command, launch
from tests.integration.hosts import free_port, near_agent
from tests.integration.live_sum import grows, of_left
from tests.integration.running import (
    STAGES,
    balanced,
    wait_until,
    workers,
)
from tests.integration.two_agents import TwoAgents
from tests.tools.page.bundled import UNREACHED, made

import followspot as fs
from followspot.control.zenoh_rpc import agents
from followspot.operator.discovery import operator_session
from followspot.transport.keys import agent_key
from followspot.transport.zenoh.network import Network


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


def test_a_detached_run_outlives_its_operators(hosts: TwoAgents) -> None:
    process = hosts.begin("--detach", "--host", "pc-right")
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    run = json.loads(stdout)["run"]
    assert wait_until(lambda: bool(list(hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    grows(written)
    watched_from_elsewhere(run, hosts.connect)
    page = page_of(run, hosts.connect)
    looking = launch("attach", *hosts.connect)
    assert run[:8] in looking.stderr.readline()
    looking.kill()
    looking.communicate()
    grows(written)
    (worker,) = workers(hosts.agents["pc-left"].process.pid)
    subprocess.run(["kill", "-9", str(worker)], check=True)
    grows(written, lambda value: not of_left(value))
    grows(written, of_left, 5)
    hosts.agents["pc-left"].process.kill()
    hosts.agents["pc-left"].process.communicate()
    grows(written, lambda value: not of_left(value), 50)
    seen = command("top", "--run", run, "--json", *hosts.connect)
    assert seen.returncode == 0, seen.stderr
    assert json.loads(seen.stdout)["faults"] == ["host pc-left is absent: nothing is heard of the run there"]
    assert {s["stage"] for s in json.loads(seen.stdout)["stages"] if s["state"] == "absent"} == {"a", "more"}
    hosts.agent("pc-left")  # it resumes its part by itself
    grows(written, of_left, 5)
    done = command("attach", "--run", "graph", "--stop", "--json", *hosts.connect)
    assert done.returncode == 0, done.stderr + done.stdout
    if page is not None:
        page.communicate(timeout=60)
        assert page.returncode == 0, "the page ends with its run"
    summary: dict[str, Any] = json.loads(done.stdout)
    assert balanced(summary)
    assert any("worker left is back" in line for line in summary["warnings"])
    assert "pc-left: the agent was restarted: its workers start again" in summary["warnings"]
    kept = command("logs", "--run", *hosts.folder.glob(f"pc-left/runs/*-{run}-pc-left"))
    assert "killed by SIGKILL" in kept.stdout, kept.stderr
    assert "worker left is back" in kept.stdout
    gone = command("attach", "--run", "graph", *hosts.connect)
    assert gone.returncode == 1
    assert "there is no run graph" in gone.stderr


def test_an_agent_that_is_ended_takes_its_part_of_a_detached_run_up_again(hosts: TwoAgents) -> None:
    stdout, _ = hosts.begin("--detach", "--host", "pc-right").communicate(timeout=60)
    run = json.loads(stdout)["run"]
    assert wait_until(lambda: bool(list(hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    (home,) = hosts.folder.glob(f"pc-left/runs/*-{run}-pc-left")
    grows(written, of_left, 5)
    assert wait_until((home / ".order").exists)
    left = hosts.agents["pc-left"].process
    left.send_signal(signal.SIGTERM)
    left.communicate(timeout=60)
    grows(written, lambda value: not of_left(value))
    hosts.agent("pc-left")
    grows(written, of_left, 5)
    done = command("attach", "--run", "graph", "--stop", "--json", *hosts.connect)
    assert done.returncode == 0, done.stderr + done.stdout
    assert not (home / ".order").exists()


def test_an_operator_that_sleeps_while_another_one_ends_the_run_says_so(hosts: TwoAgents) -> None:
    process = hosts.begin("--detach", "--host", "pc-right")
    process.communicate(timeout=60)
    assert process.returncode == 0
    asleep = launch("attach", "--json", *hosts.connect)
    assert "of graph on" in asleep.stderr.readline()
    asleep.send_signal(signal.SIGSTOP)
    done = command("attach", "--stop", "--json", *hosts.connect)
    assert done.returncode == 0, done.stderr
    asleep.send_signal(signal.SIGCONT)
    said, _ = asleep.communicate(timeout=90)
    assert asleep.returncode == 1
    why = "no longer has the run: another operator ended it, or the agent was restarted"
    assert json.loads(said)["errors"] == [
        f"worker {name} was not there at the end: host {host} {why}"
        for name, host in (("left", "pc-left"), ("right", "pc-right"), ("main", "pc-right"))
    ]


def test_the_summary_of_an_attached_run_counts_its_seconds_from_the_beginning(hosts: TwoAgents) -> None:
    process = hosts.begin("--detach", "--host", "pc-right")
    run = json.loads(process.communicate(timeout=60)[0])["run"]
    assert wait_until(lambda: bool(list(hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv"))))
    (written,) = hosts.folder.glob(f"pc-right/runs/*-{run}-pc-right/ticks.csv")
    grows(written, more=100)
    summary = json.loads(command("attach", "--stop", "--json", *hosts.connect).stdout)
    period = 0.02
    assert summary["frames"] * period < summary["seconds"], "no device gives more frames in a second"


def test_a_script_holds_and_ends_a_run_under_agents(hosts: TwoAgents) -> None:
    process = hosts.begin("--detach", "--host", "pc-right")
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    network = fs.Network(connect=tuple(word for word in hosts.connect if word != "--connect"))
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


def test_an_agent_that_does_not_answer_hides_no_runs_of_other_agents(hosts: TwoAgents) -> None:
    run = json.loads(hosts.begin("--detach", "--host", "pc-right").communicate(timeout=60)[0])["run"]
    with operator_session(Network(connect=tuple(hosts.endpoints.values()))) as session:
        token = session.liveliness().declare_token(agent_key("pc-aside"))
        assert wait_until(lambda: len(agents(session)) == 3)
        listed = command("runs", "--json", *hosts.connect)
        stopped = command("attach", "--stop", "--json", *hosts.connect)
        token.undeclare()
    assert run in [found["run"] for found in json.loads(listed.stdout)], listed.stderr
    assert stopped.returncode == 0, stopped.stderr


def test_a_search_for_runs_tells_endpoints_without_an_agent(tmp_path: Path) -> None:
    unreached = f"tcp/127.0.0.1:{free_port()}"
    agent = near_agent("pc-left", tmp_path)
    missed = command("attach", "--connect", unreached)
    listed = command("runs", "--connect", agent.endpoint, "--connect", unreached)
    assert agent.end() == 0
    why = f"{unreached} ({unreached}: nothing listens there)"
    assert f"there is no run; runs in reach, though no agent is heard at {why}: none" in missed.stderr
    assert f"warning: only 1 agent is heard at {agent.endpoint}, {why}: the list" in listed.stderr
    assert "warning" not in command("runs").stderr
