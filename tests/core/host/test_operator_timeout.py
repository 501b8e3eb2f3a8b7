"""A silent operator: its log lines, its timeout, and suspensions of the agent."""

from __future__ import annotations

from followspot.host.operator_timeout import OperatorTimeout

TIMEOUT = 60.0


def checked(timeout: OperatorTimeout, begin: float, end: float, period: float = 1.0) -> list[str]:
    """The lines from one check per period, s."""
    said = []
    now = begin
    while now < end:
        now += period
        if line := timeout.check(now):
            said.append(line)
    return said


def test_an_active_operator_is_not_reported() -> None:
    timeout = OperatorTimeout(TIMEOUT, 0.0)
    for now in range(0, 1000, 9):
        timeout.note_request(now)
        assert checked(timeout, now, now + 9) == []
    assert not timeout.timed_out


def test_a_silent_operator_is_reported_once_and_when_it_is_back() -> None:
    timeout = OperatorTimeout(TIMEOUT, 0.0)
    assert checked(timeout, 0, 50) == ["the operator is silent: what runs here goes on for 60 s"]
    assert timeout.silent
    timeout.note_request(50.5)
    assert checked(timeout, 50, 60) == ["the operator is back after 50 s"]
    assert not timeout.silent
    assert checked(timeout, 60, 65) == ["the operator is silent: what runs here goes on for 60 s"]


def test_it_times_out_once_and_for_all() -> None:
    timeout = OperatorTimeout(TIMEOUT, 0.0)
    checked(timeout, 0, 60)
    assert not timeout.timed_out
    assert checked(timeout, 60, 61) == ["the operator was silent for 60 s: what runs here is ended"]
    assert timeout.timed_out
    timeout.note_request(61)
    assert checked(timeout, 61, 200) == []
    assert timeout.timed_out


def test_a_detached_run_has_no_timeout() -> None:
    timeout = OperatorTimeout(None, 0.0)
    assert checked(timeout, 0, 100_000, period=1.5) == []
    assert not timeout.timed_out


def test_suspended_time_of_the_agent_does_not_count() -> None:
    """After two hours of suspension the operator still has the rest of its timeout."""
    timeout = OperatorTimeout(TIMEOUT, 0.0)
    checked(timeout, 0, 40)
    assert checked(timeout, 7200, 7220) == []
    assert not timeout.timed_out
    assert checked(timeout, 7220, 7240) == ["the operator was silent for 60 s: what runs here is ended"]


def test_a_request_after_a_pause_restarts_the_timeout() -> None:
    timeout = OperatorTimeout(TIMEOUT, 0.0)
    checked(timeout, 0, 5)
    timeout.note_request(7200.0)
    assert timeout.check(7200.1) == ""
    assert checked(timeout, 7200, 7210) == []
    assert 0.0 <= timeout.seconds(7203.0) <= 3.0
