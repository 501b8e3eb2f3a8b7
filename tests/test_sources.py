"""The sources of docs/sources.md keep their promises and run."""

from __future__ import annotations

import importlib
import re
import socket
import sys
import threading
from pathlib import Path
from types import ModuleType

import pytest

from followspot import Context
from followspot.cli.main import main
from followspot.testing import check_stage

PAGE = (Path(__file__).parent.parent / "docs/sources.md").read_text()
ROWS = "time,x,y,z\n0,0,0,1\n0.5,0.1,0,1\n1.5,0.2,0,1\n"


def block(language: str) -> str:
    (found,) = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    return str(found)


@pytest.fixture
def beacons(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The page's module, in a folder with its graph and a recording."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    Path("beacons.py").write_text(block("python"))
    Path("walk.yaml").write_text(block("yaml"))
    Path("walk.csv").write_text(ROWS)
    monkeypatch.delitem(sys.modules, "beacons", raising=False)
    return importlib.import_module("beacons")


def test_the_source_of_a_recording_plays_it(beacons: ModuleType) -> None:
    check_stage(beacons.Logged, path="walk.csv")
    command = block("sh").splitlines()[0].split()[1:]
    assert main([*command, "--out", "out", "--quiet"]) == 0
    assert Path("out/beacons.csv").read_text().splitlines()[1:] == [
        "0,0.000000000,0.0,0.0,1.0",
        "1,0.500000000,0.1,0.0,1.0",
        "2,1.500000000,0.2,0.0,1.0",
    ]


def test_the_live_source_receives_and_ends_with_the_run(beacons: ModuleType) -> None:
    check_stage(beacons.Live)
    ended, received, warnings = threading.Event(), threading.Event(), set[str]()
    context = Context("beacon", pause=lambda _: not ended.is_set(), warn=warnings.add)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]

    def send() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while not received.wait(0.02):
                for text in (b"[1, 2", b"[1, 2, 3]"):
                    sender.sendto(text, ("127.0.0.1", port))

    thread = threading.Thread(target=send)
    thread.start()
    try:
        messages = iter(beacons.Live(context, port=port).process())
        beacon = next(messages)
        while not warnings:  # the first datagram may have been sent before the source was listening
            next(messages)
    finally:
        received.set()
        thread.join()
    ended.set()
    assert list(messages) == []
    assert beacon.xyz.tolist() == [[1.0, 2.0, 3.0]]
    assert all(text.startswith("left out a datagram") for text in warnings)
