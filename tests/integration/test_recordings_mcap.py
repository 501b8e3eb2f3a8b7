"""Recorders that are killed, and recorders that run for long."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from followspot_recording.recording import Recording

CHUNK = 1.0
"""MiB."""
SIZE = (240, 320, 3)
PER_CHUNK = 4
"""Pictures of that size that fit into a chunk."""
RECORDER = f"""
import resource, sys, time
import numpy as np
from pathlib import Path
from followspot import Context
from followspot.messages import Header, stamped
from followspot.message_checks.sealing import seal
from followspot.tracking import Frame
from followspot_recording.sink import RecordingSink

def resident():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

count = int(sys.argv[2])
pictures = [np.random.default_rng(n).integers(0, 256, {SIZE}, "u1") for n in range(4)]
sink = RecordingSink(
    Context("a"), path=Path(sys.argv[1]), port="camera/cam0.out", picture_format="none",
    chunk_size={CHUNK}, chunk_time=60.0
)
sink.setup()
for number in range(count):
    header = Header("camera/cam0", number, number * 16_666_667)
    sink.process(stamped(seal(Frame("cam0", pictures[number % 4].copy())), header))
    if number == 20:
        before = resident()
print(resident() - before, flush=True)
time.sleep(60)
"""


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """A recording of 400 pictures whose recorder was killed; and by how much it grew meanwhile, KiB."""
    path = tmp_path_factory.mktemp("killed") / "show.mcap"
    command = [sys.executable, "-c", RECORDER, str(path), "400"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        grown = int(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
    return path, grown


def test_a_killed_recorder_loses_at_most_its_last_chunk(killed: tuple[Path, int]) -> None:
    with Recording(killed[0]) as recording:
        found = [message.seq for message in recording.messages("camera/cam0.out")]
        assert "the recording was not finished" in recording.problem
    assert found == list(range(len(found)))
    assert len(found) >= 400 - PER_CHUNK - 1


def test_the_memory_of_a_recorder_does_not_grow(killed: tuple[Path, int]) -> None:
    """The recorder wrote 90 MB: a hundred chunks."""
    path, grown = killed
    assert path.stat().st_size > 80_000_000
    assert grown < 10_000
