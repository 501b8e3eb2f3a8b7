"""Notes of workers that died: the line of each, and each traceback once."""

from __future__ import annotations

from followspot.host.restart_notes import RestartNotes

ERROR = "stage half failed at src#3: ZeroDivisionError: by zero"
TRACEBACK = 'Traceback (most recent call last):\n  File "half.py", line 8, in process'


def test_the_restart_stands_in_the_line_of_the_error_above_its_traceback() -> None:
    note = RestartNotes().of("left", f"{ERROR}\n{TRACEBACK}", 0.2)
    assert note == f"{ERROR}; it is started again in 0.2 s\n{TRACEBACK}"


def test_the_traceback_of_an_error_that_kills_a_worker_again_is_shown_once() -> None:
    notes = RestartNotes()
    notes.of("left", f"{ERROR}\n{TRACEBACK}", 0.1)
    assert notes.of("left", f"{ERROR}\n{TRACEBACK}", 0.2) == f"{ERROR}; it is started again in 0.2 s"
    assert TRACEBACK in notes.of("right", f"{ERROR}\n{TRACEBACK}", 0.1)
    assert notes.of("left", f"{ERROR}\n{TRACEBACK} again", 0.4).endswith("again")


def test_a_death_without_a_traceback_is_one_line() -> None:
    assert RestartNotes().of("left", "worker left died: exit code 3", 0.1) == (
        "worker left died: exit code 3; it is started again in 0.1 s"
    )
