"""Ctrl-C reaches all processes of a terminal: at any moment of the start it ends a run quietly."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from tests.integration.running import children, wait_until

GRAPH = Path(__file__).parents[2] / "graphs/glowballs.yaml"


@pytest.mark.parametrize("later", [0, pytest.param(1, marks=pytest.mark.thorough), 7])
def test_ctrl_c_while_workers_start_is_an_interruption(tmp_path: Path, later: int) -> None:
    """later: processes that are there beside the first one of the workers."""
    command = [
        sys.executable,
        "-m",
        "followspot.cli.main",
        "run",
        GRAPH,
        "--placement",
        "camera",
        "--out",
        "out",
    ]
    process = subprocess.Popen(
        [*command, "--frames", "2000", "-q"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # the group of a terminal
    )

    def started() -> int:
        own = children(process.pid)
        return len(own) + sum(len(children(pid)) for pid in own)

    assert wait_until(lambda: started() > later or process.poll() is not None)
    os.killpg(process.pid, signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert process.returncode in (0, 130), errors + out
    assert "Traceback" not in errors
    assert "died" not in errors + out


PRESSED = """
import os, signal, sys

class Press:
    def find_spec(self, name, path, target=None):
        if name == sys.argv[1]:
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)  # a test in the background of a shell ignores it
sys.meta_path.insert(0, Press())
from followspot.cli.main import main
sys.exit(main(["graphs"]))
"""


@pytest.mark.parametrize("module", ["argparse", "followspot.cli.parser", "followspot.errors"])
def test_ctrl_c_while_the_command_is_imported_is_an_interruption(module: str) -> None:
    done = subprocess.run([sys.executable, "-c", PRESSED, module], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "\nfollowspot: interrupted\n")


AGAIN = (
    PRESSED.removesuffix('sys.exit(main(["graphs"]))\n')
    + """
import threading

def press_again():
    threading.main_thread().join()
    os.kill(os.getpid(), signal.SIGINT)

code = main(["graphs"])
threading.Thread(target=press_again).start()
sys.exit(code)
"""
)


def test_ctrl_c_again_while_the_command_ends_shows_no_traceback() -> None:
    done = subprocess.run([sys.executable, "-c", AGAIN, "argparse"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "\nfollowspot: interrupted\n")
