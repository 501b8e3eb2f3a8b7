"""What `timeout`, `kill` and a closed terminal leave of a command."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from followspot.cli.ending_signals import ending_as_on_ctrl_c

ENDED = """
import os, signal, sys
from argparse import Namespace
from followspot.cli import command_line
from followspot.cli.main import main
from followspot.operating_system.temporary_folder import TemporaryFolder

def work(args):
    with TemporaryFolder("test"):
        os.kill(os.getpid(), int(sys.argv[1]))
        signal.pause()

command_line._parsed = lambda words: Namespace(quiet=True, verbose=False, run_command=work)
sys.exit(main([]))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_command_that_is_ended_removes_its_temporary_files(number: signal.Signals, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", ENDED, str(int(number))],
        env={"TMPDIR": str(tmp_path)},
        capture_output=True,
        text=True,
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # the tests may run below nohup
    )
    assert (done.returncode, done.stderr) == (130, "\nfollowspot: interrupted\n")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [["agent", "--name", "left"], ["router"]], ids=["agent", "router"])
def test_agents_and_routers_end_in_order_when_their_terminal_closes(words: list[str], tmp_path: Path) -> None:
    code = "import sys; from followspot.cli.main import main; sys.exit(main())"
    with subprocess.Popen(
        [sys.executable, "-c", code, *words, "--listen", "tcp/127.0.0.1:0"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    ) as process:
        assert process.stderr
        assert " listens on tcp/127.0.0.1:" in process.stderr.readline()
        process.send_signal(signal.SIGHUP)
        assert process.stderr.read() == ""
    assert process.returncode == 0


def test_what_is_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ending_as_on_ctrl_c():
            signal.raise_signal(signal.SIGHUP)
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)
