"""The ledger's file outlives the agent; then only workers of the next agent write to it."""

from __future__ import annotations

import mmap
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.integration.running import alive

from followspot.host.ledger_file import ledger_memory

COUNTING = """
import mmap, sys, time
file = open(sys.argv[1], "r+b")
words = mmap.mmap(file.fileno(), 8192)
file.close()
print("ready", flush=True)
time.sleep(600)
"""


def counting(file: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen([sys.executable, "-c", COUNTING, str(file)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.parametrize("kept", [True, False], ids=["a file", "memory"])
def test_the_memory_is_allocated_at_once(tmp_path: Path, kept: bool) -> None:
    fd = ledger_memory(tmp_path / ".ledger" if kept else None, 100_000)
    assert os.fstat(fd).st_size == 100_000
    assert os.fstat(fd).st_blocks * 512 >= 100_000, "a disk that is full later takes nothing away"
    os.close(fd)


def test_a_file_keeps_its_counts(tmp_path: Path) -> None:
    for expected in (0, 1):
        fd = ledger_memory(tmp_path / ".ledger", 8192)
        with mmap.mmap(fd, 8192) as words:
            assert words[5] == expected
            words[5] += 1
        os.close(fd)


def test_a_hanging_worker_of_a_killed_agent_is_killed_before_its_file_is_used(tmp_path: Path) -> None:
    files = [tmp_path / "one", tmp_path / "another"]
    for file in files:
        file.write_bytes(bytes(8192))
    processes = [counting(file) for file in files]
    try:
        processes[0].send_signal(signal.SIGSTOP)
        os.close(ledger_memory(files[0], 8192))
        assert not alive(processes[0].pid)
        assert processes[1].poll() is None, "it counts elsewhere"
    finally:
        for process in processes:
            process.kill()
            process.communicate()


def test_a_full_disk_is_an_error_before_the_first_count(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"No space|too large"):
        ledger_memory(tmp_path / ".ledger", 1 << 60)
