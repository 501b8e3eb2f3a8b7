"""An operator that falls silent: what is said of it, when it is given up, and pauses of the listener."""

from __future__ import annotations

from followspot.host.operator_timeout import Absence

TIMEOUT = 60.0


def looked(absence: Absence, begin: float, end: float, period: float = 1.0) -> list[str]:
    """What is said from one look a period."""
    said = []
    now = begin
    while now < end:
        now += period
        if line := absence.look(now):
            said.append(line)
    return said


def test_an_operator_that_asks_is_never_spoken_of() -> None:
    absence = Absence(TIMEOUT, 0.0)
    for now in range(0, 1000, 9):
        absence.heard(now)
        assert looked(absence, now, now + 9) == []
    assert not absence.discarded


def test_a_silent_operator_is_spoken_of_once_and_again_when_it_is_back() -> None:
    absence = Absence(TIMEOUT, 0.0)
    assert looked(absence, 0, 50) == ["the operator is silent: what runs here goes on for 60 s"]
    assert absence.silent
    absence.heard(50.5)
    assert looked(absence, 50, 60) == ["the operator is back after 50 s"]
    assert not absence.silent
    assert looked(absence, 60, 65) == ["the operator is silent: what runs here goes on for 60 s"]


def test_it_is_given_up_after_the_timeout_and_for_good() -> None:
    absence = Absence(TIMEOUT, 0.0)
    looked(absence, 0, 60)
    assert not absence.discarded
    assert looked(absence, 60, 61) == ["the operator was silent for 60 s: what runs here is ended"]
    assert absence.discarded
    absence.heard(61)
    assert looked(absence, 61, 200) == []
    assert absence.discarded


def test_a_run_that_goes_on_alone_waits_for_nobody() -> None:
    absence = Absence(None, 0.0)
    assert looked(absence, 0, 100_000, period=1.5) == []
    assert not absence.discarded


def test_who_slept_has_missed_nobody() -> None:
    """An agent that was stopped for two hours gives its operator the time that is left."""
    absence = Absence(TIMEOUT, 0.0)
    looked(absence, 0, 40)
    assert looked(absence, 7200, 7220) == []
    assert not absence.discarded
    assert looked(absence, 7220, 7240) == ["the operator was silent for 60 s: what runs here is ended"]


def test_a_request_that_was_heard_after_a_pause_counts_from_then() -> None:
    absence = Absence(TIMEOUT, 0.0)
    looked(absence, 0, 5)
    absence.heard(7200.0)
    assert absence.look(7200.1) == ""
    assert looked(absence, 7200, 7210) == []
    assert 0.0 <= absence.seconds(7203.0) <= 3.0
