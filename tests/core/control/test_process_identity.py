"""Whether the process that operates a run has certainly died."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace

import pytest

from followspot.control.process_identity import ProcessIdentity, _started, own_identity

HERE = replace(own_identity("desk"), machine="m")


@pytest.fixture
def main() -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        yield process
        process.kill()


def test_a_living_process_is_not_dead(main: subprocess.Popen[bytes]) -> None:
    there = replace(HERE, pid=main.pid, started=_started(main.pid))
    assert there.started > 0
    assert not HERE.dead(HERE)
    assert not there.dead(HERE)


def test_a_killed_process_is_dead_even_as_a_zombie(
    main: subprocess.Popen[bytes],
) -> None:
    there = replace(HERE, pid=main.pid, started=_started(main.pid))
    main.kill()
    while not there.dead(HERE):  # a zombie
        time.sleep(0.01)
    main.wait()
    assert there.dead(HERE)


def test_a_reused_process_id_does_not_count() -> None:
    assert replace(HERE, started=HERE.started - 1).dead(HERE)


@pytest.mark.parametrize(
    "there",
    [
        ProcessIdentity(),
        replace(HERE, pid=2**22 + 1, boot=""),
        replace(HERE, pid=2**22 + 1, space="pid:[1]"),
        replace(HERE, boot="another", name=""),
        replace(HERE, boot="another", name="laptop"),
        replace(HERE, boot="another", machine="another"),
        replace(HERE, boot="another", machine=""),
    ],
    ids=["unknown", "no boot", "container", "uncertified", "other name", "other machine", "no machine"],
)
def test_a_process_elsewhere_is_never_certainly_dead(there: ProcessIdentity) -> None:
    assert not there.dead(HERE)
    assert not there.dead(ProcessIdentity())


def test_a_process_from_before_a_reboot_is_dead() -> None:
    assert replace(HERE, boot="before").dead(HERE)
