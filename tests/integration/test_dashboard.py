"""A run that is looked at is the same run: same tracks, same ledger, and nothing of the page stays."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest
from browser import CHROMIUM, browser

from followspot.deploy.launch import run_plan
from followspot.graph.compile import compile_graph
from followspot.runtime.wiring import RunOptions

ROOT = Path(__file__).parents[2]
GRAPH = ROOT / "graphs" / "glowballs.yaml"
FRAMES = 12


@pytest.fixture(scope="module")
def unseen_tracks(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("unseen")
    assert run_plan(compile_graph(GRAPH), RunOptions(out, FRAMES)).ok
    return (out / "tracks.csv").read_bytes()


@pytest.fixture
def room_for_sockets() -> Iterator[Path]:
    """A folder with a short name, for those of sockets have at most 107 bytes."""
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


@contextmanager
def watched(out: Path, *options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A run with a page, and the page's address."""
    command = [sys.executable, "-m", "followspot.cli.main", "run", str(GRAPH), "--json", "--out", str(out)]
    command += ["--dashboard-at", "127.0.0.1:0", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"http://\S+/", line)
            assert found, line
            rest: list[str] = []
            reading = threading.Thread(target=lambda: rest.extend(process.stderr or ()), daemon=True)
            reading.start()
            yield process, found[0]
            reading.join(timeout=60)
            assert rest == []  # nothing is complained of
        finally:
            process.kill()


@pytest.mark.thorough
def test_a_run_in_many_processes_that_is_looked_at_is_the_same_and_the_page_ends_with_it(
    tmp_path: Path, room_for_sockets: Path, unseen_tracks: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    placement = ROOT / "graphs" / "placements" / "two.yaml"
    monkeypatch.setenv("TMPDIR", str(room_for_sockets))
    with watched(tmp_path, "--quiet", "--placement", str(placement)) as (process, url):
        status = json.load(urlopen(url + "status", timeout=60))
        while status["fired"] <= FRAMES or not status["paths"]:
            time.sleep(0.1)
            status = json.load(urlopen(url + "status", timeout=60))
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=120)
    with pytest.raises(OSError, match="refused"):
        urlopen(url, timeout=5)
    assert not list(room_for_sockets.glob("followspot-page-*"))
    summary = json.loads(out)
    assert summary["ok"]
    assert [edge["from"] for edge in status["edges"]] == [edge["from"] for edge in summary["edges"]]
    assert all(
        now["sent"] <= then["sent"] for now, then in zip(status["edges"], summary["edges"], strict=True)
    )
    assert {path["sink"] for path in status["paths"]} == {"save"}
    assert (tmp_path / "tracks.csv").read_bytes().startswith(unseen_tracks)


@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_a_browser_shows_pictures_room_and_graph(tmp_path: Path) -> None:
    with watched(tmp_path / "run", "--quiet") as (process, url), browser(tmp_path / "chromium") as chromium:
        chromium.open(url, 390, 844)
        chromium.wait("document.querySelectorAll('figure:not(.dark)').length === 6")
        chromium.wait("document.querySelector('#legend li').dataset.state === 'tracked'")
        chromium.wait("document.querySelector('#life').dataset.life === 'running'")
        assert chromium.ask("document.documentElement.scrollWidth") <= 390  # nothing sticks out of a phone
        chromium.ask("document.querySelector('#groups button').focus()")
        chromium.press("Enter")
        chromium.wait("document.querySelectorAll('#detail td').length > 20")
        assert chromium.ask("document.querySelector('#detail h2').textContent") == "camera · sim.camera"
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        chromium.wait("document.querySelector('#life').dataset.life === 'ended'")
        assert [error for error in chromium.errors if "ERR_CONNECTION" not in error] == []
