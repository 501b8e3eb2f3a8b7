"""Saved orders of detached runs: which of them a restarted agent resumes."""

from __future__ import annotations

import os
import time
from pathlib import Path

from followspot.control.host import RunOrder
from followspot.control.lifecycle import PrepareRun
from followspot.host.agent_run import AgentRun
from followspot.host.agent_runs import AgentRuns
from followspot.host.kept_runs import KeptRuns
from followspot.host.local_host import LocalHost


def leave(runs: Path, run: str, host: str, *, text: str = "", age: float = 0.0) -> None:
    folder = runs / f"20261121-190000-{run}-{host}"
    folder.mkdir(parents=True)
    path = folder / ".order"
    path.write_text(text or PrepareRun(order=RunOrder(run, {}, detached=True)).model_dump_json())
    os.utime(path, (time.time() - age,) * 2)


def test_only_recent_complete_orders_of_this_host_are_resumed(tmp_path: Path) -> None:
    leave(tmp_path, "aaaaaaaa", "left")
    leave(tmp_path, "bbbbbbbb", "pc-left")
    leave(tmp_path, "cccccccc", "left", age=3600.0)
    leave(tmp_path, "dddddddd", "left", text='{"order": {"run": "dddd')
    leave(tmp_path, "eeeeeeee", "left", text='{"order": {"run": "eeeeeeee"}}')
    assert [order.run for order in KeptRuns(tmp_path, "left").left()] == ["aaaaaaaa"]
    assert list(KeptRuns(tmp_path / "none", "left").left()) == []


def test_a_resumed_run_goes_on_since_it_began(tmp_path: Path) -> None:
    order = PrepareRun(order=RunOrder("aaaaaaaa", {}, detached=True, age_s=1000.0))
    leave(tmp_path, "aaaaaaaa", "left", text=order.model_dump_json(), age=500.0)
    (left,) = KeptRuns(tmp_path, "left").left()
    assert 1500.0 <= left.age_s < 2000.0, "under the earlier agent, and without one"
    run = AgentRun("show", left, LocalHost("left"))
    assert left.age_s <= run.resume_order().age_s < 2000.0


def test_a_closed_run_is_not_resumed(tmp_path: Path) -> None:
    said: list[str] = []
    agent_runs = AgentRuns(tmp_path, "left", said.append)
    for run in ("aaaaaaaa", "bbbbbbbb"):
        leave(tmp_path, run, "left")
        agent_run = AgentRun("show", RunOrder(run, {}, detached=True), LocalHost("left"))
        agent_run.run.out = str(tmp_path / f"20261121-190000-{run}-left")
        agent_runs.add(agent_run)
    agent_runs.close("aaaaaaaa")
    assert [order.run for order in agent_runs.kept.left()] == ["bbbbbbbb"]
    assert said == ["run aaaaaaaa of show: over"]
    assert (agent_runs.known("aaaaaaaa"), agent_runs.known("bbbbbbbb")) == ("unknown", "here")
    agent_runs.forget()
    assert list(agent_runs.kept.left()) == []
