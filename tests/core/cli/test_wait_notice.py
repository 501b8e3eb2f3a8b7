"""What a command says while it waits for a run."""

from __future__ import annotations

import signal
from argparse import Namespace
from contextlib import nullcontext
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from followspot.cli import wait_notice
from followspot.cli.ending_signals import ending_as_on_ctrl_c
from followspot.cli.wait_notice import pending_of, wait_notices
from followspot.control.dispatch import NoAnswer, Request
from followspot.control.host import HostLost, HostStatus, RunOrder, WorkerStatus
from followspot.control.swap import ChangeOrder
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.log.run_log import RunLog
from followspot.operator.coordinator import Coordinator
from followspot.operator.run_dispatcher import run_dispatcher
from followspot.operator.run_handle import RunHandle
from followspot.operator.run_requests import RunMetadata

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


class Silent:
    """A host that does not answer; meanwhile it asks the run what it waits for."""

    name = "pc-left"

    def __init__(self) -> None:
        self.log = RunLog()
        self.handle: RunHandle
        self.heard: list[str] = []

    def ask(self, order: ChangeOrder) -> None:
        self.heard.append(pending_of(self.handle))
        raise HostLost("host pc-left does not answer")

    def status(self) -> HostStatus:
        return HostStatus((WorkerStatus("main", "running"),), (), age_s=6.0)


def test_a_change_that_waits_says_for_which_host_and_since_when_it_is_silent(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text("graph: g\nstages:\n  a: {uses: ticks.live}\n")
    (tmp_path / "p.yaml").write_text("placement: p\nworkers:\n  main: {host: pc-left, stages: [a]}\n")
    plan = compile_graph(tmp_path / "g.yaml", placement=tmp_path / "p.yaml", plugin_files=[TICKS])
    host = Silent()
    run = Coordinator(plan, [host], RunOrder("feedc0de", {}), begun=True)  # type: ignore[list-item]
    dispatcher = run_dispatcher(run, RunMetadata())
    host.handle = RunHandle("feedc0de", "g", lambda request, timeout: dispatcher.dispatch(request))
    with pytest.raises(FollowspotError, match="does not answer"):
        host.handle.change(["a.period=0.5"])
    assert host.heard[0] == (
        "host pc-left to build the new stages; host pc-left is absent: last heard 6 s ago"
    )
    assert run.status().change_awaits == ""


def test_a_run_whose_process_is_suspended_is_said_to_be(capsys: pytest.CaptureFixture[str]) -> None:
    def ask(request: Request, timeout: float) -> Any:
        raise NoAnswer("the run feedc0de does not answer: its process 7 is suspended")

    assert pending_of(RunHandle("feedc0de", "g", ask)) == (
        "an answer: the run feedc0de does not answer: its process 7 is suspended"
    )


def test_what_lasts_is_told_again_on_standard_error_alone(capsys: pytest.CaptureFixture[str]) -> None:
    asked: list[int] = []
    twice = Event()

    def what() -> str:
        asked.append(len(asked))
        if len(asked) == 3:
            twice.set()
        return f"host pc-{len(asked)}"

    with wait_notices(what, first=0.01, following=0.01):
        assert twice.wait(60.0)
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.splitlines()[:2] == [
        "followspot: waiting for host pc-1 (0 s so far)",
        "followspot: waiting for host pc-2 (0 s so far)",
    ]


def test_what_is_done_soon_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with wait_notices(lambda: "nobody", first=3600.0):
        pass
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("pid", "goes_on"), [(7, True), (None, False)], ids=["its own", "under agents"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_command_that_gives_up_a_change_says_whether_the_run_makes_it_all_the_same(
    number: signal.Signals,
    pid: int | None,
    goes_on: bool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A run under agents alone does not: the command leads the change, and undoes it."""
    run = RunHandle("feedc0de", "g", lambda request, timeout: None, pid)
    monkeypatch.setattr(wait_notice, "connected_run", lambda *_: nullcontext(run))
    monkeypatch.setattr(wait_notice, "network_of", lambda _: None)
    usual = {
        signal.SIGINT: signal.default_int_handler,
        signal.SIGTERM: signal.SIG_DFL,
        signal.SIGHUP: signal.SIG_DFL,
    }  # the tests may have been started below nohup, or in the background
    before = {each: signal.signal(each, handler) for each, handler in usual.items()}
    try:
        with (
            pytest.raises(KeyboardInterrupt),
            ending_as_on_ctrl_c(),
            wait_notice.run_with_notices(Namespace(run=None)),
        ):
            signal.raise_signal(number)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)
    line = "g (feedc0de) still does what it was asked to"
    assert (line in capsys.readouterr().err) == goes_on
