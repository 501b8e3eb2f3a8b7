"""Whether it is certain that the process has died that operated a run."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import pytest

from followspot.control.origin import Origin, _started, own_origin

HERE = replace(own_origin("desk"), machine="m")


@pytest.fixture
def main() -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        yield process
        process.kill()


def test_whoever_lives_is_not_dead(main: subprocess.Popen[bytes]) -> None:
    there = replace(HERE, pid=main.pid, started=_started(main.pid))
    assert there.started > 0
    assert not HERE.dead(HERE)
    assert not there.dead(HERE)


def test_who_was_killed_is_dead_also_before_its_parent_knows(
    main: subprocess.Popen[bytes],
) -> None:
    there = replace(HERE, pid=main.pid, started=_started(main.pid))
    main.kill()
    while not there.dead(HERE):  # a zombie
        time.sleep(0.01)
    main.wait()
    assert there.dead(HERE)


def test_another_process_that_was_given_the_number_is_not_taken_for_it() -> None:
    assert replace(HERE, started=HERE.started - 1).dead(HERE)


@pytest.mark.parametrize(
    "there",
    [
        Origin(),
        replace(HERE, pid=2**22 + 1, boot=""),
        replace(HERE, pid=2**22 + 1, space="pid:[1]"),
        replace(HERE, boot="another", name=""),
        replace(HERE, boot="another", name="laptop"),
        replace(HERE, boot="another", machine="another"),
        replace(HERE, boot="another", machine=""),
    ],
    ids=["unknown", "no boot", "container", "uncertified", "other name", "other machine", "no machine"],
)
def test_nothing_is_certain_of_who_is_elsewhere(there: Origin) -> None:
    assert not there.dead(HERE)
    assert not there.dead(Origin())


def test_who_was_there_before_this_machine_was_started_again_is_dead() -> None:
    assert replace(HERE, boot="before").dead(HERE)
